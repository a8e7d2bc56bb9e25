//! `nailnoise optimise`: the designs of the lowest level under constraints.

use std::path::{Path, PathBuf};

use clap::Args;
use nailnoise_dynamics::Outcome;
use serde::Serialize;

use super::python::Cluster;
use super::run::delivered;
use super::{Common, Keeping, Status, print_json, status_of, table};
use crate::artifacts::Delivery;
use crate::atomic_write::AtomicWrite;
use crate::design::{Assignment, Design, inputs};
use crate::error::Error;
use crate::graph::Graph;
use crate::optimisation::{Constraint, Objective, Optimisation, Request, Varied, design_over, optimise};
use crate::output::{self, Exports};
use crate::result::Check;
use crate::store::Store;
use crate::tables::optimisation as tables;
use crate::tables::performance::{CSV_HEADINGS, csv_cells};
use crate::units::Units;
use crate::{figures, report};

/// The page; the last file to be written, so that a folder with it has all the rest.
const LAST: &str = "optimise.html";

/// Designs at a time on a cluster, unless the user says otherwise.
const ON_CLUSTER: u16 = 8;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise optimise my-tool.toml --vary exhaust.holes=3..12 --subject-to \"penetration >= 80 mm\"" =>
        "the quietest number of holes that still drives the nail",
    "nailnoise optimise my-tool.toml --vary exhaust.holes=3..12 --vary \"supply.pressure=80psig..110psig\" \
     --pareto=-drive_energy" => "the front of noise and driving energy",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// A key and its range, as supply.pressure=80psig..110psig, or its choices A,B,C; :log behind a range for equal
    /// ratios; once for each key
    #[arg(long, value_name = "KEY=LOW..HIGH", required = true)]
    vary: Vec<Varied>,
    /// total, a source, or a figure of the shot; with a minus it is maximised
    #[arg(long, value_name = "WHAT", default_value = "total", allow_hyphen_values = true)]
    minimise: Objective,
    /// As "penetration >= 80 mm" or "exhaust <= 92 dB"; once for each constraint. Without one on the outcome,
    /// "outcome == drives" is added if the tool has this outcome
    #[arg(long, value_name = "CONSTRAINT")]
    subject_to: Vec<Constraint>,
    /// A second objective, for the front of both; with a minus it is maximised, as --pareto=-drive_energy
    #[arg(long, value_name = "WHAT", allow_hyphen_values = true)]
    pareto: Option<Objective>,
    /// Designs whose levels are computed
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    trials: u32,
    /// The same seed tries the same designs
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Designs at a time, which know nothing of each other [default: 1, or 8 on a cluster]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    batch: Option<u16>,
    /// Also run each of the best designs and leave its report, which the page opens
    #[arg(long)]
    reports: bool,
    /// Compute the levels on a cluster of Dask, by the address of its scheduler (needs the Python package)
    #[arg(long, value_name = "ADDRESS", conflicts_with = "no_cache")]
    scheduler: Option<String>,
    /// Keep the levels in this folder, which the workers of the cluster share
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    store: Option<PathBuf>,
}

