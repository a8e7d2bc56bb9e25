//! Reasons why a file is not a valid fitted law.

use thiserror::Error;

use super::form::FormError;

/// Identifier of the file layout of a fit.
pub const FIT_SCHEMA: &str = "nailnoise-fit/1";

/// Why a file is not a valid fitted law.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LawError {
    /// The schema is not supported.
    #[error("its schema is \"{found}\", not \"{FIT_SCHEMA}\"")]
    Schema {
        /// The schema found.
        found: String,
    },
    /// The form or a term is invalid.
    #[error(transparent)]
    Form(#[from] FormError),
    /// A term does not match the form.
    #[error("term {place} is \"{found}\", and the form has \"{expected}\" there")]
    Term {
        /// Position of the term, from 1.
        place: usize,
        /// The term found.
        found: String,
        /// The term in the form.
        expected: String,
    },
    /// A value is outside its domain.
    #[error("{what} is {value}, and must be {rule}")]
    Value {
        /// The quantity.
        what: String,
        /// The number.
        value: f64,
        /// The requirement.
        rule: &'static str,
    },
    /// The covariance has the wrong size, is not symmetric, or has a negative eigenvalue.
    #[error("the covariance is no symmetric matrix of {size} rows without negative eigenvalues")]
    Covariance {
        /// Number of terms.
        size: usize,
    },
}
