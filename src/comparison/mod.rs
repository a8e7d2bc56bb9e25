//! Compares designs: their differences, and the effects of these on sources, bands, intervals and cycle.
//!
//! A comparison needs only finished results, so designs computed on different days can be compared as well as those
//! just run. The first result is the reference, to which changes refer.

mod consistency;
mod differences;
mod error;
mod finished;
mod ranges;

use serde::Serialize;

use crate::model::sources;
use crate::result::{Performance, RankedSource, StudySummary, TOTAL};
use crate::stages::cycle::EventWords;
use crate::stages::headline::{Headline, unlike};
use crate::wording::{Placed, unit_of_figure};

pub use differences::InputRow;
pub use error::ComparisonError;
use finished::in_order;
pub use finished::{Finished, Input};

/// Version of the layout of [`Comparison`].
pub const SCHEMA: &str = "nailnoise-compare/1";

/// Results being compared; every list of values has one entry per result, in the order given.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// Names of the designs, the reference first.
    pub designs: Vec<String>,
    /// Frequency range of the levels of each result \[Hz\] if the ranges differ; null if they are the same. If they
    /// differ, changes are not due only to the designs.
    pub unlike_ranges: Option<Vec<[f64; 2]>>,
    /// Keys and fields of assemblies whose values differ; a block that is missing from a design is one row.
    pub inputs: Vec<InputRow>,
    /// Results of an earlier version without the fields of their assembly, so that only numbers are compared.
    pub without_assembly: Vec<String>,
    /// Outcomes of the shots.
    pub outcomes: Vec<String>,
    /// Headline of each shot; null if the nail is driven and the exhaust opens.
    pub headlines: Vec<Option<Headline>>,
    /// Why the levels must not be compared, if the shots end differently; null if they end alike.
    pub unlike: Option<String>,
    /// Sources in the order of the reference's ranking, followed by sources that are not in it.
    pub sources: Vec<SourceRow>,
    /// A-weighted level of all sources together \[dB re 1 pW s\].
    pub total: Levels,
    /// Intervals of the levels of each design from the study that applies to it; null without one.
    pub studies: Vec<Option<StudySummary>>,
    /// Reserve of the drive, air per shot, and rate of each design; null for a result of an earlier version.
    pub performance: Vec<Option<Performance>>,
    /// Sources of each design, loudest first.
    pub rankings: Vec<Vec<String>>,
    /// Figures of the cycle, SI units.
    pub cycle: Vec<ValueRow>,
    /// Event times \[s\].
    pub events: Vec<ValueRow>,
    /// Descriptions of the events.
    #[serde(skip)]
    pub(crate) event_words: EventWords,
}

/// A number of each result.
#[derive(Debug, Clone, Serialize)]
pub struct ValueRow {
    /// Name of the quantity.
    pub name: String,
    /// Unit of its values; empty if they have none.
    pub unit: &'static str,
    /// Its values; null for none.
    pub values: Vec<Option<f64>>,
}

/// A level of each result.
#[derive(Debug, Clone, Serialize)]
pub struct Levels {
    /// Levels \[dB\]; null if silent.
    pub level_db: Vec<Option<f64>>,
    /// Changes from the reference \[dB\]; null if either is silent.
    pub change_db: Vec<Option<f64>>,
}

impl Levels {
    fn new(level_db: Vec<Option<f64>>) -> Self {
        let reference = level_db.first().copied().flatten();
        let change_db = level_db.iter().map(|level| Some((*level)? - reference?)).collect();
        Self { level_db, change_db }
    }
}

/// A source of each result.
#[derive(Debug, Clone, Serialize)]
pub struct SourceRow {
    /// `workpiece`, `exhaust` or `body`.
    pub source: String,
    /// A-weighted level over the common range \[dB re 1 pW s\].
    #[serde(flatten)]
    pub levels: Levels,
    /// Method by which each was computed; if the methods differ, their errors do not cancel in the change.
    pub methods: Vec<Option<String>>,
    /// Uncertainty of each method, \[dB\] below and above the level; null if the method gives no bound.
    pub uncertainty_db: Vec<[Option<f64>; 2]>,
    /// A-weighted one-third-octave levels, by nominal mid-band frequency \[Hz\].
    pub bands: Vec<Labelled>,
    /// A-weighted levels of the intervals between events.
    pub intervals: Vec<Labelled>,
}

