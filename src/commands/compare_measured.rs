//! `nailnoise compare --measured`: predictions beside measurements, like with like.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use super::table::table;
use super::{Changes, Memory, print, print_json};
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::measurement::comparison::{ComparedQuantity, MeasuredComparison, Measurements, Predicted, compare, predict};
use crate::measurement::error::MeasurementError;
use crate::measurement::virtual_test::{VirtualTest, wrapping};
use crate::report;
use crate::stages::{Progress, WithoutStages};
use crate::staging;
use crate::store::Store;
use crate::study::{self, Draws, Part, common_draws, nominal};
use crate::wording::drawn_structures;

/// Draws where `--draws` gives no number.
const DRAWS: u32 = 64;

/// What of the arguments of `compare` takes part.
pub(super) struct Request<'a> {
    /// File of measurements.
    pub(super) file: &'a Path,
    /// Design files.
    pub(super) designs: &'a [PathBuf],
    /// Values over those of the files.
    pub(super) changes: &'a Changes,
    /// Number of draws.
    pub(super) draws: Option<u32>,
    /// Their seed.
    pub(super) seed: u64,
    /// Draws on each structure that is drawn; structures are held without it.
    pub(super) structures: Option<u16>,
    /// Folder of the page.
    pub(super) out: &'a Path,
    /// Whether one JSON value is printed.
    pub(super) json: bool,
    /// Memory of a stage.
    pub(super) memory: &'a Memory,
}

pub(super) fn execute(arguments: &Request<'_>, cache: &Store, progress: &Progress) -> Result<ExitCode, Error> {
    let measured = Measurements::read(arguments.file)?;
    let designs = arguments
        .designs
        .iter()
        .map(|path| arguments.changes.load(path))
        .collect::<Result<Vec<Design>, _>>()?;
    for design in &designs {
        let predicted = [design.analysis.range_low, design.analysis.range_high];
        if let Some(range) = measured.range_hz.filter(|range| *range != predicted) {
            return Err(MeasurementError::Range {
                path: arguments.file.to_owned(),
                measured: range,
                design: design.name().to_owned(),
                predicted,
            }
            .into());
        }
        cost::refuse(design, &cost::of_run(design)?, arguments.memory.limit())?;
    }
    let graph = Graph::new(Arc::new(cache.clone()), Arc::new(WithoutStages(progress.observer())));
    let request = study::Request {
        draws: arguments.draws.unwrap_or(DRAWS) as usize,
        seed: arguments.seed,
        shots_a_structure: arguments.structures.map(usize::from),
        part: Part::All,
        workpiece_sensors: true,
    };
    let mut predicted = Vec::new();
    // The designs' own shots first: the draws then find modes and radiation.
    let mut shots = Vec::new();
    for design in &designs {
        progress.stage(&format!("shot of {}", design.name()));
        let test = VirtualTest::new(&graph, design, wrapping(design), arguments.seed)?;
        let shot = test.own()?;
        shots.push((test, shot));
    }
    let references: Vec<&Design> = designs.iter().collect();
    let drawn = common_draws(&graph, &references, &request, progress)?;
    for ((design, (test, shot)), drawn) in designs.iter().zip(&shots).zip(&drawn) {
        predicted.push(prediction(&graph, design, (test, shot), (&request, drawn))?);
    }
    let comparison = compare(&measured, &predicted);
    let page = arguments.out.join(format!("measured-{}.html", designs[0].name()));
    staging::write(&page, report::measured(&comparison).as_bytes())?;
    progress.end();
    if arguments.json {
        print_json(&comparison)?;
    } else {
        print(&text(&comparison))?;
        print(&format!("\n  as a page: {}\n", page.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn prediction(
    graph: &Graph,
    design: &Design,
    (test, shot): (&VirtualTest<'_>, &crate::measurement::virtual_test::BareShot),
    (request, drawn): (&study::Request, &Draws),
) -> Result<Predicted, Error> {
    let levels = nominal(graph, design, request)?.ok_or(Error::Upstream { stage: "levels" })?;
    predict(test, design, shot, (&levels, drawn), request.seed)
}

fn text(comparison: &MeasuredComparison) -> String {
    let mut text = format!("measured: {}\n  {}\n", comparison.tool, comparison.source);
    for own in &comparison.designs {
        text.push_str(&format!(
            "predicted: {}, {} draws of its ranges and wraps, {}\n",
            own.name,
            own.draws,
            drawn_structures(own.structures)
        ));
    }
    text.push('\n');
    let rows: Vec<Vec<String>> = comparison.rows.iter().map(row).collect();
    text.push_str(&table(
        &[
            "quantity",
            "design",
            "unit",
            "measured",
            "predicted",
            "5 .. 95 %",
            "distance",
        ],
        &rows,
    ));
    text.push_str(
        "\n  distance: between the intervals, 0 where they overlap, positive where the prediction is higher\n",
    );
    for open in &comparison.open {
        text.push_str(&format!("  - not compared: {open}\n"));
    }
    text
}

fn row(own: &ComparedQuantity) -> Vec<String> {
    let measured = match own.measured {
        [None, Some(high)] => format!("<= {high:.2}"),
        [Some(low), None] => format!(">= {low:.2}"),
        [Some(low), Some(high)] => format!("{low:.2} .. {high:.2}"),
        [None, None] => "-".to_owned(),
    };
    vec![
        own.quantity.clone(),
        own.design.clone(),
        own.unit.clone(),
        measured,
        format!("{:.2}", own.predicted),
        own.interval
            .map_or_else(|| "-".to_owned(), |[low, high]| format!("{low:.2} .. {high:.2}")),
        format!("{:+.2}", own.distance),
    ]
}
