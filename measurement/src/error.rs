//! Reason why a measurement cannot be used: the fault, its file and channel, and the remedy.

use std::fmt::Display;
use std::path::PathBuf;

use miette::{Diagnostic, LabeledSpan, SourceCode};
use nailnoise_acoustics::InputError;
use nailnoise_documents::{DocumentError, KeyError, Place};

use super::recordings::Fault;

/// Why a measurement cannot be used. As a [`Diagnostic`] it shows the place in the manifest and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasurementError {
    /// A file cannot be read.
    #[error("cannot read {}{}: {cause}", path.display(),
        channel.as_ref().map_or_else(String::new, |name| format!(", channel {name}")))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The channel that it should contain; none for the manifest.
        channel: Option<String>,
        /// Error of the operating system.
        cause: String,
        /// How to fix it.
        help: String,
    },
    /// A manifest is not valid TOML.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A key of the manifest is wrong or missing.
    #[error(transparent)]
    Manifest(#[from] KeyError),
    /// A recording cannot be used.
    #[error("{}, channel {channel}: {fault}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// Name of the channel.
        channel: String,
        /// The fault.
        fault: Box<Fault>,
    },
    /// Air or room properties are impossible.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The manifest does not contain the shot.
    #[error("the manifest has no shot {repeat} of configuration {configuration}, both counted from 0")]
    NoShot {
        /// Index of the configuration.
        configuration: usize,
        /// Index of the repeat.
        repeat: usize,
    },
    /// The signals of a shot cannot be evaluated.
    #[error("{configuration}, repeat {repeat}: {problem}")]
    Shot {
        /// Name of the configuration.
        configuration: String,
        /// The repeat, from 1.
        repeat: usize,
        /// What is wrong.
        problem: String,
        /// How to fix it.
        help: String,
    },
}

/// The syntax of a manifest.
const SYNTAX: &str = "write `key = value`, texts in quotes: temperature = \"21 degC\"; groups as `[channels]`";

impl MeasurementError {
    /// The place in the manifest that the error points to.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Manifest(KeyError { at, .. }) | Self::Document(DocumentError::Syntax { at, .. }) => Some(at),
            _ => None,
        }
    }
}

impl Diagnostic for MeasurementError {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        match self {
            Self::Unreadable { help, .. } | Self::Manifest(KeyError { help, .. }) | Self::Shot { help, .. } => {
                Some(Box::new(help))
            }
            Self::Document(_) => Some(Box::new(SYNTAX)),
            Self::Recording { fault, .. } => Some(Box::new(fault.remedy())),
            Self::Input(_) => None,
            Self::NoShot { .. } => Some(Box::new("ask for configurations and repeats that the manifest lists")),
        }
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place().map(Place::source_code)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(self.place()?.label("here"))))
    }
}
