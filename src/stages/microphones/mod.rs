//! Virtual microphones around the device: sound power as EN 12549 would measure it, next to the radiated power.

mod bands;
mod completion;
mod continuation;
mod ear;
pub(crate) mod noise;
mod received;
mod sources;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::sound::{Iso3744Box, background_correction, environmental_correction};
use nailnoise_acoustics::signals::{SILENCE, band_containing, energy_level, level_energy};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::sound::SoundSource;
use crate::error::Error;
use crate::result::{
    ArrayMeasurement, EarReport, MicrophoneBand, MicrophoneLevel, MicrophoneReport, ReceivedSource, TOTAL,
};
use bands::{Integration, Spectra, bands, density, integrals, within};
pub(crate) use continuation::Continuation;
use received::{Received, SourcePart};
pub use sources::{JetOutlet, ToolSphere};

/// Ratio of the reference exposure (20 uPa)² s to the reference energy 1 pW s and the reference area 1 m²: 400 Pa s/m,
/// which replaces the impedance of air in L_W = L_p + 10 lg S.
const REFERENCE: f64 = 400.0;

/// Sampling rate of the sound files \[1/s\].
pub(crate) const SAMPLE_RATE: u32 = 48_000;

/// Duration of a sound file after the end of the shot \[s\], for the travel time and for ringing at the ends of the
/// range.
const TAIL: f64 = 0.05;

/// Maximum duration of a sound file \[s\].
const LONGEST: f64 = 2.0;

/// The microphones around a device above a reflecting plane.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MicrophoneArray {
    /// The ambient air.
    pub air: Air,
    /// Point where the device's axis meets the base plane of the measurement surface, in the coordinates of the bodies
    /// \[m\].
    pub foot: [f64; 3],
    /// Height of the reflecting plane, not below that point, in the same coordinates \[m\].
    pub reflecting_plane: f64,
    /// Height of the device's centre above that point \[m\].
    pub centre_height: f64,
    /// The operator's ear, in the same coordinates \[m\].
    pub ear: [f64; 3],
    /// Range over which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
}

/// The room of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Room {
    /// Equivalent absorption area \[m²\]; 0 for a free field over the plane.
    pub absorption: f64,
    /// A-weighted level of the background noise \[dB re 20 uPa\]; 0 for no background noise.
    pub background_level: f64,
}

/// Sound of a source, or of a part of one, at the microphones and then at the operator's ear. The energies of a part
/// may have either sign.
///
/// Stages that make sources give the sound as far as its pressures are known; [`MicrophoneArray::complete`] continues
/// it to the top of the common range.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AtMicrophones {
    /// Name of the source.
    pub source: String,
    /// How its sound is propagated to a receiver.
    pub how: String,
    /// Frequencies over which it is received and compared \[Hz\].
    pub range_hz: [f64; 2],
    /// Frequency up to which its signals have the phases of the model \[Hz\]; phases above are drawn or chosen.
    pub phases_to_hz: f64,
    /// Error of interpolated pressures over frequency, see [`ReceivedSource`].
    pub interpolation_error: Option<f64>,
    /// A-weighted and unweighted exposure at each receiver in each one-third-octave band of the common range \[Pa² s\].
    pub exposures: Vec<Vec<[f64; 2]>>,
    /// A-weighted and unweighted energy radiated over `range_hz` in each of these bands \[J\].
    pub radiated: Vec<[f64; 2]>,
    /// Its pressure at 48 kHz from the trigger on, for each receiver \[Pa\].
    pub signals: Vec<Vec<f64>>,
}

/// A source, or a part of one, with its sound at the microphones.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Heard {
    /// Its energy over frequency and time.
    pub source: SoundSource,
    /// Its sound at the microphones.
    pub received: AtMicrophones,
}

/// Sum of A-weighted and unweighted values over bands.
fn over_bands(bands: &[[f64; 2]]) -> [f64; 2] {
    bands.iter().fold([0.0; 2], |[a, z], band| [a + band[0], z + band[1]])
}

