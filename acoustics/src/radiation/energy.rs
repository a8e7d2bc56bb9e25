use super::resistance::ModalRadiation;
use crate::error::{AcousticsError, same_length};
use crate::fourier::{Transform, TransformSettings, Work};
use crate::levels::{Contribution, SourceSpectrum};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, Par};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Fourier transforms of modal accelerations on the bins of the analysed range.
#[derive(Debug, Clone)]
pub struct ModalSpectra {
    /// Frequencies of the bins \[Hz\].
    pub frequency: Vec<f64>,
    /// A(f): modes x bins; unit of the modal acceleration times seconds.
    pub accelerations: DMatrix<Complex<f64>>,
    /// Analysed range \[Hz\].
    pub range_hz: [f64; 2],
}

impl ModalSpectra {
    /// Transforms the acceleration records of `modes` modes, `samples` long at `sample_interval` \[s\].
    ///
    /// Records are asked for one mode at a time, in parallel, so that no more than one per thread need exist.
    ///
    /// # Errors
    /// See [`Transform::new`] and [`Transform::apply`].
    pub fn from_accelerations(
        modes: usize,
        samples: usize,
        sample_interval: f64,
        settings: &TransformSettings,
        record: impl Fn(usize) -> Vec<f64> + Sync,
    ) -> Result<Self, AcousticsError> {
        let transform = Transform::new(samples, sample_interval, settings)?;
        let frequency = transform.frequencies();
        let rows: Vec<Vec<Complex<f64>>> = (0..modes)
            .into_par_iter()
            .map_init(
                || transform.work(),
                |work, mode| transform.apply_in(&record(mode), work),
            )
            .collect::<Result<_, _>>()?;
        let accelerations = DMatrix::from_fn(modes, frequency.len(), |mode, bin| rows[mode][bin]);
        Ok(Self {
            frequency,
            accelerations,
            range_hz: settings.range_hz,
        })
    }

    /// The same from records of several modes at once, samples x modes, each history contiguous: `block` modes at a time.
    ///
    /// # Errors
    /// As [`Self::from_accelerations`], and those of `records`.
    pub fn from_blocks<E: From<AcousticsError> + Send>(
        modes: usize,
        block: usize,
        samples: usize,
        sample_interval: f64,
        settings: &TransformSettings,
        records: impl Fn(Range<usize>) -> Result<DMatrix<f64>, E> + Sync,
    ) -> Result<Self, E> {
        let transform = Transform::new(samples, sample_interval, settings)?;
        let frequency = transform.frequencies();
        let first: Vec<usize> = (0..modes).step_by(block.max(1)).collect();
        let of_block = |work: &mut Work, first: usize| {
            let records = records(first..modes.min(first + block.max(1)))?;
            let rows = records
                .column_iter()
                .map(|record| transform.apply_in(record.as_slice(), work));
            Ok::<Vec<_>, E>(rows.collect::<Result<Vec<_>, _>>()?)
        };
        let blocks: Vec<Vec<Vec<Complex<f64>>>> = first
            .into_par_iter()
            .map_init(|| transform.work(), of_block)
            .collect::<Result<_, _>>()?;
        let rows: Vec<Vec<Complex<f64>>> = blocks.into_iter().flatten().collect();
        let accelerations = DMatrix::from_fn(rows.len(), frequency.len(), |mode, bin| rows[mode][bin]);
        Ok(Self {
            frequency,
            accelerations,
            range_hz: settings.range_hz,
        })
    }

