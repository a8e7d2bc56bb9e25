//! A tool as a network of blocks: gas volumes, passages, bodies, contacts, springs, friction, a fastener, triggers.
//!
//! An [`Assembly`] is the topology with every number in SI. It is compiled once into a plan, which is integrated into a
//! [`Record`] of named channels.
//!
//! | part | modules |
//! |---|---|
//! | description | `assembly`, `text` (its reader) |
//! | compilation | `plan`, `probe` (channels and expressions), `start` |
//! | physics | `kernels`, `delay` and `past_flows` (of flows), `rates` (right-hand side), `elements`, `jacobian` |
//! | modes | `mode`, `switching`, `signals` (triggers and gates), `events`, `watch` (changes only noted) |
//! | integration | `numerics`, `integrate`, `equations`, `linear`, `tolerances` |
//! | two-way coupling | `drive` and `wood` (a body whose motion is prescribed), `coupled` |
//! | results | `record`, `recorder` (histories), `resistance` (of the work to a fastener), `audit` (conservation) |

pub mod assembly;
mod audit;
mod coupled;
mod delay;
mod drive;
mod elements;
mod equations;
mod error;
mod events;
pub(crate) mod gas;
mod integrate;
pub(crate) mod jacobian;
mod kernels;
mod linear;
mod locate;
pub(crate) mod mode;
mod numerics;
mod past_flows;
pub(crate) mod plan;
mod probe;
pub(crate) mod rates;
mod record;
mod recorder;
mod resistance;
mod signals;
mod start;
mod switching;
mod text;
mod tolerances;
mod watch;
mod wood;

use crate::{CouplingWork, Workpiece};

pub use assembly::Assembly;
pub use error::RunError;
pub use numerics::Numerics;
pub use record::{
    Channel, ConditionChange, Effort, EventTime, FlowHistory, LedgerEntry, LoadHistory, LogEntry, Peak,
    PressureHistory, Record, StateColumn, Strike,
};
pub use resistance::FastenerResistance;
pub use text::{
    AssemblyError, AssemblyText, BUILT_IN, CYCLE, Change, Changes, DeclaredKey, Fault, FieldSpec, FieldText, FieldType,
    KeyValue, Keys, LAYOUT, Literal, PlacedBlock, PlacedError, Resolved, TableSpec, Travels, Unused,
};

/// Integrates an assembly from the trigger at t = 0 to its end.
///
/// # Errors
/// [`RunError`]: a block that no kernel supports, a tool that is not seated, a volume that vanishes, a spring beyond
/// its law, blocks that switch endlessly, or an integration that cannot continue.
pub fn simulate(assembly: &Assembly, numerics: &Numerics) -> Result<Record, RunError> {
    numerics.check(assembly.end)?;
    let plan = plan::Plan::new(assembly)?;
    integrate::integrate(&plan, numerics)
}

/// Number of times that a run is repeated at a tenth of its tolerance.
const REFINEMENTS: usize = 2;

/// Integrates an assembly like [`simulate`], and repeats the run at a tenth of the tolerance while a balance of the
/// record exceeds its limit. Errors of the integration add up over many strokes or blows.
///
/// # Errors
/// The errors of [`simulate`] at the tolerance of `numerics`.
pub fn simulate_balanced(assembly: &Assembly, numerics: &Numerics) -> Result<Record, RunError> {
    let mut numerics = *numerics;
    let mut record = simulate(assembly, &numerics)?;
    for _ in 0..REFINEMENTS {
        if record.is_certified() {
            break;
        }
        numerics.relative_tolerance *= 0.1;
        match simulate(assembly, &numerics) {
            Ok(finer) => record = finer,
            Err(_) => break,
        }
    }
    Ok(record)
}

/// Integrates an assembly like [`simulate`] with an external structure instead of one of its bodies, given by index.
/// They are coupled in both directions. The forces of other bodies act on the structure, and its motion acts on the
/// assembly. Both are consistent at every sample.
///
/// [`WoodForces::nail`](crate::WoodForces::nail) is the force of the fasteners that enter the body,
/// [`WoodForces::seat`](crate::WoodForces::seat) the sum of all others. Contacts, springs and friction between the body
/// and the ground are those of the lumped body and do not act. The force of the structure's support is output for the
/// first contact or, without contacts, for the first spring. The entry `coupling.BODY` of the ledger is the work on the
/// structure.
///
/// # Errors
/// The errors of [`simulate`], [`RunError::Workpiece`] for a body that cannot be replaced, [`RunError::Coupling`], and
/// those of the structure.
pub fn simulate_on<W: Workpiece<Error: From<RunError>>>(
    assembly: &Assembly,
    numerics: &Numerics,
    body: usize,
    wood: &mut W,
) -> Result<(Record, CouplingWork), W::Error> {
    numerics.check(assembly.end)?;
    let (plan, driven) = plan::Plan::driven(assembly, body)?;
    coupled::integrate_on(plan, driven, numerics, wood)
}
