//! A workpiece whose motion an external structure prescribes.
//!
//! Over one window of the coupled run, the surface of the workpiece and the material that grips its fastener follow
//! cubics in the time since the start of the window. That time is a state that replaces the position of the lumped
//! workpiece, so every force and margin remains a function of the state.

use crate::WoodMotion;
use crate::coupling::{Cubic, Step};

/// The body that an external structure replaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Driven {
    /// Its index.
    pub(crate) body: usize,
    /// Contact or spring to the ground that outputs the force of the support.
    pub(crate) shown: Option<Carrier>,
    /// Position of the integral of the work on it.
    pub(crate) work: usize,
}

/// A block that carries the lumped workpiece, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Carrier {
    Contact(usize),
    Spring(usize),
}

/// Motion over one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    seat: Cubic,
    nail: Cubic,
    /// The same motions without the forces at the end of the window.
    free_seat: Cubic,
    free_nail: Cubic,
    /// Force of the support at both ends, and the window's length.
    support: [f64; 2],
    length: f64,
}

impl Drive {
    pub(crate) fn new(step: &Step, length: f64) -> Self {
        let Step { start, end, free, .. } = step;
        Self {
            seat: Cubic::new(start.seat, end.seat, length),
            nail: Cubic::new(start.nail, end.nail, length),
            free_seat: Cubic::new(start.seat, free.seat, length),
            free_nail: Cubic::new(start.nail, free.nail, length),
            support: [start.support, end.support],
            length,
        }
    }

    /// At rest for a time.
    pub(crate) fn at_rest(rest: &WoodMotion, length: f64) -> Self {
        let step = Step {
            start: *rest,
            end: *rest,
            free: *rest,
            to: length,
        };
        Self::new(&step, length)
    }

    /// Motions of surface and grip, then the same without the forces at the end of the window.
    #[inline]
    pub(crate) fn motions(&self, clock: f64) -> [(f64, f64); 4] {
        [&self.seat, &self.nail, &self.free_seat, &self.free_nail].map(|cubic| cubic.at(clock))
    }

    /// Force of the support.
    pub(crate) fn support(&self, clock: f64) -> f64 {
        self.support[0] + (self.support[1] - self.support[0]) * (clock / self.length)
    }

    /// Accelerations of surface and grip.
    pub(crate) fn accelerations(&self, clock: f64) -> [f64; 2] {
        [&self.seat, &self.nail].map(|cubic| cubic.acceleration(clock))
    }
}
