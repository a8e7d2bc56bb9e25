//! The interface between the cycle and an external workpiece.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CycleError;

/// Forces of the cycle on the wood at one instant, down on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WoodForces {
    /// F_pen, of the rod through the nail \[N\].
    pub nail: f64,
    /// z_max, deepest depth of the tip of the nail so far, which determines where F_pen acts \[m\].
    pub depth: f64,
    /// F_n + F_e, of nose and guard spring \[N\].
    pub seat: f64,
}

/// Motion of the wood at one instant, down positive.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WoodMotion {
    /// Position \[m\] and velocity \[m/s\] of the surface under the nose, the work-conjugates of
    /// [`WoodForces::seat`].
    pub seat: [f64; 2],
    /// Position and velocity of the wood that grips the nail, the work-conjugates of [`WoodForces::nail`].
    pub nail: [f64; 2],
    /// Force of the support on the wood, up \[N\].
    pub support: f64,
}

/// Derivative of the motion at the end of a step with respect to the forces there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Compliance {
    /// Positions of nail and seat (rows) by the forces of nail and seat (columns) \[m/N\].
    pub position: [[f64; 2]; 2],
    /// Velocities of the same \[m/(N s)\].
    pub velocity: [[f64; 2]; 2],
}

/// A workpiece on its support, outside the cycle.
///
/// It advances by steps of the sample interval of the cycle; within a step the forces are linear in time. The cycle
/// tries forces at the end of a step as often as it needs, and then accepts one set of them.
pub trait Workpiece {
    /// Error of the structure.
    type Error: From<CycleError>;

    /// Brings the wood to rest under its weight and the force \[N\] of the seated tool; returns its motion.
    ///
    /// # Errors
    /// There is no state of rest.
    fn start(&mut self, seat: f64) -> Result<WoodMotion, Self::Error>;

    /// Compliance with the tip of the nail at a depth \[m\]. It only accelerates the search for the forces; the
    /// compliance of the unsupported wood is sufficient.
    fn compliance(&self, depth: f64) -> Compliance;

    /// Motion at the end of the current step under trial forces there.
    ///
    /// # Errors
    /// The structure cannot compute the step.
    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;

    /// Completes the current step with these forces; returns the motion at its end.
    ///
    /// # Errors
    /// The structure cannot compute the step.
    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;
}

/// Work of a coupled run, and how well the two sides agree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CouplingWork {
    /// Steps taken together.
    pub steps: usize,
    /// Trials of forces, over all steps.
    pub trials: usize,
    /// Steps whose forces jump within every trial, so that the last trial was taken.
    pub unsettled: usize,
    /// Largest difference between a force of the cycle and that on the wood at the end of a step \[N\].
    pub mismatch: f64,
}
