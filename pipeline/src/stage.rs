//! Steps of a computation.

use serde::Serialize;

use crate::codec::Codec;
use crate::error::StageError;
use crate::progress::Progress;

/// A step of a computation: a value that contains all its inputs and nothing else.
///
/// Its fields are its inputs; large ones are [`Stored`](crate::Stored). The graph makes all of them in parallel before
/// it calls [`compute`](Self::compute), except those in [`OnDemand`](crate::OnDemand).
pub trait Stage: Serialize + Send + Sync + 'static {
    /// Its output.
    type Output: Send + Sync + 'static;
    /// Its error type, the same for all stages of a graph.
    type Error: StageError;
    /// How the output is stored between runs: [`Postcard`](crate::Postcard), [`Uncached`](crate::Uncached) or a special
    /// format.
    type Codec: Codec<Self::Output>;
    /// Its name in the store, in progress messages and in the timing of a run.
    const NAME: &'static str;
    /// Digests of the code that it calls.
    const CODE: Code;

    /// Computes the output.
    ///
    /// # Errors
    /// Errors of the computation or of an input.
    fn compute(&self, progress: &Progress) -> Result<Self::Output, Self::Error>;
}

/// Name and digest of each unit of code that a stage calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Code(pub &'static [(&'static str, &'static str)]);
