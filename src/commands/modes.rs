//! `nailnoise modes`: the vibration modes of a body.

use std::process::ExitCode;

use clap::{Args, ValueEnum};
use nailnoise_fem::Sturm;
use serde::Serialize;

use super::table::table;
use super::{Common, Progress, print, print_json, status_of};
use crate::error::Error;
use crate::output;
use crate::pipeline::{self, Body, Observer as _};
use crate::result::{Check, DesignId};

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Body whose modes are computed
    #[arg(long, value_enum)]
    body: BodyName,
}

#[derive(Clone, Copy, ValueEnum)]
enum BodyName {
    /// The wood block, free
    Workpiece,
    /// The worktable, clamped at the floor
    Worktable,
}

/// Layout of `modes --json`.
#[derive(Serialize)]
struct ModesResult {
    schema: &'static str,
    design: DesignId,
    body: &'static str,
    dofs: usize,
    modes: Vec<Mode>,
    sturm: Sturm,
    checks: Vec<Check>,
}

#[derive(Serialize)]
struct Mode {
    hz: f64,
    residual: f64,
    rigid: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    common.start_threads()?;
    let design = common.load()?;
    let folder = common.out(&design);
    let mut progress = Progress::new();
    progress.stage("modes");
    let body = match arguments.body {
        BodyName::Workpiece => pipeline::workpiece(&design)?,
        BodyName::Worktable => pipeline::table(&design)?,
    };
    progress.stage("writing files");
    let file = output::write_modes(&folder, &body)?;
    drop(progress);
    let basis = &body.basis;
    let mode = |(index, &hz): (usize, &f64)| Mode {
        hz,
        residual: basis.residuals[index],
        rigid: basis.rigid[index],
    };
    let result = ModesResult {
        schema: "nailnoise-modes/1",
        design: DesignId {
            name: design.name().to_owned(),
            digest: design.digest(),
        },
        body: body.name,
        dofs: basis.dofs,
        modes: basis.hz.iter().enumerate().map(mode).collect(),
        sturm: basis.sturm,
        checks: body.checks(),
    };
    if common.json {
        print_json(&result)?;
    } else {
        print(&text(&result, &body));
        print(&format!("  mode shapes in {}\n", file.display()));
    }
    Ok(status_of(&result.checks))
}

fn text(result: &ModesResult, body: &Body) -> String {
    let rows: Vec<Vec<String>> = result
        .modes
        .iter()
        .enumerate()
        .map(|(index, mode)| {
            let kind = if mode.rigid { "rigid" } else { "" };
            vec![
                format!("{}", index + 1),
                format!("{:.2}", mode.hz),
                format!("{:.1e}", mode.residual),
                kind.to_owned(),
            ]
        })
        .collect();
    let mut text = format!("{}: modes of the {}\n\n", result.design.name, result.body);
    text.push_str(&table(&["mode", "Hz", "residual", ""], &rows));
    text.push_str(&format!(
        "\n  {} modes below {:.1} Hz by Sturm count, {} found; {} degrees of freedom, {} elements\n",
        result.sturm.count,
        result.sturm.upper_hz,
        result.modes.len(),
        result.dofs,
        body.mesh.element_count(),
    ));
    text
}
