//! The interface between the cycle and an external workpiece.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Forces of the cycle on the wood at one instant, positive downwards.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WoodForces {
    /// F_pen, of the rod through the nail \[N\].
    pub nail: f64,
    /// z_max, largest depth of the nail's tip so far, which determines where F_pen acts \[m\].
    pub depth: f64,
    /// F_n + F_e, of nose and guard spring \[N\].
    pub seat: f64,
}

/// Motion of the wood at one instant, positive downwards.
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

/// An external workpiece on its support.
///
/// It advances with steps of the cycle's sample interval; within a step the forces are linear in time. The cycle tries
/// forces at the end of a step as often as it needs, and then accepts one set of them.
pub trait Workpiece {
    /// Error of the structure, or of the cycle.
    type Error;

    /// Brings the wood to rest under its weight and the force of the seated tool \[N\]; returns its motion.
    ///
    /// # Errors
    /// If there is no state of rest.
    fn start(&mut self, seat: f64) -> Result<WoodMotion, Self::Error>;

    /// Compliance with the tip of the nail at a given depth \[m\]. It only accelerates the search for the forces, so
    /// the compliance of the unsupported wood suffices.
    fn compliance(&self, depth: f64) -> Compliance;

    /// Motion at the end of the current step under trial forces there.
    ///
    /// # Errors
    /// If the structure cannot compute the step.
    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;

    /// Completes the current step with these forces; returns the motion at its end.
    ///
    /// # Errors
    /// If the structure cannot compute the step.
    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;
}

/// Work counters of a coupled run, and how well the two sides agree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CouplingWork {
    /// Number of joint steps.
    pub steps: usize,
    /// Number of force trials over all steps.
    pub trials: usize,
    /// Number of steps in which forces jump in every trial, so that the last trial was accepted.
    pub unsettled: usize,
    /// Largest difference between a force of the cycle and that on the wood at the end of a step \[N\].
    pub mismatch: f64,
}
