//! `nailnoise run`: the ranked sources of a design.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;

use super::intervals::{self, Known, NotKnown, OwnShot};
use super::progress::noted;
use super::table::{dash, decibels, fixed, table};
use super::{Common, Keeping, message, print, progress, status_of};
use crate::bundle::{Bundle, Text, deliver};
use crate::chain::{Chain, Options};
use crate::cost::MemoryLimit;
use crate::declaration;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::output::{self, Exports, event_name};
use crate::report;
use crate::result::{Check, Coupling, RankedSource, RunResult, loudest};
use crate::run::Run;
use crate::stages::Progress;
use crate::staging;
use crate::store::Store;
use crate::wording::{band, order, readable};

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise run my-tool.toml" => "ranks the sources; files and report in out/my-tool/",
    "nailnoise run my-tool.toml --set supply.pressure=80psig --out out/80psig" => "the same tool at another pressure, in a folder of its own",
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
    /// Write films and the sound field for ParaView: the bodies over the shot and over the bands; the sound on surfaces, in
    /// planes and by direction, in third octaves. With boundary elements this takes about four times as long as a first run
    #[arg(long)]
    fields: bool,
    /// Write every sample of the histories of the cycle and of the sensors, instead of one each 10 us or more
    #[arg(long)]
    histories: bool,
    /// Also print the parts of each source, and the error of its method
    #[arg(long)]
    components: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    let design = common.begin()?;
    let folder = common.out(&design)?;
    let cache = arguments.keeping.cache()?;
    let store = cache.clone();
    let progress = progress();
    let exports = Exports {
        figures: arguments.figures,
        films: arguments.fields,
        histories: arguments.histories,
    };
    let Delivered {
        bundle,
        unchanged,
        checks,
    } = delivered(&design, &folder, exports, cache, common.memory.limit(), &progress)?;
    progress.end();
    let shot = OwnShot::parse(&bundle.json)?;
    let contradiction;
    if common.json {
        // Scripts do not wait for a screening.
        let study = Known::of(&store, &design, &shot).transpose();
        let study = study.as_ref().map(Result::as_ref);
        contradiction = study.and_then(contradiction_of);
        print(&study.map_or_else(|| bundle.json.clone(), |study| amended(&bundle.json, study)))?;
    } else {
        let study = intervals::study_of(&store, &design, &shot, &progress);
        progress.end();
        contradiction = contradiction_of(study.as_ref());
        if let Err(error) = add_study(&folder, study.as_ref(), &bundle) {
            message(&format!("the files lack the intervals of the levels: {error}"));
        }
        print(&with_intervals(&bundle.text, study.as_ref()))?;
        if arguments.components {
            print(&bundle.text.parts)?;
        }
        if unchanged {
            print("  unchanged design: result from the cache\n")?;
        }
        print(&format!(
            "\n  files in {}; open report.html for the report\n",
            folder.display()
        ))?;
    }
    let status = status_of(&checks);
    match contradiction {
        // The numbers are right: the design is outside its limits.
        Some(check) if status == ExitCode::SUCCESS => {
            message(&format!("check failed: {}", check.name));
            Ok(ExitCode::from(1))
        }
        _ => Ok(status),
    }
}

/// The check that fails where a design contradicts its draws.
fn contradiction_of(study: Result<&Known, &NotKnown>) -> Option<Check> {
    match study {
        Ok(study) => study.check(),
        Err(reason) => reason.check.clone(),
    }
}

/// A result as JSON with the additions of a study: K of the declaration, and the check that fails if the design
/// contradicts the draws.
fn amended(json: &str, study: Result<&Known, &NotKnown>) -> String {
    let json = match study.ok().and_then(intervals::k_of) {
        Some(uncertainty) => declaration::with_uncertainty(json, &uncertainty),
        None => json.to_owned(),
    };
    match contradiction_of(study) {
        Some(check) => with_check(&json, &check),
        None => json,
    }
}

