//! Events, triggers and outcomes.

use serde::Serialize;

use super::{BlockRef, Comparison};

/// Named event of the cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// Name.
    pub name: String,
    /// Description; empty if the assembly gives none.
    pub description: String,
    /// When it happens.
    pub edge: Edge,
    /// Index of an event that must have happened.
    pub after: Option<usize>,
    /// Time that must have passed since `after` \[s\].
    pub delay: f64,
    /// Index of an event that must not have occurred when the condition becomes true.
    pub before: Option<usize>,
    /// Index of an event at which the search ends.
    pub until: Option<usize>,
    /// Further condition at the edge.
    pub condition: Option<Condition>,
    /// Minimum duration for which the condition must be satisfied \[s\].
    pub lasting: f64,
    /// Which of several edges counts.
    pub pick: Pick,
}

/// When an event happens.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Edge {
    /// At a time \[s\].
    At(f64),
    /// When the condition begins to be satisfied.
    Becomes(Condition),
    /// When the condition is satisfied; at the start of the search if it is already satisfied then.
    Is(Condition),
    /// When a block logs a word.
    Logged(Word),
}

/// Conditions that must all be satisfied.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Condition {
    /// Comparisons that must all be satisfied.
    pub all: Vec<Comparison>,
}

/// Which of several edges counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Pick {
    /// The first.
    First,
    /// The last.
    Last,
}

/// A change logged by a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Word {
    /// Block.
    pub block: BlockRef,
    /// Restriction of a series (index), for seats and holes of passages.
    pub restriction: usize,
    /// Change.
    pub action: Action,
}

/// Changes of blocks; the log uses the name in lower case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Action {
    /// Contact closes; force becomes active.
    Closes,
    /// Contact or seat opens.
    Opens,
    /// Seat or gate shuts.
    Shuts,
    /// Gate opens.
    GateOpens,
    /// Gate shuts.
    GateShuts,
    /// Holes are uncovered.
    Uncovered,
    /// Holes are covered.
    Covered,
    /// Flow through the last restriction in flow direction becomes sonic.
    Choked,
    /// Flow through that restriction becomes subsonic.
    Unchoked,
    /// Flow or motion reverses.
    Reverses,
    /// Driver strikes the fastener.
    Struck,
    /// Driver leaves the fastener.
    Left,
    /// Tip enters the workpiece.
    Enters,
    /// Head reaches the surface.
    Seats,
    /// Fastener unloads.
    Unloads,
    /// Fastener reloads.
    Reloads,
    /// Friction sticks.
    Sticks,
    /// Friction slips.
    Slips,
    /// Latch catches.
    Catches,
    /// Latch releases.
    Releases,
    /// Motor runs.
    Runs,
    /// Motor stops.
    Stops,
    /// Trigger switches on.
    SwitchesOn,
    /// Trigger switches off.
    SwitchesOff,
}

impl Action {
    /// Whether one restriction of a passage logs the word, rather than the passage itself.
    pub(crate) fn is_of_restriction(self) -> bool {
        matches!(self, Self::Opens | Self::Shuts | Self::Uncovered | Self::Covered)
    }

    /// The word of the log.
    pub fn word(self) -> &'static str {
        match self {
            Self::Closes => "closes",
            Self::Opens => "opens",
            Self::GateOpens => "gate opens",
            Self::Shuts => "shuts",
            Self::GateShuts => "gate shuts",
            Self::Uncovered => "uncovered",
            Self::Covered => "covered",
            Self::Choked => "choked",
            Self::Unchoked => "unchoked",
            Self::Reverses => "reverses",
            Self::Struck => "struck",
            Self::Left => "left",
            Self::Enters => "enters",
            Self::Seats => "seats",
            Self::Unloads => "unloads",
            Self::Reloads => "reloads",
            Self::Sticks => "sticks",
            Self::Slips => "slips",
            Self::Catches => "catches",
            Self::Releases => "releases",
            Self::Runs => "runs",
            Self::Stops => "stops",
            Self::SwitchesOn => "switches on",
            Self::SwitchesOff => "switches off",
        }
    }
}

/// Boolean signal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trigger {
    /// Name.
    pub name: String,
    /// State at the start.
    pub starts: bool,
    /// Words that set it.
    pub set: Vec<Word>,
    /// Words that clear it; if empty, it stays set.
    pub clear: Vec<Word>,
    /// Scheduled changes: (time \[s\], state).
    pub schedule: Vec<(f64, bool)>,
}

/// Outcome of a shot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Word.
    pub name: String,
    /// Test.
    pub test: OutcomeTest,
}

/// Test of an outcome, evaluated at the end of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum OutcomeTest {
    /// An event happened (index).
    Happened(usize),
    /// An event did not happen (index).
    Missing(usize),
    /// An event happened before another, or that one did not happen (indices).
    Before(usize, usize),
    /// A condition on the state at the end.
    AtEnd(Condition),
}
