#![doc = include_str!("../README.md")]

pub mod conflict;
pub mod likelihood;
pub mod next;
pub mod normal;
mod random;
pub mod ranks;
pub mod sampler;
pub mod statistics;
mod subspace;

use std::borrow::Cow;

use likelihood::Prediction;

/// A simulation whose inputs are conditioned on readings.
///
/// The inputs are a point z of independent standard normal variables. Rules may constrain some variables, for example
/// so that one dimension exceeds another; the prior is then the normal distribution restricted to points that satisfy
/// the rules.
pub trait Simulator: Sync {
    /// Number of variables, including shared errors of readings.
    fn variables(&self) -> usize;

    /// Predictions for the readings of a condition, in order, without shared errors.
    ///
    /// # Errors
    /// The name of the outcome if it differs from the observed one, or the reason why the point cannot be simulated.
    fn predict(&self, z: &[f64], condition: usize) -> Result<Vec<Prediction>, Cow<'static, str>>;

    /// Whether each variable is constrained by a rule. The sampler updates these variables only with prior-reversible
    /// moves.
    fn is_ruled(&self) -> Vec<bool> {
        vec![false; self.variables()]
    }

    /// Resets the variables of each rule that `proposed` violates to their values in `current`, which satisfies all
    /// rules.
    fn restore(&self, proposed: &mut [f64], current: &[f64]) {
        let _ = (proposed, current);
    }
}