/// A result as JSON with one more check in front of the others.
fn with_check(json: &str, check: &Check) -> String {
    const LIST: &str = "\n  \"checks\": [";
    let Ok(check) = serde_json::to_string(check) else {
        return json.to_owned();
    };
    let Some(at) = json.find(LIST).map(|at| at + LIST.len()) else {
        return json.to_owned();
    };
    let (before, after) = json.split_at(at);
    let comma = if after.trim_start().starts_with(']') { "" } else { "," };
    format!("{before}\n    {check}{comma}{after}")
}

/// Files of a run in its folder.
pub(super) struct Delivered {
    bundle: Bundle,
    /// Whether it is that of an earlier run.
    unchanged: bool,
    /// Its checks, and those of sound fields.
    pub(super) checks: Vec<Check>,
}

/// Runs a design and leaves its files in a folder; with films, the sound fields, too.
pub(super) fn delivered(
    design: &Design,
    folder: &Path,
    exports: Exports,
    store: Store,
    memory: MemoryLimit,
    progress: &Progress,
) -> Result<Delivered, Error> {
    let (bundle, unchanged) = deliver(design, folder, exports, text, &store, memory, progress)?;
    let mut checks = bundle.checks.clone();
    if exports.films {
        let graph = Graph::new(Arc::new(store), progress.observer());
        let fields = Chain::new(&graph, design, Options::default())?.fields.get()?;
        fields.notes.iter().for_each(|note| progress.note(note));
        progress.stage("writing sound fields");
        output::write_sound_fields(folder, &design.digest(), &fields)?;
        checks.extend(fields.checks.iter().cloned());
    }
    Ok(Delivered {
        bundle,
        unchanged,
        checks,
    })
}

/// Adds the results of a study to report and result in a folder, which are complete without it.
pub(super) fn add_study(folder: &Path, study: Result<&Known, &NotKnown>, bundle: &Bundle) -> Result<(), Error> {
    if let Ok(study) = study {
        let path = folder.join("report.html");
        let report = fs::read_to_string(&path).map_err(|source| Error::Write {
            path: path.clone(),
            source,
        })?;
        let intervals = intervals::of_report(study, &bundle.text);
        staging::write(&path, report::with_intervals(&report, &intervals).as_bytes())?;
    }
    let json = amended(&bundle.json, study);
    if json != bundle.json {
        staging::write(&folder.join("result.json"), json.as_bytes())?;
    }
    Ok(())
}

/// The table with the intervals of a study, or why there is none.
fn with_intervals(text: &Text, study: Result<&Known, &NotKnown>) -> String {
    let Text {
        before,
        headings,
        rows,
        between,
        notes,
        after,
        ..
    } = text;
    let (mut headings, mut rows) = (headings.clone(), rows.clone());
    let legend = match study {
        Ok(study) => {
            headings.splice(2..2, intervals::headings(study));
            for row in &mut rows {
                row.splice(2..2, intervals::cells(study, &row[0]));
            }
            intervals::legend(study)
        }
        Err(none) if none.check.is_some() => format!("\n  {}\n", none.reason),
        Err(none) => format!("\n  how sure these levels are is not known: {}\n", none.reason),
    };
    let (mut own, ear) = text.declared.clone();
    (own.k_db, own.k_basis) = study.ok().and_then(intervals::k_of).unzip();
    let [power, peak] = declaration::lines(&own, &ear);
    let declared = format!("\n  declared: {power}\n  {peak}\n");
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    let notes = match noted(notes) {
        notes if notes.is_empty() => notes,
        notes => format!("\n{notes}"),
    };
    let failed = contradiction_of(study).map_or_else(String::new, |check| {
        format!("\n  check against the draws FAILED: {}\n", check.name)
    });
    let (alarm, after) = match &text.headline {
        None => (String::new(), after.clone()),
        // The last line must state no less than the first.
        Some(headline) => (
            super::alarm(&headline.lines()),
            format!("\n  {}\n{after}", super::red(&headline.text)),
        ),
    };
    format!(
        "{alarm}{before}{}{legend}{failed}{declared}{between}{notes}{after}",
        table(&headings, &rows)
    )
}

