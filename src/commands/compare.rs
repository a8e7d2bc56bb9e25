//! `nailnoise compare`: compares designs.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::Status;
use super::{
    Changes, Keeping, Memory, Shown, Threads, comparison_page, comparison_sounds, folder_of, message, print,
    print_json, status_of, table,
};
use crate::artifacts::Delivery;
use crate::atomic_write;
use crate::comparison::ComparisonError;
use crate::comparison::{Comparison, Finished, Labelled, Limit};
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::output::Exports;
use crate::report;
use crate::result::Check;
use crate::stages::Progress;
use crate::store::Store;
use crate::study::{PairedStudy, Request, common_draws};
use crate::tables;
use crate::units::Units;
use crate::wording::order;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise compare as-it-is.toml muffler.toml" => "the differences and their effect on each source",
    "nailnoise compare as-it-is.toml muffler.toml --draws 64" => "how sure the changes are",
    "nailnoise compare old.toml new.toml --fail-above total=100" => "status 1 if the new design is louder than 100 dB",
    "nailnoise compare my-tool.toml --measured out/test/measurement.json" => "with the measurements of the tool",
    "nailnoise compare n80cb-as-tested.toml --measured n80cb" => "the shipped tool and its published tests",
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
    #[command(flatten)]
    pub(super) shown: Shown,
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
    let progress = arguments.shown.progress();
    let cache = arguments.keeping.cache()?;
    if let [design] = arguments.designs.as_slice() {
        return Err(ComparisonError::NothingToCompare { path: design.clone() }.into());
    }
    if arguments.draws.is_some()
        && let Some(path) = arguments.designs.iter().find(|path| Finished::is_at(path).is_some())
    {
        return Err(ComparisonError::NothingToDraw { path: path.clone() }.into());
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
    let units = arguments.shown.units;
    let page = comparison_page::place(&arguments.out, &comparison.designs, &identity);
    atomic_write::write(
        &page,
        report::comparison(&comparison, &paired, &identity, &recordings, units).as_bytes(),
    )?;
    if arguments.json {
        print_json(&Layout {
            comparison: &comparison,
            paired: &paired,
        })?;
    } else {
        arguments.shown.print(&super::alarm(&comparison.alarms()))?;
        arguments
            .shown
            .print(&text(&comparison, arguments.bands, arguments.intervals, units))?;
        paired
            .iter()
            .try_for_each(|paired| arguments.shown.print(&changes(paired)))?;
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
    /// Comparison of each design with the first over common draws; absent without `--draws`.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    paired: &'a [PairedStudy],
}

/// Compares each design with the first over common draws, if requested.
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

/// Formats the changes of a design.
fn changes(paired: &PairedStudy) -> String {
    format!(
        "\n{}\n\n{}",
        paired.basis(),
        table::text(&tables::study::changes(paired))
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
        exports: Exports {
            units: arguments.shown.units,
            ..Exports::default()
        },
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

/// The name, followed by a number if another result of the comparison has the same name.
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

fn text(comparison: &Comparison, bands: bool, intervals: bool, units: Units) -> String {
    let mut text = String::from("differences\n\n");
    if comparison.inputs.is_empty() {
        text.push_str(&format!("  {}\n", comparison.no_difference()));
    } else {
        text.push_str(&table::text(&comparison.input_table().in_units(units)));
    }
    text.push_str("\nA-weighted single-event sound power levels, dB re 1 pW s; changes from the first\n\n");
    text.push_str(&table::text(&comparison.level_table()));
    if let Some(performance) = comparison.performance_table() {
        text.push_str(&format!("\n{}", table::text(&performance.in_units(units))));
    }
    if let Some(intervals) = comparison.interval_table() {
        text.push_str(&format!("\nintervals of the levels\n\n{}", table::text(&intervals)));
    }
    for line in comparison.unlike_methods() {
        text.push_str(&format!("  {line}\n"));
    }
    text.push_str("\nuncertainty of each method, dB (open: no bound)\n\n");
    text.push_str(&table::text(&comparison.method_table()));
    text.push_str("\nranking\n\n");
    text.push_str(&table::text(&comparison.ranking_table()));
    for (design, name) in comparison.designs.iter().enumerate() {
        text.push_str(&format!("  {name}: ranking {}\n", order(&comparison.placed(design))));
    }
    let shot = comparison.shot_table().in_units(units);
    text.push_str(&format!("\nthe shot\n\n{}", table::text(&shot)));
    if shot.rows.len() == 1 {
        text.push_str("  all figures and events are equal\n");
    }
    for row in &comparison.sources {
        let mut part = |title: &str, first: &str, labelled: &[Labelled]| {
            let levels = table::text(&comparison.labelled_table(first, labelled));
            text.push_str(&format!("\n{}, {title}, dB(A)\n\n{levels}", row.source));
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
