#![doc = include_str!("../README.md")]

pub mod conflict;
pub mod likelihood;
pub mod next;
pub mod normal;
mod random;
pub mod sampler;
pub mod statistics;
mod subspace;

use likelihood::Prediction;

/// A simulation whose inputs are conditioned on readings.
///
/// The inputs are a point z of independent standard normal variables. Some variables may be tied by rules, for example
/// that one dimension exceeds another; the prior is then the normal distribution without the points that break a rule.
pub trait Simulator: Sync {
    /// Number of variables, errors that readings share among them.
    fn variables(&self) -> usize;

    /// Predictions for the readings of a condition, in their order, without the effect of shared errors.
    ///
    /// # Errors
    /// The name of the outcome if it is not one that was observed, or why the point cannot be simulated.
    fn predict(&self, z: &[f64], condition: usize) -> Result<Vec<Prediction>, &'static str>;

    /// Whether each variable belongs to a rule. The sampler moves these variables only by the prior.
    fn is_ruled(&self) -> Vec<bool> {
        vec![false; self.variables()]
    }

    /// Returns the variables of each rule that `proposed` breaks to their values in `current`, which breaks none.
    fn restore(&self, proposed: &mut [f64], current: &[f64]) {
        let _ = (proposed, current);
    }
}
