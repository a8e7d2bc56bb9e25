//! The second evaluation of a source's power, the share of each mode, and the uncertainty of the method.

use super::loading_report::FluidLoading;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Band in which the true level is expected around the predicted one, from the method only: it excludes the uncertainty
/// of the design's values.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Uncertainty {
    /// How much lower the true level may be \[dB\]; null if the method gives no bound.
    pub minus: Option<f64>,
    /// How much higher it may be \[dB\]; null if the method gives no bound.
    pub plus: Option<f64>,
    /// Origin of the band.
    pub basis: String,
}

/// Power of a vibrating surface, evaluated in two ways and with radiation efficiency 1: from boundary elements, in sand
/// from Rayleigh's integral, or for a rigid tool in closed form as a sphere of equal volume.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RadiationReport {
    /// Transition from boundary elements to the high-frequency limit: start and end \[Hz\]. Rayleigh's integral and the
    /// closed form need no limit; both values are then twice the upper end of the range.
    pub join_hz: [f64; 2],
    /// Upper ends of single-frequency solutions and of boundary elements averaged over neighbouring frequencies \[Hz\];
    /// for Rayleigh's integral and the closed form, twice the upper end of the range.
    pub solved_hz: [f64; 2],
    /// Number of frequencies at which the radiation matrix was computed, excluding those of averages; for the closed
    /// form, the number of frequencies of the spectrum.
    pub frequencies: usize,
    /// Largest interpolation error of the matrix over frequency: root mean square over the entries, relative to
    /// sqrt(R_ii R_jj) \[-\].
    pub interpolation_error: f64,
    /// A-weighted level from the intensity on the surface minus that from the far field, below the transition \[dB\];
    /// null if silent.
    pub surface_difference_db: Option<f64>,
    /// Level of the limit minus that of the boundary elements in their last three bands, lowest and highest \[dB\]: the
    /// possible error of the limit above. Zero if the limit is not used.
    pub limit_error_db: [f64; 2],
    /// The same difference over the uppermost third of an octave of the boundary elements, where the limit takes over
    /// \[dB\]; null if silent or if the limit is not used.
    pub blend_error_db: Option<f64>,
    /// A-weighted level for radiation efficiency 1 over the source's range \[dB re 1 pW s\]; null if silent.
    pub erp_lwa_db: Option<f64>,
    /// Changes due to fluid loading; null if the loads on the modes are unknown.
    pub fluid_loading: Option<FluidLoading>,
    /// The contribution of each mode; the shares sum to one. Empty for a rigid tool.
    pub modes: Vec<ModeShare>,
    /// One-third-octave bands.
    pub bands: Vec<RadiationBand>,
}

/// The contribution of a mode to the A-weighted energy of its source: twice the real part of conj(V_i) (R V)_i,
/// integrated over the range.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ModeShare {
    /// `workpiece` or `worktable`.
    pub body: Cow<'static, str>,
    /// Its number from 1; null for all static corrections combined.
    pub mode: Option<usize>,
    /// Its frequency \[Hz\].
    pub hz: Option<f64>,
    /// Damping ratio that radiation adds to it \[-\]; null if radiation damping is not modelled.
    pub radiation_damping: Option<f64>,
    /// Added mass of the air at its resonance, relative to the modal mass \[-\], an upper bound above the range of
    /// boundary elements; null if the method provides no reactance.
    pub added_mass: Option<f64>,
    /// Frequency shift due to the added mass \[Hz\], which occurs only if the mass acts.
    pub shift_hz: Option<f64>,
    /// Share of the source's A-weighted energy \[-\]; negative for a mode that absorbs sound from others.
    pub share: f64,
}

/// One band of a [`RadiationReport`], unweighted \[dB re 1 pW s\]; null if silent.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct RadiationBand {
    /// Nominal mid-band frequency (IEC 61260-1) \[Hz\].
    pub hz: f64,
    /// From the far field.
    pub lw_db: Option<f64>,
    /// From the intensity on the surface; null above the boundary elements' range.
    pub surface_lw_db: Option<f64>,
    /// With radiation efficiency 1.
    pub erp_lw_db: Option<f64>,
    /// From the high-frequency limit, where boundary elements are available too; null elsewhere.
    pub limit_lw_db: Option<f64>,
}

impl Uncertainty {
    /// How much lower and how much higher the true level may be \[dB\].
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.minus, self.plus]
    }
}
