//! Motion of the bodies in third octaves.

use schemars::JsonSchema;
use serde::Serialize;

use crate::stages::motion_bands::{BandMotion, BodyBands};

/// Motion of an elastic body in one-third-octave bands, to compare with a body measured by several accelerometers.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BodyMotion {
    /// Name of the body.
    pub body: String,
    /// Its motion in each band, in ascending order.
    pub bands: Vec<MotionBand>,
}

/// Motion of a body in a one-third-octave band. The RMS values are means over the area of the outer surface and over
/// 1 s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct MotionBand {
    /// Exact mid-band frequency \[Hz\].
    pub hz: f64,
    /// Time integral of the kinetic energy \[J s\].
    pub kinetic_energy_j_s: f64,
    /// RMS normal velocity \[m/s\].
    pub rms_velocity_m_s: f64,
    /// RMS normal acceleration \[m/s2\].
    pub rms_acceleration_m_s2: f64,
}

impl From<&BodyBands> for BodyMotion {
    fn from(own: &BodyBands) -> Self {
        Self {
            body: own.body.clone(),
            bands: own.bands.iter().map(MotionBand::from).collect(),
        }
    }
}

impl From<&BandMotion> for MotionBand {
    fn from(own: &BandMotion) -> Self {
        Self {
            hz: own.hz,
            kinetic_energy_j_s: own.kinetic,
            rms_velocity_m_s: own.velocity,
            rms_acceleration_m_s2: own.acceleration,
        }
    }
}
