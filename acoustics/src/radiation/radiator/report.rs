//! The second evaluation of a source's power, the share of each mode, and the uncertainty of the method.

use super::loading_report::FluidLoading;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Band in which the true level is expected around the one predicted, from the method only: it excludes the uncertainty
/// of the design's values.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Uncertainty {
    /// How much lower the true level may be \[dB\]; null when the method gives no bound.
    pub minus: Option<f64>,
    /// How much higher it may be \[dB\]; null when the method gives no bound.
    pub plus: Option<f64>,
    /// Where the band comes from.
    pub basis: String,
}

/// Power of a vibrating surface by boundary elements, in sand by Rayleigh's integral, or of a rigid tool as the sphere
/// of its volume in closed form, evaluated twice, with that of radiation efficiency 1.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RadiationReport {
    /// Where boundary elements give way to the limit of high frequencies: beginning and end of the blend \[Hz\]; by
    /// Rayleigh's integral and in closed form, which need no limit, twice the top of the range.
    pub join_hz: [f64; 2],
    /// Up to where every single frequency is solved, and up to where boundary elements are known in the mean over
    /// neighbouring frequencies \[Hz\]; by Rayleigh's integral and in closed form twice the top of the range.
    pub solved_hz: [f64; 2],
    /// Frequencies at which the radiation matrix was computed, those of means not counted; those of the spectrum in
    /// closed form.
    pub frequencies: usize,
    /// Largest interpolation error of the matrix over frequency, root mean square of the entries relative to
    /// sqrt(R_ii R_jj) \[-\].
    pub interpolation_error: f64,
    /// A-weighted level by the intensity on the surface less that by the far field, below the blend \[dB\]; null when
    /// silent.
    pub surface_difference_db: Option<f64>,
    /// Level of the limit less that of the boundary elements in their last three bands, lowest and highest \[dB\]: the
    /// possible error of the limit above. Zero if there is none.
    pub limit_error_db: [f64; 2],
    /// The same over the uppermost third of an octave of the boundary elements, where the limit takes over \[dB\]; null
    /// when silent or if there is no limit.
    pub blend_error_db: Option<f64>,
    /// A-weighted level of radiation efficiency 1 over the source's range \[dB re 1 pW s\]; null when silent.
    pub erp_lwa_db: Option<f64>,
    /// What fluid loading changes; null where its loads on the modes are not known.
    pub fluid_loading: Option<FluidLoading>,
    /// The contribution of each mode; the shares sum to one. None of a rigid tool.
    pub modes: Vec<ModeShare>,
    /// One-third-octave bands.
    pub bands: Vec<RadiationBand>,
}

/// The contribution of a mode to the A-weighted energy of its source, twice the real part of conj(V_i) (R V)_i over the
/// range.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ModeShare {
    /// `workpiece` or `worktable`.
    pub body: Cow<'static, str>,
    /// Its number from 1; null for all static corrections together.
    pub mode: Option<usize>,
    /// Its frequency \[Hz\].
    pub hz: Option<f64>,
    /// Damping ratio that radiation adds to it \[-\]; null where radiation does not damp.
    pub radiation_damping: Option<f64>,
    /// Mass of air that moves along at its resonance, relative to its own \[-\], an upper bound above the range of
    /// boundary elements; null where the method gives no reactance.
    pub added_mass: Option<f64>,
    /// By how much that moves its frequency \[Hz\]; it does where the mass acts.
    pub shift_hz: Option<f64>,
    /// Part of the source's A-weighted energy \[-\]; negative for a mode that takes sound from others.
    pub share: f64,
}

/// One band of a [`RadiationReport`], unweighted \[dB re 1 pW s\]; null when silent.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
pub struct RadiationBand {
    /// Nominal mid-band frequency (IEC 61260-1) \[Hz\].
    pub hz: f64,
    /// By the far field.
    pub lw_db: Option<f64>,
    /// By the intensity on the surface; null above the boundary elements' range.
    pub surface_lw_db: Option<f64>,
    /// With radiation efficiency 1.
    pub erp_lw_db: Option<f64>,
    /// By the limit of high frequencies, where boundary elements are known too; null elsewhere.
    pub limit_lw_db: Option<f64>,
}

impl Uncertainty {
    /// How much lower and how much higher the true level may be \[dB\].
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.minus, self.plus]
    }
}
