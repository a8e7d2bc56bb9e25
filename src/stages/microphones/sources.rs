//! Sound of each source at the microphones: exposures over frequency, and signals.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{ExhaustNoise, Floor, Outlet, Recording};
use nailnoise_acoustics::radiation::radiator::Pressures;
use nailnoise_acoustics::radiation::sound::{omnidirectional_transfer, oscillating_sphere_pressure};
use nailnoise_acoustics::signals::fourier::{Transform, TransformSettings};
use nailnoise_acoustics::signals::{ChirpTransform, PowerSignals, SourceSpectrum};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use rayon::prelude::*;
use serde::Serialize;

use super::received::{Received, SourcePart};
use super::{AtMicrophones, LONGEST, MicrophoneArray, SAMPLE_RATE, TAIL};
use crate::error::Error;
use crate::stages::cycle::ShotRecord;
use crate::stages::sound::Sound;

/// Number of azimuths of the exhaust's jets; enough for the mean over them to equal that over all.
const AZIMUTHS: usize = 12;

/// Position where the exhaust's jets leave the tool, and their direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JetOutlet {
    /// Position \[m\].
    pub position: [f64; 3],
    /// Fraction of the jets' thrust that acts on the tool along the driving direction, positive towards the wood \[-\].
    pub thrust_share: f64,
}

/// The sphere with the volume of the tool.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToolSphere {
    /// Its centre \[m\].
    pub centre: [f64; 3],
    /// Its volume \[m³\].
    pub volume: f64,
}

impl MicrophoneArray {
    /// Sound of a source from its pressures at the microphones, or at the microphones and their images; all records end
    /// at `end` \[s\].
    ///
    /// # Errors
    /// The errors of the levels.
    pub fn pressures(&self, found: &Pressures, radiated: &SourceSpectrum, end: f64) -> Result<AtMicrophones, Error> {
        let exposure = self.reflected(found).map(|p| 2.0 * p.norm_sqr());
        self.of_pressures(found, exposure, radiated, end)
    }

    /// Sound of a part of a source from the pressures of the source and of the part at the same places and frequencies.
    /// Exposures are 2 Re(p_i conj p), which may have either sign and sum to that of the source over all parts; signals
    /// are those of p_i.
    ///
    /// # Errors
    /// The errors of the levels.
    pub fn part(
        &self,
        whole: &Pressures,
        part: &Pressures,
        radiated: &SourceSpectrum,
        end: f64,
    ) -> Result<AtMicrophones, Error> {
        let [all, own] = [whole, part].map(|found| self.reflected(found));
        let exposure = own.zip_map(&all, |own, all| 2.0 * (own * all.conj()).re);
        self.of_pressures(part, exposure, radiated, end)
    }

    /// Pressures at the microphones, including those reflected from the plane, which are the pressures at the
    /// microphones' images.
    fn reflected(&self, found: &Pressures) -> DMatrix<Complex<f64>> {
        let (values, places) = (&found.values, self.receivers().len());
        if values.nrows() == 2 * places {
            values.rows(0, places) + values.rows(places, places)
        } else {
            values.clone()
        }
    }

    fn of_pressures(
        &self,
        found: &Pressures,
        exposure: DMatrix<f64>,
        radiated: &SourceSpectrum,
        end: f64,
    ) -> Result<AtMicrophones, Error> {
        let receivers = Receivers::new(self, end);
        let frequency = &found.frequency;
        let mut pressures = self.reflected(found);
        let part = SourcePart {
            frequency: frequency.clone(),
            exposure,
        };
        if let Some([from, to]) = found.fade_hz {
            for (mut bin, hz) in pressures.column_iter_mut().zip(frequency) {
                let t = ((hz / from).ln() / (to / from).ln()).clamp(0.0, 1.0);
                bin.iter_mut().for_each(|p| *p *= (0.5 * PI * t).cos());
            }
        }
        let (_, signals) = receivers.of_pressures(frequency, &pressures);
        Ok(self.received(Received {
            radiated,
            how: found.method,
            range: found.range_hz,
            phases_to_hz: found.range_hz[1],
            interpolation_error: Some(found.interpolation_error),
            parts: vec![part],
            signals,
        }))
    }