/// Layout of `optimise --json`.
#[derive(Serialize)]
struct Layout<'a> {
    schema: &'static str,
    #[serde(flatten)]
    found: &'a Optimisation,
    /// Files of the designs of the front.
    files: Vec<String>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let design = common.begin_with_any_tool()?;
    let folder = match &common.options.out {
        Some(folder) => folder.clone(),
        None => common.out(&design)?.join("optimised"),
    };
    let progress = common.shown.progress();
    progress.stage("designs with levels");
    let store = match &arguments.store {
        Some(folder) => Store::shared(folder)?,
        None => arguments.keeping.cache()?,
    };
    let base = (design.path(), &common.options.changes.set[..]);
    let graph = Graph::quiet(&store, progress.observer());
    let default = if arguments.scheduler.is_some() { ON_CLUSTER } else { 1 };
    let request = Request {
        vary: arguments.vary.clone(),
        objectives: [&arguments.minimise]
            .into_iter()
            .chain(&arguments.pareto)
            .cloned()
            .collect(),
        constraints: constraints(arguments, &design, &progress)?,
        trials: arguments.trials as usize,
        seed: arguments.seed,
        batch: arguments.batch.unwrap_or(default).into(),
    };
    let mut fill = |designs: &[Vec<Assignment>]| on_cluster(arguments, &design, &store, designs);
    let found = optimise(
        &graph,
        base,
        &request,
        common.options.memory.limit(),
        &progress,
        &mut fill,
    )?;
    let folder = folder.as_path();
    let mut checks = Vec::new();
    let names: Vec<String> = (1..=found.front.len())
        .map(|number| format!("{}-{number}", design.name()))
        .collect();
    let staging = AtomicWrite::within(folder)?;
    let mut designs = Vec::with_capacity(names.len());
    for (name, trial) in names.iter().zip(found.best()) {
        let text = design_over(&found, trial, base, folder)?;
        staging.write(Path::new(&format!("{name}.toml")), text.as_bytes())?;
        designs.push(text);
    }
    let reports = match arguments.reports {
        false => vec![None; names.len()],
        true => {
            for (name, text) in names.iter().zip(&designs) {
                progress.note(&format!("report of {name}"));
                let design = Design::parse(text, folder.join(format!("{name}.toml")))?;
                checks.extend(reported(
                    &design,
                    &folder.join(name),
                    graph.store(),
                    arguments,
                    &progress,
                )?);
            }
            names.iter().map(|name| Some(format!("{name}/report.html"))).collect()
        }
    };
    let units = common.shown.units;
    let charts = figures::in_units(figures::optimisation(&found), units);
    staging.write(Path::new("candidates.csv"), &csv(&found)?)?;
    staging.write(
        Path::new(LAST),
        report::optimised(&found, &charts, &reports, units).as_bytes(),
    )?;
    staging.place(&outdated(folder, design.name(), names.len()), Path::new(LAST))?;
    progress.end();
    let files = names
        .iter()
        .map(|name| folder.join(format!("{name}.toml")).display().to_string())
        .collect();
    if common.options.json {
        print_json(&Layout {
            schema: "nailnoise-optimise/2",
            found: &found,
            files,
        })?;
    } else {
        common.shown.print(&text(&found, &files, &folder.join(LAST), units))?;
    }
    Ok(match found.front.is_empty() {
        true => Status::from(1),
        false => status_of(&checks),
    })
}

/// The constraints of the command line, and that the shot drives, unless they name another outcome.
fn constraints(
    arguments: &Arguments,
    design: &Design,
    progress: &crate::stages::Progress,
) -> Result<Vec<Constraint>, Error> {
    let mut constraints = arguments.subject_to.clone();
    if constraints.iter().any(Constraint::is_of_outcome) {
        return Ok(constraints);
    }
    let drives = Outcome::Drives.name();
    match inputs::assembly::cycle(design)? {
        Some(cycle) if cycle.assembly.outcomes.iter().all(|own| own.name != drives) => {
            progress.note("no constraint on the outcome: this tool has no outcome \"drives\", so every shot counts");
        }
        _ => constraints.push(format!("outcome == {drives}").parse()?),
    }
    Ok(constraints)
}

/// Runs a design and leaves its report and result in a folder; its checks.
fn reported(
    design: &Design,
    folder: &Path,
    store: &Store,
    arguments: &Arguments,
    progress: &crate::stages::Progress,
) -> Result<Vec<Check>, Error> {
    let (_, checks) = delivered(&Delivery {
        design,
        folder,
        exports: Exports {
            units: arguments.common.shown.units,
            ..Exports::default()
        },
        screening: false,
        printer: super::run::printed,
        store,
        memory: arguments.common.options.memory.limit(),
        progress,
    })?;
    Ok(checks)
}

