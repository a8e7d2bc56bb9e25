//! `nailnoise compare`: designs side by side.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::Status;
use super::table::{dash, decibels, fixed, table, with_legend};
use super::{
    Changes, Keeping, Memory, Threads, comparison_page, comparison_sounds, folder_of, message, print, print_json,
    progress, status_of,
};
use crate::artifacts::Delivery;
use crate::comparison::{Comparison, Finished, Labelled, Levels, Limit};
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::output::Exports;
use crate::report;
use crate::result::Check;
use crate::stages::Progress;
use crate::staging;
use crate::store::Store;
use crate::study::{self, Estimate, PairedStudy, Request, common_draws};
use crate::wording::{band, change, drawn_structures, order, rounded};

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise compare as-it-is.toml muffler.toml" => "what differs, and what that does to each source",
    "nailnoise compare as-it-is.toml muffler.toml --draws 64" => "how sure the changes are",
    "nailnoise compare old.toml new.toml --fail-above total=100" => "status 1 if the new design is louder than 100 dB",
    "nailnoise compare my-tool.toml --measured out/test/measurement.json" => "beside the measurements of the tool",
    "nailnoise compare n80cb-as-tested.toml --measured n80cb" => "the tool of the program beside its published tests",
))]
pub(super) struct Arguments {
    /// Design files or finished results (a folder with result.json, or the file); the first is the reference
    #[arg(required = true, num_args = 1.., value_name = "DESIGN")]
    pub(super) designs: Vec<PathBuf>,
    /// Compare with measurements instead: measurement.json of `measure`, a file as designs/measured/n80cb.json, or
    /// n80cb for the published ones. One design, or one on the worktable and one in the sandbox, as they were tested
    #[arg(long, value_name = "FILE", conflicts_with_all = ["bands", "intervals", "fail_above"])]
    pub(super) measured: Option<PathBuf>,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    pub(super) json: bool,
    /// Folder for the results of the designs that are run, one subfolder each
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(super) out: PathBuf,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) keeping: Keeping,
    #[command(flatten)]
    pub(super) memory: Memory,
    #[command(flatten)]
    pub(super) changes: Changes,
    /// Show the levels of every one-third-octave band
    #[arg(long)]
    bands: bool,
    /// Show the levels between neighbouring events
    #[arg(long)]
    intervals: bool,
    /// Draw N shots of all designs in common, and state how sure the changes are; each argument must be a design file
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=60_000))]
    pub(super) draws: Option<u32>,
    /// Seed of --draws
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "draws")]
    pub(super) seed: u64,
    /// Draw the structures (block, table, tool body), too, each for N of the draws; without it they are those of the
    /// designs. Modes and radiation of a new structure take minutes
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "8",
        requires = "draws")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) structures: Option<u16>,
    /// End with status 1 if a design other than the reference is louder: total=100, exhaust=95.5
    #[arg(long, value_name = "SOURCE=DB")]
    fail_above: Vec<Limit>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.threads.start()?;
    let progress = progress();
    let cache = arguments.keeping.cache()?;
    if let [design] = arguments.designs.as_slice() {
        return Err(Error::NothingToCompare { path: design.clone() });
    }
    if arguments.draws.is_some()
        && let Some(path) = arguments.designs.iter().find(|path| Finished::is_at(path).is_some())
    {
        return Err(Error::NothingToDraw { path: path.clone() });
    }
    let (mut results, mut checks): (Vec<Finished>, Vec<Check>) = (Vec::new(), Vec::new());
    let mut folders = Vec::new();
    for path in &arguments.designs {
        let (mut result, folder) = match Finished::is_at(path) {
            Some(file) => (Finished::read(&file)?, file.parent().map(Path::to_owned)),
            None => finish(path, &results, arguments, &cache, &progress, &mut checks)?,
        };
        let name = free_name(result.name(), &results);
        folders.extend(folder.map(|folder| (name.clone(), folder)));
        result.rename(name);
        results.push(result);
    }
    let paired = paired(arguments, &cache, &progress)?;
    progress.end();
    let comparison = Comparison::new(&results);
    let recordings = comparison_sounds::recordings(&folders);
    let identity = comparison_page::identity(&arguments.designs);
    let page = comparison_page::place(&arguments.out, &comparison.designs, &identity);
    staging::write(
        &page,
        report::comparison(&comparison, &identity, &recordings).as_bytes(),
    )?;
    if arguments.json {
        print_json(&Layout {
            comparison: &comparison,
            paired: &paired,
        })?;
    } else {
        print(&super::alarm(&comparison.alarms()))?;
        print(&text(&comparison, arguments.bands, arguments.intervals))?;
        paired.iter().try_for_each(|paired| print(&changes(paired)))?;
        print(&format!("\n  as a page: {}\n", page.display()))?;
    }
    let exceeded = comparison.exceeded(&arguments.fail_above);
    exceeded
        .iter()
        .for_each(|line| message(&format!("limit exceeded: {line}")));
    let status = status_of(&checks);
    if status == Status::SUCCESS && !exceeded.is_empty() {
        return Ok(Status::from(1));
    }
    Ok(status)
}

