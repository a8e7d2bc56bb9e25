//! The graph of the stages of this program.

pub use nailnoise_pipeline::key;
use nailnoise_pipeline::store::Key;

use crate::error::Error;

/// Runs stages: looks their outputs up in the store, else computes and stores them.
pub type Graph = nailnoise_pipeline::Graph<Error>;

/// A key that depends on the code of the entire program, for results of more than the stages.
pub(crate) fn program_key() -> Key {
    Key::empty().with(env!("NAILNOISE_SOURCES"))
}
