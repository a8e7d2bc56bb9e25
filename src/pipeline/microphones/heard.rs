//! What each source sounds like at the microphones: exposures over frequency, and a signal.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::exhaust::{Floor, Outlet, Recording};
use nailnoise_acoustics::fourier::{Transform, TransformSettings};
use nailnoise_acoustics::levels::{PowerSignals, SourceSpectrum};
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::sound::{OverTime, shaken_sphere_pressure, spread_evenly};
use nailnoise_dynamics::CycleRecord;
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use rayon::prelude::*;

use super::{Inputs, SAMPLE_RATE, tool_height};
use crate::design::Design;
use crate::error::Error;
use crate::pipeline::exhaust::Exhaust;
use crate::pipeline::radiator::{Flush, Radiator};
use crate::pipeline::sound::Sound;
use crate::stages::spectra::side_by_side;

/// Azimuths of the exhaust's jets: enough that the mean over them is that over all.
const AZIMUTHS: usize = 12;

/// Octaves over which signals fade out at the end of boundary elements.
const FADE_OCTAVES: f64 = 1.0 / 3.0;

/// The part of a source that has frequencies of its own.
pub(super) struct Part {
    /// \[Hz\].
    pub(super) frequency: Vec<f64>,
    /// Density of the sound exposure, microphones x frequencies \[Pa² s/Hz\].
    pub(super) exposure: DMatrix<f64>,
}

/// A source at the microphones.
pub(super) struct Heard<'a> {
    /// The source as it is radiated.
    pub(super) radiated: &'a SourceSpectrum,
    /// How its sound is carried to a place.
    pub(super) how: &'static str,
    /// Range over which it is heard \[Hz\].
    pub(super) range: [f64; 2],
    /// Error of interpolated pressures over frequency, relative to the loudest mode at any microphone.
    pub(super) interpolation_error: Option<f64>,
    pub(super) parts: Vec<Part>,
    /// Pressure at [`SAMPLE_RATE`] from the trigger on, microphone by microphone \[Pa\].
    pub(super) signals: Vec<Vec<f64>>,
}

/// Places and time of what is heard.
pub(super) struct Scene<'a> {
    pub(super) design: &'a Design,
    pub(super) air: &'a Air,
    pub(super) places: Vec<Point3<f64>>,
    /// Height of the reflecting plane \[m\].
    pub(super) plane: f64,
    /// Samples of a signal.
    pub(super) samples: usize,
}

