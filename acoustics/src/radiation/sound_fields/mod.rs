//! Sound fields of a shot in one-third-octave bands: on surfaces, in planes and on a sphere of directions.

mod boundary_elements;
pub(crate) mod planes;
pub(crate) mod sphere;
mod velocity;

pub use boundary_elements::{SolvedSurface, boundary_element_field};
pub use planes::Cuts;
pub use velocity::velocity_field;

use crate::radiation::ModalSpectra;
use crate::signals::{Band, SourceSpectrum, Weighting, third_octaves};
use serde::{Deserialize, Serialize};

/// Reference of sound exposure, (20 uPa)² over 1 s \[Pa² s\].
const EXPOSURE: f64 = 4e-10;

/// Reference of velocity exposure, (50 nm/s)² over 1 s \[m2/s\].
const VELOCITY: f64 = 2.5e-15;

/// Range of levels shown below the highest of a field \[dB\].
const SHOWN: f64 = 60.0;

const PRESSURE: &str = "sound exposure level [dB re (20 uPa)2 s]";
const MOTION: &str = "velocity exposure level [dB re (50 nm/s)2 s]";

/// The field of one source.
pub struct SoundField {
    /// Surfaces with fields.
    pub series: Vec<FieldSeries>,
    /// Number of frequencies at which the field is computed.
    pub samples: usize,
    /// Error of the interpolation between them, relative to the largest value of the field \[-\].
    pub error: f64,
    /// Nominal mid-band frequency of the highest band \[Hz\].
    pub highest_hz: f64,
    /// Energy of the field over all bands relative to that of the source \[dB\], by name of the comparison.
    pub balances: Vec<(&'static str, f64)>,
}

/// A surface with fields, by band.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FieldSeries {
    /// Its name.
    pub name: String,
    /// Shapes that bands refer to.
    pub shapes: Vec<FieldShape>,
    /// The bands, in ascending order.
    pub bands: Vec<BandField>,
}

/// Points and polygons.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FieldShape {
    /// Positions \[m\].
    pub points: Vec<[f64; 3]>,
    /// Corners of every polygon.
    pub polygons: Vec<Vec<usize>>,
}

/// Fields of one band.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BandField {
    /// Nominal mid-band frequency \[Hz\].
    pub hz: f64,
    /// Index of its shape.
    pub shape: usize,
    /// Fields on the points: name with unit, and values.
    pub points: Vec<(String, Vec<f64>)>,
    /// Fields on the polygons.
    pub polygons: Vec<(String, Vec<f64>)>,
}

/// Complete bands within the frequencies of a spectrum and below a top frequency.
pub(crate) fn bands(spectra: &ModalSpectra, top: f64) -> Vec<Band> {
    let [low, high] = spectra.range_hz;
    let whole = |b: &Band| b.low >= low * (1.0 - 1e-9) && b.high <= high.min(top) * (1.0 + 1e-9);
    third_octaves().into_iter().filter(whole).collect()
}

/// Energy of a source in each band \[J\].
pub(crate) fn energies(source: &SourceSpectrum, bands: &[Band]) -> Vec<f64> {
    let energy = |band: &Band| source.energy([band.low, band.high], Weighting::Z);
    bands.iter().map(energy).collect()
}

/// Energy in a field relative to that of its source, both over all bands \[dB\].
pub(crate) fn balance(found: &[f64], radiated: &[f64]) -> f64 {
    10.0 * (found.iter().sum::<f64>() / radiated.iter().sum::<f64>()).log10()
}

/// 10 lg of values relative to a reference, limited to a floor below the highest.
fn decibels(values: impl Iterator<Item = f64> + Clone, reference: f64) -> Vec<f64> {
    let floor = values.clone().fold(f64::MIN_POSITIVE, f64::max) * 10f64.powf(-0.1 * SHOWN);
    values.map(|v| 10.0 * (v.max(floor) / reference).log10()).collect()
}
