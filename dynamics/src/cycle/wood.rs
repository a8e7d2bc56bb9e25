//! Motion of the wood prescribed by an external structure.
//!
//! Over one window of the coupled run, the wood's surface under the nose and the wood that grips the nail follow cubics
//! in the time since the start of the window. That time is a state that replaces the position of the lumped wood, so
//! every force and margin remains a function of the state.

use super::state::*;
use crate::WoodMotion;
use nailnoise_penetration::Real;

/// A cubic through position and velocity at both ends of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cubic([f64; 4]);

impl Cubic {
    /// w(s) = w_0 + v_0 s + (3 D - 2 v_0 - v_1) s^2/h + (v_0 + v_1 - 2 D) s^3/h^2 with D = (w_1 - w_0)/h.
    fn new(start: [f64; 2], end: [f64; 2], h: f64) -> Self {
        let mean = (end[0] - start[0]) / h;
        Self([
            start[0],
            start[1],
            (3.0 * mean - 2.0 * start[1] - end[1]) / h,
            (start[1] + end[1] - 2.0 * mean) / (h * h),
        ])
    }

    #[inline]
    fn at<S: Real>(&self, clock: S) -> (S, S) {
        let c = &self.0;
        (clock.polynomial(c), clock.polynomial(&[c[1], 2.0 * c[2], 3.0 * c[3]]))
    }
}

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
        let c = &self.seat.0;
        [position, velocity, 2.0 * c[2] + 6.0 * c[3] * clock]
    }

    /// Force of the support.
    pub(crate) fn support_at(&self, clock: f64) -> f64 {
        self.support[0] + (self.support[1] - self.support[0]) * (clock / self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_meets_both_ends() {
        let (start, end, h) = ([1.0, -2.0], [1.5, 3.0], 0.25);
        let cubic = Cubic::new(start, end, h);
        for (clock, [position, velocity]) in [(0.0, start), (h, end)] {
            let found = cubic.at(clock);
            assert!((found.0 - position).abs() < 1e-14 && (found.1 - velocity).abs() < 1e-13);
        }
    }
}
