use crate::error::AcousticsError;
use crate::matrix::real_product;
use crate::signals::fourier::{Transform, TransformSettings, Work};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, Par};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Number of bins whose products are summed at once.
const STRETCH: usize = 256;

/// Fourier transforms of modal accelerations in the bins of the analysed range.
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
    /// Combines the spectra of several bodies into one; above the highest frequency of a body, its modes do not move.
    pub fn side_by_side<'a>(bodies: &[&'a Self]) -> Cow<'a, Self> {
        if let [only] = bodies {
            return Cow::Borrowed(only);
        }
        let modes = bodies.iter().map(|s| s.accelerations.nrows()).sum();
        let widest = bodies.iter().max_by_key(|s| s.frequency.len());
        let (frequency, range_hz) = widest.map_or_else(Default::default, |s| (s.frequency.clone(), s.range_hz));
        let mut accelerations = DMatrix::zeros(modes, frequency.len());
        let mut row = 0;
        for s in bodies {
            let (rows, bins) = s.accelerations.shape();
            accelerations
                .view_mut((row, 0), (rows, bins))
                .copy_from(&s.accelerations);
            row += rows;
        }
        Cow::Owned(Self {
            frequency,
            accelerations,
            range_hz,
        })
    }

    /// The spectra of modes that are combinations of these; `modes` is the matrix modes x these.
    #[must_use]
    pub fn combined(&self, modes: &DMatrix<f64>) -> Self {
        Self {
            frequency: self.frequency.clone(),
            accelerations: real_product(modes, &self.accelerations),
            range_hz: self.range_hz,
        }
    }

    /// Transforms the acceleration records of `modes` modes, with `samples` samples at `sample_interval` \[s\].
    ///
    /// Records are requested one mode at a time, in parallel, so that at most one per thread is in memory.
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

    /// Same as `from_accelerations`, with records of several modes at once (samples x modes, each column contiguous),
    /// `block` modes at a time.
    ///
    /// # Errors
    /// Those of [`Self::from_accelerations`] and of `records`.
    pub fn from_blocks<E: From<AcousticsError> + Send>(
        modes: usize,
        block: usize,
        samples: usize,
        sample_interval: f64,
        settings: &TransformSettings,
        records: impl Fn(Range<usize>) -> Result<DMatrix<f64>, E> + Sync,
    ) -> Result<Self, E> {
        let transform = Transform::new(samples, sample_interval, settings).map_err(AcousticsError::from)?;
        let frequency = transform.frequencies();
        let first: Vec<usize> = (0..modes).step_by(block.max(1)).collect();
        let of_block = |work: &mut Work, first: usize| {
            let records = records(first..modes.min(first + block.max(1)))?;
            let rows = records
                .column_iter()
                .map(|record| transform.apply_in(record.as_slice(), work));
            Ok::<Vec<_>, E>(rows.collect::<Result<Vec<_>, _>>().map_err(AcousticsError::from)?)
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

    /// Covariance C of the modal velocities in a band, modes x modes, with a frequency weighting w(f).
    ///
    /// ```text
    /// C = 2 int w Re(a a^H) / omega^2 df
    /// ```
    ///
    /// For mode shape amplitudes phi, phi^T C phi is 2 int w |v|^2 df. `None` if the band contains fewer than two bins.
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
