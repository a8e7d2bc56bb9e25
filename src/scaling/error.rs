//! Reasons why scaling to another tool is impossible.

use thiserror::Error;

use crate::design::{Conflict, DesignError, Problem};

/// Reason why scaling to another tool is impossible.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ScalingError {
    /// A class that the rules do not contain.
    #[error("there is no class of tools `{class}`")]
    UnknownClass {
        /// The name given.
        class: String,
        /// The names of the classes.
        known: String,
    },
    /// Conflicting dimensions.
    #[error("no design of a {tool} follows from the rules: {source}")]
    Together {
        /// Class, bore, stroke and mass.
        tool: String,
        /// The conflict.
        source: Box<DesignError>,
    },
    /// Rules that cannot be read; impossible with the rules of a tested program.
    #[error("the rules of scaling cannot be read: {problem}")]
    Rules {
        /// The fault.
        problem: String,
    },
}

impl ScalingError {
    /// The remedy.
    pub fn remedy(&self) -> String {
        match self {
            Self::UnknownClass { known, .. } => format!("choose from: {known}"),
            Self::Together { source, .. } => match &source.problem {
                Problem::Conflict {
                    conflict: Conflict::NailAboveRod { .. },
                    ..
                } => "give a longer --stroke or a shorter --nail".to_owned(),
                Problem::Conflict {
                    conflict: Conflict::NailLongerThanBlock { .. },
                    ..
                } => "give a shorter --nail, or write the design and make the block thicker".to_owned(),
                _ => "give a bore, stroke and mass nearer to those of the class".to_owned(),
            },
            Self::Rules { .. } => "report this as a fault of the program".to_owned(),
        }
    }
}

/// An error of the rules themselves.
pub(super) fn broken(problem: impl ToString) -> ScalingError {
    ScalingError::Rules {
        problem: problem.to_string(),
    }
}
