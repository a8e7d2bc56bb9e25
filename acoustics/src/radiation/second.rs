//! The power of a flush surface once more: from the intensity on the surface, beside that of the plane waves it sends.

use super::archive::{Archive, ArchiveReader, ArchiveWriter};
use super::energy::ModalSpectra;
use super::rayleigh::Rayleigh;
use super::resistance::{ModalRadiation, Resistance};
use super::roots::image;
use crate::error::{AcousticsError, same_length};
use crate::levels::{Band, Weighting, energy_weights};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Resistances by the intensity on a flush surface in the middle of some bands, see [`Rayleigh::surface_resistance`].
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceEvaluations {
    bands: Vec<Band>,
    resistances: Vec<Resistance>,
}

impl SurfaceEvaluations {
    /// In the middle of the one-third-octave bands up to a frequency \[Hz\].
    pub fn new(surface: &Rayleigh, top_hz: f64) -> Self {
        let bands: Vec<Band> = crate::levels::third_octaves()
            .into_iter()
            .filter(|b| b.hz <= top_hz * (1.0 + 1e-9))
            .collect();
        let resistances = bands
            .par_iter()
            .map(|band| single(surface.surface_resistance(band.hz)))
            .collect();
        Self { bands, resistances }
    }

    /// The bands.
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Energy of each band by the surface over that by `radiation`, whose R/omega² both are frozen in the middle of the
    /// band: what differs is the evaluation, not the motion. None for a silent band.
    ///
    /// # Errors
    /// A number of modes that differs.
    pub fn ratios(
        &self,
        radiation: &dyn ModalRadiation,
        spectra: &ModalSpectra,
    ) -> Result<Vec<Option<f64>>, AcousticsError> {
        same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
        for r in &self.resistances {
            same_length("rows of a resistance", r.real.nrows(), radiation.modes())?;
        }
        let ratio = |(band, surface): (&Band, &Resistance)| {
            let weights = energy_weights(&spectra.frequency, [band.low, band.high], Weighting::Z);
            let bins: Vec<usize> = (0..weights.len()).filter(|&bin| weights[bin] != 0.0).collect();
            let motion = DMatrix::from_fn(radiation.modes(), bins.len(), |mode, b| {
                spectra.accelerations[(mode, bins[b])] * weights[bins[b]].sqrt()
            });
            let energy = |r: &Resistance| -> f64 {
                let images = image(r, &motion);
                motion
                    .iter()
                    .zip(images.iter())
                    .map(|(a, x): (&Complex<f64>, _)| (a.conj() * x).re)
                    .sum()
            };
            let waves = energy(&radiation.resistance(band.hz));
            (waves > 0.0).then(|| energy(surface) / waves)
        };
        Ok(self.bands.par_iter().zip(&self.resistances).map(ratio).collect())
    }
}

impl Rayleigh {
    /// Resistance of the whole surface, sand that moves along included, at the frequency `hz`, pair by pair of points:
    ///
    /// ```text
    /// R_ij = rho0 omega^2/(2 pi c0) sum_ab q_ai* K_ab q_bj        q = S phi, K_ab = sin(k r_ab)/(k r_ab)
    /// ```
    ///
    /// the real part of the pressure on the surface times the velocity there, while [`Rayleigh::resistance`] sums the
    /// plane waves in all directions. Both take the same share off for sand that absorbs.
    pub fn surface_resistance(&self, hz: f64) -> Resistance {
        const CHUNK: usize = 256;
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let (points, real, imaginary) = self.all_sources(hz);
        let n = points.len();
        let modes = real.ncols();
        let starts: Vec<usize> = (0..n).step_by(CHUNK).collect();
        let mut whole = Resistance::zeros(modes);
        let mut skew = DMatrix::zeros(modes, modes);
        for &start in &starts {
            let rows = CHUNK.min(n - start);
            let here = |m: &DMatrix<f64>| m.rows(start, rows).transpose();
            // Pairs of this chunk and those after it, which count twice.
            let kernel = DMatrix::from_fn(rows, n - start, |i, j| {
                let (a, b) = (points[start + i], points[start + j]);
                let kr = k * (a[0] - b[0]).hypot(a[1] - b[1]);
                let twice = if j < rows { 1.0 } else { 2.0 };
                twice * if kr < 1e-8 { 1.0 } else { kr.sin() / kr }
            });
            let on_real = &kernel * real.rows(start, n - start);
            whole.real += here(&real) * &on_real;
            if let Some(imaginary) = &imaginary {
                let on_imaginary = &kernel * imaginary.rows(start, n - start);
                whole.real += here(imaginary) * &on_imaginary;
                skew += here(&real) * on_imaginary - here(imaginary) * on_real;
            }
        }
        let half = |m: &DMatrix<f64>, sign: f64| (m + sign * m.transpose()) * 0.5;
        Resistance {
            real: half(&whole.real, 1.0),
            imaginary: imaginary.is_some().then(|| half(&skew, -1.0)),
        }
        .scaled(self.factor(hz))
    }
}

/// Rounds to single precision, in which resistances are kept in files: a result does not depend on whether they were.
fn single(mut r: Resistance) -> Resistance {
    let round = |m: &mut DMatrix<f64>| m.iter_mut().for_each(|v| *v = f64::from(*v as f32));
    round(&mut r.real);
    r.imaginary.as_mut().map(round);
    r
}

impl Archive for SurfaceEvaluations {
    fn write(&self, to: &mut ArchiveWriter) {
        to.count(self.resistances.first().map_or(0, |r| r.real.nrows()));
        to.count(self.bands.len());
        for (band, r) in self.bands.iter().zip(&self.resistances) {
            to.numbers(&[f64::from(band.index)]);
            to.hermitian(r);
        }
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let modes = from.count()?;
        let (mut bands, mut resistances) = (Vec::new(), Vec::new());
        for _ in 0..from.count()? {
            let [index] = from.numbers()?;
            bands.push(Band::new(index as i32));
            resistances.push(from.hermitian(modes)?);
        }
        Ok(Self { bands, resistances })
    }
}
