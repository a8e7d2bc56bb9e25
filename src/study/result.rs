//! Results from the draws of a study; the JSON Schema of `study --json` and of `study.json` is derived from these
//! types.

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use super::condition::{Condition, condition};
use super::contributions::{Contributions, contributions};
use super::draws::{Draw, Draws};
use super::groups::GroupStudy;
use super::level_table::{LevelTable, total_of};
use super::notes::notes;
use super::one_at_a_time::OneAtATime;
use super::request::Request;
use super::statistics::{Bootstrap, Estimate, Quantiles, benefit, loss, order, weighted_mean};
use super::surrogate::{Surrogate, surrogates};
use super::tolerance::STATED_FROM;
use super::variable_report::{VariableReport, variable_reports};
use crate::design::Design;
use crate::result::{DesignId, schema_of};
use crate::stages::headline::Headline;
use crate::stages::levels::Levels;

/// Version of the layout of [`StudyResult`].
pub const SCHEMA: &str = "nailnoise-study/1";

/// The result of `nailnoise study`. Levels are A-weighted single-event sound power levels in dB re 1 pW s. Further keys
/// may be added.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "Result of nailnoise study")]
pub struct StudyResult {
    /// Version of the layout; it changes when a reader of the old layout would misread the new one.
    #[schemars(extend("const" = SCHEMA))]
    pub schema: String,
    /// The design of this study.
    pub design: DesignId,
    /// Seed of the draws.
    pub seed: u64,
    /// Outcome of the shot of the design itself, if it does not drive; null otherwise.
    #[serde(default)]
    pub headline: Option<Headline>,
    /// Number of draws that count.
    pub draws: usize,
    /// Number of structures drawn; 0 if those of the design were fixed.
    pub structures: usize,
    /// Outcomes with which a shot counts; if empty, all count.
    pub require: Vec<String>,
    /// Numbers of all candidates by their fate.
    pub candidates: Candidates,
    /// Each source, in the order of the design's own ranking by P50.
    pub sources: Vec<SourceStudy>,
    /// All sources together.
    pub total: LevelStudy,
    /// Probability of each order of the sources, loudest first.
    pub orders: Vec<OrderProbability>,
    /// Probability that one source is louder than another.
    pub louder: Vec<Louder>,
    /// Expected loss of a decision that a perfect knowledge of all inputs would avoid, if one source is silenced
    /// \[dB\].
    pub perfect_information_db: Estimate,
    /// The inputs that affect each level, largest contribution first.
    pub contributions: Vec<Contributions>,
    /// The inputs that determine whether a shot counts; null with too few candidates, or if nearly all of them count.
    #[serde(default)]
    pub condition: Option<Condition>,
    /// The groups of inputs that affect each level; null without `--groups`.
    #[serde(default)]
    pub groups: Option<GroupStudy>,
    /// Polynomial surrogates of the levels, by `nailnoise study`; empty with too few draws.
    #[serde(default)]
    pub surrogates: Vec<Surrogate>,
    /// The effect of each input on the levels of the design itself; null without `--one-at-a-time`.
    #[serde(default)]
    pub one_at_a_time: Option<OneAtATime>,
    /// P50 of the total and P(first) of each source over the first draws, doubling.
    pub convergence: Vec<Convergence>,
    /// The drawn variables.
    pub variables: Vec<VariableReport>,
    /// Notes that a reader must know in addition to the numbers.
    pub notes: Vec<String>,
}

/// Numbers of candidates by their fate.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Candidates {
    /// Number of candidates drawn.
    pub drawn: u64,
    /// Number of shots by outcome, `dry_fire` or `solver_failure`.
    pub outcomes: BTreeMap<String, u64>,
    /// Number of candidates that are not valid designs, by reason.
    pub refused: BTreeMap<String, u64>,
    /// Number of values drawn again because they conflict, by their keys.
    pub rejections: BTreeMap<String, u64>,
    /// Number of draws that could not be computed.
    pub failures: usize,
}

