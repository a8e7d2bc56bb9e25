//! Errors that prevent the use of a cache.

use std::io;
use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Errors that prevent the use of a cache.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum StoreError {
    /// No environment variable names a cache folder.
    #[error("there is no folder for the cache: neither NAILNOISE_CACHE nor XDG_CACHE_HOME nor HOME is set")]
    #[diagnostic(help("set NAILNOISE_CACHE to a folder"))]
    NoFolder,
    /// The cache path is not a folder or cannot be reached.
    #[error("the cache {} {obstacle}", path.display())]
    #[diagnostic(help("set NAILNOISE_CACHE to a folder"))]
    Unusable {
        /// The path.
        path: PathBuf,
        /// The object at that path.
        obstacle: Obstacle,
    },
    /// The results folder named by the user cannot be used.
    #[error("the store {} {obstacle}", path.display())]
    #[diagnostic(help("name a folder in which files can be written"))]
    NoStore {
        /// The path.
        path: PathBuf,
        /// The object at that path.
        obstacle: Obstacle,
    },
    /// The size limit is not a number.
    #[error("NAILNOISE_CACHE_LIMIT is \"{found}\", which is not a size in GiB")]
    #[diagnostic(help("give a number above zero, for instance 4 or 0.5"))]
    Limit {
        /// Its text.
        found: String,
    },
}

impl StoreError {
    /// Whether a command can do its work without a cache.
    pub fn is_dispensable(&self) -> bool {
        matches!(self, Self::NoFolder | Self::Unusable { .. })
    }
}

/// Why a path cannot be used as the folder of a store.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Obstacle {
    /// Something else has this name.
    #[error("is {0}, not a folder")]
    NoFolder(&'static str),
    /// The folder cannot be reached or created.
    #[error("cannot be used: {0}")]
    Unreachable(io::Error),
    /// No file can be written in it.
    #[error("takes no files: {0}")]
    ReadOnly(io::Error),
}
