//! `nailnoise sweep`: levels over a grid of values.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::table::{decibels, table};
use super::{Common, Keeping, print, print_json, progress};
use crate::error::Error;
use crate::figures::{self, Chart};
use crate::graph::Graph;
use crate::output;
use crate::result::DesignId;
use crate::stages::WithoutStages;
use crate::staging::Staging;
use crate::study::{Axis, SweptPoint, sweep};

/// The file that is written last, so that a folder that holds it holds all the rest.
const LAST: &str = "sweep.csv";

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// A key and its values: supply.pressure=80psig..110psig:7 (equal steps), wood.loss_factor=0.01..0.08:4:log (equal ratios) or
    /// support.worktable.preset=A,B,C; given again, the grid of all
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    vary: Vec<Axis>,
    /// Draw the levels over the first key as SVG
    #[arg(long)]
    figures: bool,
}

/// Layout of `sweep --json`.
#[derive(Serialize)]
struct Layout<'a> {
    schema: &'static str,
    design: DesignId,
    axes: &'a [Axis],
    points: &'a [SweptPoint],
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    common.start_threads()?;
    let design = common.load()?;
    let folder = common.out(&design)?.join("sweep");
    let progress = progress();
    progress.stage("levels over the grid");
    let store = arguments.keeping.cache()?;
    let graph = Graph::new(Arc::new(store), Arc::new(WithoutStages(progress.observer())));
    let points = sweep(&graph, (design.path(), &common.changes.set), &arguments.vary, &progress)?;
    let staging = Staging::within(&folder)?;
    if arguments.figures {
        let chart: Chart = figures::sweep(design.name(), &arguments.vary, &points);
        figures::write(&staging, "figures".as_ref(), &[chart])?;
    }
    staging.write(LAST.as_ref(), &csv(&arguments.vary, &points)?)?;
    staging.place(&[], LAST.as_ref())?;
    progress.end();
    if common.json {
        print_json(&Layout {
            schema: "nailnoise-sweep/1",
            design: DesignId {
                name: design.name().to_owned(),
                digest: design.digest(),
            },
            axes: &arguments.vary,
            points: &points,
        })?;
    } else {
        print(&text(design.name(), &arguments.vary, &points))?;
        print(&format!("\n  files in {}\n", folder.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Names of the sources, in the order of the levels.
fn sources(points: &[SweptPoint]) -> Vec<String> {
    let levels = points.iter().find_map(|point| point.levels.as_ref());
    levels.map_or_else(Vec::new, |levels| {
        levels.sources.iter().map(|source| source.source.clone()).collect()
    })
}

fn text(name: &str, axes: &[Axis], points: &[SweptPoint]) -> String {
    let sources = sources(points);
    let mut headings: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
    headings.extend(sources.iter().map(String::as_str));
    headings.extend(["total", "shot"]);
    let row = |point: &SweptPoint| {
        let mut cells = point.values.clone();
        match &point.levels {
            Some(levels) => {
                cells.extend(levels.sources.iter().map(|source| decibels(source.lwa_db)));
                cells.extend([decibels(point.total_db), levels.outcome.replace('_', " ")]);
            }
            None => {
                cells.extend(vec!["-".to_owned(); sources.len() + 1]);
                cells.push(format!("no design: {}", point.refused));
            }
        }
        cells
    };
    let rows: Vec<Vec<String>> = points.iter().map(row).collect();
    format!(
        "{name}: A-weighted single-event sound power levels, dB re 1 pW s, of the design itself; `nailnoise study` says how sure \
         they are\n\n{}",
        table(&headings, &rows)
    )
}

/// `sweep.csv`: a row for every point.
fn csv(axes: &[Axis], points: &[SweptPoint]) -> Result<Vec<u8>, Error> {
    let sources = sources(points);
    let header = axes.iter().map(|axis| axis.key.clone());
    let header = header.chain(sources.iter().map(|source| format!("L_WA,1s {source} [dB]")));
    let header = header.chain(["L_WA,1s total [dB]", "outcome", "refused"].map(str::to_owned));
    let decibels = |level: Option<f64>| level.map_or_else(String::new, |level| format!("{level:.4}"));
    let row = |point: &SweptPoint| {
        let levels = point.levels.as_ref();
        let own = |place: usize| decibels(levels.and_then(|levels| levels.sources[place].lwa_db));
        let outcome = levels.map_or_else(String::new, |levels| levels.outcome.clone());
        let cells = point.values.iter().cloned().chain((0..sources.len()).map(own));
        cells
            .chain([decibels(point.total_db), outcome, point.refused.clone()])
            .collect::<Vec<_>>()
    };
    output::table(header, points.iter().map(row))
}