    /// Sound of a source without directivity, radiated from one point; all records end at `end` \[s\].
    ///
    /// # Errors
    /// A microphone at the point; the errors of the levels.
    pub fn spread_evenly(&self, centre: [f64; 3], source: &Sound, end: f64) -> Result<AtMicrophones, Error> {
        let receivers = Receivers::new(self, end);
        let spread = |(_, signals): &(&str, PowerSignals)| receivers.spread(centre.into(), signals);
        let parts = source.signals.iter().map(spread);
        let (parts, signals): (Vec<SourcePart>, Vec<_>) = parts.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        Ok(self.received(Received {
            radiated: &source.spectrum,
            how: "omnidirectional: ERP has no directivity",
            range: source.spectrum.range_hz,
            phases_to_hz: source.spectrum.range_hz[0],
            interpolation_error: None,
            parts,
            signals: sum(signals, receivers.samples),
        }))
    }

    /// Sound of the tool as an oscillating sphere, with omnidirectional vibration of its housing; all records end at
    /// `end` \[s\].
    ///
    /// # Errors
    /// A microphone inside the sphere; the errors of the transform and levels.
    pub fn oscillating_sphere(
        &self,
        sphere: &ToolSphere,
        record: &ShotRecord,
        source: &Sound,
        end: f64,
    ) -> Result<AtMicrophones, Error> {
        let receivers = Receivers::new(self, end);
        let centre = sphere.centre.into();
        let settings = TransformSettings {
            range_hz: self.range_hz,
            ..TransformSettings::default()
        };
        let acceleration = record.tool_acceleration();
        let transform = Transform::new(acceleration.len(), record.sample_interval, &settings)?;
        let (frequency, motion) = (transform.frequencies(), transform.apply(acceleration)?);
        let mut pressures = DMatrix::zeros(receivers.positions.len(), frequency.len());
        // The cycle counts downwards as positive.
        let down = -Vector3::z();
        let plane = Some(self.reflecting_plane);
        for (mut row, place) in pressures.row_iter_mut().zip(&receivers.positions) {
            for ((p, hz), a) in row.iter_mut().zip(&frequency).zip(&motion) {
                let unit = oscillating_sphere_pressure(*hz, sphere.volume, centre, down, *place, plane, &self.air)?;
                *p = unit * a;
            }
        }
        let (rigid, of_rigid) = receivers.of_pressures(&frequency, &pressures);
        let (mut parts, mut signals) = (vec![rigid], vec![of_rigid]);
        for (_, vibration) in source.signals.iter().skip(1) {
            let (part, signal) = receivers.spread(centre, vibration)?;
            parts.push(part);
            signals.push(signal);
        }
        let (range, spread) = (source.spectrum.range_hz, parts.len() > 1);
        Ok(self.received(Received {
            radiated: &source.spectrum,
            how: if spread {
                "oscillating sphere; vibration of the housing omnidirectional"
            } else {
                "oscillating sphere"
            },
            range,
            // Of the vibration, only the energy at each frequency is known, not the phases.
            phases_to_hz: range[usize::from(!spread)],
            interpolation_error: None,
            parts,
            signals: sum(signals, receivers.samples),
        }))
    }

