//! Fourier transforms of uniform records.
//!
//! ```text
//! X(f) = integral x(t) e^{-j 2 pi f t} dt  ~  dt sum_n x_n e^{-j 2 pi f n dt}
//! ```

mod real_transform;

pub use real_transform::RealTransform;

use crate::checks::{InputError, finite, positive, same_length};
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;
use std::sync::Arc;
use thiserror::Error;

/// Why a record cannot be transformed.
#[derive(Debug, Error)]
pub enum FourierError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The analysed range is empty or extends above half the sampling frequency.
    #[error("the range {low} to {high} Hz is empty or reaches above {nyquist} Hz, half the sampling frequency")]
    Range {
        /// Lower end \[Hz\].
        low: f64,
        /// Upper end \[Hz\].
        high: f64,
        /// Highest frequency the samples can represent \[Hz\].
        nyquist: f64,
    },
    /// A record is too short to be transformed.
    #[error("the record {what} has {found} samples; at least {needed} are needed")]
    ShortRecord {
        /// The record.
        what: &'static str,
        /// Its number of samples.
        found: usize,
        /// The minimum number of samples.
        needed: usize,
    },
}

/// Parameters of the transform of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransformSettings {
    /// Analysed range \[Hz\]; the retained bins cover it.
    pub range_hz: [f64; 2],
    /// Length of the cosine taper at the end of the record \[s\].
    pub taper: f64,
    /// Smallest ratio of transform length to record length; from 2 upwards, the samples of |X|² determine it
    /// everywhere.
    pub padding: f64,
}

impl Default for TransformSettings {
    /// 20 Hz to 10 kHz, a taper of 5 ms, padded to twice the record.
    fn default() -> Self {
        Self {
            range_hz: [20.0, 10_000.0],
            taper: 5e-3,
            padding: 2.0,
        }
    }
}

/// A planned transform of records of one length to the bins of the analysed range.
#[derive(Clone)]
pub struct Transform {
    fft: Arc<dyn RealToComplex<f64>>,
    samples: usize,
    sample_interval: f64,
    taper: Vec<f64>,
    first: usize,
    bins: usize,
}

/// Buffers of a [`Transform`]: padded record, spectrum and scratch.
pub(crate) struct Work {
    padded: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl std::fmt::Debug for Transform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Transform")
            .field("samples", &self.samples)
            .field("length", &self.fft.len())
            .field("first", &self.first)
            .field("bins", &self.bins)
            .finish_non_exhaustive()
    }
}

impl Transform {
    /// Plans a transform for records of `samples` values at intervals of `sample_interval` \[s\].
    ///
    /// # Errors
    /// If a record has fewer than 8 samples, an interval or padding is not positive, or the range exceeds half the
    /// sampling frequency.
    pub fn new(samples: usize, sample_interval: f64, settings: &TransformSettings) -> Result<Self, FourierError> {
        positive("sample interval [s]", sample_interval)?;
        positive("padding", settings.padding)?;
        if samples < 8 {
            return Err(FourierError::ShortRecord {
                what: "to transform",
                found: samples,
                needed: 8,
            });
        }
        let [low, high] = settings.range_hz;
        let nyquist = 0.5 / sample_interval;
        if !(low > 0.0 && high > low && high <= nyquist) {
            return Err(FourierError::Range { low, high, nyquist });
        }
        let length = fast_length((samples as f64 * settings.padding.max(1.0)).ceil() as usize);
        let df = 1.0 / (length as f64 * sample_interval);
        let first = ((low / df).floor() as usize).max(1);
        let last = ((high / df).ceil() as usize).min(length / 2);
        let tapered = ((settings.taper / sample_interval).round().max(0.0) as usize).min(samples);
        let fall = |i: usize| 0.5 * (1.0 + (PI * (i as f64 + 0.5) / tapered as f64).cos());
        Ok(Self {
            fft: RealFftPlanner::new().plan_fft_forward(length),
            samples,
            sample_interval,
            taper: (0..tapered).map(fall).collect(),
            first,
            bins: last + 1 - first,
        })
    }

    /// Spacing of the bins \[Hz\].
    pub fn resolution(&self) -> f64 {
        1.0 / (self.fft.len() as f64 * self.sample_interval)
    }