/// A labelled level of each result.
#[derive(Debug, Clone, Serialize)]
pub struct Labelled {
    /// Band or interval.
    pub label: String,
    /// The levels.
    #[serde(flatten)]
    pub levels: Levels,
}

/// A level that must not be exceeded.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// A source, or `total`.
    pub of: String,
    /// The limit \[dB re 1 pW s\], A-weighted.
    pub level_db: f64,
}

impl std::str::FromStr for Limit {
    type Err = String;

    /// Reads `SOURCE=DB`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (of, level) = text
            .split_once('=')
            .ok_or_else(|| "expected SOURCE=DB, as in total=100 or exhaust=95.5".to_owned())?;
        let known: Vec<&str> = std::iter::once(TOTAL).chain(sources::names()).collect();
        if !known.contains(&of) {
            return Err(format!("`{of}` is not a source: choose one of {}", known.join(", ")));
        }
        match level.parse::<f64>() {
            Ok(level_db) if level_db.is_finite() => Ok(Self {
                of: of.to_owned(),
                level_db,
            }),
            _ => Err(format!("`{level}` is not a level in dB")),
        }
    }
}

impl Comparison {
    /// What to say if no input differs.
    pub(crate) fn no_difference(&self) -> &'static str {
        match self.without_assembly.is_empty() {
            true => "none: the designs have the same values",
            false => "none among the numbers; blocks, formulas and switches are not compared",
        }
    }

    /// Warnings to show before the levels: different frequency ranges, different outcomes, and how each shot ended that
    /// does not drive its nail.
    pub fn alarms(&self) -> Vec<String> {
        let named = self.designs.iter().zip(&self.headlines);
        let ends = named.filter_map(|(name, headline)| Some((name, headline.as_ref()?)));
        let ends =
            ends.flat_map(|(name, headline)| headline.lines().into_iter().map(move |line| format!("{name}: {line}")));
        let ranges = self
            .unlike_ranges
            .as_ref()
            .map(|own| ranges::warning(&self.designs, own));
        let texts = differences::warning(&self.without_assembly);
        let all = ranges.into_iter().chain(texts).chain(self.unlike.clone());
        all.chain(ends).collect()
    }

    /// The sources of a design in the order of its ranking, with levels and bands.
    pub(crate) fn placed(&self, design: usize) -> Vec<Placed<'_>> {
        let of_source = |name: &'_ String| {
            let row = self.sources.iter().find(|row| row.source == *name)?;
            Some((
                row.source.as_str(),
                row.levels.level_db[design],
                row.uncertainty_db[design],
            ))
        };
        self.rankings[design].iter().filter_map(of_source).collect()
    }

    /// Compares results.
    pub fn new(results: &[Finished]) -> Self {
        let each = |f: &dyn Fn(&Finished) -> Option<f64>| results.iter().map(f).collect::<Vec<_>>();
        let sources = in_order(results, |r| r.ranking.iter().map(|s| s.source.clone()).collect());
        let cycle = in_order(results, |r| r.cycle.iter().map(|(name, _)| name.clone()).collect());
        let mut events = in_order(results, |r| r.events.keys().cloned().collect());
        let headlines: Vec<Option<Headline>> = results.iter().map(Finished::headline).collect();
        let ends = results.iter().zip(&headlines);
        let unlike = unlike(ends.map(|(result, headline)| (result.name(), headline.as_ref())));
        events.sort_by_key(|name| name.trim_start_matches('t').parse::<u32>().unwrap_or(u32::MAX));
        Self {
            schema: SCHEMA,
            designs: results.iter().map(|r| r.design.name.clone()).collect(),
            unlike_ranges: ranges::unlike(results),
            inputs: differences::inputs(results),
            without_assembly: differences::without_assembly(results),
            outcomes: results.iter().map(|r| r.outcome.clone()).collect(),
            headlines,
            unlike,
            sources: sources.iter().map(|source| source_row(source, results)).collect(),
            total: Levels::new(each(&|r| r.total.lwa_db)),
            studies: results.iter().map(Finished::study).collect(),
            performance: results.iter().map(|r| r.performance).collect(),
            rankings: results
                .iter()
                .map(|r| r.ranking.iter().map(|s| s.source.clone()).collect())
                .collect(),
            cycle: cycle
                .into_iter()
                .map(|name| ValueRow {
                    values: each(&|r| r.cycle.get(&name).and_then(serde_json::Value::as_f64)),
                    unit: unit_of_figure(&name),
                    name,
                })
                .collect(),
            events: events
                .into_iter()
                .map(|name| ValueRow {
                    values: each(&|r| r.events.get(&name).copied().flatten()),
                    unit: "s",
                    name,
                })
                .collect(),
            event_words: EventWords::joined(results.iter().map(|r| &r.event_words)),
        }
    }

    /// Describes the values that exceed a limit. The limits do not apply to the reference, which the other designs are
    /// meant to improve.
    pub fn exceeded(&self, limits: &[Limit]) -> Vec<String> {
        let mut found = Vec::new();
        for limit in limits {
            let levels = if limit.of == "total" {
                Some(&self.total)
            } else {
                self.sources
                    .iter()
                    .find(|row| row.source == limit.of)
                    .map(|row| &row.levels)
            };
            let levels = levels.map_or(&[][..], |levels| &levels.level_db);
            for (design, level) in self.designs.iter().zip(levels).skip(1) {
                if let Some(level) = level.filter(|level| *level > limit.level_db) {
                    let (of, allowed) = (&limit.of, limit.level_db);
                    found.push(format!(
                        "{design}: {of} at {level:.1} dB is above the limit of {allowed:.1} dB"
                    ));
                }
            }
        }
        found
    }
}

