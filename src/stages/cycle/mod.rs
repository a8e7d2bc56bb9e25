//! The nailing cycle with its lumped workpiece.
//!
//! Every tool is a network of blocks: the built-in assembly with the keys of a design ([`Cycle`]), or the assembly of
//! the design itself ([`AssembledCycle`]). Both produce a [`ShotRecord`], which is all that the chain uses.

mod of_assembly;
mod shot;

use std::sync::Arc;

use nailnoise_dynamics::network::{self, Assembly, AssemblyText, Numerics, Record, RunError};
use nailnoise_dynamics::{CycleRecord, Parameters, Settings, simulate, simulate_loads};
use serde::Serialize;

use super::{Code, Progress, Stage, Uncached, code};
use crate::error::Error;

pub(crate) use of_assembly::{UNNAMED, WORKPIECE, discharged_masses, figure_unit, outflows, stops_on_housing};
pub(crate) use shot::TOOL;
pub use shot::{
    BORE, Body, EventTimes, EventWords, NailerShot, OnWorkpiece, RETURN_WALL, ShotRecord, SummaryFigures,
    event_in_words,
};

/// One nailing cycle of the tool described by a design's keys: chamber pressures, motions, events, contact forces and
/// exhaust flow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycle {
    /// Geometry, gas, contacts and wood.
    pub parameters: Parameters,
    /// Tolerance, sample interval and end.
    pub settings: Settings,
}

impl Cycle {
    /// Computes the record, without the loads on tool and workpiece.
    ///
    /// # Errors
    /// [`Error::Cycle`] if the tool cannot be computed.
    pub fn record(&self) -> Result<CycleRecord, Error> {
        Ok(simulate(&self.parameters, &self.settings)?)
    }

    /// The same cycle with the forms as printed in the thesis.
    #[must_use]
    pub fn published(self, preset: Preset) -> Self {
        Self {
            parameters: preset.apply(self.parameters),
            ..self
        }
    }
}

/// One cycle of a tool that a design describes as an assembly of blocks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AssembledCycle {
    /// Blocks, events, openings and loads.
    pub assembly: Assembly,
    /// Tolerance and sample interval.
    pub numerics: Numerics,
    /// Where its files describe the blocks, for errors of a run.
    #[serde(skip)]
    pub places: BlockPlaces,
}

impl AssembledCycle {
    /// Computes the record.
    ///
    /// # Errors
    /// [`Error::Network`] with the place of the block at fault.
    pub fn record(&self) -> Result<Record, Error> {
        network::simulate_balanced(&self.assembly, &self.numerics).map_err(|error| self.placed(error))
    }

    /// The error of a run, with the place of the block at fault.
    pub(crate) fn placed(&self, error: RunError) -> Error {
        match &self.places.0 {
            Some(text) => text.placed(&self.assembly, error).into(),
            None => error.into(),
        }
    }
}

/// The text of an assembly. It does not distinguish cycles: results depend only on its evaluated values.
#[derive(Debug, Clone, Default)]
pub struct BlockPlaces(pub(crate) Option<Arc<AssemblyText>>);

impl PartialEq for BlockPlaces {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The cycle of a design, with its inputs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Engine {
    /// The tool described by keys.
    Keys(Box<Cycle>),
    /// The network of an assembly.
    Assembly(Box<AssembledCycle>),
}

impl Engine {
    /// Acceleration due to gravity \[m/s2\].
    pub fn gravity(&self) -> f64 {
        match self {
            Self::Keys(cycle) => cycle.parameters.ambient.gravity,
            Self::Assembly(cycle) => cycle.assembly.gravity,
        }
    }

    /// The same with another sampling interval \[s\].
    #[must_use]
    pub fn sampled(mut self, interval: f64) -> Self {
        match &mut self {
            Self::Keys(cycle) => cycle.settings.sample_interval = interval,
            Self::Assembly(cycle) => cycle.numerics.sample_interval = Some(interval),
        }
        self
    }

    /// Computes the cycle.
    ///
    /// # Errors
    /// [`Error::Cycle`] or [`Error::Network`] if the tool cannot be computed.
    pub fn shot(&self) -> Result<ShotRecord, Error> {
        match self {
            Self::Keys(cycle) => Ok(ShotRecord::of_keys(simulate_loads(&cycle.parameters, &cycle.settings)?)),
            Self::Assembly(cycle) => {
                let record = cycle.record()?;
                Ok(ShotRecord::of_assembly(&cycle.assembly, record))
            }
        }
    }
}

impl Stage for Engine {
    type Output = ShotRecord;
    type Error = Error;
    /// Computing the record takes less time than reading its 20 MB.
    type Codec = Uncached;
    const NAME: &'static str = "nailing cycle";
    const CODE: Code = code![dynamics, stages_cycle];

    fn compute(&self, _: &Progress) -> Result<ShotRecord, Error> {
        self.shot()
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
