//! The statements of a study about the levels of a run.

use nailnoise_quantities::Check;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::design_id::DesignId;

/// Levels of a run over the draws of a study that applies to its design, or the reason why there are none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum RunStudy {
    /// A study applies to the design.
    Known(Box<StudySummary>),
    /// No intervals, no P(first) and no K are stated.
    Absent(NoStudy),
}

/// Reason why a run states no intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoStudy {
    /// The reason.
    pub reason: String,
    /// Outcomes that a study of the design counts, if the outcome of the design's shot is not among them; null
    /// otherwise.
    pub unmet: Option<String>,
}

/// The results of a study that concern the levels of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudySummary {
    /// The design of the study: that of the run, or one whose draws also apply to it.
    pub design: DesignId,
    /// Number of draws. Weighted draws count by their effective number.
    pub draws: usize,
    /// Meaning of the ends of the intervals.
    pub ends: Ends,
    /// Number of structures that were drawn; 0 if all draws use those of the design.
    pub structures: usize,
    /// Outcomes that count; if empty, all count.
    pub require: Vec<String>,
    /// The command that made a study that comes with the program; null for a study from the cache.
    pub provided: Option<Provided>,
    /// How draws of another study are weighted; null for draws of this design.
    pub weighting: Option<Weighting>,
    /// Levels of each source, loudest median first.
    pub sources: Vec<LevelSpread>,
    /// Level of all sources together.
    pub total: LevelSpread,
    /// Sources, and the total, whose level in the run is outside their interval: the values of the design contradict
    /// its ranges. No P(first), no order, no K and no important inputs are stated then.
    pub outside: Vec<String>,
    /// Orders of the sources, the most frequent first.
    pub orders: Vec<OrderShare>,
    /// The inputs that explain most of the variance of the total; empty with too few draws.
    pub deciding: Vec<DecidingInput>,
}

/// Meaning of the ends of intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ends {
    /// 5th and 95th percentile of the draws.
    Percentiles,
    /// The lowest and the highest level of the draws and of the run, because there are too few draws for percentiles.
    Extremes,
}

/// Levels of a source, or of all together, over the draws \[dB re 1 pW s\]; null for silence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LevelSpread {
    /// The source, or `total`.
    pub source: String,
    /// Lower end of the interval.
    pub low_db: Option<f64>,
    /// Median of the draws; null if there are too few or if silent.
    pub median_db: Option<f64>,
    /// Upper end of the interval.
    pub high_db: Option<f64>,
    /// Fraction of the draws in which it is the loudest source, an estimate of P(first); null for the total, or if it
    /// is not stated.
    pub first: Option<f64>,
    /// Fall of the total where this source alone is silent \[dB\]: ends over the draws, with the meaning of `ends`.
    /// Null for the total, for weighted draws, or where it is not stated.
    #[serde(default)]
    pub silencing_db: Option<[f64; 2]>,
}

/// An order of the sources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OrderShare {
    /// Sources, loudest first.
    pub order: Vec<String>,
    /// Fraction of the draws with this order.
    pub share: f64,
}

/// An input with a large effect on the total.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DecidingInput {
    /// The variable.
    pub variable: String,
    /// Fraction of the variance that it explains alone \[-\].
    pub first_order: f64,
    /// Half of the 90 % interval of this fraction over resampled draws; null if unknown.
    pub half_width: Option<f64>,
}

/// Origin of a study that comes with the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Provided {
    /// The command that made it.
    pub command: String,
    /// Version of the program that made it.
    pub version: String,
    /// Whether the code that computes levels has not changed since.
    pub current: bool,
}

/// How the draws of another study are weighted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Weighting {
    /// Number of draws of the study.
    pub draws: usize,
    /// Equivalent number of draws without weights.
    pub effective: f64,
    /// The quantities whose distributions differ.
    pub keys: Vec<String>,
}

impl RunStudy {
    /// No study, for this reason.
    pub fn absent(reason: impl Into<String>) -> Self {
        Self::Absent(NoStudy {
            reason: reason.into(),
            unmet: None,
        })
    }

    /// The study, if there is one.
    pub fn known(&self) -> Option<&StudySummary> {
        match self {
            Self::Known(summary) => Some(summary),
            Self::Absent(_) => None,
        }
    }

    /// The check that fails if the design contradicts its draws.
    pub fn contradiction(&self) -> Option<Check> {
        let name = match self {
            Self::Known(summary) if summary.outside.is_empty() => return None,
            Self::Known(summary) => format!("level of {} within its interval of draws", summary.outside.join(", ")),
            Self::Absent(none) => format!(
                "the outcome of the shot is the one that `study.require` counts ({})",
                none.unmet.as_ref()?
            ),
        };
        Some(Check::at_most(name, 1.0, 0.0))
    }
}

impl StudySummary {
    /// Levels of a source, or of the total for another name.
    pub fn spread(&self, source: &str) -> &LevelSpread {
        let own = self.sources.iter().find(|own| own.source == source);
        own.unwrap_or(&self.total)
    }
}
