//! Intervals of a design's levels: from a study that serves it, else from a screening of a few draws.

use std::borrow::Cow;
use std::fmt::Write as _;

use serde::Deserialize;

use super::table::decibels;
use crate::bundle::Text;
use crate::declaration;
use crate::design::Design;
use crate::error::Error;
use crate::report::Intervals;
use crate::result::{Check, RunResult};
use crate::stages::Progress;
use crate::store::Store;
use crate::study::tolerance::{STATED_FROM, content, next_within};
use crate::study::{self, Found, LevelStudy, ProvidedStudy, Request, StudyResult, Weighting};

/// Inputs that are named as those which decide the total.
const DECIDING: usize = 3;

/// Seed of screenings: the draws are the first ones of a study with the default seed.
const SEED: u64 = 1;

/// The shot of the design itself: how it ends, and its levels.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct OwnShot {
    outcome: String,
    ranking: Vec<OwnLevel>,
    total: OwnTotal,
}

#[derive(Debug, Clone, Deserialize)]
struct OwnLevel {
    source: String,
    lwa_db: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
struct OwnTotal {
    lwa_db: Option<f64>,
}

impl OwnShot {
    /// That of a result as JSON.
    ///
    /// # Errors
    /// [`Error::Json`].
    pub(super) fn parse(json: &str) -> Result<Self, Error> {
        serde_json::from_str(json).map_err(Error::Json)
    }

    /// That of a result.
    pub(super) fn of(result: &RunResult) -> Self {
        let level = |own: &crate::result::RankedSource| OwnLevel {
            source: own.source.clone(),
            lwa_db: own.lwa_db,
        };
        Self {
            outcome: result.outcome.name().to_owned(),
            ranking: result.ranking.iter().map(level).collect(),
            total: OwnTotal {
                lwa_db: result.total.lwa_db,
            },
        }
    }

    /// Level of a source, or of the total for another name \[dB\].
    fn level(&self, source: &str) -> Option<f64> {
        let own = self.ranking.iter().find(|own| own.source == source);
        own.map_or(self.total.lwa_db, |own| own.lwa_db)
    }

    /// Why no draw of a study is a shot like this one: it ends otherwise than the shots that count.
    pub(super) fn is_no_draw_of(&self, design: &Design) -> Option<NotKnown> {
        let require = &design.study().require;
        if require.is_empty() || require.contains(&self.outcome.as_str()) {
            return None;
        }
        let [own, counted] = [self.outcome.clone(), require.join(" or ")].map(|words| words.replace('_', " "));
        Some(NotKnown {
            reason: format!(
                "the shot ends as \"{own}\", and `study.require` counts only \"{counted}\":\n  no interval, no P(first) and no K \
                 are stated; correct values of the design, or the condition"
            ),
            check: Some(failed(format!("the shot ends as `study.require` says ({counted})"))),
        })
    }
}

/// A check of the design against its draws that is not met.
fn failed(name: impl Into<Cow<'static, str>>) -> Check {
    Check::at_most(name, 1.0, 0.0)
}

/// Why the intervals of a design are not known.
#[derive(Debug)]
pub(super) struct NotKnown {
    /// The reason.
    pub(super) reason: String,
    /// The check that failed, if the design contradicts its draws.
    pub(super) check: Option<Check>,
}

impl From<Error> for NotKnown {
    fn from(error: Error) -> Self {
        Self {
            reason: error.to_string(),
            check: None,
        }
    }
}

/// A study that is known of a design.
pub(super) struct Known {
    result: StudyResult,
    /// Its origin, if it is not the user's study; empty otherwise.
    origin: String,
    weighting: Option<Weighting>,
    shot: OwnShot,
}

/// The study that serves a design, and its origin if it is not the user's study: the largest of those in the cache and
/// in the program.
///
/// # Errors
/// Those of reading them.
pub(super) fn serving(store: &Store, design: &Design) -> Result<Option<(Found, String)>, Error> {
    let cached = study::kept(store, design)?;
    Ok(match (cached, ProvidedStudy::of(design)?) {
        (Some(cached), Some(provided)) if cached.size() >= provided.found.size() => Some((cached, String::new())),
        (_, Some(provided)) => {
            let origin = origin(&provided.study);
            Some((provided.found, origin))
        }
        (cached, None) => cached.map(|cached| (cached, String::new())),
    })
}

impl Known {
    /// The stored study that serves a design, or the one that comes with the program if that is larger; none without
    /// either.
    ///
    /// # Errors
    /// Those of reading them; the shot of the design is none that a study counts.
    pub(super) fn of(store: &Store, design: &Design, shot: &OwnShot) -> Result<Option<Self>, NotKnown> {
        if let Some(contradiction) = shot.is_no_draw_of(design) {
            return Err(contradiction);
        }
        let known = serving(store, design)?.map(|(found, origin)| Self {
            result: found.result,
            origin,
            weighting: found.weighting,
            shot: shot.clone(),
        });
        Ok(known)
    }

