//! Why a test cannot be processed.

use miette::Diagnostic;
use thiserror::Error;

/// Why a test cannot be processed.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum MeasurementError {
    /// Signals of a shot that cannot be evaluated.
    #[error("{configuration}, repeat {repeat}: {problem}")]
    #[diagnostic(help("{help}"))]
    Shot {
        /// Name of the configuration.
        configuration: String,
        /// The repeat, from 1.
        repeat: usize,
        /// What is wrong.
        problem: String,
        /// What to do about it.
        help: String,
    },
}
