//! Virtual microphones around the device: sound power as EN 12549 would measure it, beside the power radiated.

mod ear;
mod sources;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::{
    BandLevel, SILENCE, SourceSpectrum, Weighting, energy_level, energy_weights, level_energy,
};
use nailnoise_acoustics::sound::{Iso3744Box, background_correction, environmental_correction};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::result::{ArrayMeasurement, EarReport, MicrophoneBand, MicrophoneLevel, MicrophoneReport, ReceivedSource};
pub use ear::AtEar;
pub use sources::{JetOutlet, ToolSphere};
use sources::{Part, Received, samples};

/// Reference exposure (20 uPa)² s \[Pa² s\] over reference energy 1 pW s and reference area 1 m²: 400 Pa s/m, which
/// stands for the impedance of air in L_W = L_p + 10 lg S.
const REFERENCE: f64 = 400.0;

/// Sampling rate of the sound files \[1/s\].
pub(crate) const SAMPLE_RATE: u32 = 48_000;

/// Length of a sound file after the end of the shot \[s\], for the travel time and for ringing at the ends of the range.
const TAIL: f64 = 0.05;

/// Longest sound file \[s\].
const LONGEST: f64 = 2.0;

/// Name of the sum of all sources.
const TOTAL: &str = "total";

/// The microphones around a device above a reflecting plane.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MicrophoneArray {
    /// The ambient air.
    pub air: Air,
    /// Foot of the device's axis on the plane on which the measurement surface stands, in the coordinates of the bodies \[m\].
    pub foot: [f64; 3],
    /// Height of the plane that reflects, not below that foot, in the same coordinates \[m\].
    pub reflecting_plane: f64,
    /// Height of the device's centre above the foot \[m\].
    pub centre_height: f64,
    /// The operator's ear, in the same coordinates \[m\].
    pub ear: [f64; 3],
    /// Range in which sources are compared \[Hz\].
    pub range_hz: [f64; 2],
}

/// The room in which a measurement is made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Room {
    /// Equivalent absorption area \[m²\]; 0 in the free field over the plane.
    pub absorption: f64,
    /// A-weighted level of the background noise \[dB re 20 uPa\]; 0 without background.
    pub background_level: f64,
}

/// Sound of a source, or of a part of one, at the microphones. The energies of a part may have either sign.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AtMicrophones {
    /// Name of the source.
    pub source: String,
    /// How its sound is carried to a place.
    pub how: String,
    /// Frequencies over which it is received and compared \[Hz\].
    pub range_hz: [f64; 2],
    /// Error of interpolated pressures over frequency, see [`ReceivedSource`].
    pub interpolation_error: Option<f64>,
    /// A-weighted and unweighted exposure at each microphone \[Pa² s\].
    pub exposures: Vec<[f64; 2]>,
    /// A-weighted energy by the microphones, and radiated over the same range \[J\].
    pub energies: [f64; 2],
    /// Bands that lie in the range: nominal mid-band frequency \[Hz\], energy by the microphones and radiated \[J\].
    pub bands: Vec<(f64, [f64; 2])>,
    /// Its pressure at 48 kHz from the trigger on, microphone by microphone \[Pa\].
    pub signals: Vec<Vec<f64>>,
    /// At the operator's ear.
    pub ear: AtEar,
}

impl AtMicrophones {
    /// Its levels.
    fn levels(&self) -> ReceivedSource {
        let microphones = self.exposures.iter().zip(&self.signals);
        let [measured, radiated] = self.energies.map(energy_level);
        let of_band = |&(hz, energies): &(f64, [f64; 2])| {
            let [lw_db, true_lw_db] = energies.map(energy_level);
            MicrophoneBand { hz, lw_db, true_lw_db }
        };
        ReceivedSource {
            source: self.source.clone(),
            how: self.how.clone(),
            range_hz: self.range_hz,
            interpolation_error: self.interpolation_error,
            levels: microphones
                .map(|([weighted, plain], signal)| MicrophoneLevel {
                    lae_db: exposure_level(*weighted),
                    le_db: exposure_level(*plain),
                    peak_pa: peak(signal),
                })
                .collect(),
            lwa_db: measured,
            true_lwa_db: radiated,
            bands: self.bands.iter().map(of_band).collect(),
        }
    }

