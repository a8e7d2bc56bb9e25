//! Intervals of a design's levels: from the study that is kept, else from a screening.

use std::fmt::Write as _;

use super::table::decibels;
use crate::bundle::Text;
use crate::declaration::{self, PERCENTILES_FROM};
use crate::design::Design;
use crate::error::Error;
use crate::report::Intervals;
use crate::stages::Progress;
use crate::store::Store;
use crate::study::{self, LevelStudy, ProvidedStudy, Request, StudyResult};

/// Inputs that are named as those which decide the total.
const DECIDING: usize = 3;

/// Seed of screenings: the draws are the first ones of a study with the default seed.
const SEED: u64 = 1;

/// A study that is known of a design.
pub(super) struct Known {
    result: StudyResult,
    /// Where it is from, if it is not the user's own; empty otherwise.
    origin: String,
}

impl Known {
    /// The study of a design that is kept, or that comes with the program if that is larger; none where there is neither.
    ///
    /// # Errors
    /// Those of reading them.
    pub(super) fn of(store: &Store, design: &Design) -> Result<Option<Self>, Error> {
        let kept = study::kept(store, design)?;
        if let Some(provided) = ProvidedStudy::of(design)?
            && kept.as_ref().is_none_or(|kept| kept.draws < provided.result.draws)
        {
            return Ok(Some(Self {
                origin: origin(&provided, &provided.changed(design)?),
                result: provided.result,
            }));
        }
        Ok(kept.map(Self::own))
    }

    /// What it states.
    pub(super) fn result(&self) -> &StudyResult {
        &self.result
    }

    /// A study of the user's own.
    fn own(result: StudyResult) -> Self {
        Self {
            result,
            origin: String::new(),
        }
    }
}

/// The study that is known of a design; else a screening of a few draws, which is kept. None where the design asks for none, or why
/// there is none.
pub(super) fn study_of(store: &Store, design: &Design, progress: &Progress) -> Result<Known, String> {
    if let Some(known) = Known::of(store, design).map_err(|error| error.to_string())? {
        return Ok(known);
    }
    if store.folder().is_none() {
        return Err("without the cache no study is known".to_owned());
    }
    let request = Request::new(design.study().screening as usize, SEED);
    if request.draws == 0 {
        return Err("`study.screening` is 0".to_owned());
    }
    progress.note(&format!(
        "no study of this design is kept: {} draws give a first estimate of the uncertainty; `nailnoise study` makes more",
        request.draws
    ));
    let made = super::study::compute(store, design, &request, progress);
    made.map(|(result, _)| Known::own(result))
        .map_err(|error| error.to_string())
}

/// Where a study is from that comes with the program.
fn origin(study: &ProvidedStudy, changed: &[&str]) -> String {
    let made = format!(
        "  this study comes with the program: `{}`, version {}",
        study.command, study.version
    );
    match changed {
        [] => format!("{made}\n"),
        changed => format!(
            "{made};\n  {} changed since, so that its levels may differ from those of today; the command makes it anew\n",
            match changed {
                [one] => format!("{one} has"),
                more => format!("{} have", more.join(" and ")),
            }
        ),
    }
}

/// Headings of the columns of a study.
pub(super) fn headings(Known { result: study, .. }: &Known) -> [String; 2] {
    let levels = match study.draws {
        PERCENTILES_FROM.. => "90 % of draws dB".to_owned(),
        draws => format!("{draws} draws dB"),
    };
    [levels, "P(first)".to_owned()]
}

/// Cells of these columns in the row of a source, or of the total.
pub(super) fn cells(Known { result: study, .. }: &Known, source: &str) -> [String; 2] {
    match study.source(source) {
        Some(own) => [span(study, &own.level), first(study, source)],
        None => [span(study, &study.total), String::new()],
    }
}

/// The columns for the report, beside the levels of the printed table.
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

/// K of a declaration \[dB\], and where its sigma comes from.
pub(super) fn k_of(Known { result, .. }: &Known) -> Option<(i32, String)> {
    declaration::uncertainty(result)
}

/// The same in words.
fn declared(study: &Known) -> String {
    let of = |(k, basis)| format!("  declaration: K = {k} dB (1.645 sigma, {basis})\n");
    k_of(study).map(of).unwrap_or_default()
}

/// Levels over the draws: P5 .. P95, or the lowest and the highest.
fn span(study: &StudyResult, level: &LevelStudy) -> String {
    let ends = match study.draws {
        PERCENTILES_FROM.. => [level.level_db.p05.value, level.level_db.p95.value],
        _ => level.extremes_db,
    };
    format!("{} .. {}", decibels(ends[0]), decibels(ends[1]))
}

/// Probability of being the loudest, or how many draws it is.
fn first(study: &StudyResult, source: &str) -> String {
    let Some(share) = study.source(source).and_then(|own| own.first.value) else {
        return "-".to_owned();
    };
    match study.draws {
        PERCENTILES_FROM.. => format!("{share:.2}"),
        draws => format!("{:.0} of {draws}", share * draws as f64),
    }
}

/// A share of the draws in percent, or as a count where they are few.
fn of_draws(share: f64, draws: usize) -> String {
    match draws {
        PERCENTILES_FROM.. => format!("{:.0} % of the draws", 100.0 * share),
        _ => format!("{:.0} of {draws} draws", share * draws as f64),
    }
}

/// What the columns hold, and what not.
pub(super) fn legend(Known { result: study, origin }: &Known) -> String {
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
    let _ = match study.draws {
        PERCENTILES_FROM.. => writeln!(
            text,
            "90 % of draws, P(first): {} draws from the ranges, {structures}{condition};\n  `nailnoise study` has the details",
            study.draws
        ),
        draws => writeln!(
            text,
            "{draws} draws: lowest and highest over the ranges, {structures}{condition};\n  another draw lies outside in {:.0} % of \
             cases; `nailnoise study` makes more and says which inputs decide",
            200.0 / (draws as f64 + 1.0)
        ),
    };
    text.push_str(origin);
    let mut orders = study.orders.iter();
    if let Some(order) = orders.next() {
        let share = order.probability.value.unwrap_or(0.0);
        // Eight draws out of eight leave up to 31 % for another order, at 95 % confidence.
        let certain = if share >= 0.95 && study.draws >= PERCENTILES_FROM {
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
