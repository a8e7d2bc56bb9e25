//! `nailnoise sweep`: levels over a grid of values.

use std::collections::HashSet;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::run::delivered;
use super::{Common, Keeping, print, print_json, status_of, table};
use super::{Status, python::Cluster};
use crate::artifacts::Delivery;
use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::figures::{self, Chart};
use crate::graph::Graph;
use crate::headline;
use crate::output::{self, Exports};
use crate::report;
use crate::result::DesignId;
use crate::store::Store;
use crate::study::{Axis, Quantiles, Request, SweptPoint, at_point, sweep};
use crate::tables::performance::{CSV_HEADINGS, csv_cells};
use crate::tables::sweep::{self as tables, sources};
use crate::units::Units;

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "sweep.csv";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise sweep my-tool.toml --vary supply.pressure=80psig..110psig:7" => "levels over the pressure",
    "nailnoise sweep my-tool.toml --vary exhaust.holes=3,5,12 --vary ambient.temperature=0degC,20degC \
     --figures" => "a grid of two keys, as a chart, too",
    "nailnoise sweep my-tool.toml --vary exhaust.holes=3,5 --fields" => "films of both for ParaView in \
        out/my-tool/sweep/exhaust.holes=3/ and .../exhaust.holes=5/",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// A key and its values: supply.pressure=80psig..110psig:7 (equal steps), wood.loss_factor=0.01..0.08:4:log (equal
    /// ratios) or support.worktable.preset=A,B,C; given again, the grid of all
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    vary: Vec<Axis>,
    /// Draw N shots of all points in common, and state how sure levels and changes from the first point are
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=60_000))]
    draws: Option<u32>,
    /// Seed of --draws
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "draws")]
    seed: u64,
    /// Compute the points on a cluster of Dask, by the address of its scheduler (needs the Python package)
    #[arg(long, value_name = "ADDRESS", conflicts_with = "no_cache")]
    scheduler: Option<String>,
    /// Keep the points in this folder, which the workers of the cluster share
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    store: Option<PathBuf>,
    /// Draw the levels over the first key as SVG
    #[arg(long)]
    figures: bool,
    /// Also run each point and leave its report and result in a folder named after its values, which the page opens
    #[arg(long)]
    reports: bool,
    /// Also run each point and leave its films and sound fields for ParaView, report and result in a folder named after
    /// its values. Each takes as long as `nailnoise run --fields`
    #[arg(long)]
    fields: bool,
}

/// Layout of `sweep --json`.
#[derive(Serialize)]
struct Layout<'a> {
    schema: &'static str,
    design: DesignId,
    axes: &'a [Axis],
    points: &'a [SweptPoint],
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let design = common.begin_with_any_tool()?;
    let folder = common.out(&design)?.join("sweep");
    let progress = common.shown.progress();
    progress.stage("levels over the grid");
    let store = match &arguments.store {
        Some(folder) => Store::shared(folder)?,
        None => arguments.keeping.cache()?,
    };
    if let (Some(scheduler), Some(folder)) = (&arguments.scheduler, store.folder()) {
        let shared = arguments.store.is_some();
        let axes = arguments.vary.iter();
        let axes = axes.flat_map(|axis| ["--vary".to_owned(), format!("{}={}", axis.key, axis.values.join(","))]);
        let cluster = Cluster {
            scheduler,
            folder,
            shared,
        };
        cluster.fill("sweep-on", (common, &design), &axes.collect::<Vec<_>>())?;
    }
    let graph = Graph::quiet(&store, progress.observer());
    let base = (design.path(), &common.options.changes.set[..]);
    let request = arguments
        .draws
        .map(|draws| Request::new(draws as usize, arguments.seed));
    let limit = common.options.memory.limit();
    let mut points = sweep(&graph, base, &arguments.vary, request.as_ref(), limit, &progress)?;
    headline::explain_first(&graph, base, &arguments.vary, &mut points)?;
    let mut checks = Vec::new();
    if arguments.fields || arguments.reports {
        name_folders(&mut points, &arguments.vary);
        let exports = Exports {
            films: arguments.fields,
            units: common.shown.units,
            slow_motion: super::run::SLOW_MOTION,
            ..Exports::default()
        };
        for point in &points {
            let Some(name) = &point.folder else { continue };
            progress.note(&format!("run of {name}"));
            let design = at_point(base, &arguments.vary, &point.values)?;
            let (_, own) = delivered(&Delivery {
                design: &design,
                folder: &folder.join(name),
                exports,
                screening: false,
                printer: super::run::printed,
                store: graph.store(),
                memory: limit,
                progress: &progress,
            })?;
            checks.extend(own);
        }
    }
    let staging = AtomicWrite::within(&folder)?;
    let units = common.shown.units;
    let chart: Chart = figures::sweep(design.name(), &arguments.vary, &points).in_units(units);
    let page = report::swept(design.name(), &arguments.vary, &points, &chart, units);
    staging.write("sweep.html".as_ref(), page.as_bytes())?;
    if arguments.figures {
        figures::write(&staging, "figures".as_ref(), &[chart])?;
    }
    staging.write(LAST.as_ref(), &csv(&arguments.vary, &points)?)?;
    staging.place(&[], LAST.as_ref())?;
    progress.end();
    if common.options.json {
        print_json(&Layout {
            schema: "nailnoise-sweep/1",
            design: DesignId::from(&design),
            axes: &arguments.vary,
            points: &points,
        })?;
    } else {
        common.shown.print(&super::alarm(&headline::alarms(&points)))?;
        common
            .shown
            .print(&text(design.name(), &arguments.vary, &points, units))?;
        print(&format!("\n  {}\n", folder.join("sweep.html").display()))?;
    }
    Ok(status_of(&checks))
}

