//! Errors of a calibration, with the place in the measurement file and the remedy.

use std::fmt::Display;
use std::path::PathBuf;

use miette::{Diagnostic, LabeledSpan, SourceCode};
use nailnoise_calibration::likelihood::LikelihoodError;
use nailnoise_documents::{DocumentError, KeyError, Place};

/// Why a design cannot be calibrated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The file of measurements cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        cause: String,
    },
    /// The file is not valid TOML.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A key of the file is wrong, missing or unknown.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// `--hold-out` does not name a measurement.
    #[error("--hold-out: there is no measurement `{name}`")]
    HeldOut {
        /// The name given.
        name: String,
        /// All names.
        known: String,
    },
    /// The stated correlations of errors are impossible.
    #[error(transparent)]
    Likelihood(#[from] LikelihoodError),
    /// No candidate has the observed outcomes.
    #[error("none of {candidates} candidates shows the outcomes that were observed")]
    NothingAccepted {
        /// Candidates drawn.
        candidates: u64,
        /// For each condition and outcome, the number of candidates that failed there first.
        outcomes: String,
    },
    /// There are too few candidates for the two halves of the sampler.
    #[error("only {accepted} of {candidates} candidates show the outcomes that were observed; {wanted} are needed")]
    TooFewAccepted {
        /// Accepted candidates.
        accepted: usize,
        /// Candidates drawn.
        candidates: u64,
        /// Draws requested.
        wanted: usize,
    },
    /// The design has joint draws already.
    #[error("the design is calibrated already, with {measured}")]
    Calibrated {
        /// The file of measurements.
        measured: String,
    },
    /// A predicted mode of a plate has too many nodal lines.
    #[error("plate `{plate}` has a mode at {hz:.0} Hz with more nodal lines than the polynomials of its shape resolve")]
    Unresolved {
        /// Name of the plate.
        plate: String,
        /// Its frequency \[Hz\].
        hz: f64,
    },
    /// A worker of a cluster computes another calibration.
    #[error("a worker has another version of the program, or reads another design or other measurements")]
    OtherCalibration,
    /// The workers of a cluster did not return the results of their tasks.
    #[error("the workers returned no results")]
    NoResults,
    /// No key of the design that affects the cycle has a range.
    #[error("no key that takes part in the nailing cycle has a range, so that there is nothing to calibrate")]
    NoVariables,
}

impl CalibrationError {
    fn place(&self) -> Option<&Place> {
        match self {
            Self::Key(KeyError { at, .. }) | Self::Document(DocumentError::Syntax { at, .. }) => Some(at),
            _ => None,
        }
    }
}

impl Diagnostic for CalibrationError {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(match self {
            Self::Unreadable { .. } => Box::new("name a TOML file; docs/calibration.md describes it"),
            Self::Document(_) => Box::new("write `key = value`, texts in quotes, groups as [measured]"),
            Self::Key(KeyError { help, .. }) => Box::new(help),
            Self::HeldOut { known, .. } => Box::new(format!("choose from {known}")),
            Self::Likelihood(LikelihoodError::Indefinite { .. }) => Box::new("lower the correlations"),
            Self::Likelihood(LikelihoodError::Censored { .. }) => {
                Box::new("remove it from `correlation`, or give it as a value")
            }
            Self::NothingAccepted { outcomes, .. } => Box::new(format!(
                "they failed with {outcomes}; correct `outcome` or widen the ranges of the design"
            )),
            Self::TooFewAccepted { .. } => {
                Box::new("reduce --draws, leave out outcomes, or narrow the ranges of the design by `direct`")
            }
            Self::Calibrated { .. } => {
                Box::new("calibrate its base with all measurements in one file: draws are not drawn from draws")
            }
            Self::Unresolved { .. } => {
                Box::new("lower `modes_up_to`: at most 8 nodal lines across the grain, 5 along it")
            }
            Self::OtherCalibration => Box::new(
                "repeat the call if a file has changed meanwhile; otherwise install the same version of nailnoise on \
                 all workers",
            ),
            Self::NoResults => Box::new("read the log of the workers; repeating the call continues at the last move"),
            Self::NoVariables => Box::new("give keys a range, as { value = \"131 g\", range = \"+-5 %\" }"),
        })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place().map(Place::source_code)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(self.place()?.label("here"))))
    }
}
