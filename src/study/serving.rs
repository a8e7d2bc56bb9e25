//! The study that applies to a design, and its statements about the levels of a run.

use std::collections::BTreeMap;

use serde::Serialize;

use super::draw_table::DrawTable;
use super::draws::{Draws, draws, nominal};
use super::provided::ProvidedStudy;
use super::request::{Request, Subset};
use super::result::{LevelStudy, StudyResult};
use super::study_store::{Found, store_study, stored_study};
use super::tolerance::STATED_FROM;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::result::{
    DecidingInput, Ends, LevelSpread, NoStudy, OrderShare, Provided, RunResult, RunStudy, StudySummary, Weighting,
};
use crate::stages::{Digest, Progress};
use crate::store::{Key, Store};
use crate::study::StudyError;

/// Maximum number of inputs named for their effect on the total.
const DECIDING: usize = 3;

/// Seed of screenings: the draws are the first ones of a study with the default seed.
const SEED: u64 = 1;

/// A study that applies to a design.
#[derive(Debug, Clone, Serialize)]
pub struct Serving {
    /// Its results.
    pub result: StudyResult,
    /// Weighting of the draws of another study; `None` for draws of this design.
    pub weighting: Option<Weighting>,
    /// Origin of a study that comes with the program; `None` for a study of the user.
    pub provided: Option<Provided>,
    /// Range of the decrease of the total if one source is silent, by source \[dB\]; empty for weighted draws.
    pub silencing: BTreeMap<String, [f64; 2]>,
}

impl Serving {
    /// The study that applies to a design: the largest in the store and in the program.
    ///
    /// # Errors
    /// If a design cannot be digested, or a provided study does not follow its layout.
    pub fn of(store: &Store, design: &Design) -> Result<Option<Self>, Error> {
        let (stored, provided) = (stored_study(store, design)?, ProvidedStudy::of(design)?);
        let of_user = |found: Found| Self {
            result: found.result,
            weighting: found.weighting,
            provided: None,
            silencing: found.silencing,
        };
        Ok(match (stored, provided) {
            (Some(stored), Some(provided)) if stored.size() >= provided.found.size() => Some(of_user(stored)),
            (_, Some(provided)) => Some(Self {
                provided: Some(Provided {
                    current: provided.study.is_of_this_code(),
                    command: provided.study.command,
                    version: provided.study.version,
                }),
                ..of_user(provided.found)
            }),
            (stored, None) => stored.map(of_user),
        })
    }

    /// The statements of the study about the levels of a run of the design.
    fn of_run(&self, design: &Design, run: &RunResult) -> RunStudy {
        match contradicting_outcome(design, run) {
            Some(contradiction) => RunStudy::Absent(contradiction),
            None => RunStudy::Known(Box::new(self.summary(run))),
        }
    }

    fn summary(&self, run: &RunResult) -> StudySummary {
        let study = &self.result;
        let level = |name: &str| match run.ranking.iter().find(|own| own.source == name) {
            Some(own) => own.lwa_db,
            None => run.total.lwa_db,
        };
        let spread = |name: &str, over_draws: &LevelStudy, first: Option<f64>| {
            let [low_db, median_db, high_db] = ends(over_draws, study.draws, level(name));
            LevelSpread {
                source: name.to_owned(),
                low_db,
                median_db,
                high_db,
                first,
                silencing_db: self.silencing.get(name).copied(),
            }
        };
        let sources = study.sources.iter();
        let sources: Vec<LevelSpread> = sources
            .map(|own| spread(&own.source, &own.level, own.first.value))
            .collect();
        let total = spread("total", &study.total, None);
        let outside = sources.iter().chain([&total]);
        let outside = outside.filter(|own| is_outside(own, level(&own.source)));
        let outside: Vec<String> = outside.map(|own| own.source.clone()).collect();
        let orders = study.orders.iter().map(|own| OrderShare {
            order: own.order.clone(),
            share: own.probability.value.unwrap_or(0.0),
        });
        let of_total = study.contributions.iter().filter(|own| own.output == "total");
        let deciding = of_total.flat_map(|own| &own.inputs).map(|own| DecidingInput {
            variable: own.variable.clone(),
            first_order: own.first_order,
            half_width: own.part().half_width(),
        });
        let mut summary = StudySummary {
            design: study.design.clone(),
            draws: study.draws,
            ends: match study.draws {
                STATED_FROM.. => Ends::Percentiles,
                _ => Ends::Extremes,
            },
            structures: study.structures,
            require: study.require.clone(),
            provided: self.provided.clone(),
            weighting: self.weighting.clone(),
            sources,
            total,
            outside,
            orders: orders.collect(),
            deciding: deciding.take(DECIDING).collect(),
        };
        if !summary.outside.is_empty() {
            for own in &mut summary.sources {
                (own.first, own.silencing_db) = (None, None);
            }
            summary.orders.clear();
            summary.deciding.clear();
        }
        summary
    }
}

/// Lower end, median and upper end of a level over this number of draws; the level is `own` in the run \[dB\].
fn ends(level: &LevelStudy, draws: usize, own: Option<f64>) -> [Option<f64>; 3] {
    if draws >= STATED_FROM {
        let quantiles = &level.level_db;
        return [quantiles.p05, quantiles.p50, quantiles.p95].map(|quantile| quantile.value);
    }
    let [low, high] = level.extremes_db;
    // Silence is lower than every level.
    let low = low.zip(own).map(|(low, own)| low.min(own));
    [low, None, [high, own].into_iter().flatten().reduce(f64::max)]
}