/// Levels over the draws.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LevelStudy {
    /// Level of the design itself; null if it is silent or cannot be computed.
    pub nominal_db: Option<f64>,
    /// Fraction of the draws below the level of the design itself.
    pub below_nominal: Option<f64>,
    /// Lowest and highest level of the draws; null for silence.
    pub extremes_db: [Option<f64>; 2],
    /// P5, P50 and P95 of the draws.
    pub level_db: Quantiles,
}

impl LevelStudy {
    /// P5 and P95 of this number of draws; for fewer than [`STATED_FROM`], the lowest and the highest, which have no
    /// interval.
    pub fn ends(&self, draws: usize) -> [Estimate; 2] {
        if draws >= STATED_FROM {
            return [self.level_db.p05, self.level_db.p95];
        }
        self.extremes_db.map(|value| Estimate {
            value,
            interval: [None; 2],
        })
    }
}

/// Names of [`LevelStudy::ends`] for this number of draws.
pub fn names_of_ends(draws: usize) -> [&'static str; 2] {
    match draws {
        STATED_FROM.. => ["P5", "P95"],
        _ => ["lowest", "highest"],
    }
}

/// A source over the draws.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SourceStudy {
    /// `workpiece`, `exhaust` or `body`.
    pub source: String,
    /// Its level.
    pub level: LevelStudy,
    /// Probability that it is the loudest.
    pub first: Estimate,
    /// Expected distance to the loudest source: the loss if this one is taken for the loudest \[dB\].
    pub loss_db: Estimate,
    /// Expected reduction of the total if it is silent \[dB\].
    pub silencing_db: Estimate,
    /// One-third-octave bands.
    pub bands: Vec<LabelledStudy>,
    /// Intervals between adjacent events.
    pub intervals: Vec<LabelledStudy>,
}

/// Levels of a band or interval over the draws.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LabelledStudy {
    /// Mid-band frequency \[Hz\], or the events at both ends.
    pub label: String,
    /// Number of draws that have it; the order of events may differ.
    pub draws: usize,
    /// P5, P50 and P95.
    pub level_db: Quantiles,
}

/// Probability of an order.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct OrderProbability {
    /// Sources, loudest first.
    pub order: Vec<String>,
    /// Its probability.
    pub probability: Estimate,
}

/// Probability that one source is louder than another.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Louder {
    /// The louder source.
    pub source: String,
    /// The quieter source.
    pub than: String,
    /// The probability.
    pub probability: Estimate,
}

/// Results over the first draws.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Convergence {
    /// Number of draws.
    pub draws: usize,
    /// P50 of the total \[dB re 1 pW s\].
    pub total_p50_db: Estimate,
    /// P(first) of each source, in the order of `sources`.
    pub first: Vec<Estimate>,
}

impl StudyResult {
    /// JSON Schema (draft 2020-12) of a result.
    pub fn json_schema() -> Schema {
        schema_of::<Self>()
    }

