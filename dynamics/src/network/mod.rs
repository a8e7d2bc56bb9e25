//! A tool as a network of blocks: gas volumes, passages, bodies, contacts, springs, friction, a fastener, triggers.
//!
//! An [`Assembly`] is the topology with every number in SI. It is compiled once into a plan, which is integrated into a
//! [`Record`] of named channels.
//!
//! | part | modules |
//! |---|---|
//! | description | `assembly`, `text` (its reader) |
//! | compilation | `plan`, `probe` (channels and expressions), `start` |
//! | physics | `kernels`, `rates` (right-hand side), `jacobian` |
//! | modes | `mode`, `switching`, `signals` (triggers and gates), `events`, `watch` (changes only noted) |
//! | integration | `integrate`, `equations`, `linear`, `tolerances` |
//! | results | `record`, `audit` (conservation) |

pub mod assembly;
mod audit;
mod equations;
mod error;
mod events;
mod integrate;
pub(crate) mod jacobian;
mod kernels;
mod linear;
pub(crate) mod mode;
pub(crate) mod plan;
mod probe;
pub(crate) mod rates;
mod record;
mod signals;
mod start;
mod switching;
mod text;
mod tolerances;
mod watch;

pub use assembly::Assembly;
pub use error::RunError;
pub use record::{
    Channel, Effort, EventTime, FlowHistory, LedgerEntry, LoadHistory, LogEntry, Peak, PressureHistory, Record, Strike,
};
pub use text::{AssemblyError, AssemblyText, BUILT_IN, DeclaredKey, Fault, KeyValue, Keys, Literal, Resolved};

use crate::Method;

/// Settings for integrating and sampling an assembly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numerics {
    /// Integration method.
    pub method: Method,
    /// Integration tolerance as a fraction of the characteristic size of each state \[-\].
    pub relative_tolerance: f64,
    /// Sampling interval \[s\]; none to compute only events and ledger.
    pub sample_interval: Option<f64>,
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            method: Method::Bdf,
            relative_tolerance: 1e-7,
            sample_interval: Some(4e-6),
        }
    }
}

impl Numerics {
    fn check(&self, end: f64) -> Result<(), RunError> {
        let interval = self.sample_interval.unwrap_or(1.0);
        let rules = [
            (
                "relative_tolerance",
                self.relative_tolerance,
                self.relative_tolerance > 0.0 && self.relative_tolerance <= 1e-2,
                "above 0 and at most 0.01",
            ),
            ("sample_interval", interval, interval >= 1e-8, "at least 10 ns"),
            ("end", end, end > 0.0 && end <= 10.0, "above 0 s and at most 10 s"),
        ];
        match rules.into_iter().find(|(.., ok, _)| !ok) {
            Some((name, value, _, rule)) => Err(RunError::Value { name, value, rule }),
            None => Ok(()),
        }
    }
}

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