    /// Covariance C of the modal velocities in a band, modes x modes, with a weight w(f) of every frequency:
    ///
    /// ```text
    /// C = 2 int w Re(a a^H) / omega^2 df
    /// ```
    ///
    /// so that phi^T C phi is 2 int w |v|^2 df where the modes move by phi. None when fewer than two bins lie in the band.
    pub fn velocity_covariance(&self, [low, high]: [f64; 2], weight: impl Fn(f64) -> f64) -> Option<DMatrix<f64>> {
        let bins: Vec<usize> = (0..self.frequency.len())
            .filter(|&k| (low..high).contains(&self.frequency[k]))
            .collect();
        if bins.len() < 2 {
            return None;
        }
        let step = self.frequency[1] - self.frequency[0];
        let modes = self.accelerations.nrows();
        let mut covariance = DMatrix::zeros(modes, modes);
        let lower = BlockStructure::TriangularLower;
        let mut rows = Mat::zeros(modes, 2 * STRETCH);
        for (number, bins) in bins.chunks(STRETCH).enumerate() {
            for (column, &bin) in bins.iter().enumerate() {
                let hz = self.frequency[bin];
                let scale = (2.0 * step * weight(hz)).sqrt() / (TAU * hz);
                for (mode, a) in self.accelerations.column(bin).iter().enumerate() {
                    rows[(mode, 2 * column)] = a.re * scale;
                    rows[(mode, 2 * column + 1)] = a.im * scale;
                }
            }
            let rows = rows.as_ref().subcols(0, 2 * bins.len());
            triangular::matmul(
                MatMut::from_column_major_slice_mut(covariance.as_mut_slice(), modes, modes),
                lower,
                if number == 0 { Accum::Replace } else { Accum::Add },
                rows,
                BlockStructure::Rectangular,
                rows.transpose(),
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
        }
        covariance.fill_upper_triangle_with_lower_triangle();
        Some(covariance)
    }
}

/// Bins evaluated together: what an operator needs on its way stays in a cache and is freed again.
const STRETCH: usize = 256;

/// What `each` makes of the frequencies and motions of stretches of bins, in their order.
fn by_stretches<T: Send>(
    spectra: &ModalSpectra,
    length: usize,
    each: impl Fn(Range<usize>, &[f64], &DMatrix<Complex<f64>>) -> T + Sync,
) -> Vec<T> {
    let bins = spectra.frequency.len();
    let starts: Vec<usize> = (0..bins).step_by(length).collect();
    let of_stretch = |&start: &usize| {
        let stretch = start..bins.min(start + length);
        let motion = spectra.accelerations.columns(start, stretch.len()).into_owned();
        each(stretch.clone(), &spectra.frequency[stretch], &motion)
    };
    starts.par_iter().map(of_stretch).collect()
}

/// Rows whose forms are summed while their products are at hand.
const ROWS: usize = 256;

/// What is left of a covariance when it counts as used up, over its largest diagonal entry.
const USED_UP: f64 = 1e-12;

/// L of a symmetric, positive semidefinite C = L L^T, modes x rank, in single precision of the largest: by Cholesky's
/// factorisation with pivots, which ends with the rank of C. That is low in narrow bands.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRank(DMatrix<f32>);

impl LowRank {
    /// Of a covariance, modes x modes.
    pub fn of(covariance: &DMatrix<f64>) -> Self {
        let (order, columns) = triangle(covariance);
        let mut factor = DMatrix::zeros(order.len(), columns.len());
        for (column, mut to) in columns.iter().zip(factor.column_iter_mut()) {
            order.iter().zip(column).for_each(|(&mode, v)| to[mode] = *v as f32);
        }
        Self(factor)
    }

    /// phi^T C phi = |L^T phi|^2 for every row phi of `shapes`, C by C: the rows are read once for all of them.
    pub fn forms(of: &[Self], shapes: &DMatrix<f32>) -> Vec<Vec<f64>> {
        let ranks: Vec<usize> = of.iter().map(|own| own.0.ncols()).collect();
        let mut all = DMatrix::<f32>::zeros(shapes.ncols(), ranks.iter().sum());
        let mut first = 0;
        for (own, rank) in of.iter().zip(&ranks) {
            all.columns_mut(first, *rank).copy_from(&own.0);
            first += rank;
        }
        let blocks: Vec<usize> = (0..shapes.nrows()).step_by(ROWS).collect();
        let of_block = |moved: &mut DMatrix<f32>, first: usize| {
            let rows = ROWS.min(shapes.nrows() - first);
            let mut moved = moved.rows_mut(0, rows);
            moved.gemm(1.0, &shapes.rows(first, rows), &all, 0.0);
            let mut columns = moved.column_iter();
            let squares = |rank: &usize| {
                let mut sums = vec![0.0; rows];
                for column in columns.by_ref().take(*rank) {
                    let moved = sums.iter_mut().zip(column.iter());
                    moved.for_each(|(sum, v)| *sum += f64::from(*v) * f64::from(*v));
                }
                sums
            };
            ranks.iter().map(squares).collect::<Vec<_>>()
        };
        let blocks: Vec<Vec<Vec<f64>>> = blocks
            .into_par_iter()
            .map_init(|| DMatrix::zeros(ROWS, all.ncols()), of_block)
            .collect();
        let gather = |own: usize| blocks.iter().flat_map(|block| block[own].iter().copied()).collect();
        (0..of.len()).map(gather).collect()
    }
}

/// phi^T C phi for every row phi of `shapes` and a symmetric, positive semidefinite C, in single precision of the largest.
pub fn quadratic_forms(shapes: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let shapes = shapes.map(|v| v as f32);
    LowRank::forms(&[LowRank::of(covariance)], &shapes).swap_remove(0)
}

/// The order of the pivots, all modes, and L in that order, column by column.
fn triangle(covariance: &DMatrix<f64>) -> (Vec<usize>, Vec<Vec<f64>>) {
    let n = covariance.nrows();
    let mut rest: Vec<f64> = covariance.diagonal().iter().copied().collect();
    let least = USED_UP * rest.iter().copied().fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..n).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for k in 0..n {
        let best = (k..n).fold(k, |best, i| if rest[order[i]] > rest[order[best]] { i } else { best });
        let pivot = order[best];
        if rest[pivot].is_nan() || rest[pivot] <= least {
            break;
        }
        order.swap(k, best);
        columns.iter_mut().for_each(|column| column.swap(k, best));
        let root = rest[pivot].sqrt();
        let mut column: Vec<f64> = order.iter().map(|&i| covariance[(i, pivot)]).collect();
        for before in &columns {
            let factor = before[k];
            column[k..]
                .iter_mut()
                .zip(&before[k..])
                .for_each(|(c, b)| *c -= factor * b);
        }
        column[..k].fill(0.0);
        column[k..].iter_mut().for_each(|c| *c /= root);
        for (&i, c) in order[k..].iter().zip(&column[k..]) {
            rest[i] -= c * c;
        }
        columns.push(column);
    }
    (order, columns)
}

