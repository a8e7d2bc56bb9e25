//! Errors of a transient run.

use thiserror::Error;

/// A transient run that cannot start or continue; the text names the remedy.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TransientError {
    /// An array has the wrong size.
    #[error("{what}: {found} given where {expected} are needed; make all arrays of a body and of the loads agree")]
    Size {
        /// The array, with the name of its body if it belongs to one.
        what: String,
        /// Size required by the rest of the input.
        expected: usize,
        /// Size found.
        found: usize,
    },
    /// A number is not finite or outside its meaningful range.
    #[error("{what} is {value}, but must be {range}")]
    Value {
        /// The quantity.
        what: String,
        /// The value found.
        value: f64,
        /// The allowed values.
        range: &'static str,
    },
    /// A constant load acts on an unrestrained rigid motion of a body.
    #[error(
        "no static equilibrium: {share:.1e} of the load at t = 0 acts on rigid motions that no support can hold \
         (largest on body `{body}`); add a support in that direction, balance the load, or start from rest"
    )]
    NotSupported {
        /// Body whose rigid modes carry most of the unsupported load.
        body: String,
        /// Norm of the unsupported part, relative to that of the total modal load.
        share: f64,
    },
    /// The unilateral supports cannot balance the loads at t = 0: a body tips over or lifts off.
    #[error(
        "no static equilibrium: after {iterations} iterations {residual:.1e} of the load is unbalanced with \
         {touching} supports touching; the body `{body}` tips or is lifted off: move the load inside the support, \
         press harder, or start from rest"
    )]
    NoEquilibrium {
        /// Body with the largest unbalanced load.
        body: String,
        /// Number of Newton iterations.
        iterations: usize,
        /// Norm of the unbalanced modal load, relative to that of the total modal load.
        residual: f64,
        /// Number of supports in contact after the last iteration.
        touching: usize,
    },
    /// No unilateral support touched during the run.
    #[error(
        "a support never touches: the smallest gap of all {supports} unilateral supports in {duration:.3} s was \
         {gap:.2e} m (support {nearest}); check gap and normals, \
         or set require_contact = false"
    )]
    SupportNeverTouches {
        /// Number of unilateral supports.
        supports: usize,
        /// Index of the support that came closest.
        nearest: usize,
        /// Its smallest gap \[m\].
        gap: f64,
        /// Length of the run \[s\].
        duration: f64,
    },
    /// The supports are so stiff that a body bounces on them within a few steps.
    #[error(
        "contact too stiff for the step: the fastest contact vibration is {frequency:.0} Hz, omega h = {rate:.2} with \
         a step of {step:.2e} s (limit {limit}); use a step of at most {remedy:.1e} s or softer supports"
    )]
    ContactBeyondStep {
        /// Frequency of the fastest vibration of the bodies on their supports \[Hz\].
        frequency: f64,
        /// Its omega h.
        rate: f64,
        /// The limit of omega h in the settings.
        limit: f64,
        /// Step \[s\].
        step: f64,
        /// Step that would satisfy the limit \[s\].
        remedy: f64,
    },
    /// The set of touching supports could not be found.
    #[error(
        "contact not found at t = {time:.6} s: {violations} of {supports} supports disagree with the contact law after \
         {iterations} iterations; reduce the step or raise max_contact_iterations"
    )]
    ContactNotConverged {
        /// Time at the end of the step \[s\].
        time: f64,
        /// Number of iterations.
        iterations: usize,
        /// Number of supports whose state violates the law.
        violations: usize,
        /// Number of supports.
        supports: usize,
    },
    /// The response has become infinite or not a number.
    #[error("the response is not finite at t = {time:.6} s; check loads, damping (>= 0) and supports")]
    NotFinite {
        /// Time \[s\].
        time: f64,
    },
}