    /// States the results of draws of a design whose nominal levels are `nominal`.
    pub fn new(design: &Design, request: &Request, made: &Draws, nominal: Option<&Levels>) -> Self {
        let draws = &made.draws;
        let table = LevelTable::new(draws);
        let clusters: Vec<usize> = draws.iter().map(|draw| draw.structure).collect();
        let bootstrap = Bootstrap::new(&clusters);
        let count = table.names.len();
        let totals = table.totals();
        let nominal_of = |name: &str| nominal?.sources.iter().find(|own| own.source == name)?.lwa_db;
        let level = |levels: &[f64], nominal_db: Option<f64>| LevelStudy {
            nominal_db,
            below_nominal: nominal_db.map(|nominal| {
                levels.iter().filter(|level| **level < nominal).count() as f64 / levels.len().max(1) as f64
            }),
            extremes_db: [f64::INFINITY, f64::NEG_INFINITY].map(|start| {
                let further = if start > 0.0 { f64::min } else { f64::max };
                let end = levels.iter().copied().fold(start, further);
                end.is_finite().then_some(end)
            }),
            level_db: bootstrap.quantiles(levels),
        };
        let mut sources: Vec<SourceStudy> = (0..count)
            .into_par_iter()
            .map(|source| {
                let name = &table.names[source];
                let figures = |of: fn(&[f64], usize) -> f64| -> Vec<f64> {
                    table.levels.iter().map(|levels| of(levels, source)).collect()
                };
                let first: Vec<bool> = table.levels.iter().map(|levels| order(levels)[0] == source).collect();
                SourceStudy {
                    source: name.clone(),
                    level: level(&table.column(source), nominal_of(name)),
                    first: bootstrap.share(&first),
                    loss_db: bootstrap.mean(&figures(loss)),
                    silencing_db: bootstrap.mean(&figures(benefit)),
                    bands: labelled(draws, source, (&clusters, &bootstrap), |source| {
                        source
                            .bands
                            .iter()
                            .map(|(hz, level)| (hz.to_string(), *level))
                            .collect()
                    }),
                    intervals: labelled(draws, source, (&clusters, &bootstrap), |source| {
                        source.intervals.clone()
                    }),
                }
            })
            .collect();
        let median = |source: &SourceStudy| source.level.level_db.p50.value.unwrap_or(f64::NEG_INFINITY);
        sources.sort_by(|a, b| median(b).total_cmp(&median(a)));
        let figures =
            |of: &dyn Fn(&[f64]) -> f64| -> Vec<f64> { table.levels.iter().map(|levels| of(levels)).collect() };
        let of_each: Vec<Vec<f64>> = (0..count)
            .map(|source| figures(&|levels| benefit(levels, source)))
            .collect();
        let best = figures(&|levels| (0..count).map(|source| benefit(levels, source)).fold(0.0, f64::max));
        let perfect = bootstrap.estimate(|counts| {
            let of_one = of_each.iter().map(|benefits| weighted_mean(benefits, counts));
            weighted_mean(&best, counts) - of_one.fold(0.0, f64::max)
        });
        let names: Vec<String> = sources.iter().map(|source| source.source.clone()).collect();
        let variables = variable_reports(request, made);
        let mut notes = notes(design, request, made, &variables);
        if (2..10).contains(&made.structures) {
            notes.push(format!(
                "only {} structures were drawn: the intervals of the estimates are too narrow below ten",
                made.structures
            ));
        }
        Self {
            schema: SCHEMA.to_owned(),
            design: DesignId::from(design),
            seed: request.seed,
            headline: None,
            draws: draws.len(),
            structures: made.structures,
            require: design.study().require.clone(),
            candidates: Candidates {
                drawn: made.tally.candidates,
                outcomes: made.tally.outcomes.clone(),
                refused: made.tally.refused.clone(),
                rejections: made.tally.rejections.clone(),
                failures: made.failures.len() + made.tally.failures.len(),
            },
            total: level(&totals, nominal.and_then(total_of)),
            orders: orders(&table, &bootstrap),
            louder: louder(&table, &bootstrap, &names),
            perfect_information_db: perfect,
            contributions: contributions(made, &table, &names, &bootstrap),
            condition: condition(&made.tally.condition, &made.variables),
            groups: None,
            surrogates: Vec::new(),
            one_at_a_time: None,
            convergence: convergence(&table, &totals, &clusters, &names),
            variables,
            notes,
            sources,
        }
    }

    /// The same with surrogates of the levels, which take a second or two to compute.
    #[must_use]
    pub fn with_surrogates(mut self, design: &Design, made: &Draws) -> Self {
        let names: Vec<String> = self.sources.iter().map(|source| source.source.clone()).collect();
        self.surrogates = surrogates(design, made, &names);
        self
    }