impl AtMicrophones {
    /// A-weighted and unweighted exposure at a receiver \[Pa² s\].
    fn exposure(&self, receiver: usize) -> [f64; 2] {
        over_bands(&self.exposures[receiver])
    }

    /// Number of microphones, without the ear.
    fn microphones(&self) -> usize {
        self.exposures.len() - 1
    }

    /// Energies from the microphones in each band, A-weighted and unweighted \[J\]: the mean exposure over a surface of
    /// this area, converted with an impedance of 400 Pa s/m.
    fn measured(&self, area: f64) -> Vec<[f64; 2]> {
        let scale = area / (REFERENCE * self.microphones() as f64);
        let mean = |band: usize| {
            let all = self.exposures[..self.microphones()].iter();
            all.fold([0.0; 2], |[a, z], own| {
                [a + scale * own[band][0], z + scale * own[band][1]]
            })
        };
        (0..self.radiated.len()).map(mean).collect()
    }

    /// Its levels in the bands of the common range, for a surface of this area.
    fn levels(&self, bands: &[[f64; 2]], area: f64) -> ReceivedSource {
        let measured = self.measured(area);
        let [low, high] = self.range_hz;
        let energies = bands.iter().zip(measured.iter().zip(&self.radiated));
        let of_band = |(&[from, to], (measured, radiated)): (&[f64; 2], (&[f64; 2], &[f64; 2]))| {
            let band = band_containing((from * to).sqrt());
            let whole = from <= band.low * (1.0 + 1e-9)
                && to >= band.high * (1.0 - 1e-9)
                && band.low >= low * (1.0 - 1e-9)
                && band.high <= high * (1.0 + 1e-9);
            whole.then(|| MicrophoneBand {
                hz: band.nominal_hz(),
                lw_db: energy_level(measured[1]),
                true_lw_db: energy_level(radiated[1]),
            })
        };
        let level = |(row, signal): (usize, &Vec<f64>)| {
            let [lae_db, le_db] = self.exposure(row).map(exposure_level);
            MicrophoneLevel {
                lae_db,
                le_db,
                peak_pa: peak(signal),
            }
        };
        ReceivedSource {
            source: self.source.clone(),
            how: self.how.clone(),
            range_hz: self.range_hz,
            synthetic_from_hz: (self.phases_to_hz < high * (1.0 - 1e-9)).then_some(self.phases_to_hz),
            interpolation_error: self.interpolation_error,
            levels: self.signals[..self.microphones()]
                .iter()
                .enumerate()
                .map(level)
                .collect(),
            lwa_db: energy_level(over_bands(&measured)[0]),
            true_lwa_db: energy_level(over_bands(&self.radiated)[0]),
            bands: energies.filter_map(of_band).collect(),
        }
    }

    /// The source plus `factor` times a part: 1 for a part that is assigned to it, -1 for one that is not. Each part
    /// keeps the range over which it is received.
    #[must_use]
    pub fn with(&self, part: &Self, factor: f64) -> Self {
        let add = |own: &mut [[f64; 2]], other: &[[f64; 2]]| {
            let pairs = own.iter_mut().flatten().zip(other.iter().flatten());
            pairs.for_each(|(own, other)| *own += factor * other);
        };
        let mut sum = self.clone();
        for (own, other) in sum.exposures.iter_mut().zip(&part.exposures) {
            add(own, other);
        }
        add(&mut sum.radiated, &part.radiated);
        for (own, other) in sum.signals.iter_mut().zip(&part.signals) {
            own.iter_mut().zip(other).for_each(|(own, p)| *own += factor * p);
        }
        if factor > 0.0 {
            let ([low, high], [from, to]) = (sum.range_hz, part.range_hz);
            sum.how = format!("{}; {}: {}, {from:.0} to {to:.0} Hz", sum.how, part.source, part.how);
            sum.range_hz = [low.min(from), high.max(to)];
            sum.phases_to_hz = sum.phases_to_hz.min(part.phases_to_hz);
            sum.interpolation_error = [sum.interpolation_error, part.interpolation_error]
                .into_iter()
                .flatten()
                .reduce(f64::max);
        }
        sum
    }
}

