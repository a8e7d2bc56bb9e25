//! Constants of bodies and of the blocks between them.

use crate::network::assembly::{ContactDamping, ForceLaw};
use crate::network::resistance::ShankLaw;

/// Two bodies with a block between them; the ground has the index after the last body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pair {
    pub(crate) on: usize,
    pub(crate) against: usize,
}

/// Constants of a body.
#[derive(Debug, Clone)]
pub(crate) struct BodyPlan {
    pub(crate) parent: usize,
    pub(crate) mass: f64,
    pub(crate) gravity: f64,
    /// Index of a fastener that may join the body.
    pub(crate) fastener: Option<usize>,
}

/// A contact.
#[derive(Debug, Clone)]
pub(crate) struct ContactPlan {
    pub(crate) pair: Pair,
    /// u = side (x - at): +1 for a stop below, -1 above.
    pub(crate) side: f64,
    pub(crate) at: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: ContactDamping,
    pub(crate) exponent: f64,
    pub(crate) may_pull: bool,
    /// Whether it carries a workpiece that an external structure replaces. It then does not act.
    pub(crate) carries: bool,
    /// For a contact with a dashpot on such a workpiece, two switches. They are on if it was open at the start of the
    /// window and if it closed in the window; it then remains closed until the end of the window.
    pub(crate) landing: Option<[usize; 2]>,
    pub(crate) switch: usize,
    pub(crate) loss: Option<usize>,
}

/// A spring.
#[derive(Debug, Clone)]
pub(crate) struct SpringPlan {
    pub(crate) pair: Pair,
    pub(crate) sign: f64,
    pub(crate) free: f64,
    pub(crate) preload: f64,
    /// Coefficients of F(e).
    pub(crate) law: Vec<f64>,
    pub(crate) damping: f64,
    /// Switch of a spring that only pushes.
    pub(crate) switch: Option<usize>,
    pub(crate) limit: Option<f64>,
    /// Whether it carries a workpiece that an external structure replaces. It then does not act.
    pub(crate) carries: bool,
    pub(crate) loss: Option<usize>,
}

/// Friction.
#[derive(Debug, Clone)]
pub(crate) struct FrictionPlan {
    pub(crate) pair: Pair,
    pub(crate) static_force: f64,
    pub(crate) sliding_force: f64,
    pub(crate) viscous: f64,
    pub(crate) width: f64,
    pub(crate) stribeck: f64,
    pub(crate) stick: Option<StickPlan>,
    pub(crate) loss: usize,
}

/// Spring and dashpot that hold a pair while it sticks.
#[derive(Debug, Clone)]
pub(crate) struct StickPlan {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) switch: usize,
    /// Memory of the travel at which it stopped.
    pub(crate) place: usize,
}

/// An imposed force.
#[derive(Debug, Clone)]
pub(crate) struct ForcePlan {
    pub(crate) pair: Pair,
    pub(crate) law: ForceLaw,
    /// Position of its work integral, if the work does not follow from positions.
    pub(crate) work: Option<usize>,
}

/// A motor.
#[derive(Debug, Clone)]
pub(crate) struct MotorPlan {
    pub(crate) pair: Pair,
    pub(crate) sign: f64,
    pub(crate) stall: f64,
    pub(crate) free_speed: f64,
    pub(crate) switch: usize,
    pub(crate) work: usize,
}

/// A latch.
#[derive(Debug, Clone)]
pub(crate) struct HoldPlan {
    pub(crate) pair: Pair,
    pub(crate) at: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) switch: usize,
    /// Memory of the travel at which it caught.
    pub(crate) place: usize,
    pub(crate) loss: Option<usize>,
}

/// A fastener.
#[derive(Debug, Clone)]
pub(crate) struct FastenerPlan {
    /// Driver relative to the workpiece.
    pub(crate) work: Pair,
    /// Driver relative to the guide.
    pub(crate) guide: Pair,
    /// Driver relative to its parent.
    pub(crate) stroke: Pair,
    pub(crate) head_at: f64,
    pub(crate) tip_at: f64,
    pub(crate) length: f64,
    pub(crate) mass: f64,
    pub(crate) impact: bool,
    pub(crate) leaves_unloaded: bool,
    pub(crate) law: ShankLaw,
    pub(crate) reversible: bool,
    pub(crate) head_stiffness: f64,
    pub(crate) unloading: f64,
    pub(crate) guide_friction: f64,
    pub(crate) guide_width: f64,
    /// Switch of the driver on the head.
    pub(crate) head: usize,
    /// Switch of the fastener in the work.
    pub(crate) depth: usize,
    /// Memory of the deepest depth z*, followed by that of the force f*.
    pub(crate) deepest: usize,
    /// Memory of the driver's speed into the work just before the impact.
    pub(crate) impact_speed: usize,
    pub(crate) penetration: usize,
    pub(crate) guide_loss: Option<usize>,
}
