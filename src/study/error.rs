//! Faults of studies and sweeps.

use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Reason why a study or a sweep cannot be computed.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum StudyError {
    /// No draw of a study has levels.
    #[error("the levels of none of {draws} draws can be computed; first reason: {reason}")]
    NoLevels {
        /// Number of draws that count.
        draws: usize,
        /// Reason why the levels of the first draw cannot be computed.
        reason: String,
    },
    /// Levels of a draw that another process should have computed.
    #[error("its levels are not stored")]
    LevelsNotKept,
    /// No candidate of a study is a design whose shot counts.
    #[error(
        "none of {candidates} candidates gives a shot that counts: {}",
        outcomes_and_reasons(outcomes, refused)
    )]
    #[diagnostic(help("{}", if require.is_empty() {
        "narrow the ranges: their values are incompatible".to_owned()
    } else {
        format!("remove `require = \"{require}\"` from [study], or narrow the ranges")
    }))]
    NothingDrawn {
        /// Number of candidates drawn.
        candidates: u64,
        /// Numbers of candidates by outcome.
        outcomes: String,
        /// Numbers of candidates that are not valid designs, by reason.
        refused: String,
        /// Outcomes that count.
        require: String,
    },
    /// A ranking of input groups over drawn structures.
    #[error(
        "`--groups` and `--structures` exclude each other: every partner of a draw would need a structure of its own"
    )]
    #[diagnostic(help(
        "rank the groups on the structures of the design, without --structures; `{study} --structures` states beside \
         it what structures add"
    ))]
    GroupsOfStructures {
        /// The command without either option.
        study: String,
    },
    /// Draws that tasks should have computed are missing.
    #[error("the levels of {missing} of {draws} draws are not in {}", store.display())]
    #[diagnostic(help(
        "run the tasks that are missing, with the same design, draws and seed; without --collect, this command \
         computes what is missing"
    ))]
    NotCollected {
        /// Number of draws that are not stored.
        missing: usize,
        /// Total number of draws.
        draws: usize,
        /// The store that should contain them.
        store: PathBuf,
    },
    /// The variable of a sweep is not a possible value of a design.
    #[error("the sweep cannot vary this: {error}")]
    #[diagnostic(help("give a key of the design and its values, as in supply.pressure=80psig..110psig:7"))]
    NoAxis {
        /// The fault.
        error: crate::design::AssignmentError,
    },
    /// A sweep with too many points.
    #[error("the grid of the sweep has more than {most} points")]
    #[diagnostic(help("give fewer values, or sweep the keys one after the other"))]
    SweptTooMuch {
        /// Maximum number of points of a grid.
        most: usize,
    },
    /// A key that a sweep would vary twice.
    #[error("the sweep varies `{key}` twice")]
    #[diagnostic(help("give all its values at once, as in {key}=3,5,12"))]
    VariedTwice {
        /// The key.
        key: String,
    },
    /// A sweep without a variable.
    #[error("the sweep has no key to vary")]
    #[diagnostic(help("give a key of the design and its values, as in supply.pressure=80psig..110psig:7"))]
    NothingToVary,
    /// Joint draws that cannot be used for the request.
    #[error("the joint draws of `study.draws` {problem}")]
    #[diagnostic(help("{help}"))]
    JointDraws {
        /// The reason.
        problem: &'static str,
        /// Remedy.
        help: &'static str,
    },
    /// The values of a draw conflict.
    #[error("the drawn values are not a valid design: {reason}")]
    NoDesign {
        /// The conflicting keys, or the fault of one of them.
        reason: String,
    },
}

/// Text about the candidates when none counts: outcomes of shots, and reasons why others are not valid designs.
fn outcomes_and_reasons(outcomes: &str, refused: &str) -> String {
    let refused = (!refused.is_empty()).then(|| format!("no designs: {refused}"));
    let parts = (!outcomes.is_empty())
        .then(|| outcomes.to_owned())
        .into_iter()
        .chain(refused);
    parts.collect::<Vec<_>>().join("; ")
}
