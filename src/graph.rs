//! The graph type of this program's stages.

pub use nailnoise_pipeline::key;
use nailnoise_pipeline::store::Key;

use crate::error::Error;

/// Runs stages: reads their outputs from the store, or computes and stores them.
pub type Graph = nailnoise_pipeline::Graph<Error>;

/// A key that depends on the code of the entire program, for results that involve more than the stages.
pub(crate) fn program_key() -> Key {
    Key::empty().with(env!("NAILNOISE_SOURCES"))
}
