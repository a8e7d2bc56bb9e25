//! Second evaluation of the power of a flush surface, from the intensity on the surface, independent of the spherical
//! waves.

use super::kernel::sinc;
use super::rayleigh::Rayleigh;
use super::sources::Grid;
use crate::checks::{InputError, same_length};
use crate::radiation::operator::ModalRadiation;
use crate::radiation::packed::PackedHermitian;
use crate::radiation::resistance::Resistance;
use crate::radiation::spectra::ModalSpectra;
use crate::signals::{Band, Weighting, energy_weights};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Resistances from the intensity on a flush surface, at one frequency in each band, see
/// [`Rayleigh::surface_resistance`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfaceResistances {
    bands: Vec<Band>,
    /// Frequencies at which they are evaluated \[Hz\].
    hz: Vec<f64>,
    /// One matrix for each frequency.
    resistances: Vec<PackedHermitian>,
}

impl SurfaceResistances {
    /// Evaluates at the centres of the one-third-octave bands up to a frequency \[Hz\].
    pub fn new(surface: &Rayleigh, top_hz: f64) -> Self {
        let bands: Vec<Band> = crate::signals::third_octaves()
            .into_iter()
            .filter(|b| b.hz <= top_hz * (1.0 + 1e-9))
            .collect();
        let at = |band: &Band| {
            let r = surface.surface_resistance(band.hz);
            PackedHermitian::new(r.real.nrows(), std::iter::once(&r))
        };
        let resistances = bands.par_iter().map(at).collect();
        let hz = bands.iter().map(|band| band.hz).collect();
        Self { bands, hz, resistances }
    }

    /// Converts to different air: multiplies frequencies by `speed`, and the resistance by `factor`. The evaluation at
    /// the centre of a band then applies to another frequency of the band.
    #[must_use]
    pub(crate) fn in_air(mut self, speed: f64, factor: impl Fn(f64) -> f64) -> Self {
        self.hz.iter_mut().for_each(|hz| *hz *= speed);
        let taken = self.resistances.iter_mut().zip(&self.hz);
        taken.for_each(|(r, &hz)| r.scale(factor(hz)));
        self
    }

    /// Appends the higher bands of `above`.
    #[must_use]
    pub(crate) fn continued(mut self, above: Self) -> Self {
        let last = self.bands.last().map(|band| band.index);
        for ((band, hz), r) in above.bands.into_iter().zip(above.hz).zip(above.resistances) {
            if last.is_none_or(|last| band.index > last) {
                self.bands.push(band);
                self.hz.push(hz);
                self.resistances.push(r);
            }
        }
        self
    }

    /// The bands.
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// For each band, the ratio of the energy from the surface to that from `radiation`. R/omega² of both is taken at
    /// the same frequency of the band, so that the ratio compares the evaluations and not the motion. `None` for a
    /// silent band.
    ///
    /// # Errors
    /// If the number of modes differs.
    pub fn ratios(
        &self,
        radiation: &dyn ModalRadiation,
        spectra: &ModalSpectra,
    ) -> Result<Vec<Option<f64>>, InputError> {
        same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
        for r in &self.resistances {
            same_length("rows of a resistance", r.modes(), radiation.modes())?;
        }
        let ratio = |((band, hz), surface): ((&Band, &f64), &PackedHermitian)| {
            let weights = energy_weights(&spectra.frequency, [band.low, band.high], Weighting::Z);
            let bins: Vec<usize> = (0..weights.len()).filter(|&bin| weights[bin] != 0.0).collect();
            let motion = DMatrix::from_fn(radiation.modes(), bins.len(), |mode, b| {
                spectra.accelerations[(mode, bins[b])] * weights[bins[b]].sqrt()
            });
            let energy = |r: &Resistance| -> f64 {
                let images = r.product(&motion);
                motion
                    .iter()
                    .zip(images.iter())
                    .map(|(a, x): (&Complex<f64>, _)| (a.conj() * x).re)
                    .sum()
            };
            let waves = energy(&radiation.resistance(*hz));
            (waves > 0.0).then(|| energy(&surface.matrix(0, 1.0)) / waves)
        };
        let taken = self.bands.par_iter().zip(&self.hz).zip(&self.resistances);
        Ok(taken.map(ratio).collect())
    }
}