    /// A source by its name.
    pub fn source(&self, name: &str) -> Option<&SourceStudy> {
        self.sources.iter().find(|source| source.source == name)
    }
}

/// Quantiles of bands or intervals of a source.
fn labelled(
    draws: &[Draw],
    source: usize,
    (clusters, bootstrap): (&[usize], &Bootstrap),
    of: impl Fn(&crate::stages::levels::SourceLevels) -> Vec<(String, Option<f64>)>,
) -> Vec<LabelledStudy> {
    let mut found: Vec<(String, Vec<f64>, Vec<usize>)> = Vec::new();
    for (draw, cluster) in draws.iter().zip(clusters) {
        let Some(levels) = draw.levels.sources.get(source) else {
            continue;
        };
        for (label, level) in of(levels) {
            let level = level.map_or(f64::NEG_INFINITY, |level| level + draw.method_db[source]);
            match found.iter_mut().find(|(own, ..)| *own == label) {
                Some((_, levels, clusters)) => {
                    levels.push(level);
                    clusters.push(*cluster);
                }
                None => found.push((label, vec![level], vec![*cluster])),
            }
        }
    }
    let study = |(label, levels, clusters): (String, Vec<f64>, Vec<usize>)| LabelledStudy {
        label,
        draws: levels.len(),
        level_db: if levels.len() == draws.len() {
            bootstrap.quantiles(&levels)
        } else {
            Bootstrap::new(&clusters).quantiles(&levels)
        },
    };
    found.into_iter().map(study).collect()
}

fn orders(table: &LevelTable, bootstrap: &Bootstrap) -> Vec<OrderProbability> {
    let places: Vec<Vec<usize>> = table.levels.iter().map(|levels| order(levels)).collect();
    let mut seen = places.clone();
    seen.sort();
    seen.dedup();
    let probability = |own: &Vec<usize>| {
        let is_so: Vec<bool> = places.iter().map(|places| places == own).collect();
        OrderProbability {
            order: own.iter().map(|&source| table.names[source].clone()).collect(),
            probability: bootstrap.share(&is_so),
        }
    };
    let mut orders: Vec<OrderProbability> = seen.iter().map(probability).collect();
    orders.sort_by(|a, b| {
        b.probability
            .value
            .unwrap_or(0.0)
            .total_cmp(&a.probability.value.unwrap_or(0.0))
    });
    orders
}

fn louder(table: &LevelTable, bootstrap: &Bootstrap, names: &[String]) -> Vec<Louder> {
    let pairs = names
        .iter()
        .enumerate()
        .flat_map(|(k, a)| names[k + 1..].iter().map(move |b| (a, b)));
    let pair = |(a, b): (&String, &String)| {
        let (first, second) = (table.place(a), table.place(b));
        let is_so: Vec<bool> = table
            .levels
            .iter()
            .map(|levels| levels[first] > levels[second])
            .collect();
        Louder {
            source: a.clone(),
            than: b.clone(),
            probability: bootstrap.share(&is_so),
        }
    };
    pairs.map(pair).collect()
}

fn convergence(table: &LevelTable, totals: &[f64], clusters: &[usize], names: &[String]) -> Vec<Convergence> {
    let n = totals.len();
    let halves = std::iter::successors(Some(n), |draws| (draws / 2 >= 8).then_some(draws / 2));
    let mut sizes: Vec<usize> = halves.collect();
    sizes.reverse();
    let at = |draws: usize| {
        let bootstrap = Bootstrap::new(&clusters[..draws]);
        let first = |name: &String| {
            let is_so = |levels: &Vec<f64>| table.names[order(levels)[0]] == *name;
            bootstrap.share(&table.levels[..draws].iter().map(is_so).collect::<Vec<_>>())
        };
        Convergence {
            draws,
            total_p50_db: bootstrap.quantiles(&totals[..draws]).p50,
            first: names.iter().map(first).collect(),
        }
    };
    sizes.into_iter().map(at).collect()
}
