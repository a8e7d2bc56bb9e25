//! Choice between an explicit and an implicit method, by the fastest time constant of the equations.
//!
//! An event restarts the multistep method at order 1 with very short steps. Many segments end before it reaches the
//! step size that their motion permits. A bounce of the nose on the wood takes 80 steps of this method, but only 20 of
//! an explicit Runge-Kutta pair of order 5. The pair is the better choice while accuracy limits its step. If stability
//! limits its step, the implicit method continues. The limit follows from the spectral radius of the Jacobian (L.
//! Petzold, Automatic selection of methods for solving stiff and nonstiff systems of ordinary differential equations,
//! SIAM J. Sci. Stat. Comput. 4 (1983), 136-148).

use crate::network::equations::Problem;

/// Longest stable step times spectral radius. The pair is stable for products up to 2.36 where eigenvalues are at least
/// two degrees from the imaginary axis, and up to 3.5 on the negative real axis. At a product of 2, an undamped motion
/// grows by 2.6 % in a step, which the error estimate of the pair does not permit.
const STABLE: f64 = 2.0;
/// Number of first-order first steps that must fit into a stable step. A step of the pair costs 1.5 times as much as
/// one of the implicit method. The best value for the shipped tool is between 7 and 60 at tolerances of 1e-5 and 1e-7.
const WORTHWHILE: f64 = 15.0;
/// First step of the pair, relative to that of a first-order method with the same tolerance.
const FIRST: f64 = 32.0;
/// Number of steps after which the spectral radius is estimated again.
const RENEWAL: usize = 10;

/// Limit of the step of an explicit method.
pub(super) struct Stability {
    /// Longest stable step \[s\].
    limit: f64,
    /// Steps since the limit was estimated.
    age: usize,
}

impl Stability {
    /// The limit by the Jacobian that was evaluated last; none if the implicit method, whose first step is given, is
    /// the better choice.
    pub(super) fn new(problem: &Problem<'_>, first: f64) -> Option<Self> {
        let limit = longest_stable_step(problem);
        (limit > WORTHWHILE * first).then_some(Self { limit, age: 0 })
    }

    /// First step of the explicit method \[s\].
    pub(super) fn first_step(first: f64) -> f64 {
        FIRST * first
    }

    /// Whether a step that accuracy permits is unstable.
    pub(super) fn is_exceeded(&mut self, problem: &Problem<'_>, t: f64, y: &[f64], step: f64) -> bool {
        self.age += 1;
        if self.age == RENEWAL {
            problem.eqn.linearise(t, y);
            *self = Self {
                limit: longest_stable_step(problem),
                age: 0,
            };
        }
        step > self.limit
    }
}

/// Longest stable step by the Jacobian that was evaluated last \[s\].
fn longest_stable_step(problem: &Problem<'_>) -> f64 {
    STABLE / problem.eqn.spectral_radius(problem.atol.batch_as_slice(0))
}
