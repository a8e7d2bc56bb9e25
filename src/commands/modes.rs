//! `nailnoise modes`: the vibration modes of a body.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use nailnoise_fem::{Correlation, ModalWork, Pairing, Sturm, correlate};
use nailnoise_meshes::uff;
use serde::Serialize;

use super::Status;
use super::bodies::{BodyName, Own, length};
use super::table::table;
use super::{Common, Keeping, print, print_json, progress, status_of};
use crate::atomic_write::AtomicWrite;
use crate::chain::BodyStages;
use crate::cost;
use crate::design::inputs;
use crate::error::Error;
use crate::graph::Graph;
use crate::output;
use crate::result::{Check, DesignId};
use crate::stages::bodies::Body;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise modes my-tool.toml --body workpiece" => "all modes of the block below the top frequency",
    "nailnoise modes my-tool.toml --body tool --mac measured.uff" => "compared with the modes of a modal test",
    "nailnoise modes my-tool.toml --body worktable --animate 1" => "a film of the first mode for ParaView",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// Body whose modes are computed
    #[arg(long, value_enum)]
    body: BodyName,
    #[command(flatten)]
    own: Own,
    /// Also write the modes as a universal file (datasets 2411, 15, 2412, 55) for modal-test software
    #[arg(long)]
    uff: bool,
    /// Also write one period of this mode as a film for ParaView; may be repeated
    #[arg(long, value_name = "MODE", value_parser = clap::value_parser!(u32).range(1..))]
    animate: Vec<u32>,
    /// Universal file of measured modes, compared by the modal assurance criterion (MAC)
    #[arg(long, value_name = "FILE")]
    mac: Option<PathBuf>,
    /// Largest distance between a measured point and the node that represents it
    #[arg(long, value_name = "LENGTH", default_value = "10 mm", value_parser = length)]
    mac_reach: f64,
    /// Match measured point n with point n of a universal file of this body (--uff), not by position
    #[arg(long, requires = "mac", conflicts_with = "mac_reach")]
    by_number: bool,
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
    work: ModalWork,
    checks: Vec<Check>,
    #[serde(skip_serializing_if = "Option::is_none")]
    correlation: Option<Correlation>,
}

#[derive(Serialize)]
struct Mode {
    hz: f64,
    residual: f64,
    rigid: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let mut design = common.begin_with_any_tool()?;
    arguments.own.replace(&mut design, arguments.body.into())?;
    let folder = common.out(&design)?;
    // An unusable file is detected before time is spent on computing.
    let measurement = arguments.mac.as_deref().map(uff::read).transpose()?;
    let pairing = match arguments.by_number {
        true => Pairing::Number,
        false => Pairing::Position {
            reach: arguments.mac_reach,
        },
    };
    if let (Some(measurement), Some(path), Pairing::Position { .. }) = (&measurement, &arguments.mac, pairing)
        && measurement.nodes.is_empty()
    {
        return Err(Error::NoCoordinates { path: path.clone() });
    }
    let kind = arguments.body.into();
    cost::refuse(&design, &[cost::of_body(&design, kind)?], common.options.memory.limit())?;
    let progress = progress();
    progress.stage("modes");
    let cache = arguments.keeping.cache()?;
    let graph = Graph::new(Arc::new(cache), progress.observer());
    let stages = BodyStages::add(&graph, &design, kind, false)?;
    let body = stages.body.get().map_err(|error| inputs::located(&design, error))?;
    let modes = stages.modes.get()?;
    let shapes = body.shapes(&modes)?;
    let correlation = match (&measurement, &arguments.mac) {
        (Some(measurement), Some(path)) => {
            let found = correlate((&body.basis.hz, shapes), &body.surface, measurement, pairing);
            Some(found.ok_or_else(|| Error::NoPoint { path: path.clone() })?)
        }
        _ => None,
    };
    progress.stage("writing files");
    let staging = AtomicWrite::within(&folder)?;
    let list = output::write_modes(&staging, &body, shapes)?;
    let mut files = vec![list.clone()];
    for &mode in &arguments.animate {
        files.push(output::write_motion(&staging, &body, mode as usize - 1)?);
    }
    if arguments.uff {
        files.push(output::write_universal(
            &staging,
            design.name(),
            (&body, stages.loss_factor),
            shapes,
        )?);
    }
    staging.place(&[], &list)?;
    progress.end();
    let basis = &body.basis;
    let mode = |(index, &hz): (usize, &f64)| Mode {
        hz,
        residual: basis.residuals[index],
        rigid: basis.rigid[index],
    };
    let result = ModesResult {
        schema: "nailnoise-modes/1",
        design: DesignId::from(&design),
        body: body.name,
        dofs: basis.dofs,
        modes: basis.hz.iter().enumerate().map(mode).collect(),
        sturm: basis.sturm,
        work: basis.work,
        checks: body.checks(),
        correlation,
    };
    if common.options.json {
        print_json(&result)?;
    } else {
        common.shown.print(&text(&result, &body))?;
        for file in files {
            print(&format!("  written to {}\n", folder.join(file).display()))?;
        }
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
    if let Some(correlation) = &result.correlation {
        text.push_str(&compared(correlation));
    }
    text
}

/// Formats the comparison of measured with computed modes.
fn compared(correlation: &Correlation) -> String {
    let rows: Vec<Vec<String>> = correlation
        .pairs
        .iter()
        .enumerate()
        .map(|(index, pair)| {
            vec![
                format!("{}", index + 1),
                format!("{:.1}", pair.measured_hz),
                format!("{}", pair.mode),
                format!("{:.1}", pair.computed_hz),
                format!("{:+.1}", 100.0 * (pair.computed_hz / pair.measured_hz - 1.0)),
                format!("{:.3}", pair.mac),
            ]
        })
        .collect();
    let headings = ["measured", "Hz", "computed mode", "Hz", "%", "MAC"];
    let mut text = format!("\n{}", table(&headings, &rows));
    text.push_str(&format!(
        "\n  {} measured points matched by {}, {}; {} not on the body\n",
        correlation.matched,
        if correlation.by_position { "position" } else { "number" },
        correlation.farthest.map_or_else(
            || "distance unknown without coordinates".to_owned(),
            |farthest| format!("at most {:.1} mm off", farthest * 1e3)
        ),
        correlation.unmatched
    ));
    text
}