impl Rayleigh {
    /// Resistance of the complete surface, including moving sand, at the frequency `hz`, from a sum over pairs of
    /// points.
    ///
    /// ```text
    /// R_ij = rho0 omega^2/(2 pi c0) sum_ab q_ai* K_ab q_bj        q = S phi, K_ab = sin(k r_ab)/(k r_ab)
    /// ```
    ///
    /// It is the real part of the pressure on the surface times the velocity there. In contrast,
    /// [`Rayleigh::resistance`] sums the spherical waves that carry the power away. Both apply the same factor for
    /// absorbing sand.
    pub fn surface_resistance(&self, hz: f64) -> Resistance {
        let k = 2.0 * PI * hz / self.air().sound_speed;
        let (points, sources) = self.own_sources();
        let axis = |points: &[[f64; 2]], i: usize| points.iter().map(|p| p[i]).collect::<Vec<f64>>();
        let (x, y) = (axis(points, 0), axis(points, 1));
        let mut real = own_pairs(k, [&x, &y], sources);
        let mut imaginary = None;
        if let Some((sand, followers)) = self.moving_sand(hz) {
            // The sand has many points because its waves are short; waves in air need fewer.
            let grid = Grid::new(sand.extent, k);
            let [re, im] = sand.carried(&grid, &followers);
            let places = grid.points();
            let (sand_x, sand_y) = (axis(&places, 0), axis(&places, 1));
            let mut kernel = DMatrix::zeros(points.len(), places.len());
            for (place, mut column) in places.iter().zip(kernel.column_iter_mut()) {
                sinc(k, *place, [&x, &y], column.as_mut_slice());
            }
            let leaders = sand.edge.nrows();
            let mut both = DMatrix::zeros(places.len(), 2 * leaders);
            both.columns_mut(0, leaders).copy_from(&re);
            both.columns_mut(leaders, leaders).copy_from(&im);
            // Coupling of the points that follow edge points with the surface and with each other.
            let on_surface = sources.transpose() * (kernel * &both);
            let within = own_pairs(k, [&sand_x, &sand_y], &both);
            let within = (&within + within.transpose()) * 0.5;
            let within = |i: usize, j: usize| within.view((i * leaders, j * leaders), (leaders, leaders));
            let edge = &sand.edge;
            let across = [0, 1].map(|part| on_surface.columns(part * leaders, leaders) * edge);
            real += &across[0] + across[0].transpose() + edge.transpose() * (within(0, 0) + within(1, 1)) * edge;
            let skew = &across[1] - across[1].transpose() + edge.transpose() * (within(0, 1) - within(1, 0)) * edge;
            imaginary = Some((&skew - skew.transpose()) * 0.5);
        }
        Resistance {
            real: (&real + real.transpose()) * 0.5,
            imaginary,
        }
        .scaled(self.factor(hz))
    }
}

/// Phi^T S K S Phi over all pairs of some points, up to its antisymmetric part, in chunks.
fn own_pairs(k: f64, [x, y]: [&[f64]; 2], sources: &DMatrix<f64>) -> DMatrix<f64> {
    const CHUNK: usize = 256;
    let n = x.len();
    let mut result = DMatrix::zeros(sources.ncols(), sources.ncols());
    for start in (0..n).step_by(CHUNK) {
        let columns = CHUNK.min(n - start);
        let chunk = start..start + columns;
        // Pairs of this chunk with later ones, which count twice.
        let mut kernel = DMatrix::zeros(columns, n - start);
        for (j, mut column) in kernel.column_iter_mut().enumerate() {
            let from = [x[start + j], y[start + j]];
            sinc(k, from, [&x[chunk.clone()], &y[chunk.clone()]], column.as_mut_slice());
            if j >= columns {
                column *= 2.0;
            }
        }
        let felt = kernel * sources.rows(start, n - start);
        result += sources.rows(start, columns).transpose() * felt;
    }
    result
}