    /// The source with `factor` times a part: 1 for one that counts to it, -1 for one that does not. Each part keeps the range
    /// over which it is received.
    #[must_use]
    pub fn with(&self, part: &Self, factor: f64) -> Self {
        let add = |own: [f64; 2], other: [f64; 2]| [own[0] + factor * other[0], own[1] + factor * other[1]];
        let mut sum = self.clone();
        for (own, other) in sum.exposures.iter_mut().zip(&part.exposures) {
            *own = add(*own, *other);
        }
        sum.energies = add(sum.energies, part.energies);
        for (hz, energies) in &part.bands {
            match sum.bands.iter_mut().find(|(own, _)| own == hz) {
                Some((_, own)) => *own = add(*own, *energies),
                None => sum.bands.push((*hz, add([0.0; 2], *energies))),
            }
        }
        sum.bands.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (own, other) in sum.signals.iter_mut().zip(&part.signals) {
            own.iter_mut().zip(other).for_each(|(own, p)| *own += factor * p);
        }
        sum.ear.add(&part.ear, factor);
        if factor > 0.0 {
            let ([low, high], [from, to]) = (sum.range_hz, part.range_hz);
            sum.how = format!("{}; {}: {}, {from:.0} to {to:.0} Hz", sum.how, part.source, part.how);
            sum.range_hz = [low.min(from), high.max(to)];
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
    /// Levels, and how they compare with the power radiated.
    pub report: MicrophoneReport,
    /// Levels at the operator's ear.
    pub ear: EarReport,
    /// Pressure at 48 kHz from the trigger on, source by source and of all of them (`total`), microphone by microphone
    /// \[Pa\].
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

    /// Where sound is received: the microphones, then the operator's ear \[m\].
    fn receivers(&self) -> Vec<Point3<f64>> {
        let mut all = self.positions();
        all.push(self.ear.into());
        all
    }

    /// Energies of a source at the microphones, in the range in which all are compared.
    fn received(&self, received: Received<'_>) -> Result<AtMicrophones, Error> {
        let [low, high] = self.range_hz;
        let within = [received.range[0].max(low), received.range[1].min(high)];
        energies(received, self.surface().area(), within)
    }

    /// Levels and signals of every source and of all together, for a shot whose records last until `end` \[s\]; `radiated` is
    /// the A-weighted energy of all sources \[J\].
    ///
    /// # Errors
    /// Those of the standard's corrections.
    pub fn measurement(
        &self,
        room: &Room,
        all: [&AtMicrophones; 3],
        (end, radiated): (f64, f64),
    ) -> Result<Microphones, Error> {
        let surface = self.surface();
        let positions = surface.positions();
        let mut total = vec![vec![0.0; samples(end)]; positions.len()];
        for source in all {
            for (sum, signal) in total.iter_mut().zip(&source.signals) {
                sum.iter_mut().zip(signal).for_each(|(sum, p)| *sum += p);
            }
        }
        let sources: Vec<ReceivedSource> = all.iter().map(|source| source.levels()).collect();
        let measured = by_iso_3744(room, &self.air, &surface, &all, &total)?;
        let own = all.iter().map(|source| (source.source.clone(), source.signals.clone()));
        let signals: Vec<(String, Vec<Vec<f64>>)> = own.chain([(TOTAL.to_owned(), total)]).collect();
        let peaks = signals
            .iter()
            .flat_map(|(_, signals)| signals)
            .map(|signal| peak(signal));
        let report = MicrophoneReport {
            box_m: surface.sides,
            area_m2: surface.area(),
            positions_m: positions.map(Into::into).to_vec(),
            full_scale_pa: full_scale(peaks.fold(0.0, f64::max)),
            sources,
            total: measured,
        };
        let ear = self.at_ear(&all, radiated)?;
        Ok(Microphones { report, ear, signals })
    }
}

/// A source's energies at the microphones, and by the standard's surface without room and background.
fn energies(mut received: Received<'_>, area: f64, range: [f64; 2]) -> Result<AtMicrophones, Error> {
    let exposure = |row: usize, parts: &[Part], weighting: Weighting| -> f64 {
        let of_part = |part: &Part| -> f64 {
            let weights = energy_weights(&part.frequency, range, weighting);
            weights
                .iter()
                .zip(part.exposure.row(row).iter())
                .map(|(w, e)| w * e)
                .sum()
        };
        parts.iter().map(of_part).sum()
    };
    // The ear is the last receiver.
    let signal = received.signals.pop().unwrap_or_default();
    let microphones = received.signals.len();
    let ear = AtEar {
        exposure: exposure(microphones, &received.parts, Weighting::A),
        signal,
    };
    let of_row = |row: usize| [Weighting::A, Weighting::Z].map(|weighting| exposure(row, &received.parts, weighting));
    let exposures: Vec<[f64; 2]> = (0..microphones).map(of_row).collect();
    // The mean exposure over the surface, as the power that an impedance of 400 Pa s/m makes of it.
    let as_power = |part: &Part| {
        let mean = part.exposure.rows(0, microphones).row_mean();
        let mean = mean.iter().map(|e| e * area / REFERENCE).collect();
        SourceSpectrum::new("microphones", "ISO 3744", part.frequency.clone(), mean, range)
    };
    let parts = received.parts.iter().map(as_power).collect::<Result<Vec<_>, _>>()?;
    let measured = SourceSpectrum::sum("microphones", "ISO 3744", &parts);
    let whole = |b: &BandLevel| b.band.low >= range[0] * (1.0 - 1e-9) && b.band.high <= range[1] * (1.0 + 1e-9);
    let bands = measured.band_levels(range);
    let of_band = |(measured, radiated): (&BandLevel, &BandLevel)| {
        (measured.band.nominal_hz(), [measured.energy, radiated.energy])
    };
    Ok(AtMicrophones {
        source: received.radiated.source.clone(),
        how: received.how.to_owned(),
        range_hz: range,
        interpolation_error: received.interpolation_error,
        exposures,
        ear,
        energies: [&measured, received.radiated].map(|spectrum| spectrum.energy(range, Weighting::A)),
        bands: bands
            .iter()
            .zip(&received.radiated.band_levels(range))
            .filter(|(b, _)| whole(b))
            .map(of_band)
            .collect(),
        signals: received.signals,
    })
}

/// All sources at once by the procedure of ISO 3744, in a room with background noise.
fn by_iso_3744(
    room: &Room,
    air: &Air,
    surface: &Iso3744Box,
    sources: &[&AtMicrophones],
    signals: &[Vec<f64>],
) -> Result<ArrayMeasurement, Error> {
    // Those of the levels that the result gives of each source.
    let rounded = |energy: f64| {
        if energy < 0.0 {
            energy
        } else {
            level_energy(energy_level(energy))
        }
    };
    let sum = |energy: &dyn Fn(&AtMicrophones) -> f64| -> f64 { sources.iter().map(|s| rounded(energy(s))).sum() };
    let levels = (0..signals.len()).map(|row| MicrophoneLevel {
        lae_db: energy_level(sum(&|s| s.exposures[row][0] / REFERENCE)),
        le_db: energy_level(sum(&|s| s.exposures[row][1] / REFERENCE)),
        peak_pa: peak(&signals[row]),
    });
    let area = surface.area();
    let radiated = sum(&|s| s.energies[1]);
    // Energies as they stand for mean exposures: E = 400 Pa s/m x S x mean.
    let direct = sum(&|s| s.energies[0]);
    let (reverberant, k2) = if room.absorption > 0.0 {
        let absorption = room.absorption;
        (
            4.0 * air.impedance() / absorption * radiated * area / REFERENCE,
            environmental_correction(area, absorption)?,
        )
    } else {
        (0.0, 0.0)
    };
    // A steady level is its own exposure level over 1 s.
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
        levels: levels.collect(),
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

/// The smallest of 1, 2, 5, 10 ... above a peak, from 1e-3 on, in its unit.
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
