//! `nailnoise compare --measured`: compares predictions with measurements.

use std::path::Path;

use nailnoise_pipeline::PipelineError;

use super::{Status, compare::Arguments};
use super::{print, print_json, table};
use crate::atomic_write;
use crate::comparison::ComparisonError;
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::report;
use crate::study::{Draws, Request, common_draws, nominal};
use crate::tables::measured::quantities;
use crate::virtual_test::comparison::{MeasuredComparison, Measurements, Predicted, compare, predict};
use crate::virtual_test::{VirtualTest, wrapping};
use crate::wording::drawn_structures;

/// Number of draws if `--draws` gives none.
const DRAWS: u32 = 64;

pub(super) fn execute(arguments: &Arguments, file: &Path) -> Result<Status, Error> {
    arguments.threads.start()?;
    let progress = arguments.shown.progress();
    let cache = arguments.keeping.cache()?;
    let measured = Measurements::read(file)?;
    let designs = arguments
        .designs
        .iter()
        .map(|path| arguments.changes.load(path))
        .collect::<Result<Vec<Design>, _>>()?;
    for design in &designs {
        let predicted = [design.analysis.range_low, design.analysis.range_high];
        if let Some(range) = measured.range_hz.filter(|range| *range != predicted) {
            return Err(ComparisonError::MeasuredRange {
                path: file.to_owned(),
                measured: range,
                design: design.name().to_owned(),
                predicted,
            }
            .into());
        }
        cost::refuse(design, &cost::of_run(design)?, arguments.memory.limit())?;
    }
    let graph = Graph::quiet(&cache, progress.observer());
    let request = Request {
        shots_a_structure: arguments.structures.map(usize::from),
        workpiece_sensors: true,
        ..Request::new(arguments.draws.unwrap_or(DRAWS) as usize, arguments.seed)
    };
    let mut predicted = Vec::new();
    // The designs' own shots come first, so that the draws find modes and radiation in the cache.
    let mut shots = Vec::new();
    for design in &designs {
        progress.stage(&format!("shot of {}", design.name()));
        let test = VirtualTest::new(&graph, design, wrapping(design), arguments.seed)?;
        let shot = test.own()?;
        shots.push((test, shot));
    }
    let references: Vec<&Design> = designs.iter().collect();
    let drawn = common_draws(&graph, &references, &request, &progress)?;
    for ((design, (test, shot)), drawn) in designs.iter().zip(&shots).zip(&drawn) {
        predicted.push(prediction(&graph, design, (test, shot), (&request, drawn))?);
    }
    let comparison = compare(&measured, &predicted);
    let page = arguments.out.join(format!("measured-{}.html", designs[0].name()));
    atomic_write::write(&page, report::measured(&comparison, arguments.shown.units).as_bytes())?;
    progress.end();
    if arguments.json {
        print_json(&comparison)?;
    } else {
        arguments.shown.print(&text(&comparison))?;
        print(&format!("\n  as a page: {}\n", page.display()))?;
    }
    Ok(Status::SUCCESS)
}

fn prediction(
    graph: &Graph,
    design: &Design,
    (test, shot): (&VirtualTest<'_>, &crate::virtual_test::BareShot),
    (request, drawn): (&Request, &Draws),
) -> Result<Predicted, Error> {
    let levels = nominal(graph, design, request)?.ok_or(PipelineError::Upstream { stage: "levels" })?;
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
    text.push_str(&table::text(&quantities(comparison)));
    for open in &comparison.open {
        text.push_str(&format!("  - not compared: {open}\n"));
    }
    text
}
