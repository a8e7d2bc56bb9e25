//! `nailnoise cycle --draw`: designs drawn from the ranges of one, and the outcomes of their shots.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::{Common, message, print, print_json, progress};
use super::{Status, table::table};
use crate::atomic_write::AtomicWrite;
use crate::design::{Design, Name, Value};
use crate::error::Error;
use crate::graph::Graph;
use crate::output;
use crate::result::DesignId;
use crate::study::{Counted, DrawnShot, Rejections, ShotOutcome, ShotSampler};

/// Layout of `cycle --draw --json`; the draws themselves are in the file.
#[derive(Serialize)]
struct DrawResult<'a> {
    schema: &'static str,
    design: DesignId,
    seed: u64,
    drawn: usize,
    parameters: usize,
    candidates: usize,
    counts: &'a BTreeMap<String, usize>,
    refused: &'a BTreeMap<String, usize>,
    rejections: &'a Rejections,
    failures: Vec<Failure>,
    file: String,
}

#[derive(Serialize)]
struct Failure {
    candidate: usize,
    error: String,
}

pub(super) fn execute(common: &Common, design: &Design, count: usize, seed: u64) -> Result<Status, Error> {
    let folder = common.out(design)?;
    let progress = progress();
    progress.stage("drawing designs");
    let sampler = ShotSampler::new(design, seed)?;
    let path = folder.join("draws.csv");
    let staging = AtomicWrite::within(&folder)?;
    let mut file = staging.file("draws.csv".as_ref())?;
    file.write(&row(header(&sampler))?)?;
    let mut failures = Vec::new();
    // Every draw is written at once, so that memory does not grow with their number.
    let counted = sampler.each(&Graph::default(), count, &progress, |draw| {
        if let ShotOutcome::SolverFailure(error) = &draw.outcome {
            failures.push(Failure {
                candidate: draw.candidate,
                error: error.clone(),
            });
        }
        file.write(&row(cells(&draw))?)
    })?;
    file.finish()?;
    staging.place(&[], "draws.csv".as_ref())?;
    progress.end();
    let status = if failures.is_empty() {
        Status::SUCCESS
    } else {
        Status::from(3)
    };
    for Failure { candidate, error } in &failures {
        message(&format!("candidate {candidate} cannot be computed: {error}"));
    }
    if common.options.json {
        print_json(&DrawResult {
            schema: "nailnoise-draw/1",
            design: DesignId::from(design),
            seed,
            drawn: counted.drawn,
            parameters: sampler.parameters.len(),
            candidates: counted.candidates,
            counts: &counted.counts,
            refused: &counted.refused,
            rejections: &counted.rejections,
            failures,
            file: path.display().to_string(),
        })?;
    } else {
        common.shown.print(&text(design.name(), seed, &sampler, &counted))?;
        print(&format!("\n  every design in {}\n", path.display()))?;
    }
    Ok(status)
}

fn text(name: &str, seed: u64, sampler: &ShotSampler, study: &Counted) -> String {
    let drawn = study.drawn;
    let mut text = format!(
        "{name}: {drawn} designs drawn from the ranges of {} parameters{} (seed {})\n\n",
        sampler.parameters.len(),
        if sampler.scores.is_empty() {
            ""
        } else {
            " and the uncertainty of the fitted penetration law"
        },
        seed
    );
    let mut counts: Vec<(&String, &usize)> = study.counts.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1));
    let rows: Vec<Vec<String>> = counts
        .into_iter()
        .map(|(outcome, count)| {
            let share = 100.0 * *count as f64 / drawn.max(1) as f64;
            vec![outcome.replace('_', " "), count.to_string(), format!("{share:.1}")]
        })
        .collect();
    text.push_str(&table(&["the shot", "designs", "%"], &rows));
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(
        text,
        "\n  {} candidates, {} refused",
        study.candidates,
        study.candidates - drawn
    );
    let refused = study.refused.iter().map(|(reason, count)| (reason, *count as u64));
    let drawn_anew = study.rejections.iter().map(|(keys, count)| (keys, *count));
    let mut reasons: Vec<(&String, u64)> = refused.chain(drawn_anew).collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let rows: Vec<Vec<String>> = reasons
        .into_iter()
        .map(|(reason, count)| vec![reason.clone(), count.to_string()])
        .collect();
    if !rows.is_empty() {
        text.push_str(&table(&["incompatible values", "drawn anew"], &rows));
    }
    text
}

/// Headings of `draws.csv`, which has one row per design with values in SI units.
fn header(sampler: &ShotSampler) -> Vec<String> {
    let figures = [
        "candidate",
        "outcome",
        "mean_drive_speed [m/s]",
        "penetration [m]",
        "exhaust_mass [kg]",
    ];
    let values = sampler.parameters.iter().map(|parameter| {
        let unit = if parameter.unit.is_empty() {
            "-"
        } else {
            &parameter.unit
        };
        format!("{} [{unit}]", parameter.key)
    });
    let scores = sampler.scores.iter().map(|name| format!("{name} [-]"));
    figures
        .map(str::to_owned)
        .into_iter()
        .chain(values)
        .chain(scores)
        .collect()
}

/// Cells of a drawn design.
fn cells(draw: &DrawnShot) -> Vec<String> {
    let (speed, depth, mass) = match &draw.outcome {
        ShotOutcome::Shot(shot) => (shot.mean_drive_speed, Some(shot.penetration), Some(shot.exhaust_mass)),
        ShotOutcome::DryFire | ShotOutcome::SolverFailure(_) | ShotOutcome::Refused(_) => (None, None, None),
    };
    let figures = [speed, depth, mass].map(|value| value.map_or_else(String::new, |value| format!("{value:e}")));
    let values = draw.values.iter().map(|value| match value {
        Value::Number(value) => format!("{value:e}"),
        Value::Count(count) => count.to_string(),
        Value::Switch(on) => on.to_string(),
        Value::Choice(word) => (*word).to_owned(),
        Value::File(text) | Value::Name(Name(text)) => text.clone(),
    });
    let names = [draw.candidate.to_string(), draw.outcome.name().to_owned()];
    names.into_iter().chain(figures).chain(values).collect()
}

/// A row of the file.
fn row(cells: Vec<String>) -> Result<Vec<u8>, Error> {
    output::table(cells, std::iter::empty::<Vec<String>>())
}
