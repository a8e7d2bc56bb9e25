//! Errors of stages, and which of several to report.

use miette::Diagnostic;
use thiserror::Error;

/// Why a stage has no output although the stage itself did not fail.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PipelineError {
    /// An input could not be computed; its error is reported once, where it occurred.
    #[error("{stage} could not be computed")]
    Upstream {
        /// Name of the stage that failed.
        stage: &'static str,
    },
}

/// The error type of the stages of a graph.
pub trait StageError: std::error::Error + From<PipelineError> + Send + Sync + 'static {
    /// Whether the error is a cause, rather than the consequence of a failed input.
    fn is_cause(&self) -> bool;
}

impl StageError for PipelineError {
    fn is_cause(&self) -> bool {
        !matches!(self, Self::Upstream { .. })
    }
}

/// Returns the first error that is a cause rather than a consequence, if there are errors.
///
/// # Errors
/// That first cause.
pub fn first_cause<E: StageError>(errors: impl Iterator<Item = E>) -> Result<(), E> {
    let (causes, consequences): (Vec<E>, Vec<E>) = errors.partition(E::is_cause);
    causes.into_iter().chain(consequences).next().map_or(Ok(()), Err)
}