    /// Frequencies of the retained bins \[Hz\].
    pub fn frequencies(&self) -> Vec<f64> {
        let df = self.resolution();
        (self.first..self.first + self.bins).map(|k| k as f64 * df).collect()
    }

    /// X(f) of the tapered, zero-padded record at [`Self::frequencies`]; unit of x times seconds.
    ///
    /// # Errors
    /// If the record's length differs from the planned one, or values are not finite.
    pub fn apply(&self, record: &[f64]) -> Result<Vec<Complex<f64>>, FourierError> {
        self.apply_in(record, &mut self.work())
    }

    /// Workspace for [`Self::apply_in`].
    pub(crate) fn work(&self) -> Work {
        Work {
            padded: self.fft.make_input_vec(),
            spectrum: self.fft.make_output_vec(),
            scratch: self.fft.make_scratch_vec(),
        }
    }

    /// Same as [`Self::apply`] with a workspace that is reused for several records.
    pub(crate) fn apply_in(&self, record: &[f64], work: &mut Work) -> Result<Vec<Complex<f64>>, FourierError> {
        same_length("record", record.len(), self.samples)?;
        finite("record", record)?;
        let Work {
            padded,
            spectrum,
            scratch,
        } = work;
        padded[..self.samples].copy_from_slice(record);
        // The transform has overwritten it.
        padded[self.samples..].fill(0.0);
        let start = self.samples - self.taper.len();
        for (x, w) in padded[start..self.samples].iter_mut().zip(&self.taper) {
            *x *= w;
        }
        // The only possible error is a wrong buffer length, and all buffers come from the plan.
        self.fft
            .process_with_scratch(padded, spectrum, scratch)
            .map_err(|_| InputError::Length {
                what: "transform buffer",
                found: padded.len(),
                expected: self.fft.len(),
            })?;
        Ok(spectrum[self.first..self.first + self.bins]
            .iter()
            .map(|x| x * self.sample_interval)
            .collect())
    }
}

/// A uniform record after a linear filter, y = IFFT\[H(f) X(f)\], at the times of the record.
///
/// `response` is H at a frequency f >= 0 \[Hz\]. The record is padded with zeros to `padding` times its length. The
/// filter's decay after the end of the record then does not wrap around to its beginning.
///
/// # Errors
/// If the record has fewer than 8 samples, values are not finite, or an interval or padding is not positive.
pub fn filtered(
    record: &[f64],
    sample_interval: f64,
    padding: f64,
    response: impl Fn(f64) -> Complex<f64>,
) -> Result<Vec<f64>, FourierError> {
    positive("sample interval [s]", sample_interval)?;
    positive("padding", padding)?;
    finite("record", record)?;
    if record.len() < 8 {
        return Err(FourierError::ShortRecord {
            what: "to filter",
            found: record.len(),
            needed: 8,
        });
    }
    let length = fast_length((record.len() as f64 * padding.max(1.0)).ceil() as usize);
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut padded = forward.make_input_vec();
    padded[..record.len()].copy_from_slice(record);
    let mut spectrum = forward.make_output_vec();
    let buffer = |_| InputError::Length {
        what: "transform buffer",
        found: record.len(),
        expected: length,
    };
    forward.process(&mut padded, &mut spectrum).map_err(buffer)?;
    let df = 1.0 / (length as f64 * sample_interval);
    for (k, x) in spectrum.iter_mut().enumerate() {
        *x *= response(k as f64 * df) / length as f64;
    }
    // The mean and the Nyquist term of a real record are real; the phase of a response is meaningless there.
    let last = spectrum.len() - 1;
    spectrum[0].im = 0.0;
    spectrum[last].im = 0.0;
    inverse.process(&mut spectrum, &mut padded).map_err(buffer)?;
    padded.truncate(record.len());
    Ok(padded)
}

/// The smallest even length of at least `n` with no prime factor above 5.
pub(crate) fn fast_length(n: usize) -> usize {
    let mut best = n.next_power_of_two().max(2);
    let mut fives = 1;
    while fives < best {
        let mut odd = fives;
        while odd < best {
            let twos = n.div_ceil(odd).next_power_of_two().max(2);
            best = best.min(odd * twos);
            odd *= 3;
        }
        fives *= 5;
    }
    best
}
