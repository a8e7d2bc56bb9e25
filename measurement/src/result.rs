//! Results of a wrapping test: levels of its configurations, sources and intervals; accelerations and markers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::manifest::Setup;
use super::repeats::RepeatedLevel;
use super::subtraction::Reading;
use super::wrapping::Configuration;

/// Layout of the result.
pub const SCHEMA: &str = "nailnoise-measurement/1";

/// Result of `nailnoise measure`. All levels are A-weighted single-event sound power levels L_WA,1s \[dB re 1 pW s\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasurementResult {
    /// Layout: `nailnoise-measurement/1`.
    pub schema: String,
    /// File of the manifest.
    pub manifest: String,
    /// Support of the workpiece.
    pub setup: Setup,
    /// Area of the measurement surface \[m2\].
    pub area_m2: f64,
    /// Correction for the room \[dB\]. The background correction K1 is 0, because the residual is subtracted line by
    /// line.
    pub k2_db: f64,
    /// Range of the levels \[Hz\].
    pub range_hz: [f64; 2],
    /// How the residual was subtracted.
    pub processing: Processing,
    /// The configurations as recorded.
    pub configurations: Vec<MeasuredConfiguration>,
    /// The sources: configurations 3 to 5 minus the residual.
    pub sources: Vec<MeasuredSource>,
    /// Upper bound for the workpiece: the total minus exhaust and body.
    pub bound: Option<MeasuredBound>,
    /// The total minus the level of the sum of the three sources \[dB\].
    pub closure_db: Option<f64>,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// How the residual was subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Processing {
    /// Which lines are set to zero.
    pub reading: Reading,
    /// Whether each repeat uses the residual of the same repeat instead of the mean.
    pub paired: bool,
    /// Whether the residual is also subtracted from the total.
    pub total_less_residual: bool,
}

/// Level of a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredBand {
    /// Nominal mid-band frequency \[Hz\].
    pub hz: f64,
    /// Mean of the repeats' levels \[dB re 1 pW s\]; none if nothing is left.
    pub lwa_db: Option<f64>,
}

/// Level between two markers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredInterval {
    /// First marker.
    pub from: String,
    /// Last marker.
    pub to: String,
    /// Mean times of both from the trigger \[s\].
    pub seconds: [f64; 2],
    /// Mean level of the repeats that show both \[dB re 1 pW s\]; interval ends are accurate to 1.5 ms.
    pub lwa_db: Option<f64>,
}

/// An accelerometer in a configuration, averaged over the repeats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredAcceleration {
    /// Its name.
    pub name: String,
    /// Root mean square over 1 s \[g\].
    pub rms_g: f64,
    /// Peak \[g\].
    pub peak_g: f64,
}

/// A marker in a configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredMarker {
    /// Its name.
    pub name: String,
    /// Event of the cycle, if it has a counterpart.
    pub event: Option<String>,
    /// What happens.
    pub meaning: String,
    /// Number of repeats that show it.
    pub repeats: usize,
    /// Mean time from the trigger \[s\].
    pub seconds: f64,
    /// Standard deviation over the repeats \[s\]; none for a single repeat.
    pub deviation_s: Option<f64>,
}

/// A configuration as recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredConfiguration {
    /// What it measures.
    pub configuration: Configuration,
    /// Its name, such as `W-1`.
    pub name: String,
    /// Level as recorded.
    pub level: Option<RepeatedLevel>,
    /// Level above the residual \[dB\]; below 3 dB, the subtraction is not reliable.
    pub above_residual_db: Option<f64>,
    /// Levels by one-third octave as recorded.
    pub bands: Vec<MeasuredBand>,
    /// Levels between markers as recorded.
    pub intervals: Vec<MeasuredInterval>,
    /// Accelerometers.
    pub accelerations: Vec<MeasuredAcceleration>,
    /// Markers.
    pub markers: Vec<MeasuredMarker>,
    /// Delay of each repeat relative to the first shot of the first configuration, from the acceleration of the handle
    /// or table \[s\].
    pub delays_s: Vec<Option<f64>>,
}

/// A source after subtraction of the residual.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredSource {
    /// Its name.
    pub source: String,
    /// Configuration that measured it.
    pub configuration: String,
    /// Level from lines.
    pub level: Option<RepeatedLevel>,
    /// Level from energies over the range, without a limit; none if the residual is larger. It has no bias but more
    /// scatter.
    pub by_energy_db: Option<f64>,
    /// Level that a silent source would yield from lines \[dB re 1 pW s\]; nothing lower can be measured.
    pub floor_db: Option<f64>,
    /// Share of the recorded energy in lines set to zero by the limit.
    pub zeroed_share: f64,
    /// Share of the remaining energy that lies before the trigger.
    pub before_trigger_share: f64,
    /// One-third-octave levels from lines.
    pub bands: Vec<MeasuredBand>,
    /// One-third-octave levels from band energies.
    pub bands_by_energy: Vec<MeasuredBand>,
    /// Number of bands whose energy does not exceed the residual's.
    pub negative_bands: usize,
    /// Levels between markers.
    pub intervals: Vec<MeasuredInterval>,
}

/// Upper bound of the workpiece.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredBound {
    /// The total minus exhaust and body, from lines.
    pub level: Option<RepeatedLevel>,
    /// The same with exhaust and body from energies, which have no bias.
    pub by_energy_db: Option<f64>,
    /// One-third-octave levels, from lines.
    pub bands: Vec<MeasuredBand>,
    /// Number of bands in which nothing is left.
    pub negative_bands: usize,
}