impl Scene<'_> {
    /// On the axis of driving, `height` above what is nailed.
    fn on_axis(&self, height: f64) -> Point3<f64> {
        let nail = &self.design.nail;
        Point3::new(
            nail.offset_along,
            nail.offset_across,
            self.design.workpiece.thickness + height,
        )
    }

    /// A part and its signals from complex pressures, places x frequencies \[Pa s\].
    fn of_pressures(&self, frequency: &[f64], pressures: &DMatrix<Complex<f64>>) -> (Part, Vec<Vec<f64>>) {
        let over_time = OverTime::new(frequency, f64::from(SAMPLE_RATE), self.samples);
        let signal = |row: usize| {
            let spectrum: Vec<Complex<f64>> = pressures.row(row).iter().copied().collect();
            over_time.signal(&spectrum)
        };
        let part = Part {
            frequency: frequency.to_vec(),
            exposure: pressures.map(|p| 2.0 * p.norm_sqr()),
        };
        (part, (0..pressures.nrows()).into_par_iter().map(signal).collect())
    }

    /// A part that is known by its energy alone, from a point.
    fn spread(&self, centre: Point3<f64>, signals: &PowerSignals) -> Result<(Part, Vec<Vec<f64>>), Error> {
        let (frequency, signal) = (signals.frequency(), signals.one_signal());
        let mut pressures = DMatrix::zeros(self.places.len(), frequency.len());
        for (mut row, place) in pressures.row_iter_mut().zip(&self.places) {
            let spread = spread_evenly(centre, *place, self.plane, self.air)?;
            for ((p, hz), x) in row.iter_mut().zip(frequency).zip(&signal) {
                *p = spread.pressure(*hz, *x);
            }
        }
        Ok(self.of_pressures(frequency, &pressures))
    }

    /// The workpiece with its support.
    pub(super) fn workpiece<'a>(&self, inputs: &Inputs<'a>) -> Result<Heard<'a>, Error> {
        match inputs.radiator {
            Radiator::Bem(bem) => self.standing(bem, inputs.spectra, &inputs.workpiece.spectrum),
            Radiator::Rayleigh(flush) => self.flush(inputs, flush),
            Radiator::Erp(_) => self.evenly(inputs.workpiece),
        }
    }

    /// Block and table by boundary elements, as far as they reach.
    fn standing<'a>(
        &self,
        bem: &ModalBem,
        spectra: &[ModalSpectra],
        radiated: &'a SourceSpectrum,
    ) -> Result<Heard<'a>, Error> {
        self.solved(bem, &side_by_side(spectra), radiated)
    }

    /// A source by boundary elements, as far as they reach.
    fn solved<'a>(
        &self,
        bem: &ModalBem,
        together: &ModalSpectra,
        radiated: &'a SourceSpectrum,
    ) -> Result<Heard<'a>, Error> {
        let frequency = &together.frequency;
        let mut pressures = bem.pressures(frequency, &together.accelerations)?;
        let places = self.places.len();
        if pressures.nrows() == 2 * places {
            // The plane's reflections are what its images hear.
            pressures = pressures.rows(0, places) + pressures.rows(places, places);
        }
        let to = bem.solved_hz()[1];
        let from = to * 2f64.powf(-FADE_OCTAVES);
        let part = Part {
            frequency: frequency.clone(),
            exposure: pressures.map(|p| 2.0 * p.norm_sqr()),
        };
        // Above, boundary elements are known in the mean alone, without a phase.
        for (mut bin, hz) in pressures.column_iter_mut().zip(frequency) {
            let t = ((hz / from).ln() / (to / from).ln()).clamp(0.0, 1.0);
            bin.iter_mut().for_each(|p| *p *= (0.5 * PI * t).cos());
        }
        let (_, signals) = self.of_pressures(frequency, &pressures);
        Ok(Heard {
            radiated,
            how: "boundary elements",
            range: [together.range_hz[0], from.min(together.range_hz[1])],
            interpolation_error: Some(bem.summary.heard),
            parts: vec![part],
            signals,
        })
    }

    /// The block's top and the sand around it, in an infinite plane.
    fn flush<'a>(&self, inputs: &Inputs<'a>, flush: &Flush) -> Result<Heard<'a>, Error> {
        let (sound, spectra) = (&flush.sound.heard, &inputs.spectra[0]);
        let pressures = sound.pressures(&flush.sound.waves, &spectra.frequency, &spectra.accelerations);
        let (part, signals) = self.of_pressures(&spectra.frequency, &pressures);
        Ok(Heard {
            radiated: &inputs.workpiece.spectrum,
            how: "Rayleigh's integral",
            range: spectra.range_hz,
            interpolation_error: Some(sound.error()),
            parts: vec![part],
            signals,
        })
    }

    /// All signals of a source from the middle of the workpiece.
    fn evenly<'a>(&self, source: &'a Sound) -> Result<Heard<'a>, Error> {
        let middle = Point3::new(0.0, 0.0, 0.5 * self.design.workpiece.thickness);
        let parts = source.signals.iter().map(|(_, signals)| self.spread(middle, signals));
        let (parts, signals): (Vec<Part>, Vec<_>) = parts.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        Ok(Heard {
            radiated: &source.spectrum,
            how: "spread evenly: ERP knows no directions",
            range: source.spectrum.range_hz,
            interpolation_error: None,
            parts,
            signals: sum(signals, self.samples),
        })
    }

    /// The tool: by boundary elements, or as a shaken sphere.
    pub(super) fn body<'a>(&self, inputs: &Inputs<'a>) -> Result<Heard<'a>, Error> {
        match inputs.tool.and_then(|tool| Some((tool, tool.bem.as_ref()?))) {
            Some((tool, bem)) => self.solved(bem, &tool.spectra, &inputs.body.spectrum),
            None => self.shaken(inputs.record, inputs.body),
        }
    }

    /// The tool as a shaken sphere, its housing's vibration spread evenly.
    fn shaken<'a>(&self, record: &CycleRecord, source: &'a Sound) -> Result<Heard<'a>, Error> {
        let centre = self.on_axis(0.5 * tool_height(self.design));
        let analysis = &self.design.analysis;
        let settings = TransformSettings {
            range_hz: [analysis.range_low, analysis.range_high],
            ..TransformSettings::default()
        };
        let acceleration = &record.tool.acceleration;
        let transform = Transform::new(acceleration.len(), record.sample_interval, &settings)?;
        let (frequency, motion) = (transform.frequencies(), transform.apply(acceleration)?);
        let mut pressures = DMatrix::zeros(self.places.len(), frequency.len());
        let volume = self.design.body.volume();
        // The cycle counts downwards.
        let down = -Vector3::z();
        for (mut row, place) in pressures.row_iter_mut().zip(&self.places) {
            for ((p, hz), a) in row.iter_mut().zip(&frequency).zip(&motion) {
                let unit = shaken_sphere_pressure(*hz, volume, centre, down, *place, Some(self.plane), self.air)?;
                *p = unit * a;
            }
        }
        let (rigid, of_rigid) = self.of_pressures(&frequency, &pressures);
        let (mut parts, mut signals) = (vec![rigid], vec![of_rigid]);
        for (_, vibration) in source.signals.iter().skip(1) {
            let (part, signal) = self.spread(centre, vibration)?;
            parts.push(part);
            signals.push(signal);
        }
        Ok(Heard {
            radiated: &source.spectrum,
            how: if parts.len() > 1 {
                "shaken sphere, vibration of the housing spread evenly"
            } else {
                "shaken sphere"
            },
            range: source.spectrum.range_hz,
            interpolation_error: None,
            parts,
            signals: sum(signals, self.samples),
        })
    }

    /// The exhaust: jets all around from the tool's top, and the point source of the outflow.
    pub(super) fn exhaust<'a>(&self, exhaust: &Exhaust, radiated: &'a SourceSpectrum) -> Result<Heard<'a>, Error> {
        let outlet = Outlet {
            position: self.on_axis(tool_height(self.design)).into(),
            directions: jets(self.design.exhaust.thrust_share),
        };
        let floor = Floor {
            height: self.plane,
            coherence: 0.0,
        };
        let (mut parts, mut signals) = (Vec::new(), Vec::new());
        for (number, opening) in exhaust.openings.iter().enumerate() {
            let at = |(microphone, place): (usize, &Point3<f64>)| {
                let point: [f64; 3] = (*place).into();
                let recording = Recording {
                    rate: f64::from(SAMPLE_RATE),
                    samples: self.samples,
                    seed: (100 * number + microphone) as u64,
                };
                let received = opening.at(&outlet, point, Some(&floor), self.air)?;
                let signal = opening.sound_at(&outlet, point, Some(&floor), self.air, &recording)?;
                Ok::<_, Error>((received, signal))
            };
            let heard = self
                .places
                .par_iter()
                .enumerate()
                .map(at)
                .collect::<Result<Vec<_>, _>>()?;
            let frequency = opening.spectrum.frequency.clone();
            parts.push(Part {
                exposure: DMatrix::from_fn(heard.len(), frequency.len(), |i, bin| heard[i].0.exposure_density[bin]),
                frequency,
            });
            signals.push(heard.into_iter().map(|(_, signal)| signal).collect());
        }
        Ok(Heard {
            radiated,
            how: "jets all around the tool's top",
            range: radiated.range_hz,
            interpolation_error: None,
            parts,
            signals: sum(signals, self.samples),
        })
    }
}