/// Computes the levels of designs on a cluster, if there is one, into the store.
fn on_cluster(arguments: &Arguments, design: &Design, store: &Store, designs: &[Vec<Assignment>]) -> Result<(), Error> {
    let (Some(scheduler), Some(folder)) = (&arguments.scheduler, store.folder()) else {
        return Ok(());
    };
    let cluster = Cluster {
        scheduler,
        folder,
        shared: arguments.store.is_some(),
    };
    let set = arguments.common.options.changes.set.len();
    let points = designs.iter().flat_map(|own| {
        let own = own[set..].iter().map(ToString::to_string);
        std::iter::once("--point".to_owned()).chain(own)
    });
    cluster.fill("sweep-on", (&arguments.common, design), &points.collect::<Vec<_>>())
}

/// Designs of an earlier search in the folder that this one does not write.
fn outdated(folder: &Path, name: &str, count: usize) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for number in count + 1.. {
        let file = PathBuf::from(format!("{name}-{number}.toml"));
        if !folder.join(&file).exists() {
            break;
        }
        files.push(file);
    }
    files
}

fn text(found: &Optimisation, files: &[String], page: &Path, units: Units) -> String {
    let title = format!(
        "{}: {} candidates, levels of {}, {} feasible",
        found.design.name,
        found.trials.len(),
        found.with_levels(),
        found.feasible()
    );
    let page = page.display();
    if files.is_empty() {
        return format!("{title}; loosen a constraint or widen a range\n\n  {page} says what excludes them\n");
    }
    let table = table::text(&tables::best(found, &[]).in_units(units));
    let list: String = files.iter().map(|file| format!("  {file}\n")).collect();
    format!(
        "{title}; head below the surface, energy left as the nail is flush, air of a shot\n\n{table}\n{list}  \
         {page}\n\n  `nailnoise run {}` computes the best in full; `nailnoise compare \
         --draws` says how sure the change is\n",
        files[0]
    )
}

/// `candidates.csv`: a row for every candidate, figures in SI units.
fn csv(found: &Optimisation) -> Result<Vec<u8>, Error> {
    let shots = || {
        std::iter::once(&found.start)
            .chain(&found.trials)
            .filter_map(|own| own.shot.as_ref())
    };
    let levels = shots().find_map(|shot| shot.levels.as_ref());
    let sources = levels.map_or_else(Vec::new, |own| {
        own.sources.iter().map(|own| own.source.clone()).collect()
    });
    let figures = shots()
        .next()
        .map_or_else(Vec::new, |own| own.figures.iter().map(|own| own.0.clone()).collect());
    let header = found.variables.iter().map(|own| own.key.clone());
    let header = header.chain([
        "feasible".to_owned(),
        "outcome".to_owned(),
        "L_WA,1s total [dB]".to_owned(),
    ]);
    let header = header.chain(sources.iter().map(|source| format!("L_WA,1s {source} [dB]")));
    let header = header
        .chain(figures.iter().cloned())
        .chain(CSV_HEADINGS.map(str::to_owned))
        .chain(["not feasible because".to_owned()]);
    let rows = found.trials.iter().map(|trial| {
        let figure = |name: &String| {
            let value = trial.shot.as_ref().and_then(|shot| shot.figure(name));
            value.map_or_else(String::new, |value| format!("{value}"))
        };
        let outcome = trial
            .shot
            .as_ref()
            .map_or_else(String::new, |shot| shot.outcome.clone());
        let mut row = trial.values.clone();
        row.extend([
            trial.feasible.to_string(),
            outcome,
            figure(&crate::result::TOTAL.to_owned()),
        ]);
        row.extend(sources.iter().chain(&figures).map(figure));
        row.extend(csv_cells(trial.shot.as_ref().map(|shot| &shot.performance)));
        row.push(tables::excluded(found, trial));
        row
    });
    output::table(header, rows)
}