/// Whether a level \[dB\] is outside its interval; silence is lower than every level.
fn is_outside(spread: &LevelSpread, level: Option<f64>) -> bool {
    match level {
        Some(own) => spread.low_db.is_some_and(|low| own < low) || spread.high_db.is_none_or(|high| own > high),
        None => spread.low_db.is_some(),
    }
}

/// The reason why no draw of a study is a shot like that of a run: its outcome is not one that counts.
fn contradicting_outcome(design: &Design, run: &RunResult) -> Option<NoStudy> {
    let (require, outcome) = (&design.study().require, &run.outcome);
    if require.is_empty() || require.contains(outcome) {
        return None;
    }
    let [own, counted] = [outcome.clone(), require.join(" or ")].map(|words| words.replace('_', " "));
    Some(NoStudy {
        reason: format!(
            "the shot ends as \"{own}\", and `study.require` counts only \"{counted}\": no interval, no P(first) and \
             no \
             K are stated; correct values of the design, or the condition"
        ),
        unmet: Some(counted),
    })
}

/// Origin of the intervals of a run, decided before it is computed.
#[derive(Debug, Clone)]
pub enum StudySource {
    /// A study that exists.
    Known(Box<Serving>),
    /// A screening: a few draws that are made after the run.
    Screening(Request),
    /// None, for this reason.
    Absent(String),
}

impl StudySource {
    /// The source for a run of a design; `screening` is whether a few draws may be made.
    pub fn find(store: &Store, design: &Design, screening: bool) -> Self {
        let request = Request::new(design.study().screening as usize, SEED);
        match Serving::of(store, design) {
            Ok(Some(serving)) => Self::Known(Box::new(serving)),
            Err(error) => Self::Absent(error.to_string()),
            Ok(None) if request.draws == 0 => Self::Absent("`study.screening` is 0".to_owned()),
            Ok(None) if store.folder().is_none() => Self::Absent("without the cache no study is known".to_owned()),
            Ok(None) if screening => Self::Screening(request),
            Ok(None) => Self::Absent("no study serves this design, and no draws were made for it".to_owned()),
        }
    }

    /// The known statements about the levels of a run of the design.
    pub fn of_run(&self, design: &Design, run: &RunResult) -> RunStudy {
        let none = |reason: String| match contradicting_outcome(design, run) {
            Some(contradiction) => RunStudy::Absent(contradiction),
            None => RunStudy::absent(reason),
        };
        match self {
            Self::Known(serving) => serving.of_run(design, run),
            Self::Screening(request) => none(format!("the screening of {} draws has not ended", request.draws)),
            Self::Absent(reason) => none(reason.clone()),
        }
    }

    /// Whether a run is to be followed by a screening; none is made if no draw can have the outcome of the shot.
    pub fn awaits_screening(&self, design: &Design, run: &RunResult) -> bool {
        matches!(self, Self::Screening(_)) && contradicting_outcome(design, run).is_none()
    }

    /// The source after its screening, which is stored; a source that needs none is returned unchanged.
    #[must_use]
    pub fn screened(self, store: &Store, design: &Design, progress: &Progress) -> Self {
        let Self::Screening(request) = self else { return self };
        progress.note(&format!(
            "no study serves this design: {} draws give a first impression of the uncertainty; \
             `nailnoise study` makes more",
            request.draws
        ));
        match study(store, design, &request, progress) {
            Ok((result, made)) => Self::Known(Box::new(Serving {
                result,
                weighting: None,
                provided: None,
                silencing: DrawTable::of(&made).silencing(),
            })),
            Err(error) => Self::Absent(error.to_string()),
        }
    }

    /// The part of a key that distinguishes the results of one design.
    pub fn digest(&self) -> Digest {
        match self {
            Self::Known(serving) => Key::empty().with(serving),
            Self::Screening(request) => Key::empty().with("screening").with(&request.draws),
            Self::Absent(reason) => Key::empty().with(reason),
        }
        .digest()
    }
}

/// Makes a study of a design and stores it for later runs; also returns its draws.
///
/// # Errors
/// The errors of [`draws`]; [`StudyError::NotCollected`] if draws are missing that were to be read only.
pub fn study(
    store: &Store,
    design: &Design,
    request: &Request,
    progress: &Progress,
) -> Result<(StudyResult, Draws), Error> {
    let graph = Graph::quiet(store, progress.observer());
    let made = draws(&graph, design, request, progress)?;
    if request.part == Subset::Kept && !made.failures.is_empty() {
        return Err(StudyError::NotCollected {
            missing: made.failures.len(),
            draws: made.failures.len() + made.draws.len(),
            store: store.folder().map(std::path::Path::to_owned).unwrap_or_default(),
        }
        .into());
    }
    progress.stage("levels of the design itself");
    let nominal = nominal(&graph, design, request)?;
    progress.stage("statistics");
    let result = StudyResult::new(design, request, &made, nominal.as_deref());
    store_study(store, design, &result, &made)?;
    Ok((result, made))
}
