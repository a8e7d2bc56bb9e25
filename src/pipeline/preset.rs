//! The cycle of a design in the forms the thesis printed, for comparison with the corrected ones.

use nailnoise_dynamics::{CycleRecord, Parameters, simulate};

use super::{cycle_settings, parameters};
use crate::design::Design;
use crate::error::Error;

/// A published form of the model, put in the place of the forms that the design chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Every form as published: gas, valve, nail, impact, contacts, intake, trigger channel and refill; without the
    /// leak and the damping that the thesis does not have, and with the seat diameter its valve balance needs.
    PublishedAll,
    /// The published nail alone: elastic penetration, and no impact of the rod on the nail.
    PublishedNailOnly,
}

impl Preset {
    /// Its name, as in the output.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PublishedAll => "published_all",
            Self::PublishedNailOnly => "published_nail_only",
        }
    }

    /// The parameters with the published forms.
    pub fn apply(self, parameters: Parameters) -> Parameters {
        match self {
            Self::PublishedAll => parameters.published_all(),
            Self::PublishedNailOnly => parameters.published_nail_only(),
        }
    }
}

/// Computes the nailing cycle of a design in a published form.
///
/// # Errors
/// As [`cycle`](super::cycle).
pub fn cycle_as_published(design: &Design, preset: Preset) -> Result<CycleRecord, Error> {
    Ok(simulate(&preset.apply(parameters(design)?), &cycle_settings(design))?)
}