/// Directions of jets that blow all around and, for a thrust on the tool, as much upwards as it asks for.
fn jets(thrust_share: f64) -> Vec<[f64; 3]> {
    let around = (1.0 - thrust_share * thrust_share).max(0.0).sqrt();
    if around < 1e-6 {
        return vec![[0.0, 0.0, thrust_share]];
    }
    let direction = |i: usize| {
        let (sin, cos) = (2.0 * PI * (i as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
        [around * cos, around * sin, thrust_share]
    };
    (0..AZIMUTHS).map(direction).collect()
}

/// The parts' signals together, microphone by microphone.
fn sum(parts: Vec<Vec<Vec<f64>>>, samples: usize) -> Vec<Vec<f64>> {
    let mut parts = parts.into_iter();
    let mut sum = parts.next().unwrap_or_default();
    for part in parts {
        for (sum, signal) in sum.iter_mut().zip(part) {
            sum.iter_mut().zip(signal).for_each(|(sum, p)| *sum += p);
        }
    }
    sum.iter_mut().for_each(|signal| signal.resize(samples, 0.0));
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jets_have_the_thrust_that_the_cycle_takes() {
        for share in [0.0, 0.4, 1.0, -1.0] {
            let all = jets(share);
            let mean = |i: usize| all.iter().map(|d| d[i]).sum::<f64>() / all.len() as f64;
            assert!(mean(0).abs() < 1e-12 && mean(1).abs() < 1e-12);
            assert!((mean(2) - share).abs() < 1e-12);
            assert!(
                all.iter()
                    .all(|d| (d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12)
            );
        }
    }
}
