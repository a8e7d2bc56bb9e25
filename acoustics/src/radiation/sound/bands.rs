//! Energies of a shot's sound in frequency bands, at points and per solid angle.

use super::fields::Field;
use crate::radiation::ModalSpectra;
use crate::signals::Band;
use nalgebra::{DMatrix, Point3, Vector3};

/// Widest range covered by one polynomial, as a ratio of frequencies.
const WIDEST: f64 = 4.0;

/// Points and far-field directions at which the sound of a body is computed.
#[derive(Debug, Clone, Copy)]
pub struct FieldPoints<'a> {
    /// Points \[m\].
    pub points: &'a [Point3<f64>],
    /// Directions as unit vectors.
    pub directions: &'a [Vector3<f64>],
}

/// The sound of a shot around a body, in bands.
#[derive(Debug, Clone, PartialEq)]
pub struct BandSound {
    /// Sound exposure 2 int |p|² df, points x bands \[Pa² s\].
    pub exposure: DMatrix<f64>,
    /// Energy per solid angle in the far field, directions x bands \[J/sr\].
    pub directivity: DMatrix<f64>,
    /// Estimated error of interpolation over frequency, relative to the largest value per unit of any mode's
    /// acceleration.
    pub error: f64,
    /// Number of frequencies at which the field was computed.
    pub samples: usize,
}

impl BandSound {
    pub(crate) fn zeros(bands: &[Band], around: &FieldPoints<'_>) -> Self {
        Self {
            exposure: DMatrix::zeros(around.points.len(), bands.len()),
            directivity: DMatrix::zeros(around.directions.len(), bands.len()),
            error: 0.0,
            samples: 0,
        }
    }

    /// Adds squares of the pressure \[Pa² s\] and of the far field, the latter times a factor, to a band.
    pub(crate) fn add(&mut self, band: usize, exposure: &[f64], (field, factor): (&[f64], f64)) {
        self.exposure
            .column_mut(band)
            .iter_mut()
            .zip(exposure)
            .for_each(|(to, e)| *to += e);
        self.directivity
            .column_mut(band)
            .iter_mut()
            .zip(field)
            .for_each(|(to, e)| *to += factor * e);
    }
}

/// Groups of adjacent bands that share a polynomial, no wider than [`WIDEST`]; bands that satisfy `alone` form separate
/// groups.
pub(crate) fn groups(bands: &[Band], alone: impl Fn(&Band) -> bool) -> Vec<&[Band]> {
    let mut groups = Vec::new();
    let mut rest = bands;
    while let Some(first) = rest.first() {
        let fits = |b: &&Band| !alone(b) && !alone(first) && b.high <= WIDEST * first.low * (1.0 + 1e-9);
        let (group, others) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        groups.push(group);
        rest = others;
    }
    groups
}

/// Bins with nonzero weight in a band.
pub(crate) fn bins_of(weights: &[f64]) -> Vec<usize> {
    (0..weights.len()).filter(|&bin| weights[bin] != 0.0).collect()
}

/// Modal accelerations in some bins.
pub(crate) fn of_bins(spectra: &ModalSpectra, bins: &[usize]) -> Field {
    Field::from_fn(spectra.accelerations.nrows(), bins.len(), |mode, b| {
        spectra.accelerations[(mode, bins[b])]
    })
}

/// Sum over the bins (columns) of w |x|², by row.
pub(crate) fn squares(values: &Field, weights: &[f64]) -> Vec<f64> {
    let of_row = |row: usize| {
        weights
            .iter()
            .enumerate()
            .map(|(b, w)| w * values[(row, b)].norm_sqr())
            .sum()
    };
    (0..values.nrows()).map(of_row).collect()
}
