//! Stages, their keys, and the store of their outputs.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use nailnoise_pipeline::{PipelineError, StageError};
use thiserror::Error;

mod graph;
mod inputs;
mod store;

/// An error of a stage.
#[derive(Debug, Error)]
enum Failure {
    #[error("a failure")]
    Own,
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
}

impl StageError for Failure {
    fn is_cause(&self) -> bool {
        matches!(self, Self::Own)
    }
}

type Stored<T> = nailnoise_pipeline::Stored<T, Failure>;
type Graph = nailnoise_pipeline::Graph<Failure>;

/// A place for the files of one test, emptied.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pipeline").join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}
