//! Cost of one stage.

use nailnoise_fem::ModalCost;
use serde::Serialize;

/// Speed of sound used in the estimates \[m/s\].
pub(super) const SOUND_SPEED: f64 = 343.0;

/// Estimated cost of computing a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageCost {
    /// Name of the stage.
    pub stage: &'static str,
    /// Named counts that determine its cost.
    pub counts: Vec<(&'static str, f64)>,
    /// Memory \[GB\].
    pub gigabytes: f64,
    /// Processor time \[s\].
    pub cpu_seconds: f64,
    /// The keys that affect it most.
    pub keys: &'static [Remedy],
}

/// A key, and the direction in which to change it to reduce the cost: "raise" or "lower".
pub type Remedy = (&'static str, &'static str);

/// Name of the number of degrees of freedom of a body.
const DOFS: &str = "degrees of freedom";

impl StageCost {
    /// Cost of the modes of a body with this many elements.
    pub(super) fn of_modes(stage: &'static str, elements: f64, cost: ModalCost, keys: &'static [Remedy]) -> Self {
        Self {
            stage,
            counts: vec![("elements", elements), (DOFS, cost.dofs as f64), ("modes", cost.modes)],
            gigabytes: cost.gigabytes,
            cpu_seconds: cost.cpu_seconds,
            keys,
        }
    }

    /// Degrees of freedom of a body's modes; none for other stages.
    pub fn dofs(&self) -> Option<f64> {
        let own = self.counts.iter().find(|(what, _)| *what == DOFS);
        own.map(|(_, count)| *count)
    }

    /// Number of modes of a body; none for other stages.
    pub(super) fn modes(&self) -> Option<f64> {
        let own = self.counts.iter().find(|(what, _)| *what == "modes");
        own.map(|(_, count)| *count).filter(|_| self.dofs().is_some())
    }

    /// Replaces the counts and the cost of modes with those from a mesh.
    pub fn refine(&mut self, cost: &ModalCost) {
        for (what, count) in &mut self.counts {
            match *what {
                DOFS => *count = cost.dofs as f64,
                "modes" => *count = cost.modes,
                _ => {}
            }
        }
        (self.gigabytes, self.cpu_seconds) = (cost.gigabytes, cost.cpu_seconds);
    }

    /// Its counts as text: "3e6 samples, 195 modes".
    pub fn counted(&self) -> String {
        let count = |(what, count): &(&str, f64)| match *count {
            n if n < 1e6 => format!("{n:.0} {what}"),
            n => format!("{n:.1e} {what}"),
        };
        self.counts.iter().map(count).collect::<Vec<_>>().join(", ")
    }
}
