//! Faults of results that are to be compared.

use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Why results cannot be compared.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ComparisonError {
    /// A finished result contains no ranges to draw from.
    #[error("{} is a finished result, from which nothing can be drawn", path.display())]
    #[diagnostic(help("give the design file itself, or leave --draws out"))]
    NothingToDraw {
        /// The result.
        path: PathBuf,
    },
    /// A single design has nothing to be compared with.
    #[error("{} alone has nothing to be compared with", path.display())]
    #[diagnostic(help(
        "name a second design or result, or give measurements: --measured measurement.json, or --measured n80cb for \
         the published ones"
    ))]
    NothingToCompare {
        /// The design.
        path: std::path::PathBuf,
    },
    /// Measured levels over a range other than that of a design.
    #[error("{} has levels over {:.0} to {:.0} Hz, the design {design} over {:.0} to {:.0} \
        Hz", path.display(), measured[0], measured[1],
        predicted[0], predicted[1])]
    #[diagnostic(help("add --set \"analysis.range_low={} Hz\" --set \"analysis.range_high={} \
        Hz\"", measured[0], measured[1]))]
    MeasuredRange {
        /// The file of measurements.
        path: PathBuf,
        /// Its range \[Hz\].
        measured: [f64; 2],
        /// Name of the design.
        design: String,
        /// Its range \[Hz\].
        predicted: [f64; 2],
    },
    /// A file is not a result of a run.
    #[error("cannot compare the result {}: {reason}", path.display())]
    #[diagnostic(help("give the `result.json` of this version's `nailnoise run`, or the design, which is then run"))]
    NotAResult {
        /// The file.
        path: PathBuf,
        /// The fault of the file.
        reason: String,
    },
    /// The numbers of a finished result are impossible or inconsistent.
    #[error("cannot compare the result {}: `{at}` is {found}, expected is {expected}", path.display())]
    #[diagnostic(help(
        "the file was changed or damaged: compute it anew with `nailnoise run`, or give the design, which is then run"
    ))]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// Path of the number in it.
        at: String,
        /// Actual content.
        found: String,
        /// Expected content.
        expected: String,
    },
}