    /// Sound of the exhaust's openings, numbered from `first`: jets in all directions around the tool's top, and the
    /// point source of the outflow. All records end at `end` \[s\]; `noise_seed` is the seed of the jets' noise.
    ///
    /// # Errors
    /// A microphone at the outlet; the errors of the levels.
    pub fn exhaust(
        &self,
        outlet: &JetOutlet,
        (first, openings, noise_seed): (usize, &[ExhaustNoise], u32),
        radiated: &SourceSpectrum,
        end: f64,
    ) -> Result<AtMicrophones, Error> {
        let receivers = Receivers::new(self, end);
        let outlet = Outlet {
            position: outlet.position,
            directions: jets(outlet.thrust_share),
        };
        let floor = Floor {
            height: self.reflecting_plane,
            coherence: 0.0,
        };
        let (mut parts, mut signals) = (Vec::new(), Vec::new());
        for (number, opening) in (first..).zip(openings) {
            let at = |(microphone, place): (usize, &Point3<f64>)| {
                let point: [f64; 3] = (*place).into();
                let recording = Recording {
                    rate: f64::from(SAMPLE_RATE),
                    samples: receivers.samples,
                    seed: (u64::from(noise_seed) << 32) + (100 * number + microphone) as u64,
                };
                let received = opening.at(&outlet, point, Some(&floor), &self.air)?;
                let signal = opening.sound_at(&outlet, point, Some(&floor), &self.air, &recording)?;
                Ok::<_, Error>((received.exposure_density, signal))
            };
            let places = receivers.positions.par_iter().enumerate();
            let (exposures, of_opening): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
                places.map(at).collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
            let frequency = opening.spectrum.frequency.clone();
            parts.push(SourcePart {
                exposure: DMatrix::from_fn(exposures.len(), frequency.len(), |i, bin| exposures[i][bin]),
                frequency,
            });
            signals.push(of_opening);
        }
        Ok(self.received(Received {
            radiated,
            how: "jets all around the tool's top",
            range: radiated.range_hz,
            // Jets are random, so each signal is one draw.
            phases_to_hz: radiated.range_hz[1],
            interpolation_error: None,
            parts,
            signals: sum(signals, receivers.samples),
        }))
    }
}

/// The array's positions including the ear, and the length of its records.
struct Receivers<'a> {
    air: &'a Air,
    positions: Vec<Point3<f64>>,
    /// Height of the reflecting plane \[m\].
    plane: f64,
    /// Samples of a signal.
    samples: usize,
}

impl<'a> Receivers<'a> {
    /// For a shot whose records last until `end` \[s\].
    fn new(array: &'a MicrophoneArray, end: f64) -> Self {
        Self {
            air: &array.air,
            positions: array.receivers(),
            plane: array.reflecting_plane,
            samples: samples(end),
        }
    }

    /// A part and its signals from complex pressures, microphones x frequencies \[Pa s\].
    fn of_pressures(&self, frequency: &[f64], pressures: &DMatrix<Complex<f64>>) -> (SourcePart, Vec<Vec<f64>>) {
        let over_time = ChirpTransform::new(frequency, f64::from(SAMPLE_RATE), self.samples);
        let signal = |row: usize| {
            let spectrum: Vec<Complex<f64>> = pressures.row(row).iter().copied().collect();
            over_time.signal(&spectrum)
        };
        let part = SourcePart {
            frequency: frequency.to_vec(),
            exposure: pressures.map(|p| 2.0 * p.norm_sqr()),
        };
        (part, (0..pressures.nrows()).into_par_iter().map(signal).collect())
    }

    /// A part with a known energy but unknown pressures, radiated from a point.
    fn spread(&self, centre: Point3<f64>, signals: &PowerSignals) -> Result<(SourcePart, Vec<Vec<f64>>), Error> {
        let (frequency, signal) = (signals.frequency(), signals.combined_signal());
        let mut pressures = DMatrix::zeros(self.positions.len(), frequency.len());
        for (mut row, place) in pressures.row_iter_mut().zip(&self.positions) {
            let spread = omnidirectional_transfer(centre, *place, self.plane, self.air)?;
            for ((p, hz), x) in row.iter_mut().zip(frequency).zip(&signal) {
                *p = spread.pressure(*hz, *x);
            }
        }
        Ok(self.of_pressures(frequency, &pressures))
    }
}

/// Number of samples of a signal for a shot whose records last until `end` \[s\].
pub(super) fn samples(end: f64) -> usize {
    ((end + TAIL).min(LONGEST) * f64::from(SAMPLE_RATE)).ceil() as usize
}

/// Directions of jets at equally spaced azimuths, inclined upwards so that the fraction of their mean thrust on the
/// tool is `thrust_share`.
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

/// Sum of the parts' signals for each microphone.
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