/// Names a folder after its values for each point that has levels.
fn name_folders(points: &mut [SweptPoint], axes: &[Axis]) {
    let safe = |c: char| {
        if c.is_alphanumeric() || "=.,+-_".contains(c) {
            c
        } else {
            '_'
        }
    };
    let mut taken = HashSet::new();
    for point in points.iter_mut().filter(|point| point.levels.is_some()) {
        let values = axes.iter().zip(&point.values);
        let values: Vec<String> = values.map(|(axis, value)| format!("{}={value}", axis.key)).collect();
        // Most file systems allow 255 bytes.
        let name: String = values.join(",").replace(' ', "").chars().map(safe).take(80).collect();
        let names = std::iter::once(name.clone()).chain((2..).map(|number| format!("{name}-{number}")));
        point.folder = names.into_iter().find(|name| taken.insert(name.clone()));
    }
}

fn text(name: &str, axes: &[Axis], points: &[SweptPoint], units: Units) -> String {
    let levels = table::text(&tables::points(axes, points).in_units(units));
    let drawn = tables::over_draws(axes, points).map_or_else(String::new, |drawn| {
        format!(
            "\n  90 % of common draws that count at all points, structures as in the design, dB; changes from the \
             first \
             point\n\n{}",
            table::text(&drawn)
        )
    });
    format!(
        "{name}: A-weighted single-event sound power levels, dB re 1 pW s, of the design itself; `nailnoise study` \
         says how sure they are; head below the surface, energy left as the nail is flush, air of a \
         shot\n\n{levels}{drawn}"
    )
}

/// `sweep.csv`: one row per point.
fn csv(axes: &[Axis], points: &[SweptPoint]) -> Result<Vec<u8>, Error> {
    let sources = sources(points);
    let header = axes.iter().map(|axis| axis.key.clone());
    let header = header.chain(sources.iter().map(|source| format!("L_WA,1s {source} [dB]")));
    let header = header.chain(["L_WA,1s total [dB]", "outcome", "refused"].map(str::to_owned));
    let with_films = points.iter().any(|point| point.folder.is_some());
    let header = header.chain(with_films.then(|| "folder".to_owned()));
    let drawn = points.iter().find_map(|point| point.drawn.as_ref());
    let quantiles = |own: &Quantiles| [own.p05, own.p50, own.p95].map(|own| own.value);
    let header = header.chain(drawn.into_iter().flatten().flat_map(|change| {
        let of = |what: &str| ["P5", "P50", "P95"].map(|p| format!("{what} {} {p} [dB]", change.source));
        [of("L_WA,1s"), of("change of")].concat()
    }));
    let header = header.chain(CSV_HEADINGS.map(str::to_owned));
    let widths = drawn.map_or(0, |drawn| 6 * drawn.len());
    let decibels = |level: Option<f64>| level.map_or_else(String::new, |level| format!("{level:.4}"));
    let row = |point: &SweptPoint| {
        let levels = point.levels.as_ref();
        let own = |place: usize| decibels(levels.and_then(|levels| levels.sources[place].lwa_db));
        let outcome = levels.map_or_else(String::new, |levels| levels.outcome.clone());
        let cells = point.values.iter().cloned().chain((0..sources.len()).map(own));
        cells
            .chain([decibels(point.total_db), outcome, point.refused.clone()])
            .chain(with_films.then(|| point.folder.clone().unwrap_or_default()))
            .chain(match &point.drawn {
                None => vec![String::new(); widths],
                Some(drawn) => drawn
                    .iter()
                    .flat_map(|change| [quantiles(&change.level_db), quantiles(&change.change_db)].concat())
                    .map(decibels)
                    .collect(),
            })
            .chain(csv_cells(point.performance.as_ref()))
            .collect::<Vec<_>>()
    };
    output::table(header, points.iter().map(row))
}