/// The parts of every source, loudest first.
fn components(result: &RunResult) -> String {
    let mut rows = Vec::new();
    for source in &result.ranking {
        rows.extend(source.parts().into_iter().map(|part| {
            vec![
                source.source.clone(),
                part.name.clone(),
                decibels(part.lwa_db),
                decibels(part.lw_db),
                dash(loudest(&part.bands, |band| band.lwa_db), |band| {
                    format!("{} Hz", band.hz)
                }),
            ]
        }));
    }
    let headings = ["source", "part", "L_WA,1s dB", "L_W,1s dB", "loudest band (A)"];
    let mut text = format!("\n{}\n", table(&headings, &rows));
    let methods = result.ranking.iter().map(|source| {
        vec![
            source.source.clone(),
            decibels(source.lw_db),
            band(source.uncertainty_db.bounds()),
            format!("{:.0} - {:.0} Hz", source.range_hz[0], source.range_hz[1]),
            source.method.clone(),
        ]
    });
    text.push_str(&table(
        &[
            "source",
            "L_W,1s dB",
            "error of the method dB",
            "computed over",
            "method",
        ],
        &methods.collect::<Vec<_>>(),
    ));
    let placed: Vec<_> = result.ranking.iter().map(RankedSource::placed).collect();
    text.push_str(&format!(
        "\n  ranking by the errors of the methods alone: {}\n",
        order(&placed)
    ));
    text
}

/// Effect of the two-way coupling.
fn coupled(coupling: &Coupling) -> String {
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
            &event_name(&event.event),
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
    format!("\n{}", table(&headings, &rows))
}

/// Printed notes other than that on the shot, each by its first clause.
const CLAUSES: usize = 3;

/// Result of the shot, and further notes: the report has all notes in full.
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

/// Whether the checks pass; those that fail are named.
fn checked(result: &RunResult) -> String {
    let failed: Vec<&str> = result
        .checks
        .iter()
        .filter(|check| !check.ok)
        .map(|check| &*check.name)
        .collect();
    let (total, checks) = (result.timing.whole(), result.checks.len());
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

/// The result as a person reads it.
pub(super) fn text(run: &Run) -> Text {
    let result = &run.result;
    let rows: Vec<Vec<String>> = result
        .ranking
        .iter()
        .map(|source| {
            let band_of = loudest(&source.bands, |band| band.lwa_db);
            let interval = loudest(&source.intervals, |interval| interval.lwa_db);
            vec![
                source.source.clone(),
                decibels(source.lwa_db),
                format!("{:.1} %", 100.0 * source.share),
                dash(band_of, |band| format!("{} Hz", band.hz)),
                dash(interval, |interval| event_name(&interval.from)),
            ]
        })
        .chain([vec!["total".to_owned(), decibels(result.total.lwa_db)]])
        .collect();
    let headings = ["source", "L_WA,1s dB", "share", "band", "loudest after"];
    let mut before = format!(
        "{}: A-weighted single-event sound power levels re 1 pW s, one shot",
        result.design.name
    );
    if let Some(range) = result.range() {
        before.push_str(&format!(",\nthird-octave bands {range}"));
    }
    before.push_str("\n\n");
    let mut text = String::new();
    if let Some(starts) = &result.starts {
        text.push_str(&format!(
            "\n  workpiece over {} starts: {:.1} dB, standard deviation {:.2} dB\n",
            starts.lwa_db.len(),
            starts.mean_lwa_db,
            starts.deviation_db
        ));
    }
    if let Some(coupling) = &result.coupling {
        text.push_str(&coupled(coupling));
    }
    Text {
        headline: result.headline.clone(),
        before,
        headings: headings.map(str::to_owned).to_vec(),
        rows,
        between: text,
        notes: in_short(result),
        declared: (result.declaration.clone(), result.ear.clone()),
        after: checked(result),
        parts: components(result),
    }
}
