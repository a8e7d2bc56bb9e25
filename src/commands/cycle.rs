//! `nailnoise cycle`: one nailing cycle, without sound.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nailnoise_dynamics::network::Effort;
use nailnoise_dynamics::{CycleRecord, EnergyFlow, NailerFigures, simulate_figures};
use serde::Serialize;

use super::assembly::Asked;
use super::{Common, Status, print, print_json, status_of, table, warn};
use crate::atomic_write::AtomicWrite;
use crate::chain;
use crate::cost;
use crate::design::Design;
use crate::design::inputs::assembly::AssembledTool;
use crate::error::Error;
use crate::figures::{self, Chart};
use crate::output::{self, Exports};
use crate::penetration;
use crate::result::DesignId;
use crate::stages::cycle::{Cycle, Preset};
use crate::tables::{self, dash, fixed};
use crate::units::Units;
use crate::wording::figure;

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "events.csv";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise cycle my-tool.toml --figures" => "pressures, motion and forces of one shot, with charts",
    "nailnoise cycle my-tool.toml --sensitivity --outputs \
     speed,penetration" => "which parameters decide speed and depth",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Compute the model as printed in the thesis: every form, or only the nail
    #[arg(long, value_name = "WHAT", value_enum, num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "all")]
    as_published: Option<Published>,
    /// Replace the penetration law of the design by points from a CSV file: depth in m and force in N per line
    #[arg(long, value_name = "FILE", conflicts_with_all = ["as_published", "sensitivity", "draw"])]
    penetration_table: Option<PathBuf>,
    /// Draw pressures, motion, pressure ratios, forces and energy flow as SVG
    #[arg(long)]
    figures: bool,
    /// Rank the parameters by the effect of their ranges on the shot, instead of computing one shot
    #[arg(long, conflicts_with_all = ["as_published", "figures"])]
    sensitivity: bool,
    /// Results of the shot for --sensitivity, by name or group: speed, penetration, events, forces, masses, all
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "sensitivity")]
    outputs: Vec<String>,
    /// Parameters for --sensitivity, for example supply.pressure,piston.bore [default: all with a range]
    #[arg(long, value_name = "KEYS", value_delimiter = ',', requires = "sensitivity")]
    parameters: Vec<String>,
    /// Draw N designs from the ranges and count the outcomes of their shots, instead of computing one shot
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    #[arg(conflicts_with_all = ["as_published", "figures", "sensitivity"])]
    draw: Option<u32>,
    /// Seed of --draw; the same seed draws the same designs
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "draw")]
    seed: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum Published {
    /// Every form as printed, without anything that the thesis does not include
    All,
    /// Only the nail: elastic penetration, and no impact of the rod on it
    Nail,
}

impl From<Published> for Preset {
    fn from(published: Published) -> Self {
        match published {
            Published::All => Self::PublishedAll,
            Published::Nail => Self::PublishedNailOnly,
        }
    }
}

/// Layout of `cycle --json`.
#[derive(Serialize)]
struct CycleResult<'a> {
    schema: &'static str,
    design: DesignId,
    /// The published form that replaces the one of the design; null for the design as given.
    preset: Option<Preset>,
    /// File of the penetration law that replaces the one of the design; null if there is none.
    penetration_table: Option<String>,
    #[serde(flatten)]
    cycle: &'a NailerFigures,
    work: Effort,
    /// Files of the charts requested.
    figures: Vec<String>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    if let Some(tool) = AssembledTool::load(&common.design, &common.options.changes.set)? {
        return of_assembly(arguments, &tool);
    }
    let design = common.begin()?;
    cost::refuse(&design, &[cost::of_cycle(&design)], common.options.memory.limit())?;
    if arguments.sensitivity {
        return super::sensitivity::execute(common, &design, &arguments.outputs, &arguments.parameters);
    }
    if let Some(count) = arguments.draw {
        return super::draw::execute(common, &design, count as usize, arguments.seed);
    }
    let preset = arguments.as_published.map(Preset::from);
    let folder = match preset {
        // In a subfolder, so that the files of the design itself are not overwritten.
        Some(preset) if common.options.out.is_none() => common.out(&design)?.join(preset.as_str()),
        _ => common.out(&design)?,
    };
    let progress = common.shown.progress();
    progress.stage("nailing cycle");
    let cycle = cycle(&design, preset, arguments.penetration_table.as_deref())?;
    let penetration_table = arguments
        .penetration_table
        .as_ref()
        .map(|path| path.display().to_string());
    let form = match (preset, &penetration_table) {
        (Some(preset), _) => words_of(preset).to_owned(),
        (None, Some(path)) => format!(", penetration law of {path}"),
        (None, None) => String::new(),
    };
    let result = |cycle, work, files: &[PathBuf]| CycleResult {
        schema: "nailnoise-cycle/1",
        design: DesignId::from(&design),
        preset,
        penetration_table: penetration_table.clone(),
        cycle,
        work,
        figures: files.iter().map(|file| file.display().to_string()).collect(),
    };
    // Histories and their tables take most of the time of a shot; a program that reads JSON requests them explicitly.
    if common.options.json && common.options.out.is_none() && !arguments.figures {
        let (figures, work) = simulate_figures(&cycle.parameters, &cycle.settings)?;
        progress.end();
        print_json(&result(&figures, work, &[]))?;
        return Ok(status_of(&figures.checks));
    }
    let record = cycle.record()?;
    progress.stage("writing files");
    let outcome = record.figures.outcome.name().replace('_', " ");
    let headline = format!("{}{form}: {outcome}", design.name());
    let charts = arguments
        .figures
        .then(|| figures::in_units(figures::cycle(&headline, &design, (&record).into()), common.shown.units));
    let files = write(&folder, &record, &charts.unwrap_or_default())?;
    progress.end();
    if common.options.json {
        print_json(&result(&record.figures, record.record.work, &files))?;
    } else {
        common.shown.print(&text(&headline, &record, common.shown.units))?;
        print(&format!("\n  files in {}\n", folder.display()))?;
        for file in &files {
            print(&format!("  {}\n", file.display()))?;
        }
    }
    Ok(status_of(&record.figures.checks))
}

