//! Why a measurement cannot be used: what is wrong, in which file and channel, and what to do about it.

use std::fmt::Display;
use std::path::PathBuf;

use miette::{Diagnostic, LabeledSpan, SourceCode};

use super::recordings::Fault;
use crate::design::{DesignError, Place};

/// Why a measurement cannot be used. As a [`Diagnostic`] it shows the place in the manifest and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasurementError {
    /// A file that cannot be read.
    #[error("cannot read {}{}: {cause}", path.display(), channel.as_ref().map_or_else(String::new, |name| format!(", channel {name}")))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The channel that it should hold; none for the manifest.
        channel: Option<String>,
        /// What the system said.
        cause: String,
        /// What to do about it.
        help: String,
    },
    /// A manifest that is no TOML.
    #[error(transparent)]
    Syntax(Box<DesignError>),
    /// A key of the manifest that is wrong, or missing.
    #[error("{}, line {}: `{key}` {problem}", at.file(), at.line())]
    Manifest {
        /// Its full name.
        key: String,
        /// What is wrong with it.
        problem: String,
        /// What to do about it.
        help: String,
        /// Where.
        at: Box<Place>,
    },
    /// A recording that cannot be used.
    #[error("{}, channel {channel}: {fault}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// Name of the channel.
        channel: String,
        /// What is wrong with it.
        fault: Box<Fault>,
    },
    /// Levels over another range than those of a design.
    #[error("{} has levels over {:.0} to {:.0} Hz, the design {design} over {:.0} to {:.0} Hz", path.display(), measured[0], measured[1],
        predicted[0], predicted[1])]
    Range {
        /// The file of measurements.
        path: PathBuf,
        /// Its range \[Hz\].
        measured: [f64; 2],
        /// Name of the design.
        design: String,
        /// Its range \[Hz\].
        predicted: [f64; 2],
    },
    /// A shot that the manifest does not have.
    #[error("the manifest has no shot {repeat} of configuration {configuration}, both counted from 0")]
    NoShot {
        /// Index of the configuration.
        configuration: usize,
        /// Index of the repeat.
        repeat: usize,
    },
    /// Signals of a shot that cannot be evaluated.
    #[error("{configuration}, repeat {repeat}: {problem}")]
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

impl MeasurementError {
    /// The place in the manifest that it points at.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Manifest { at, .. } => Some(at),
            _ => None,
        }
    }
}

impl Diagnostic for MeasurementError {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        match self {
            Self::Unreadable { help, .. } | Self::Manifest { help, .. } | Self::Shot { help, .. } => {
                Some(Box::new(help))
            }
            Self::Syntax(error) => error.help(),
            Self::Recording { fault, .. } => Some(Box::new(fault.remedy())),
            Self::Range { measured, .. } => Some(Box::new(format!(
                "add --set \"analysis.range_low={} Hz\" --set \"analysis.range_high={} Hz\"",
                measured[0], measured[1]
            ))),
            Self::NoShot { .. } => Some(Box::new("ask for configurations and repeats that the manifest lists")),
        }
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        match self {
            Self::Syntax(error) => error.source_code(),
            _ => self.place().map(|place| &place.source as &dyn SourceCode),
        }
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        match self {
            Self::Syntax(error) => error.labels(),
            _ => {
                let label = LabeledSpan::new_with_span(Some("here".to_owned()), self.place()?.span.clone());
                Some(Box::new(std::iter::once(label)))
            }
        }
    }
}