    fn states_percentiles(&self) -> bool {
        self.result.draws >= STATED_FROM
    }

    /// The interval of a source or of the total \[dB\]: P5 to P95, or the lowest and the highest of the draws and the design.
    fn interval(&self, source: &str) -> [Option<f64>; 2] {
        let level: &LevelStudy = match self.result.source(source) {
            Some(own) => &own.level,
            None => &self.result.total,
        };
        if self.states_percentiles() {
            return [level.level_db.p05.value, level.level_db.p95.value];
        }
        let own = self.shot.level(source);
        let [low, high] = level.extremes_db;
        // Silence is below every level.
        let low = low.zip(own).map(|(low, own)| low.min(own));
        [low, [high, own].into_iter().flatten().reduce(f64::max)]
    }

    /// Sources, and the total, whose level in the design lies outside their interval.
    fn outside(&self) -> Vec<&str> {
        let names = self.result.sources.iter().map(|own| own.source.as_str());
        let is_outside = |name: &&str| {
            let [low, high] = self.interval(name);
            match self.shot.level(name) {
                Some(own) => low.is_some_and(|low| own < low) || high.is_none_or(|high| own > high),
                None => low.is_some(),
            }
        };
        names.chain(["total"]).filter(is_outside).collect()
    }

    /// The check that fails where the design lies outside its own interval.
    pub(super) fn check(&self) -> Option<Check> {
        let outside = self.outside();
        (!outside.is_empty()).then(|| failed(format!("level of {} within its interval of draws", outside.join(", "))))
    }
}

/// The known study of a design; else a screening of a few draws, which is stored.
///
/// # Errors
/// Why there is none, or that the design requests none.
pub(super) fn study_of(store: &Store, design: &Design, shot: &OwnShot, progress: &Progress) -> Result<Known, NotKnown> {
    if let Some(known) = Known::of(store, design, shot)? {
        return Ok(known);
    }
    let none = |reason: &str| NotKnown {
        reason: reason.to_owned(),
        check: None,
    };
    if store.folder().is_none() {
        return Err(none("without the cache no study is known"));
    }
    let request = Request::new(design.study().screening as usize, SEED);
    if request.draws == 0 {
        return Err(none("`study.screening` is 0"));
    }
    progress.note(&format!(
        "no study serves this design: {} draws give a first impression of the uncertainty; `nailnoise study` makes more",
        request.draws
    ));
    let (result, _) = super::study::compute(store, design, &request, progress)?;
    Ok(Known {
        result,
        origin: String::new(),
        weighting: None,
        shot: shot.clone(),
    })
}

/// Origin of a study that comes with the program.
fn origin(study: &ProvidedStudy) -> String {
    let made = format!(
        "  this study comes with the program: `{}`, version {}",
        study.command, study.version
    );
    if study.is_of_this_code() {
        return format!("{made}\n");
    }
    format!(
        "{made};\n  the code has changed since, so that its levels may differ from those of today; the command makes it anew\n"
    )
}

/// Headings of the columns of a study.
pub(super) fn headings(study: &Known) -> [String; 2] {
    if study.states_percentiles() {
        return ["90 % of draws dB".to_owned(), "P(first)".to_owned()];
    }
    [format!("{} draws dB", study.result.draws), "loudest in".to_owned()]
}

/// Cells of these columns in the row of a source, or of the total.
pub(super) fn cells(study: &Known, source: &str) -> [String; 2] {
    let [low, high] = study.interval(source).map(decibels);
    let first = match study.result.source(source) {
        Some(_) if study.check().is_none() => first(&study.result, source),
        _ => String::new(),
    };
    [format!("{low} .. {high}"), first]
}

/// The columns for the report, next to the levels of the printed table.
pub(super) fn of_report(study: &Known, text: &Text) -> Intervals {
    let row = |row: &Vec<String>| {
        let [interval, first] = cells(study, &row[0]);
        [row[0].clone(), interval, first]
    };
    Intervals {
        headings: headings(study),
        rows: text.rows.iter().map(row).collect(),
        legend: (legend(study) + &declared(study))
            .replace(";\n", ";")
            .replace(",\n   ", ","),
    }
}

/// K of a declaration \[dB\], and the origin of its sigma; none with few draws, or if the design contradicts them.
pub(super) fn k_of(study: &Known) -> Option<(i32, String)> {
    match study.check() {
        Some(_) => None,
        None => declaration::uncertainty(&study.result),
    }
}

/// The same in words.
fn declared(study: &Known) -> String {
    match k_of(study) {
        Some((k, basis)) => format!("  declaration: K = {k} dB (1.645 sigma, {basis})\n"),
        None => format!("  declaration: {}\n", declaration::NO_K),
    }
}

/// Probability of being the loudest, or how many draws it is.
fn first(study: &StudyResult, source: &str) -> String {
    let Some(share) = study.source(source).and_then(|own| own.first.value) else {
        return "-".to_owned();
    };
    match study.draws {
        STATED_FROM.. => format!("{share:.2}"),
        draws => format!("{:.0} of {draws}", share * draws as f64),
    }
}

/// A share of the draws in percent, or as a count if they are few.
fn of_draws(share: f64, draws: usize) -> String {
    match draws {
        STATED_FROM.. => format!("{:.0} % of the draws", 100.0 * share),
        _ => format!("{:.0} of {draws} draws", share * draws as f64),
    }
}

/// Contents and omissions of the columns.
pub(super) fn legend(known: &Known) -> String {
    let study = &known.result;
    let structures = match study.structures {
        0 => "structures as in the design".to_owned(),
        count => format!("{count} structures"),
    };
    let condition = match study.require.as_slice() {
        [] => String::new(),
        outcomes => format!(", outcome {}", outcomes.join(" or ").replace('_', " ")),
    };
    let mut text = String::from("\n  ");
    // Writing to a string cannot fail.
    let _ = match (&known.weighting, study.draws) {
        (Some(weighting), _) => writeln!(
            text,
            "90 % of draws, P(first): {} draws of {}, weighted for other ranges of {}: worth {:.0} draws;\n  \
             {structures}{condition}; `nailnoise study` makes draws of this design",
            weighting.draws,
            study.design.name,
            weighting.keys.join(", "),
            weighting.effective
        ),
        (None, STATED_FROM..) => writeln!(
            text,
            "90 % of draws, P(first): {} draws from the ranges, {structures}{condition};\n  `nailnoise study` has the details",
            study.draws
        ),
        (None, draws) => writeln!(
            text,
            "{draws} draws: lowest and highest level of draws from the ranges and of the design, {structures}{condition};\n  a \
             further draw lies between with a probability of {:.0} %{};\n  percentiles, P(first) and K need {STATED_FROM} draws: \
             `nailnoise study`, which also says which inputs decide",
            100.0 * next_within(draws),
            content(draws).map_or_else(String::new, |share| format!(
                ", and with 90 % confidence at least {:.0} % of all do (Wilks 1941)",
                (100.0 * share).floor()
            ))
        ),
    };
    text.push_str(&known.origin);
    let outside = known.outside();
    if !outside.is_empty() {
        let level = |name: &&str| {
            let [low, high] = known.interval(name).map(decibels);
            format!(
                "{name} {} dB, draws {low} .. {high} dB",
                decibels(known.shot.level(name))
            )
        };
        let _ = writeln!(
            text,
            "  the design lies outside its own interval: {};\n  its values and ranges contradict each other, so that no P(first), no \
             order and no K are stated;\n  `nailnoise study` lists the values at an end of their range",
            outside.iter().map(level).collect::<Vec<_>>().join("; ")
        );
        return text;
    }
    let mut orders = study.orders.iter();
    if let Some(order) = orders.next() {
        let share = order.probability.value.unwrap_or(0.0);
        // Eight draws out of eight leave up to 31 % for another order, at 95 % confidence.
        let certain = if share >= 0.95 && known.states_percentiles() {
            ""
        } else {
            "not certain: "
        };
        let _ = writeln!(
            text,
            "  ranking {certain}{} in {}{}",
            order.order.join(" > "),
            of_draws(share, study.draws),
            orders.next().map_or_else(String::new, |next| {
                let share = next.probability.value.unwrap_or(0.0);
                format!(",\n    {} in {}", next.order.join(" > "), of_draws(share, study.draws))
            })
        );
    }
    let of_total = study.contributions.iter().find(|own| own.output == "total");
    let mut inputs = of_total
        .into_iter()
        .flat_map(|own| &own.inputs)
        .take(DECIDING)
        .peekable();
    if inputs.peek().is_some() {
        let named = inputs.map(|own| {
            let error = own.part().half_width();
            let error = error.map_or_else(String::new, |half| format!(" +-{:.0}", 100.0 * half));
            format!("`{}` ({:.0}{error} %)", own.variable, 100.0 * own.first_order)
        });
        let named: Vec<String> = named.collect();
        let _ = writeln!(text, "  inputs that decide the total: {}", named.join(", "));
    }
    text
}
