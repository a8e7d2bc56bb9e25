//! The wood as a structure outside the cycle: what the cycle asks of it.

use serde::{Deserialize, Serialize};

use crate::CycleError;

/// Forces of the cycle on the wood at one instant, down on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct WoodForces {
    /// F_pen, of the rod through the nail \[N\].
    pub nail: f64,
    /// z_max, deepest depth of the nail's tip so far: where along the nail F_pen acts \[m\].
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
    /// The same of what holds the nail: its velocity is that which gives with [`WoodForces::nail`] the nail's power on
    /// the wood.
    pub nail: [f64; 2],
    /// Force of the support on the wood, up \[N\].
    pub support: f64,
}

/// What forces at the end of a step do to the motion there, within the step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Compliance {
    /// Positions of nail and seat (rows) by the forces of nail and seat (columns) \[m/N\].
    pub position: [[f64; 2]; 2],
    /// Velocities of the same \[m/(N s)\].
    pub velocity: [[f64; 2]; 2],
}

/// A workpiece on its support, outside the cycle.
///
/// It advances by steps of the cycle's sample interval, in each of which the forces on it are linear in time. The cycle
/// asks as often as it needs how the wood would move under trial forces at the end of a step, and then accepts some.
pub trait Workpiece {
    /// What can go wrong.
    type Error: From<CycleError>;

    /// Brings the wood to rest under its own weight and the force \[N\] of the seated tool; its motion there.
    ///
    /// # Errors
    /// That there is no such rest.
    fn start(&mut self, seat: f64) -> Result<WoodMotion, Self::Error>;

    /// Compliance with the nail's tip at a depth \[m\]; it only speeds the search for the forces up, so that of a wood
    /// free of its support will do.
    fn compliance(&self, depth: f64) -> Compliance;

    /// Motion at the end of the present step if these are the forces there.
    ///
    /// # Errors
    /// That the structure cannot follow.
    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;

    /// Ends the present step with these forces; the motion there.
    ///
    /// # Errors
    /// That the structure cannot follow.
    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, Self::Error>;
}

/// Work of a coupled run, and how well the two sides agree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
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
