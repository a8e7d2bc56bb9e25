//! The discrete state between two events: switches and their memories.
//!
//! For a fixed mode, the right-hand side is smooth for any state, so a step may extend beyond an event and be cut back
//! to it.

use super::drive::Drive;
use super::plan::Plan;

/// Switches of all blocks, and values to remember.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mode {
    /// 0 or 1; a fastener uses the values of [`head`] and [`depth`].
    pub(crate) switches: Vec<u8>,
    /// Travel at which a latch caught; deepest depth, force and impact speed of a fastener.
    pub(crate) memory: Vec<f64>,
    /// Motion of a workpiece that an external structure prescribes.
    pub(crate) wood: Option<Drive>,
}

/// Switch values of a driver on its fastener's head.
pub(crate) mod head {
    /// The fastener waits in its guide, at rest.
    pub(crate) const WAITING: u8 = 0;
    /// The driver pushes it.
    pub(crate) const ATTACHED: u8 = 1;
    /// The driver has left it.
    pub(crate) const LEFT: u8 = 2;
}

/// Switch values of a fastener in the workpiece.
pub(crate) mod depth {
    /// No force: above the workpiece, or separated from the fastener driven so far.
    pub(crate) const FREE: u8 = 0;
    /// Goes deeper, f = E(z) within its length.
    pub(crate) const LOADING: u8 = 1;
    /// Goes deeper with its head on the surface.
    pub(crate) const SEATED: u8 = 2;
    /// Springs back, f = f* + k_u (z - z*).
    pub(crate) const UNLOADING: u8 = 3;
}

/// Switch values of friction that may stick.
pub(crate) mod friction {
    /// Slides forth, v > 0.
    pub(crate) const FORTH: u8 = 0;
    /// Slides back, v < 0.
    pub(crate) const BACK: u8 = 1;
    /// Sticks where it stopped.
    pub(crate) const STUCK: u8 = 2;
    /// Inactive, during the search for the initial equilibrium.
    pub(crate) const IDLE: u8 = 3;
}

impl Mode {
    /// All switches off; latches at their initial travel.
    pub(crate) fn new(plan: &Plan) -> Self {
        let mut memory = vec![0.0; plan.memories];
        for hold in &plan.holds {
            memory[hold.place] = hold.at;
        }
        for fastener in &plan.fasteners {
            memory[fastener.impact_speed] = fastener.law.usual_impact();
        }
        Self {
            switches: vec![0; plan.switches],
            memory,
            wood: None,
        }
    }

    #[inline]
    pub(crate) fn is_on(&self, switch: usize) -> bool {
        self.switches[switch] != 0
    }
}
