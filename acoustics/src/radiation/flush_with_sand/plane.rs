use super::Rayleigh;
use crate::checks::ReceiverError;
use crate::radiation::SampledRadiation;
use nalgebra::{Complex, DMatrix, Point3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Pressures due to the modes of a flush surface at points above the infinite rigid plane.
///
/// Pressures are computed with the travel time from `origin` removed, at the frequencies at which the resistance of the
/// surface is sampled, and interpolated in the same way.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SoundAbovePlane {
    /// Points x modes for each sample.
    #[serde(with = "crate::blocks")]
    samples: Vec<DMatrix<Complex<f64>>>,
    distances: Vec<f64>,
    sound_speed: f64,
    error: f64,
}

impl SoundAbovePlane {
    /// Computes the pressures of `surface` at `places` for the samples of its resistance.
    ///
    /// # Errors
    /// If points are below the plane, or closer to it than the quadrature of the surface resolves.
    pub fn new(
        surface: &Rayleigh,
        sampled: &SampledRadiation,
        places: &[Point3<f64>],
        origin: Point3<f64>,
    ) -> Result<Self, ReceiverError> {
        let distances: Vec<f64> = places.iter().map(|p| (p - origin).norm()).collect();
        let sound_speed = surface.air().sound_speed;
        let take = |&hz: &f64| {
            let mut pressures = surface.pressure_at(hz, places)?;
            for (mut row, r) in pressures.row_iter_mut().zip(&distances) {
                let turn = Complex::from_polar(1.0, 2.0 * PI * hz * r / sound_speed);
                row.iter_mut().for_each(|p| *p *= turn);
            }
            Ok(pressures)
        };
        let samples = sampled
            .samples_hz()
            .par_iter()
            .map(take)
            .collect::<Result<Vec<_>, ReceiverError>>()?;
        let error = sampled.error_of(&samples);
        Ok(Self {
            samples,
            distances,
            sound_speed,
            error,
        })
    }

    /// Converts to different air: multiplies frequencies by `speed`, and the pressure at each sample by `factor`.
    pub(super) fn in_air(mut self, speed: f64, factors: &[f64]) -> Self {
        self.sound_speed *= speed;
        for (sample, factor) in self.samples.iter_mut().zip(factors) {
            *sample *= Complex::from(*factor);
        }
        self
    }

    /// Appends the samples `taken` from `above`.
    pub(super) fn continued(mut self, mut above: Self, taken: &[usize]) -> Self {
        let moved = taken.iter().map(|&sample| std::mem::take(&mut above.samples[sample]));
        self.samples.extend(moved);
        self.error = self.error.max(above.error);
        self
    }

    /// Estimated interpolation error over frequency, relative to the loudest mode at the points.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Pressure, points x frequencies \[Pa s\], for modal accelerations, modes x frequencies \[m/s\].
    pub fn pressures(
        &self,
        sampled: &SampledRadiation,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let mut pressures = sampled.interpolated(frequency, &self.samples, accelerations);
        for (mut bin, hz) in pressures.column_iter_mut().zip(frequency) {
            for (p, r) in bin.iter_mut().zip(&self.distances) {
                *p *= Complex::from_polar(1.0, -2.0 * PI * hz * r / self.sound_speed);
            }
        }
        pressures
    }
}