fn source_row(source: &str, results: &[Finished]) -> SourceRow {
    let found: Vec<_> = results
        .iter()
        .map(|result| result.ranking.iter().find(|ranked| ranked.source == source))
        .collect();
    let labelled = |labels: Vec<String>, level: &dyn Fn(&RankedSource, &str) -> Option<f64>| {
        labels
            .into_iter()
            .map(|label| {
                let of_each = found
                    .iter()
                    .map(|ranked| ranked.and_then(|ranked| level(ranked, &label)));
                Labelled {
                    levels: Levels::new(of_each.collect()),
                    label,
                }
            })
            .collect()
    };
    let names = |labels: &dyn Fn(&RankedSource) -> Vec<String>| {
        in_order(results, |result| {
            let ranked = result.ranking.iter().find(|ranked| ranked.source == source);
            ranked.map_or_else(Vec::new, labels)
        })
    };
    let bands = names(&|ranked| ranked.bands.iter().map(|band| band.label()).collect());
    let intervals = names(&|ranked| ranked.intervals.iter().map(|interval| interval.label()).collect());
    SourceRow {
        source: source.to_owned(),
        levels: Levels::new(found.iter().map(|ranked| ranked.and_then(|r| r.lwa_db)).collect()),
        methods: found.iter().map(|ranked| ranked.map(|r| r.method.clone())).collect(),
        uncertainty_db: found
            .iter()
            .map(|ranked| ranked.map_or([None; 2], |r| r.uncertainty_db.bounds()))
            .collect(),
        bands: labelled(bands, &|ranked, label| {
            ranked.bands.iter().find(|band| band.label() == label)?.lwa_db
        }),
        intervals: labelled(intervals, &|ranked, label| {
            ranked
                .intervals
                .iter()
                .find(|interval| interval.label() == label)?
                .lwa_db
        }),
    }
}