/// Energy of every mode: its own part of the quadratic form, twice the real part of conj(V_i) (R V)_i, integrated with the
/// given weight of every bin.
///
/// The modes sum to the whole. A mode that moves against the others takes sound from them, and its energy is negative.
///
/// # Errors
/// A number of modes that differs from the operator's, another number of weights than bins.
pub fn mode_energies(
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
    weights: &[f64],
) -> Result<Vec<f64>, AcousticsError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    same_length("weights of the bins", weights.len(), spectra.frequency.len())?;
    let of_stretch = |stretch: Range<usize>, frequency: &[f64], motion: &DMatrix<Complex<f64>>| {
        let images = radiation.images(frequency, motion);
        let mut energies = vec![0.0; radiation.modes()];
        let bins = motion.column_iter().zip(images.column_iter());
        for ((a, image), weight) in bins.zip(&weights[stretch]) {
            for ((energy, a), image) in energies.iter_mut().zip(a.iter()).zip(image.iter()) {
                *energy += 2.0 * weight * (a.conj() * image).re;
            }
        }
        energies
    };
    let mut energies = vec![0.0; radiation.modes()];
    for part in by_stretches(spectra, 2 * STRETCH, of_stretch) {
        energies.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    Ok(energies)
}

/// Energy spectrum of a surface that moves in modes, with its patches as contributions.
///
/// ```text
/// E(f) = 2 V^H R V = 2 A^H (R / omega^2) A
/// ```
///
/// # Errors
/// A number of modes that differs from the operator's, a range beyond the operator's.
pub fn radiated_energy(
    source: impl Into<String>,
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
) -> Result<SourceSpectrum, AcousticsError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    let [low, high] = spectra.range_hz;
    if high > radiation.highest_hz() * (1.0 + 1e-9) {
        let highest = radiation.highest_hz();
        return Err(AcousticsError::OutsideRange {
            what: "analysed frequency [Hz]",
            value: high,
            low: 0.0,
            high: highest,
        });
    }
    let mut forms = DMatrix::zeros(radiation.patches().len(), spectra.frequency.len());
    let of_stretch = |stretch: Range<usize>, frequency: &[f64], motion: &DMatrix<Complex<f64>>| {
        (stretch, radiation.energy_forms(frequency, motion))
    };
    for (stretch, found) in by_stretches(spectra, STRETCH, of_stretch) {
        forms.columns_mut(stretch.start, stretch.len()).copy_from(&found);
    }
    forms *= 2.0;
    let mut density = Vec::with_capacity(spectra.frequency.len());
    for mut bin in forms.column_iter_mut() {
        let total = bin.sum();
        // Interpolation leaves R semidefinite only to its error: where motions all but cancel, the sum may dip below 0.
        if total < 0.0 {
            bin.fill(0.0);
        }
        density.push(total.max(0.0));
    }
    let part = |(p, name): (usize, &String)| Contribution {
        name: name.clone(),
        energy_density: forms.row(p).iter().copied().collect(),
    };
    let contributions = radiation.patches().iter().enumerate().map(part).collect();
    let frequency = spectra.frequency.clone();
    let mut spectrum = SourceSpectrum::new(source, radiation.method(), frequency, density, [low, high])?;
    spectrum.contributions = contributions;
    Ok(spectrum)
}
