//! `nailnoise cycle`: one nailing cycle without its sound.

use std::process::ExitCode;

use clap::Args;
use nailnoise_dynamics::{CycleRecord, Events, Outcome, Summary, Work};
use serde::Serialize;

use super::table::table;
use super::{Common, Progress, print, print_json, status_of};
use crate::error::Error;
use crate::output::{self, EVENT_NAMES};
use crate::pipeline::{self, Observer as _};
use crate::result::{Check, DesignId};

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
}

/// Layout of `cycle --json`.
#[derive(Serialize)]
struct CycleResult<'a> {
    schema: &'static str,
    design: DesignId,
    outcome: Outcome,
    events: &'a Events,
    summary: &'a Summary,
    checks: Vec<Check>,
    work: &'a Work,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    common.start_threads()?;
    let design = common.load()?;
    let folder = common.out(&design);
    let mut progress = Progress::new();
    progress.stage("nailing cycle");
    let record = pipeline::cycle(&design)?;
    progress.stage("writing files");
    output::write_cycle(&folder, &record)?;
    drop(progress);
    let checks: Vec<Check> = record.checks.iter().map(Check::from).collect();
    let status = status_of(&checks);
    let result = CycleResult {
        schema: "nailnoise-cycle/1",
        design: DesignId {
            name: design.name().to_owned(),
            digest: design.digest(),
        },
        outcome: record.outcome,
        events: &record.events,
        summary: &record.summary,
        checks,
        work: &record.work,
    };
    if common.json {
        print_json(&result)?;
    } else {
        print(&text(&result, &record));
        print(&format!("\n  files in {}\n", folder.display()));
    }
    Ok(status)
}

fn text(result: &CycleResult<'_>, record: &CycleRecord) -> String {
    let mut text = format!("{}: {}\n\n", result.design.name, words(&result.outcome));
    let events: Vec<Vec<String>> = result
        .events
        .to_array()
        .iter()
        .zip(EVENT_NAMES)
        .enumerate()
        .map(|(index, (time, name))| {
            let time = time.map_or_else(|| "-".to_owned(), |time| format!("{:.3}", 1e3 * time));
            vec![format!("t{index:<2} {name}"), time]
        })
        .collect();
    text.push_str(&table(&["event", "time ms"], &events));
    text.push('\n');
    let summary = serde_json::to_value(result.summary).unwrap_or_default();
    let rows: Vec<Vec<String>> = summary
        .as_object()
        .into_iter()
        .flatten()
        .map(|(name, value)| {
            let value = value
                .as_f64()
                .map_or_else(|| "-".to_owned(), |value| format!("{value:.5}"));
            vec![name.replace('_', " "), value]
        })
        .collect();
    text.push_str(&table(&["summary", "SI"], &rows));
    text.push('\n');
    let checks: Vec<Vec<String>> = result
        .checks
        .iter()
        .map(|check| {
            let verdict = if check.ok { "ok" } else { "FAILED" };
            vec![
                check.name.clone(),
                format!("{:.2e}", check.value),
                format!("{:.0e}", check.limit),
                verdict.to_owned(),
            ]
        })
        .collect();
    text.push_str(&table(&["check", "value", "limit", ""], &checks));
    text.push_str(&format!(
        "\n  {} steps, {} rejected, {} events, {} Jacobians; {} samples of {:.1} us\n",
        result.work.steps,
        result.work.rejected,
        result.work.events,
        result.work.jacobians,
        record.len(),
        1e6 * record.sample_interval,
    ));
    text
}

/// A serde word (`strikes_bumper`) in words.
fn words(outcome: &Outcome) -> String {
    let value = serde_json::to_value(outcome).unwrap_or_default();
    value.as_str().unwrap_or_default().replace('_', " ")
}