/// The cycle of a design, in a published form or with points of a penetration law.
fn cycle(design: &Design, preset: Option<Preset>, penetration_table: Option<&Path>) -> Result<Cycle, Error> {
    let mut cycle = chain::cycle_stage(design)?;
    if let Some(path) = penetration_table {
        cycle.parameters.penetration_table = Some(penetration::table(path)?);
    }
    Ok(match preset {
        Some(preset) => cycle.published(preset),
        None => cycle,
    })
}

/// The cycle of a tool described by its file as an assembly.
fn of_assembly(arguments: &Arguments, tool: &AssembledTool) -> Result<Status, Error> {
    let options = [
        ("--as-published", arguments.as_published.is_some()),
        ("--penetration-table", arguments.penetration_table.is_some()),
        ("--draw", arguments.draw.is_some()),
    ];
    if let Some((option, _)) = options.into_iter().find(|(_, given)| *given) {
        return Err(Error::OfDesign { option });
    }
    let common = &arguments.common;
    if arguments.sensitivity {
        let (outputs, parameters) = (&arguments.outputs, &arguments.parameters);
        if tool.has_design {
            let design = common.begin_with_any_tool()?;
            return super::sensitivity::execute(common, &design, outputs, parameters);
        }
        common.options.threads.start()?;
        warn(tool);
        return super::sensitivity::execute_tool(common, tool, outputs, parameters);
    }
    common.options.threads.start()?;
    warn(tool);
    let asked = Asked {
        path: &common.design,
        out: common.options.out.as_deref(),
        json: common.options.json,
        figures: arguments.figures,
        shown: common.shown,
    };
    super::assembly::cycle(tool, &asked)
}

/// Writes the tables of a cycle and these charts together; returns the files of the charts.
fn write(folder: &Path, record: &CycleRecord, charts: &[Chart]) -> Result<Vec<PathBuf>, Error> {
    let staging = AtomicWrite::within(folder)?;
    let exports = Exports {
        histories: true,
        ..Exports::default()
    };
    for file in output::of_cycle(record.into(), exports)? {
        staging.write(&file.path, &file.content)?;
    }
    let figures = figures::write(&staging, Path::new("figures"), charts)?;
    staging.place(&[], Path::new(LAST))?;
    Ok(figures.iter().map(|file| folder.join(file)).collect())
}

fn text(headline: &str, record: &CycleRecord, units: Units) -> String {
    let mut text = format!("{headline}\n\n");
    text.push_str(&table::text(&tables::cycle::events(&record.record.events)));
    text.push('\n');
    let summary = serde_json::to_value(&record.figures.summary).unwrap_or_default();
    let rows: Vec<Vec<String>> = summary
        .as_object()
        .into_iter()
        .flatten()
        .map(|(name, value)| {
            let value = dash(value.as_f64(), |value| figure(name, value));
            vec![name.replace('_', " "), value]
        })
        .collect();
    text.push_str(&table::numbers(&["summary", "value"], &rows, units));
    text.push('\n');
    text.push_str(&table::numbers(
        &["energy", "J"],
        &energy(&record.figures.energy),
        units,
    ));
    text.push('\n');
    text.push_str(&table::text(&tables::run::checks(&record.figures.checks)));
    text.push_str(&format!(
        "\n  {} steps, {} rejected, {} events, {} Jacobians; {} samples of {:.1} us\n",
        record.record.work.steps,
        record.record.work.rejected,
        record.record.work.events,
        record.record.work.jacobians,
        record.len(),
        1e6 * record.sample_interval(),
    ));
    text
}

/// Every term of the energy flow with its name; terms of a group have both names.
fn energy(flow: &EnergyFlow) -> Vec<Vec<String>> {
    let row = |name: String, value: &serde_json::Value| vec![name.replace('_', " "), fixed(value.as_f64(), 4)];
    let value = serde_json::to_value(flow).unwrap_or_default();
    let mut rows = Vec::new();
    for (name, value) in value.as_object().into_iter().flatten() {
        match value.as_object() {
            Some(group) => rows.extend(group.iter().map(|(own, value)| row(format!("{name}, {own}"), value))),
            None => rows.push(row(name.clone(), value)),
        }
    }
    rows
}

/// A preset as text that is appended to the name of the design.
fn words_of(preset: Preset) -> &'static str {
    match preset {
        Preset::PublishedAll => ", every form as published",
        Preset::PublishedNailOnly => ", nail as published",
    }
}