/// Levels and signals of all sources at the microphones.
#[derive(Debug, Clone)]
pub struct Microphones {
    /// Levels, compared with the radiated power.
    pub report: MicrophoneReport,
    /// Levels at the operator's ear.
    pub ear: EarReport,
    /// Pressure at 48 kHz from the trigger on, for each source and their sum (`total`) and each microphone \[Pa\].
    pub signals: Vec<(String, Vec<Vec<f64>>)>,
}

impl MicrophoneArray {
    /// The measurement surface.
    fn surface(&self) -> Iso3744Box {
        Iso3744Box::around(self.centre_height)
    }

    /// Positions of the microphones, in the coordinates of the bodies \[m\].
    pub fn positions(&self) -> Vec<Point3<f64>> {
        self.surface().positions_around(self.foot.into())
    }

    /// Positions of the receivers: the microphones, then the operator's ear \[m\].
    pub(crate) fn receivers(&self) -> Vec<Point3<f64>> {
        let mut all = self.positions();
        all.push(self.ear.into());
        all
    }

    /// Travel time from the device's centre to each receiver \[s\].
    fn travel_times(&self) -> Vec<f64> {
        let [x, y, foot] = self.foot;
        let centre = Point3::new(x, y, foot + self.centre_height);
        let time = |place: &Point3<f64>| (place - centre).norm() / self.air.sound_speed;
        self.receivers().iter().map(time).collect()
    }

    /// Energies of a source at the microphones, over the common range of all sources.
    fn received(&self, received: Received<'_>) -> AtMicrophones {
        let [low, high] = self.range_hz;
        let range = received.range.map(|end| end.clamp(low, high));
        let bands = within(&bands(self.range_hz), range);
        let mut exposures = vec![vec![[0.0; 2]; bands.len()]; received.signals.len()];
        for SourcePart { frequency, exposure } in &received.parts {
            let integration = Integration::new(frequency, &bands);
            for (own, density) in exposures.iter_mut().zip(exposure.row_iter()) {
                let density: Vec<f64> = density.iter().copied().collect();
                let found = integration.energies(&density);
                (own.iter_mut().flatten().zip(found.iter().flatten())).for_each(|(own, e)| *own += e);
            }
        }
        let spectrum = received.radiated;
        AtMicrophones {
            source: spectrum.source.clone(),
            how: received.how.to_owned(),
            range_hz: range,
            phases_to_hz: received.phases_to_hz.clamp(range[0], range[1]),
            interpolation_error: received.interpolation_error,
            exposures,
            radiated: integrals(&spectrum.frequency, &spectrum.energy_density, &bands),
            signals: received.signals,
        }
    }

    /// Levels and signals of every source and of their sum; the sources must be complete, see [`Self::complete`].
    ///
    /// # Errors
    /// The errors of the standard's corrections; signals that are not finite.
    pub fn measurement(&self, room: &Room, all: &[AtMicrophones]) -> Result<Microphones, Error> {
        let surface = self.surface();
        let positions = surface.positions();
        let ear = self.at_ear(all)?;
        let mut total: Vec<Vec<f64>> = Vec::new();
        for source in all {
            total.resize(positions.len(), Vec::new());
            for (sum, signal) in total.iter_mut().zip(&source.signals) {
                sum.resize(sum.len().max(signal.len()), 0.0);
                sum.iter_mut().zip(signal).for_each(|(sum, p)| *sum += p);
            }
        }
        let bands = bands(self.range_hz);
        let sources: Vec<ReceivedSource> = all.iter().map(|source| source.levels(&bands, surface.area())).collect();
        let levels = together(&total, &bands);
        let measured = by_iso_3744(room, &self.air, &surface, all, levels)?;
        let own = all.iter().map(|source| {
            let signals = source.signals[..positions.len()].to_vec();
            (source.source.clone(), signals)
        });
        let signals: Vec<(String, Vec<Vec<f64>>)> = own.chain([(TOTAL.to_owned(), total)]).collect();
        let peaks = signals
            .iter()
            .flat_map(|(_, signals)| signals)
            .map(|signal| peak(signal));
        let report = MicrophoneReport {
            box_m: surface.sides,
            area_m2: surface.area(),
            positions_m: positions.map(Into::into).to_vec(),
            range_hz: self.range_hz,
            full_scale_pa: full_scale(peaks.fold(0.0, f64::max)),
            sources,
            total: measured,
        };
        Ok(Microphones { report, ear, signals })
    }
}

