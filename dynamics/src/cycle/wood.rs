//! Motion of the wood prescribed by an external structure.
//!
//! Over one window of the coupled run, the wood's surface under the nose and the wood that grips the nail follow cubics
//! in the time since the start of the window. That time is a state that replaces the position of the lumped wood, so
//! every force and margin remains a function of the state.

use super::state::*;
use crate::WoodMotion;
use crate::coupling::Cubic;
use nailnoise_penetration::Real;

/// The wood over one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DrivenWood {
    seat: Cubic,
    nail: Cubic,
    /// The same motions without the forces of nose and nail at the end of the window.
    free_seat: Cubic,
    free_nail: Cubic,
    /// Force of the support at both ends and the window's length.
    support: [f64; 2],
    length: f64,
    /// Whether the nose was off the wood at the start of the window.
    pub(crate) open_at_start: bool,
    /// Whether the nose met the wood in this window; it then stays in contact until the end of the window.
    pub(crate) caught: bool,
}

impl DrivenWood {
    /// Creates the motion from the values at the start, at the end, and at the end without forces there.
    pub(crate) fn new(start: &WoodMotion, end: &WoodMotion, free: &WoodMotion, length: f64, open: bool) -> Self {
        Self {
            seat: Cubic::new(start.seat, end.seat, length),
            nail: Cubic::new(start.nail, end.nail, length),
            free_seat: Cubic::new(start.seat, free.seat, length),
            free_nail: Cubic::new(start.nail, free.nail, length),
            support: [start.support, end.support],
            length,
            open_at_start: open,
            caught: false,
        }
    }

    /// Wood at rest.
    pub(crate) fn at_rest(rest: &WoodMotion) -> Self {
        Self::new(rest, rest, rest, 1.0, false)
    }

    /// Gap margin of an open nose and its rate.
    ///
    /// A nose that lands on the wood with a dashpot starts with a finite force, which pushes the wood away. With the
    /// motion due to that force, neither contact nor gap would be consistent. The contact test therefore uses the
    /// motion without it, like that of the bodies on their support; the difference is of second order in the window
    /// length.
    pub(crate) fn seat_gap(&self, y: &State) -> (f64, f64) {
        let cubic = if self.open_at_start {
            &self.free_seat
        } else {
            &self.seat
        };
        let (position, velocity) = cubic.at(y[Y_W]);
        (y[Y_G] - position, y[V_G] - velocity)
    }

    /// Position of the wood that grips the nail, without the nail's force.
    pub(crate) fn free_nail(&self, y: &State) -> f64 {
        self.free_nail.at(y[Y_W]).0
    }

    /// Position and velocity under the nose.
    #[inline]
    pub(crate) fn seat_motion<S: Real>(&self, clock: S) -> (S, S) {
        self.seat.at(clock)
    }

    /// Position and velocity of the wood that grips the nail.
    #[inline]
    pub(crate) fn nail_motion<S: Real>(&self, clock: S) -> (S, S) {
        self.nail.at(clock)
    }

    /// Position, velocity and acceleration under the nose.
    pub(crate) fn seat_at(&self, clock: f64) -> [f64; 3] {
        let (position, velocity) = self.seat.at(clock);
        [position, velocity, self.seat.acceleration(clock)]
    }

    /// Force of the support.
    pub(crate) fn support_at(&self, clock: f64) -> f64 {
        self.support[0] + (self.support[1] - self.support[0]) * (clock / self.length)
    }
}
