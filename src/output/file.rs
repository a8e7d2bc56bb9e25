//! Files in the folder of a run.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Name of the fields' folder in the folder of a run.
pub(super) const FIELDS: &str = "fields";

/// A file with its path in the folder of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct File {
    /// The path.
    pub path: PathBuf,
    /// The content of the file.
    #[serde(with = "serde_bytes")]
    pub content: Vec<u8>,
}

impl File {
    pub(crate) fn new(path: impl Into<PathBuf>, content: impl Into<Vec<u8>>) -> Self {
        Self {
            path: path.into(),
            content: content.into(),
        }
    }
}
