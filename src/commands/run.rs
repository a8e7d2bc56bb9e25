//! `nailnoise run`: the ranked sources of a design.

use std::sync::Arc;

use clap::Args;

use super::next_lines::next_lines;
use super::{Common, Keeping, message, print, status_of, table};
use super::{Status, progress::noted};
use crate::artifacts::{Delivered, Delivery, PrintedResult};
use crate::calibration::next_of_study;
use crate::chain::{Chain, Options};
use crate::declaration;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::output::{self, Exports};
use crate::result::{Check, Coupling, RankedSource, RunResult};
use crate::stages::cycle::EventWords;
use crate::store::Store;
use crate::tables::{dash, fixed, run as tables};
use crate::wording::{order, readable};

/// Default factor of the film: the first tenth of a second of a shot in ten seconds.
pub(super) const SLOW_MOTION: u32 = 100;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise run my-tool.toml" => "ranks the sources; files and report in out/my-tool/",
    "nailnoise run my-tool.toml --set supply.pressure=80psig --out \
     out/80psig" => "the same tool at another pressure, in a folder of its own",
    "nailnoise run my-tool.toml --json | jq .total.lwa_db" => "one number of the result, for a script",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// Draw third-octave levels, levels between events, and sound power over time as SVG
    #[arg(long)]
    figures: bool,
    /// Write films and the sound field for ParaView: the bodies over the shot and over the bands; the sound on
    /// surfaces, in planes and by direction, in third octaves. With boundary elements this takes about four times as
    /// long as a first run
    #[arg(long)]
    fields: bool,
    /// With --fields: how many times slower than the shot its film plays, a second of the shot in so many seconds
    #[arg(long, value_name = "FACTOR", default_value_t = SLOW_MOTION)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    slow_motion: u32,
    /// Write every sample of the histories of the cycle and of the sensors, instead of one each 10 us or more
    #[arg(long)]
    histories: bool,
    /// Also print the parts of each source, and the error of its method
    #[arg(long)]
    components: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let design = common.begin_with_any_tool()?;
    let folder = common.out(&design)?;
    let cache = arguments.keeping.cache()?;
    let progress = common.shown.progress();
    let delivery = Delivery {
        design: &design,
        folder: &folder,
        exports: Exports {
            figures: arguments.figures,
            films: arguments.fields,
            histories: arguments.histories,
            units: common.shown.units,
            slow_motion: arguments.slow_motion,
        },
        // Scripts should not wait for a screening.
        screening: !common.options.json,
        printer: printed,
        store: &cache,
        memory: common.options.memory.limit(),
        progress: &progress,
    };
    let (delivered, checks) = delivered(&delivery)?;
    let Delivered {
        artifacts,
        unchanged,
        incomplete,
    } = delivered;
    progress.end();
    if let Some(error) = incomplete {
        message(&format!(
            "the files do not contain the intervals of the levels: {error}"
        ));
    }
    if common.options.json {
        print(&artifacts.json)?;
    } else {
        common.shown.print(&shown(&artifacts.printed))?;
        if arguments.components {
            common.shown.print(&artifacts.printed.parts)?;
        }
        if unchanged {
            print("  unchanged design: result from the cache\n")?;
        }
        print(&next(&cache, &design))?;
        print(&format!(
            "\n  files in {}; open report.html for the report\n",
            folder.display()
        ))?;
    }
    let status = status_of(&checks);
    match artifacts.contradiction {
        // The numbers are correct, but the design is outside its limits.
        Some(check) if status == Status::SUCCESS => {
            message(&format!("check failed: {}", check.name));
            Ok(Status::from(1))
        }
        _ => Ok(status),
    }
}

/// Runs a design and writes its files to a folder; with films, also the sound fields. The checks include those of the
/// sound fields.
pub(super) fn delivered(delivery: &Delivery<'_>) -> Result<(Delivered, Vec<Check>), Error> {
    let delivered = delivery.deliver()?;
    let mut checks = delivered.artifacts.checks.clone();
    if delivery.exports.films {
        let (design, progress) = (delivery.design, delivery.progress);
        let graph = Graph::new(Arc::new(delivery.store.clone()), progress.observer());
        let fields = Chain::new(&graph, design, Options::default())?.fields.get()?;
        fields.notes.iter().for_each(|note| progress.note(note));
        progress.stage("writing sound fields");
        output::write_sound_fields(delivery.folder, &design.digest(), &fields)?;
        checks.extend(fields.checks.iter().cloned());
    }
    Ok((delivered, checks))
}

/// What to measure next, by the draws of the study of the design; empty without one. A study that cannot be read has
/// been named before.
fn next(store: &Store, design: &Design) -> String {
    let rows = next_of_study(store, design).unwrap_or_default();
    match next_lines(&rows) {
        lines if lines.is_empty() => lines,
        lines => format!("\n{lines}"),
    }
}

/// Formats a result for standard output.
fn shown(text: &PrintedResult) -> String {
    let notes = match noted(&text.notes) {
        notes if notes.is_empty() => notes,
        notes => format!("\n{notes}"),
    };
    let (alarm, last) = match &text.headline {
        None => (String::new(), String::new()),
        // The last line repeats the warning of the first.
        Some(headline) => (
            super::alarm(&headline.lines()),
            format!("\n  {}\n", super::red(&headline.text)),
        ),
    };
    format!("{alarm}{}{notes}{last}{}", text.levels, text.checks)
}

