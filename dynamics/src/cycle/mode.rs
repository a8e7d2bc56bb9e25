//! Which contacts are closed and which passages are open: the discrete state between two events.
//!
//! For a fixed mode, the right-hand side is smooth for any state, so a step may extend beyond an event and be cut back
//! to it: no force or flow depends on the sign of a gap.

use super::state::{V_W, Y_W};
use super::wood::DrivenWood;
use nailnoise_penetration::Real;

/// A contact with the force F = k u + c u' while closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Contact {
    Bumper,
    Stopper,
    Cap,
    Seat,
    Nose,
    Support,
}

impl Contact {
    pub(crate) const COUNT: usize = 6;
    pub(crate) const ALL: [Self; Self::COUNT] = [
        Self::Bumper,
        Self::Stopper,
        Self::Cap,
        Self::Seat,
        Self::Nose,
        Self::Support,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bumper => "the bumper",
            Self::Stopper => "the stopper",
            Self::Cap => "the head valve's cap",
            Self::Seat => "the head valve's seat",
            Self::Nose => "the nose",
            Self::Support => "the support",
        }
    }
}

/// How the rod acts on the wood through the nail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Penetration {
    /// No force: the rod is above the wood, or off the nail, which it has driven to `deepest` against `force`.
    Free { deepest: f64, force: f64 },
    /// The nail moves deeper, F = E(z); `seated` beyond its length.
    Loading { seated: bool },
    /// The seated nail springs back, F = force + k_u (z - deepest).
    Unloading { deepest: f64, force: f64 },
}

/// Position of the nail relative to the rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NailState {
    /// In the magazine's guide, at rest.
    Waiting,
    /// Driven by the rod.
    Attached,
    /// Left by the rod.
    Left,
}

/// Which end of the trigger channel is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channel {
    Closed,
    Venting,
    Filling,
}

/// Discrete state of the cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode {
    /// Closed contacts, indexed by [`Contact`].
    pub(crate) closed: [bool; Contact::COUNT],
    /// Whether the guard spring touches the wood.
    pub(crate) guard: bool,
    /// Whether the intake is open.
    pub(crate) intake: bool,
    /// Whether the exhaust is open.
    pub(crate) exhaust: bool,
    /// Whether the check-ring holes are uncovered.
    pub(crate) check_holes: bool,
    /// Penetration.
    pub(crate) penetration: Penetration,
    /// Nail.
    pub(crate) nail: NailState,
    /// State of the trigger channel at its far end, where switching arrives with a delay.
    pub(crate) channel: Channel,
    /// v0, speed of the rod relative to the wood just before it hit the nail \[m/s\].
    pub(crate) impact: f64,
    /// Whether the trigger is released (latched).
    pub(crate) released: bool,
    /// Motion of the wood, if it is not a mass of the cycle.
    pub(crate) wood: Option<DrivenWood>,
}

impl Mode {
    pub(crate) fn closed(&self, contact: Contact) -> bool {
        self.closed[contact as usize]
    }

    /// Position and velocity of the wood under the nose.
    #[inline]
    pub(crate) fn seat_motion<S: Real>(&self, y: &[S]) -> (S, S) {
        match &self.wood {
            None => (y[Y_W], y[V_W]),
            Some(wood) => wood.seat_motion(y[Y_W]),
        }
    }

    /// Position and velocity of the wood that grips the nail.
    #[inline]
    pub(crate) fn nail_motion<S: Real>(&self, y: &[S]) -> (S, S) {
        match &self.wood {
            None => (y[Y_W], y[V_W]),
            Some(wood) => wood.nail_motion(y[Y_W]),
        }
    }
}