/// Levels of the sum of all sources, whose pressures are added.
fn together(signals: &[Vec<f64>], bands: &[[f64; 2]]) -> Vec<MicrophoneLevel> {
    let samples = signals.iter().map(Vec::len).max().unwrap_or(0);
    let spectra = Spectra::new(samples, f64::from(SAMPLE_RATE));
    let integration = Integration::new(&spectra.frequency, bands);
    let level = |signal: &Vec<f64>| {
        let energies = integration.energies(&density(&spectra.lines(signal)));
        let [lae_db, le_db] = over_bands(&energies).map(exposure_level);
        MicrophoneLevel {
            lae_db,
            le_db,
            peak_pa: peak(signal),
        }
    };
    signals.iter().map(level).collect()
}

/// All sources together by the procedure of ISO 3744, in a room with background noise.
fn by_iso_3744(
    room: &Room,
    air: &Air,
    surface: &Iso3744Box,
    sources: &[AtMicrophones],
    levels: Vec<MicrophoneLevel>,
) -> Result<ArrayMeasurement, Error> {
    // Rounded like the levels that the result states for each source.
    let rounded = |energy: f64| {
        if energy < 0.0 {
            energy
        } else {
            level_energy(energy_level(energy))
        }
    };
    let sum = |energy: &dyn Fn(&AtMicrophones) -> f64| -> f64 { sources.iter().map(|s| rounded(energy(s))).sum() };
    let area = surface.area();
    let radiated = sum(&|s| over_bands(&s.radiated)[0]);
    // Energies from mean exposures: E = 400 Pa s/m x S x mean.
    let direct = sum(&|s| over_bands(&s.measured(area))[0]);
    let (reverberant, k2) = if room.absorption > 0.0 {
        let absorption = room.absorption;
        (
            4.0 * air.impedance() / absorption * radiated * area / REFERENCE,
            environmental_correction(area, absorption)?,
        )
    } else {
        (0.0, 0.0)
    };
    // The exposure level of a steady sound over 1 s is its level.
    let background = if room.background_level > 0.0 {
        level_energy(Some(room.background_level)) * area
    } else {
        0.0
    };
    let of_tool = direct + reverberant;
    let k1 = if background > 0.0 && of_tool > SILENCE {
        background_correction(10.0 * ((of_tool + background) / background).log10())
    } else {
        Some(0.0)
    };
    let measured = energy_level(of_tool + background);
    Ok(ArrayMeasurement {
        levels,
        lpa_db: measured.map(|level| level - 10.0 * area.log10()),
        k1_db: k1,
        k2_db: k2,
        lwa_db: measured.zip(k1).map(|(level, k1)| level - k1 - k2),
        true_lwa_db: energy_level(radiated),
    })
}

/// Level of a sound exposure \[dB re (20 uPa)² s\].
fn exposure_level(exposure: f64) -> Option<f64> {
    energy_level(exposure / REFERENCE)
}

fn peak(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |peak: f64, p| peak.max(p.abs()))
}

/// The smallest of 1, 2, 5, 10 ... above a peak, starting at 1e-3, in the unit of the peak.
pub(crate) fn full_scale(peak: f64) -> f64 {
    let steps = (-3..9).flat_map(|decade| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(decade)));
    steps.into_iter().find(|scale| *scale > peak).unwrap_or(peak.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scale_is_a_round_pressure_above_the_peak() {
        for (peak, scale) in [(0.0, 1e-3), (0.7, 1.0), (1.0, 2.0), (3.3, 5.0), (12.0, 20.0)] {
            assert!((full_scale(peak) / scale - 1.0).abs() < 1e-12, "{peak}");
        }
    }
}
