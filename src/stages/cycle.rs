//! The nailing cycle with its lumped workpiece.

use nailnoise_dynamics::{CycleRecord, Parameters, Settings, simulate};
use serde::Serialize;

use super::{Code, Progress, Stage, Uncached, code};
use crate::error::Error;

/// One nailing cycle: chamber pressures, motions, events, contact forces and exhaust flow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycle {
    /// Geometry, gas, contacts and wood.
    pub parameters: Parameters,
    /// Tolerance, sample interval and end.
    pub settings: Settings,
}

impl Cycle {
    /// The same cycle with the forms as printed in the thesis.
    #[must_use]
    pub fn published(self, preset: Preset) -> Self {
        Self {
            parameters: preset.apply(self.parameters),
            ..self
        }
    }
}

impl Stage for Cycle {
    type Output = CycleRecord;
    type Error = Error;
    /// Computing the record takes less time than reading its 20 MB.
    type Codec = Uncached;
    const NAME: &'static str = "nailing cycle";
    const CODE: Code = code![dynamics, stages_cycle];

    fn compute(&self, _: &Progress) -> Result<CycleRecord, Error> {
        Ok(simulate(&self.parameters, &self.settings)?)
    }
}

/// A published form of the model, which replaces the forms chosen by the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Every form as published: gas, valve, nail, impact, contacts, intake, trigger channel and refill. Leak and
    /// damping, which the thesis does not have, are excluded, and the seat diameter is the one that its valve balance
    /// needs.
    PublishedAll,
    /// Only the published nail: elastic penetration, and no impact of the rod on the nail.
    PublishedNailOnly,
}

impl Preset {
    /// Name of the preset in the output.
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
