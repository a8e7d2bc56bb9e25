//! The nailing cycle with its lumped workpiece.

use nailnoise_dynamics::{CycleRecord, Parameters, Settings, simulate};
use serde::Serialize;

use super::{Code, NotKept, Progress, Stage, code};
use crate::error::Error;

/// One nailing cycle: chamber pressures, motions, events, contact forces and exhaust flow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycle {
    /// Geometry, gas, contacts and wood.
    pub parameters: Parameters,
    /// Tolerance, sample interval and end.
    pub settings: Settings,
}

impl Stage for Cycle {
    type Output = CycleRecord;
    /// Computing the record takes less time than reading its 20 MB.
    type Codec = NotKept;
    const NAME: &'static str = "nailing cycle";
    const CODE: Code = code![dynamics, stages_cycle];

    fn compute(&self, _: &Progress) -> Result<CycleRecord, Error> {
        Ok(simulate(&self.parameters, &self.settings)?)
    }
}
