//! Shots that are computed for readings: the record of the tool of the keys, or of a design's own assembly.

use std::borrow::Cow;

use nailnoise_dynamics::network::{self, Assembly, Record, RunError};
use nailnoise_dynamics::{CycleError, CycleRecord, Outcome, Settings, simulate};

use crate::design::Design;
use crate::design::inputs;
use crate::error::Error;
use crate::stages::cycle::UNNAMED;

/// Integration tolerance of the cycles. In 66 shots of tools that agree with a calibration, it changed the depth of the
/// head by less than 11 um, times up to the end of the drive by less than 20 us, and the air by less than 0.2 %. Times
/// of the return change by up to 0.2 ms, as they do at a third of this tolerance.
const TOLERANCE: f64 = 3e-5;

/// Sampling interval \[s\].
const SAMPLES: f64 = 5e-5;

/// Time without further penetration after which the drive is complete \[s\].
const AT_REST: f64 = 5e-3;

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
    /// The shot of a design. The record of the tool of the keys ends at `end` \[s\], or at `analysis.cycle_end` if the
    /// drive, or its outcome if that is needed, is not decided by then. The record of an assembly ends as its file
    /// states.
    ///
    /// # Errors
    /// Why the shot is missing: `refused`, `dry_fire` or `solver_failure`.
    pub(super) fn of(design: &Design, end: f64, needs_outcome: bool) -> Result<Self, &'static str> {
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
        let parameters = inputs::cycle::parameters(design).map_err(|_| REFUSED)?;
        let recorded_until = |end: f64| {
            let settings = Settings {
                relative_tolerance: TOLERANCE,
                sample_interval: SAMPLES,
                end,
                ..inputs::cycle::cycle_settings(design)
            };
            simulate(&parameters, &settings).map_err(|error| match error {
                CycleError::DryFire { .. } => DRY_FIRE,
                CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. } => {
                    SOLVER_FAILURE
                }
                _ => REFUSED,
            })
        };
        let mut record = recorded_until(end)?;
        let is_decided = drive_is_complete(&record) && (!needs_outcome || outcome_is_decided(&record));
        if end < design.analysis.cycle_end && end > AT_REST && !is_decided {
            record = recorded_until(design.analysis.cycle_end)?;
        }
        Ok(Self::Keys(Box::new(record)))
    }

    /// The name of its outcome.
    pub(super) fn outcome(&self) -> Cow<'static, str> {
        match self {
            Self::Keys(record) => Cow::Borrowed(record.figures.outcome.name()),
            Self::Assembly(record) => record
                .outcome
                .as_ref()
                .map_or(Cow::Borrowed(UNNAMED), |own| Cow::Owned(own.clone())),
        }
    }
}

/// Whether no event of the outcome may follow after the end of a record.
fn outcome_is_decided(record: &CycleRecord) -> bool {
    !matches!(
        record.figures.outcome,
        Outcome::DoesNotOpen | Outcome::DoesNotRelease | Outcome::DoesNotExhaust
    )
}

/// Whether the piston has stopped on the workpiece, and the nail remains at its depth until the record ends.
fn drive_is_complete(record: &CycleRecord) -> bool {
    let depth = record.history("nail.deepest");
    let before = depth
        .len()
        .saturating_sub((AT_REST / record.sample_interval()) as usize + 1);
    record.figures.events.t9.is_some() && depth.last() == depth.get(before)
}

/// The assembly of a design at its own values; none for the tool of the keys.
///
/// # Errors
/// If the values do not yield an assembly.
pub(super) fn assembly_of(design: &Design) -> Result<Option<Assembly>, Error> {
    Ok(inputs::assembly::cycle(design)?.map(|own| own.assembly))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::collections::BTreeSet;

    use super::super::measurements::Measurements;
    use super::super::quantities::END_OF_DRIVE;
    use super::super::random::standard_normal;
    use super::super::tool::Tool;
    use super::*;

    /// With a vent of 1.5 mm2, the volume above the valve empties slowly, and the drive begins at 52 ms.
    #[test]
    fn a_record_goes_on_until_the_drive_is_complete() {
        let mut design = Design::shipped("n80cb.toml").unwrap();
        let depth = |design: &Design, end: f64| match Shot::of(design, end, false).unwrap() {
            Shot::Keys(record) => (record.figures.summary.head_depth, record.len()),
            Shot::Assembly(_) => unreachable!(),
        };
        let end = design.analysis.cycle_end;
        let (short, whole) = (depth(&design, 45e-3), depth(&design, end));
        assert!(short.1 < whole.1 && (short.0 - whole.0).abs() < 1e-6);
        design.trigger.vent_area = 1.5e-6;
        let late = depth(&design, 45e-3);
        assert_eq!(late, depth(&design, end));
        assert!(late.0 > 0.0, "{late:?}");
    }

    /// The outcome of a drive is known before the return stroke; the last events of the draws below come later.
    #[test]
    fn a_short_record_has_the_outcome_of_the_long_one() {
        let design = Design::shipped("n80cb.toml").unwrap();
        let tool = Tool::new(&design, &Measurements::default(), 1).unwrap();
        let mut outcomes = BTreeSet::new();
        for draw in 0..64 {
            let z: Vec<f64> = (0..tool.keys()).map(|k| standard_normal(7, draw, k as u64)).collect();
            let Some(drawn) = tool.design(&design, &z) else {
                continue;
            };
            let of = |end: f64| Shot::of(&drawn, end, true).map(|shot| shot.outcome().into_owned());
            let (short, long) = (of(END_OF_DRIVE), of(drawn.analysis.cycle_end));
            assert_eq!(short, long, "draw {draw}");
            outcomes.extend(long.ok());
        }
        assert!(outcomes.len() >= 4, "{outcomes:?}");
    }
}
