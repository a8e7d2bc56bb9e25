//! Why a file contains no fitted law.

use thiserror::Error;

use super::form::FormError;

/// The layout of a fit in a file.
pub const FIT_SCHEMA: &str = "nailnoise-fit/1";

/// Why a file contains no fitted law.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LawError {
    /// Another layout.
    #[error("its schema is \"{found}\", not \"{FIT_SCHEMA}\"")]
    Schema {
        /// The schema found.
        found: String,
    },
    /// A form or term that is none.
    #[error(transparent)]
    Form(#[from] FormError),
    /// Terms that are not those of the form.
    #[error("term {place} is \"{found}\", and the form has \"{expected}\" there")]
    Term {
        /// Place of the term, from 1.
        place: usize,
        /// The term found.
        found: String,
        /// The term of the form.
        expected: String,
    },
    /// A number out of its domain.
    #[error("{what} is {value}, and must be {rule}")]
    Value {
        /// The quantity.
        what: String,
        /// The number.
        value: f64,
        /// The requirement.
        rule: &'static str,
    },
    /// A covariance of another size, not symmetric, or with a negative eigenvalue.
    #[error("the covariance is no symmetric matrix of {size} rows without negative eigenvalues")]
    Covariance {
        /// Number of terms.
        size: usize,
    },
}