/// The table of the sources with their intervals, its legend, and the declaration.
fn levels(result: &RunResult) -> String {
    let mut text = format!(
        "{}: A-weighted single-event sound power levels re 1 pW s, one shot",
        result.design.name
    );
    if let Some(range) = result.range() {
        text.push_str(&format!(",\nthird-octave bands {range}"));
    }
    text.push_str(&format!("\n\n{}", table::text(&tables::ranking(result))));
    if let Some(check) = result.study.contradiction() {
        text.push_str(&format!("\n  check against the draws FAILED: {}\n", check.name));
    }
    let [power, peak] = declaration::lines(&result.declaration, &result.ear);
    if let Some(supply) = result.supply_in_words() {
        text.push_str(&format!("\n  the supply: {supply}\n"));
    }
    if let Some(performance) = &result.performance {
        text.push_str(&format!("  the shot: {}\n", performance.in_words()));
    }
    text.push_str(&format!("\n  declared: {power}\n  {peak}\n"));
    text
}

/// The parts of each source, loudest first.
fn components(result: &RunResult) -> String {
    let mut text = format!("\n{}\n", table::text(&tables::parts(&result.ranking)));
    text.push_str(&table::text(&tables::methods(result)));
    let placed: Vec<_> = result.ranking.iter().map(RankedSource::placed).collect();
    text.push_str(&format!(
        "\n  ranking by the errors of the methods alone: {}\n",
        order(&placed)
    ));
    text
}

/// Effect of the two-way coupling.
fn coupled(coupling: &Coupling, words: &EventWords) -> String {
    let mut rows = Vec::new();
    let mut row = |name: &str, unit: &str, digits: usize, one: Option<f64>, two: Option<f64>| {
        let change = dash(one.zip(two), |(one, two)| format!("{:+.digits$}", two - one));
        rows.push(vec![
            format!("{name} {unit}"),
            fixed(one, digits),
            fixed(two, digits),
            change,
        ]);
    };
    for level in &coupling.levels {
        row(&level.source, "dB", 1, level.one_way_lwa_db, level.two_way_lwa_db);
    }
    let milli = |x: Option<f64>| x.map(|x| 1e3 * x);
    for event in &coupling.events {
        row(
            &words.in_words(&event.event),
            "ms",
            3,
            milli(event.one_way_s),
            milli(event.two_way_s),
        );
    }
    for figure in &coupling.figures {
        let (unit, scale) = readable(figure.unit);
        let digits = if unit == "mm" { 2 } else { 3 };
        let scaled = |x: Option<f64>| x.map(|x| scale * x);
        let name = figure.figure.replace('_', " ");
        row(&name, unit, digits, scaled(figure.one_way), scaled(figure.two_way));
    }
    let headings = ["coupling", "one way", "two ways", "change"];
    format!("\n{}", table::table(&headings, &rows))
}

/// Number of printed notes other than that on the shot, each reduced to its first clause.
const CLAUSES: usize = 3;

/// Result of the shot, and further notes; the report contains all notes in full.
fn in_short(result: &RunResult) -> Vec<String> {
    let (shot, more) = result.notes.split_at(result.notes.len().min(1));
    let clauses = more
        .iter()
        .take(CLAUSES)
        .filter_map(|note| note.split([',', ';']).next());
    let clauses = shot.iter().map(String::as_str).chain(clauses).map(str::to_owned);
    let rest = match more.len().saturating_sub(CLAUSES) {
        0 => String::new(),
        count => format!("{count} more and "),
    };
    let methods = format!("{rest}{} notes on methods: report.html", result.method_notes.len());
    clauses.chain([methods]).collect()
}

/// Whether the checks of the computation pass; failed ones are named.
fn checked(result: &RunResult) -> String {
    let checks: Vec<&Check> = result.numerical_checks().collect();
    let failed: Vec<&str> = checks
        .iter()
        .filter(|check| !check.ok)
        .map(|check| &*check.name)
        .collect();
    let (total, checks) = (result.timing.whole(), checks.len());
    match failed.as_slice() {
        [] if result.headline.is_some() => format!("\n  {checks} numerical checks ok; {total:.1} s\n"),
        [] => format!("\n  all {checks} checks ok; {total:.1} s\n"),
        failed => format!(
            "\n  {} of {checks} checks FAILED: {}; {total:.1} s\n",
            failed.len(),
            failed.join("; ")
        ),
    }
}

/// The result as shown in a terminal.
pub(super) fn printed(result: &RunResult) -> PrintedResult {
    let mut levels = levels(result);
    if let Some(starts) = &result.starts {
        levels.push_str(&format!(
            "\n  workpiece over {} starts: {:.1} dB, standard deviation {:.2} dB\n",
            starts.lwa_db.len(),
            starts.mean_lwa_db,
            starts.deviation_db
        ));
    }
    if let Some(coupling) = &result.coupling {
        levels.push_str(&coupled(coupling, &result.event_words));
    }
    PrintedResult {
        headline: result.headline.clone(),
        levels,
        notes: in_short(result),
        checks: checked(result),
        parts: components(result),
    }
}
