//! Reasons why an optimisation cannot begin.

use miette::Diagnostic;
use thiserror::Error;

/// Reason why an optimisation cannot begin.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[non_exhaustive]
pub enum OptimisationError {
    /// A text without a key, or a key without values.
    #[error("`{text}` does not vary a key")]
    #[diagnostic(help(
        "give a range or choices, as in supply.pressure=80psig..110psig or support.worktable.preset=A,B"
    ))]
    NotVaried {
        /// The text given.
        text: String,
    },
    /// The same key twice.
    #[error("--vary gives `{key}` twice")]
    #[diagnostic(help("give all its values at once: {key}=LOW..HIGH or {key}=A,B,C"))]
    VariedTwice {
        /// The key.
        key: String,
    },
    /// A range that cannot be searched.
    #[error("the range of `{key}` cannot be searched: {problem}")]
    #[diagnostic(help("give LOW..HIGH with one unit, the lower end first; `:log` needs ends above zero"))]
    BadRange {
        /// The key.
        key: String,
        /// The fault.
        problem: String,
    },
    /// A text that is not a constraint.
    #[error("`{text}` is not a constraint: {problem}")]
    #[diagnostic(help(
        "give FIGURE >= VALUE or FIGURE <= VALUE, as in \"penetration >= 80 mm\" or \"exhaust <= 92 dB\", or \
         \"outcome == drives\""
    ))]
    BadConstraint {
        /// The text given.
        text: String,
        /// The fault.
        problem: String,
    },
    /// An objective or a constraint on an unknown figure.
    #[error("there is no figure `{name}`")]
    #[diagnostic(help("choose from {known}"))]
    NoSuchFigure {
        /// The name given.
        name: String,
        /// All names.
        known: String,
    },
}