/// Layout of `compare --json`.
#[derive(Serialize)]
struct Layout<'a> {
    #[serde(flatten)]
    comparison: &'a Comparison,
    /// Each design against the first over common draws; absent without `--draws`.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    paired: &'a [PairedStudy],
}

/// Each design against the first over common draws, on request.
fn paired(arguments: &Arguments, cache: &Store, progress: &Progress) -> Result<Vec<PairedStudy>, Error> {
    let Some(draws) = arguments.draws else {
        return Ok(Vec::new());
    };
    let request = Request {
        shots_a_structure: arguments.structures.map(usize::from),
        ..Request::new(draws as usize, arguments.seed)
    };
    let load = |path: &PathBuf| Design::load_with(path, &arguments.changes.set);
    let designs = arguments.designs.iter().map(load).collect::<Result<Vec<_>, _>>()?;
    for design in &designs {
        cost::refuse(design, &cost::of_run(design)?, arguments.memory.limit())?;
    }
    let graph = Graph::quiet(cache, progress.observer());
    let pair = |other: &Design| {
        let made = common_draws(&graph, &[&designs[0], other], &request, progress)?;
        Ok(PairedStudy::new((&designs[0], &made[0]), (other, &made[1]), &request))
    };
    designs.iter().skip(1).map(pair).collect()
}

/// The changes of a design as a person reads them.
fn changes(paired: &PairedStudy) -> String {
    let level = |estimate: &Estimate| dash(estimate.value, change);
    let row = |own: &study::Change| {
        let quantiles = &own.change_db;
        vec![
            own.source.clone(),
            level(&quantiles.p05),
            level(&quantiles.p50),
            level(&quantiles.p95),
            super::study_text::probability(&own.quieter),
            decibels(own.width_db),
            decibels(own.level_width_db),
        ]
    };
    let headings = [
        "change",
        "P5 dB",
        "P50 dB",
        "P95 dB",
        "P(quieter)",
        "width dB",
        "width of the level dB",
    ];
    format!(
        "\n{} against {} over {} common draws (seed {}), {}; not drawn, because the designs differ in them: {}\n\n{}",
        paired.design,
        paired.reference,
        paired.draws,
        paired.seed,
        drawn_structures(paired.structures),
        if paired.decided.is_empty() {
            "nothing".to_owned()
        } else {
            paired.decided.join(", ")
        },
        table(&headings, &paired.changes.iter().map(row).collect::<Vec<_>>())
    )
}

/// Runs a design and writes its files to a separate folder, like `nailnoise run`.
fn finish(
    path: &Path,
    before: &[Finished],
    arguments: &Arguments,
    cache: &Store,
    progress: &Progress,
    checks: &mut Vec<Check>,
) -> Result<(Finished, Option<PathBuf>), Error> {
    let design = arguments.changes.load(path)?;
    progress.note(&format!("design {}", design.name()));
    let name = free_name(design.name(), before);
    let folder = folder_of(&arguments.out, &name, design.path())?;
    let delivery = Delivery {
        design: &design,
        folder: &folder,
        exports: Exports::default(),
        screening: false,
        printer: super::run::printed,
        store: cache,
        memory: arguments.memory.limit(),
        progress,
    };
    let artifacts = delivery.deliver()?.artifacts;
    checks.extend(artifacts.checks.into_iter().map(|check| check.of(&name)));
    Ok((Finished::parse(&folder, &artifacts.json)?, Some(folder)))
}

/// The name, followed by a number if another result of the comparison has it.
fn free_name(name: &str, others: &[Finished]) -> String {
    let taken = |name: &str| others.iter().any(|other| other.name() == name);
    if !taken(name) {
        return name.to_owned();
    }
    (2..)
        .map(|n| format!("{name}-{n}"))
        .find(|name| !taken(name))
        .unwrap_or_default()
}

