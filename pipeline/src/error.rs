//! Errors of stages, and which of several is reported.

use miette::Diagnostic;
use thiserror::Error;

/// Why the output of a stage is not there although the stage itself did not fail.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PipelineError {
    /// An input could not be computed; its own error is reported once, where it occurred.
    #[error("{stage} could not be computed")]
    Upstream {
        /// Name of the stage that failed.
        stage: &'static str,
    },
}

/// The error type of the stages of a graph.
pub trait StageError: std::error::Error + From<PipelineError> + Send + Sync + 'static {
    /// Whether it is a cause, not the consequence of an input that failed.
    fn is_cause(&self) -> bool;
}

impl StageError for PipelineError {
    fn is_cause(&self) -> bool {
        !matches!(self, Self::Upstream { .. })
    }
}

/// Fails with the first error that is a cause rather than a consequence of another, if there are errors.
///
/// # Errors
/// That one.
pub fn first_cause<E: StageError>(errors: impl Iterator<Item = E>) -> Result<(), E> {
    let (causes, consequences): (Vec<E>, Vec<E>) = errors.partition(E::is_cause);
    causes.into_iter().chain(consequences).next().map_or(Ok(()), Err)
}
