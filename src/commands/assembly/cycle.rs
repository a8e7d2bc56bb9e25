//! `nailnoise cycle` of an assembly: one cycle of the network.

use std::path::{Path, PathBuf};

use nailnoise_dynamics::network::{Assembly, Effort, EventTime, LedgerEntry, Peak, Record, Strike};
use nailnoise_quantities::Check;
use serde::Serialize;

use super::openings::{HEADINGS, OpeningFigures};
use crate::atomic_write::AtomicWrite;
use crate::commands::{Shown, Status, given_or_named, print, print_json, progress, status_of, table};
use crate::design::inputs::assembly::AssembledTool;
use crate::error::Error;
use crate::figures;
use crate::output::{self, CycleView, Exports};
use crate::stages::cycle::event_in_words;
use crate::tables::{self, fixed};
use crate::units::Units;

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "events.csv";

/// Options of the command.
pub(in crate::commands) struct Asked<'a> {
    /// The file of the tool.
    pub(in crate::commands) path: &'a Path,
    /// Folder of the files; by default named after the tool.
    pub(in crate::commands) out: Option<&'a Path>,
    pub(in crate::commands) json: bool,
    pub(in crate::commands) figures: bool,
    pub(in crate::commands) shown: Shown,
}

/// Layout of `cycle --json` of an assembly.
#[derive(Serialize)]
struct CycleResult<'a> {
    schema: &'static str,
    tool: &'a str,
    assembly: &'a str,
    outcome: Option<&'a str>,
    /// End of the record \[s\].
    end: f64,
    events: &'a [EventTime],
    openings: Vec<OpeningFigures<'a>>,
    peaks: &'a [Peak],
    strikes: &'a [Strike],
    ledger: &'a [LedgerEntry],
    checks: &'a [Check],
    work: Effort,
    /// Names of the channels, the columns of `histories.csv`.
    channels: Vec<&'a str>,
    /// Files of the charts requested.
    figures: Vec<String>,
}

pub(in crate::commands) fn execute(tool: &AssembledTool, asked: &Asked<'_>) -> Result<Status, Error> {
    let folder = given_or_named(asked.out, &tool.name, asked.path)?;
    let progress = progress();
    progress.stage("cycle");
    let record = tool.record()?;
    let mut drawn = Vec::new();
    if !asked.json || asked.out.is_some() || asked.figures {
        progress.stage("writing files");
        drawn = write(&folder, tool, &record, asked.figures.then_some(asked.shown.units))?;
    }
    progress.end();
    let status = status_of(&record.checks);
    let result = CycleResult {
        schema: "nailnoise-network-cycle/1",
        tool: &tool.name,
        assembly: &tool.resolved.assembly.name,
        outcome: record.outcome.as_deref(),
        end: record.end,
        events: &record.events,
        openings: OpeningFigures::of(&tool.resolved.assembly, &record),
        peaks: &record.peaks,
        strikes: &record.strikes,
        ledger: &record.ledger,
        checks: &record.checks,
        work: record.work,
        channels: record.channels.iter().map(|channel| channel.name.as_str()).collect(),
        figures: drawn.iter().map(|file| file.display().to_string()).collect(),
    };
    if asked.json {
        print_json(&result)?;
    } else {
        asked
            .shown
            .print(&text(tool, &record, &result.openings, asked.shown.units))?;
        print(&format!("\n  files in {}\n", folder.display()))?;
        for file in &drawn {
            print(&format!("  {}\n", file.display()))?;
        }
    }
    Ok(status)
}

/// Writes the tables and, if units are given, the charts in them; returns the files of the charts.
fn write(folder: &Path, tool: &AssembledTool, record: &Record, charts: Option<Units>) -> Result<Vec<PathBuf>, Error> {
    let staging = AtomicWrite::within(folder)?;
    let exports = Exports {
        histories: true,
        ..Exports::default()
    };
    let view = CycleView { record, nailer: None };
    for file in output::of_cycle(view, exports)? {
        staging.write(&file.path, &file.content)?;
    }
    let charts = charts.map_or_else(Vec::new, |units| {
        figures::in_units(figures::network(&headline(tool, record), record), units)
    });
    let drawn = figures::write(&staging, Path::new("figures"), &charts)?;
    staging.place(&[], Path::new(LAST))?;
    Ok(drawn.iter().map(|file| folder.join(file)).collect())
}

/// The tool and its outcome.
fn headline(tool: &AssembledTool, record: &Record) -> String {
    let outcome = record
        .outcome
        .as_ref()
        .map(|outcome| format!(": {}", outcome.replace('_', " ")));
    format!("{}{}", tool.name, outcome.unwrap_or_default())
}

/// Largest pressures, speeds of the moving bodies, and depths of the fasteners.
fn largest_values(assembly: &Assembly, record: &Record) -> Vec<Vec<String>> {
    let largest =
        |channel: String, size: fn(f64) -> f64| record.get(&channel)?.iter().copied().map(size).reduce(f64::max);
    let row = |name: String, value: f64, unit: &str| vec![name, format!("{value:.3} {unit}")];
    let mut rows = Vec::new();
    for volume in &assembly.volumes {
        let highest = largest(format!("{}.pressure", volume.name), |own| own);
        rows.extend(highest.map(|own| row(format!("highest pressure, {}", volume.name), 1e-3 * own, "kPa")));
    }
    for body in &assembly.bodies {
        let fastest = largest(format!("{}.velocity", body.name), f64::abs);
        rows.extend(fastest.map(|own| row(format!("highest speed, {}", body.name), own, "m/s")));
    }
    for fastener in &assembly.fasteners {
        let deepest = largest(format!("{}.deepest", fastener.name), |own| own);
        rows.extend(deepest.map(|own| row(format!("depth of the tip, {}", fastener.name), 1e3 * own, "mm")));
    }
    rows
}

fn text(tool: &AssembledTool, record: &Record, openings: &[OpeningFigures<'_>], units: Units) -> String {
    let mut text = format!("{}\n\n", headline(tool, record));
    let mut section = |headings: &[&str], rows: Vec<Vec<String>>| {
        if !rows.is_empty() {
            text.push_str(&table::numbers(headings, &rows, units));
            text.push('\n');
        }
    };
    let events = record.events.iter().map(|event| {
        let words = event_in_words(&event.name, &event.description);
        vec![words, fixed(event.time.map(|time| 1e3 * time), 3)]
    });
    section(&["event", "time ms"], events.collect());
    let peaks = record
        .peaks
        .iter()
        .map(|peak| vec![peak.block.clone(), format!("{:.1}", peak.force)]);
    section(&HEADINGS, openings.iter().map(OpeningFigures::row).collect());
    section(&["peak force", "N"], peaks.collect());
    section(&["figure", "value"], largest_values(&tool.resolved.assembly, record));
    let strikes = record.strikes.iter().map(|strike| {
        vec![
            format!("{} at {:.3} ms", strike.fastener, 1e3 * strike.time),
            format!("{:.3} to {:.3}", strike.before, strike.after),
        ]
    });
    section(&["strike", "speed m/s"], strikes.collect());
    let ledger = record
        .ledger
        .iter()
        .map(|entry| vec![entry.name.clone(), format!("{:.5e} {}", entry.value, entry.unit)]);
    section(&["balance", "value"], ledger.collect());
    text.push_str(&table::text(&tables::run::checks(&record.checks)));
    text.push_str(&format!(
        "\n  {} steps, {} rejected, {} switches of blocks, {} Jacobians\n",
        record.work.steps, record.work.rejected, record.work.events, record.work.jacobians
    ));
    text
}
