//! `nailnoise run`: the ranked sources of a design.

use std::process::ExitCode;

use clap::Args;

use super::table::{decibels, table};
use super::{Common, Progress, print, print_json, status_of};
use crate::error::Error;
use crate::output;
use crate::pipeline::{self, Observer as _, Options};
use crate::result::RunResult;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    common.start_threads()?;
    let design = common.load()?;
    let folder = common.out(&design);
    let mut progress = Progress::new();
    let run = pipeline::run(&design, Options::default(), &mut progress)?;
    progress.stage("writing files");
    output::write_run(&folder, &run)?;
    drop(progress);
    if common.json {
        print_json(&run.result)?;
    } else {
        print(&text(&run.result));
        print(&format!("\n  files in {}\n", folder.display()));
    }
    Ok(status_of(&run.result.checks))
}

/// The result as a person reads it.
fn text(result: &RunResult) -> String {
    let rows: Vec<Vec<String>> = result
        .ranking
        .iter()
        .map(|source| {
            let loudest = source
                .bands
                .iter()
                .filter(|band| band.lwa_db.is_some())
                .max_by(|a, b| a.lwa_db.partial_cmp(&b.lwa_db).unwrap_or(std::cmp::Ordering::Equal));
            vec![
                source.source.clone(),
                decibels(source.lwa_db),
                decibels(source.lw_db),
                format!("{:.1} %", 100.0 * source.share),
                loudest.map_or_else(|| "-".to_owned(), |band| format!("{} Hz", band.hz)),
                format!("{:.0} - {:.0} Hz", source.range_hz[0], source.range_hz[1]),
                source.method.clone(),
            ]
        })
        .chain([vec![
            "total".to_owned(),
            decibels(result.total.lwa_db),
            decibels(result.total.lw_db),
        ]])
        .collect();
    let headings = [
        "source",
        "L_WA,1s dB",
        "L_W,1s dB",
        "share (A)",
        "loudest band (A)",
        "computed over",
        "method",
    ];
    let mut text = format!(
        "{}: single-event sound power levels re 1 pW s, one shot",
        result.design.name
    );
    if let Some(source) = result.ranking.first() {
        let (first, last) = (source.bands.first(), source.bands.last());
        if let (Some(first), Some(last)) = (first, last) {
            text.push_str(&format!(", third-octave bands {} to {} Hz", first.hz, last.hz));
        }
    }
    text.push_str("\n\n");
    text.push_str(&table(&headings, &rows));
    text.push('\n');
    for note in &result.notes {
        text.push_str(&format!("  - {note}\n"));
    }
    let failed = result.checks.iter().filter(|check| !check.ok).count();
    let total: f64 = result.timing.0.iter().map(|stage| stage.1).sum();
    let checks = result.checks.len();
    text.push_str(&match failed {
        0 => format!("\n  all {checks} checks ok; {total:.1} s\n"),
        _ => format!("\n  {failed} of {checks} checks FAILED; {total:.1} s\n"),
    });
    text
}