fn text(comparison: &Comparison, bands: bool, intervals: bool) -> String {
    let designs = &comparison.designs;
    let mut text = String::from("differences\n\n");
    let headings = |first| {
        std::iter::once(first)
            .chain(designs.iter().map(String::as_str))
            .collect::<Vec<_>>()
    };
    let rows: Vec<Vec<String>> = comparison
        .inputs
        .iter()
        .map(|row| {
            let key = match row.unit.as_str() {
                "" => row.key.clone(),
                unit => format!("{} [{unit}]", row.key),
            };
            std::iter::once(key).chain(row.values.iter().map(plain)).collect()
        })
        .collect();
    if rows.is_empty() {
        text.push_str("  none: the designs have the same values\n");
    } else {
        text.push_str(&table(&headings("key"), &rows));
    }

    text.push_str("\nA-weighted single-event sound power levels, dB re 1 pW s; changes from the first\n\n");
    let with_changes = |first: &'static str| {
        let mut headings = headings(first);
        headings.extend(designs.iter().skip(1).map(|_| "change"));
        headings
    };
    let sources = comparison
        .sources
        .iter()
        .map(|row| level_row(&row.source, &row.levels))
        .chain([level_row("total", &comparison.total)]);
    text.push_str(&table(&with_changes("source"), &sources.collect::<Vec<_>>()));
    if let Some(intervals) = comparison.intervals() {
        text.push_str(&format!("\nintervals of the levels\n\n{}", with_legend(&intervals)));
    }
    for row in &comparison.sources {
        let methods: Vec<&str> = row.methods.iter().flatten().map(String::as_str).collect();
        if methods.windows(2).any(|pair| pair[0] != pair[1]) {
            text.push_str(&format!(
                "  {}: computed by different methods ({}), whose errors do not cancel in the change\n",
                row.source,
                methods.join("; ")
            ));
        }
    }
    text.push_str("\nuncertainty of each method, dB (open: no bound)\n\n");
    let bands_of = |row: &crate::comparison::SourceRow| {
        let of_each = row.uncertainty_db.iter().map(|bounds| band(*bounds));
        std::iter::once(row.source.clone()).chain(of_each).collect::<Vec<_>>()
    };
    text.push_str(&table(
        &headings("source"),
        &comparison.sources.iter().map(bands_of).collect::<Vec<_>>(),
    ));

    text.push_str("\nranking\n\n");
    let places = comparison.rankings.iter().map(Vec::len).max().unwrap_or(0);
    let rows: Vec<Vec<String>> = (0..places)
        .map(|place| {
            let of_each = comparison
                .rankings
                .iter()
                .map(|ranking| ranking.get(place).cloned().unwrap_or_default());
            std::iter::once(format!("{}", place + 1)).chain(of_each).collect()
        })
        .collect();
    text.push_str(&table(&headings("place"), &rows));
    for (design, name) in comparison.designs.iter().enumerate() {
        text.push_str(&format!("  {name}: ranking {}\n", order(&comparison.placed(design))));
    }

    text.push_str("\nthe shot\n\n");
    let outcome = std::iter::once("outcome".to_owned()).chain(comparison.outcomes.iter().cloned());
    let figures = comparison.cycle.iter().filter(|row| differs(&row.values)).map(|row| {
        let values = row.values.iter().map(|value| dash(*value, significant));
        std::iter::once(row.labelled(" [", "]")).chain(values).collect()
    });
    let events = comparison.events.iter().filter(|row| differs(&row.values)).map(|row| {
        let values = row.values.iter().map(|value| fixed(value.map(|t| 1e3 * t), 3));
        std::iter::once(format!("{} [ms]", row.name)).chain(values).collect()
    });
    let rows: Vec<Vec<String>> = std::iter::once(outcome.collect())
        .chain(figures)
        .chain(events)
        .collect();
    text.push_str(&table(&headings("figure"), &rows));
    if rows.len() == 1 {
        text.push_str("  all figures and events are equal\n");
    }

    for row in &comparison.sources {
        let mut part = |title: &str, first: &'static str, labelled: &[Labelled]| {
            let rows: Vec<Vec<String>> = labelled.iter().map(|l| level_row(&l.label, &l.levels)).collect();
            text.push_str(&format!("\n{}, {title}, dB(A)\n\n", row.source));
            text.push_str(&table(&with_changes(first), &rows));
        };
        if bands {
            part("one-third-octave bands", "Hz", &row.bands);
        }
        if intervals {
            part("between events", "interval", &row.intervals);
        }
    }
    text
}

fn level_row(label: &str, levels: &Levels) -> Vec<String> {
    let changed = |db: &Option<f64>| dash(*db, change);
    std::iter::once(label.to_owned())
        .chain(levels.level_db.iter().map(|level| decibels(*level)))
        .chain(levels.change_db.iter().skip(1).map(changed))
        .collect()
}

/// Whether values differ by more than the rounding of a table.
fn differs(values: &[Option<f64>]) -> bool {
    values.iter().any(|value| match (value, values[0]) {
        (Some(a), Some(b)) => (a - b).abs() > 1e-6 * a.abs().max(b.abs()),
        (a, b) => a.is_some() != b.is_some(),
    })
}

fn significant(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

fn plain(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Null => "-".to_owned(),
        serde_json::Value::String(word) => word.clone(),
        // The digits of a design value without the last ones of a conversion of units.
        serde_json::Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), |value| rounded(value, 12, 1e7)),
        other => other.to_string(),
    }
}
