//! Shots that are computed for readings: the record of the tool of the keys, or of a design's own assembly.

use std::borrow::Cow;

use nailnoise_dynamics::network::{self, Assembly, Record, RunError};
use nailnoise_dynamics::{CycleError, CycleRecord, Settings, simulate};

use crate::design::Design;
use crate::design::inputs;
use crate::error::Error;
use crate::stages::cycle::UNNAMED;

/// Integration tolerance of the cycles; it changes the depth of the head by less than 1 um.
const TOLERANCE: f64 = 1e-5;

/// Sampling interval \[s\].
const SAMPLES: f64 = 5e-5;

/// Why a shot is missing.
const REFUSED: &str = "refused";
const DRY_FIRE: &str = "dry_fire";
const SOLVER_FAILURE: &str = "solver_failure";

/// The record of a shot.
#[derive(Debug)]
pub(super) enum Shot {
    /// Of the tool described by keys.
    Keys(Box<CycleRecord>),
    /// Of an assembly.
    Assembly(Box<Record>),
}

impl Shot {
    /// The shot of a design. That of the keys is recorded until `end` \[s\], that of an assembly until the assembly's
    /// own end.
    ///
    /// # Errors
    /// Why the shot is missing: `refused`, `dry_fire` or `solver_failure`.
    pub(super) fn of(design: &Design, end: f64) -> Result<Self, &'static str> {
        if let Some(own) = inputs::assembly::cycle(design).map_err(|_| REFUSED)? {
            let numerics = network::Numerics {
                relative_tolerance: TOLERANCE,
                sample_interval: Some(SAMPLES),
                ..own.numerics
            };
            let record = network::simulate(&own.assembly, &numerics).map_err(|error| match error {
                RunError::Integration { .. } | RunError::Collapse { .. } | RunError::Chatter { .. } => SOLVER_FAILURE,
                _ => REFUSED,
            })?;
            return Ok(Self::Assembly(Box::new(record)));
        }
        let settings = Settings {
            relative_tolerance: TOLERANCE,
            sample_interval: SAMPLES,
            end,
            ..inputs::cycle::cycle_settings(design)
        };
        let parameters = inputs::cycle::parameters(design).map_err(|_| REFUSED)?;
        let record = simulate(&parameters, &settings).map_err(|error| match error {
            CycleError::DryFire { .. } => DRY_FIRE,
            CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. } => SOLVER_FAILURE,
            _ => REFUSED,
        })?;
        Ok(Self::Keys(Box::new(record)))
    }

    /// The name of its outcome.
    pub(super) fn outcome(&self) -> Cow<'static, str> {
        match self {
            Self::Keys(record) => Cow::Borrowed(record.outcome.name()),
            Self::Assembly(record) => record
                .outcome
                .as_ref()
                .map_or(Cow::Borrowed(UNNAMED), |own| Cow::Owned(own.clone())),
        }
    }
}

/// The assembly of a design at its own values; none for the tool of the keys.
///
/// # Errors
/// If the values do not yield an assembly.
pub(super) fn assembly_of(design: &Design) -> Result<Option<Assembly>, Error> {
    Ok(inputs::assembly::cycle(design)?.map(|own| own.assembly))
}

/// A history with a sampling interval at a given time, interpolated linearly; none outside the record.
pub(super) fn interpolated(values: &[f64], interval: f64, time: f64) -> Option<f64> {
    let place = time / interval;
    let index = place.floor().max(0.0) as usize;
    let (low, high) = (values.get(index)?, values.get(index + 1).or(values.get(index))?);
    Some(low + (high - low) * (place - index as f64))
}
