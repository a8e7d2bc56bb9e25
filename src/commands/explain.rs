//! `nailnoise check DESIGN`: whether a design can run and drives its nail, missing parts, implausible values, the
//! effect of each input, the first inputs to measure, and the cost of a run.

use std::collections::BTreeMap;

use nailnoise_fem::ModalCost;
use serde::Serialize;

use super::effects::{Effect, Effects, ToMeasure};
use super::next_lines::next_lines;
use super::table::{table, words};
use super::{Shown, Status, bodies::modal_cost};
use super::{outside_table, print_json, progress, red};
use crate::calibration::{NextRow, next_of_study};
use crate::chain;
use crate::cost::{self, MemoryLimit, StageCost};
use crate::design::inputs::bodies as inputs;
use crate::design::inputs::cycle::parameters;
use crate::design::inputs::radiation::workpiece;
use crate::design::{Design, Entry, OutsideValue, Provenance};
use crate::error::Error;
use crate::graph::Graph;
use crate::headline::{Headline, headline, sentence};
use crate::result::pressures;
use crate::stages::bodies::{BodyKind, MeshSource};
use crate::stages::radiation::{WorkpieceRadiation, describe_gap};
use crate::store::Store;
use crate::study::{in_force, variables};
use crate::units::Units;

/// Number of inputs in the table of effects.
const LISTED: usize = 12;

/// Number of quantities in the table of measurements.
const MEASURED: usize = 8;

/// Largest number of degrees of freedom of the bodies that are meshed and checked here \[-\]: a million take 7 s and
/// 1.6 GB.
const MESHED: f64 = 1e6;

/// Ratio of gmsh's time per degree of freedom to that of the built-in meshers.
const GMSH: f64 = 8.0;

/// Layout of `check DESIGN --json`.
#[derive(Serialize)]
struct Explanation {
    schema: &'static str,
    design: String,
    digest: String,
    /// Number of values with each provenance.
    provenance: BTreeMap<&'static str, usize>,
    /// Whether a run is possible, that is, there are no obstacles.
    runs: bool,
    /// How the shot ends, if the nail is not driven or the exhaust does not open; null otherwise.
    headline: Option<Headline>,
    /// Supply pressure in words; without a place in JSON, which has its value among the inputs of a run.
    #[serde(skip)]
    supply: String,
    /// The shot; null if it cannot be computed.
    shot: Option<ShotSummary>,
    /// Values outside the ranges for such tools or for the design.
    outside: Vec<OutsideValue>,
    /// Effect of each input, in descending order.
    effects: Effects,
    /// Inputs to measure, in descending order of effect.
    measure_first: Vec<ToMeasure>,
    /// Quantities to measure next, by the draws of the design's study. Those that narrow the interval most for an hour
    /// of work are first. Empty without a study.
    measure_next: Vec<NextRow>,
    /// Estimates with their ranges, widest first, excluding those not used by this design.
    estimates: Vec<Estimate>,
    /// Estimates, and values without a source, that have no range: their uncertainty is unknown. Those not used by this
    /// design are excluded.
    unknowns: Vec<String>,
    bodies: Vec<BodyPlan>,
    /// Estimated cost of each stage without a stored result, based on the design only.
    stages: Vec<StageCost>,
    /// The thin gap below the workpiece, and the error of its panels; null without a gap.
    gap: Option<String>,
    /// Obstacles to a run, and their remedies.
    obstacles: Vec<String>,
}

#[derive(Serialize)]
struct Estimate {
    key: String,
    value: f64,
    unit: String,
    range: [f64; 2],
    /// Width of the range relative to the value, if the value is not zero.
    relative: Option<f64>,
    source: String,
}

/// Outcome of the shot; the cycle is fast enough to be computed here.
#[derive(Serialize)]
struct ShotSummary {
    outcome: nailnoise_dynamics::Outcome,
    /// Description in a sentence.
    text: String,
    mean_drive_speed: Option<f64>,
    penetration: f64,
    exhaust_mass: f64,
}

#[derive(Serialize)]
struct BodyPlan {
    body: &'static str,
    /// Origin of its mesh.
    mesh: String,
    /// Whether gmsh is needed for it.
    gmsh: bool,
    cost: Option<ModalCost>,
    /// Whether it was meshed and checked; large bodies are left to the run.
    checked: bool,
}

/// Options of the command.
pub(super) struct Asked {
    /// Memory limit of a stage.
    pub(super) memory: MemoryLimit,
    /// Whether to print JSON.
    pub(super) json: bool,
    /// Whether to compute the effects of all inputs on the total.
    pub(super) effects: bool,
    /// Units of the text.
    pub(super) shown: Shown,
}

pub(super) fn execute(design: &Design, asked: &Asked) -> Result<Status, Error> {
    let stages = cost::of_run(design)?;
    cost::refuse(design, &stages, asked.memory)?;
    let explanation = explain(design, stages, asked)?;
    // Meshing refines the estimated costs of the modes.
    cost::refuse(design, &explanation.stages, asked.memory)?;
    if asked.json {
        print_json(&explanation)?;
    } else {
        asked.shown.print(&text(&explanation, asked.shown.units))?;
    }
    Ok(Status::from(if explanation.runs { 0 } else { 2 }))
}

fn explain(design: &Design, mut stages: Vec<StageCost>, asked: &Asked) -> Result<Explanation, Error> {
    let entries = design.entries();
    let mut provenance = BTreeMap::new();
    for entry in &entries {
        *provenance.entry(entry.provenance.as_str()).or_insert(0) += 1;
    }
    let own = parameters(design)?;
    let record = chain::cycle(design);
    let kinds = chain::solved_bodies(design);
    let (mut bodies, mut obstacles) = (Vec::new(), Vec::new());
    let weight = |kind: &BodyKind| {
        let own = stages.iter().find(|stage| stage.stage == kind.modes());
        let source = inputs::geometry(design, *kind, false).map(|geometry| geometry.mesh);
        let gmsh = source.is_ok_and(|source| source.needs_gmsh());
        own.and_then(StageCost::dofs).unwrap_or(0.0) * if gmsh { GMSH } else { 1.0 }
    };
    let mut checks = match kinds.iter().map(weight).sum::<f64>() <= MESHED {
        true => chain::check_bodies(design, &kinds),
        false => Vec::new(),
    }
    .into_iter();
    for &kind in &kinds {
        let source = inputs::geometry(design, kind, false).map(|geometry| geometry.mesh);
        let gmsh = source.as_ref().is_ok_and(MeshSource::needs_gmsh);
        let checked = checks.next();
        let mut plan = BodyPlan {
            body: kind.name(),
            mesh: source
                .as_ref()
                .map_or_else(|_| "none".to_owned(), |source| origin(source, gmsh)),
            gmsh,
            cost: None,
            checked: checked.is_some(),
        };
        let problems = match checked {
            None => Vec::new(),
            Some(Ok(checked)) => {
                let cost = modal_cost(&checked.meshed, inputs::below_hz(design, kind))?;
                // The mesh exists by now.
                if let Some(stage) = stages.iter_mut().find(|stage| stage.stage == kind.modes()) {
                    stage.refine(&cost);
                }
                plan.cost = Some(cost);
                checked.problems
            }
            Some(Err(error)) => {
                plan.mesh = "none".to_owned();
                vec![error]
            }
        };
        obstacles.extend(
            problems
                .iter()
                .map(|error| format!("{}: {}", kind.name(), error.in_words())),
        );
        bodies.push(plan);
    }
    let record = match record {
        Ok(record) => Some(record),
        // A dry fire is treated likewise: it is an obstacle like others and is reported together with the rest.
        Err(error @ Error::Cycle(_)) => {
            obstacles.push(format!("nailing cycle: {}", error.in_words()));
            None
        }
        Err(error) => return Err(error),
    };
    let progress = progress();
    let graph = Graph::quiet(&Store::of_user()?, progress.observer());
    let runs = obstacles.is_empty();
    let effects = Effects::of(&graph, design, asked.effects && runs, &progress)?;
    let headline = match &record {
        Some(record) => headline(&graph, design, record.into())?,
        None => None,
    };
    progress.end();
    Ok(Explanation {
        schema: "nailnoise-check-design/1",
        runs,
        headline,
        supply: pressures(design.supply.pressure, design.ambient.pressure),
        outside: design.outside_values(),
        measure_first: effects.to_measure(design),
        measure_next: next_of_study(graph.store(), design)?,
        effects,
        design: design.name().to_owned(),
        digest: design.digest(),
        provenance,
        estimates: estimates(design, &entries)?,
        unknowns: unknowns(design, &entries)?,
        shot: record.map(|record| ShotSummary {
            outcome: record.figures.outcome,
            text: sentence((&record).into(), &own),
            mean_drive_speed: record.figures.summary.mean_drive_speed,
            penetration: record.figures.summary.penetration,
            exhaust_mass: record.figures.summary.exhaust_mass,
        }),
        bodies,
        stages,
        gap: gap(design)?,
        obstacles,
    })
}

/// Error of the panels below a workpiece near the floor, if boundary elements are used. For a user's mesh it is only
/// known after reading.
fn gap(design: &Design) -> Result<Option<String>, Error> {
    if !design.workpiece.mesh.is_empty() {
        return Ok(None);
    }
    match workpiece(design)? {
        WorkpieceRadiation::BoundaryElements(elements) => Ok(elements.gap()?.map(|gap| describe_gap(&gap))),
        _ => Ok(None),
    }
}

fn origin(source: &MeshSource, gmsh: bool) -> String {
    match source {
        MeshSource::Block { .. } | MeshSource::Worktable(..) => "built in".to_owned(),
        MeshSource::Tool(..) if gmsh => "parametric, dimensions differ from the shipped mesh: by gmsh".to_owned(),
        MeshSource::Tool(..) => "parametric, shipped mesh".to_owned(),
        MeshSource::File(file) if gmsh => format!("{}, by gmsh", file.path().display()),
        MeshSource::File(file) => file.path().display().to_string(),
    }
}

fn estimates(design: &Design, entries: &[Entry]) -> Result<Vec<Estimate>, Error> {
    let used = variables(design)?;
    let mut estimates: Vec<Estimate> = entries
        .iter()
        .filter(|entry| matches!(entry.provenance, Provenance::Estimated | Provenance::Scaled))
        .filter(|entry| used.iter().any(|own| own.name == entry.key))
        .filter_map(|entry| {
            let (value, range) = (serde_json::to_value(&entry.value).ok()?.as_f64()?, entry.range?);
            Some(Estimate {
                key: entry.key.clone(),
                value,
                unit: entry.unit.clone(),
                range,
                relative: (value != 0.0).then(|| (range[1] - range[0]) / value.abs()),
                source: entry.source.clone(),
            })
        })
        .collect();
    let width = |estimate: &Estimate| estimate.relative.unwrap_or(f64::INFINITY);
    estimates.sort_by(|a, b| width(b).total_cmp(&width(a)));
    Ok(estimates)
}

fn unknowns(design: &Design, entries: &[Entry]) -> Result<Vec<String>, Error> {
    let open = |entry: &&Entry| {
        let unsure = match entry.provenance {
            Provenance::Estimated | Provenance::Scaled => true,
            Provenance::Design => entry.source.is_empty(),
            _ => false,
        };
        let number = serde_json::to_value(&entry.value).is_ok_and(|value| value.is_number());
        // Positions and records of surfaces and analysis settings are choices instead of uncertain quantities.
        let place = ["surfaces.", "recorded_surfaces.", "analysis."]
            .iter()
            .any(|group| entry.key.starts_with(group));
        unsure && number && !place && entry.range.is_none()
    };
    let open: Vec<String> = entries.iter().filter(open).map(|entry| entry.key.clone()).collect();
    let used = in_force(design, &open)?;
    Ok(open
        .into_iter()
        .zip(used)
        .filter_map(|(key, used)| used.then_some(key))
        .collect())
}

fn text(e: &Explanation, units: Units) -> String {
    [
        can_it_run(e),
        does_it_drive(e),
        missing(e),
        outside(e, units),
        effects(e, units),
        to_measure(e, units),
        next(e),
        costs(e),
    ]
    .concat()
}

fn can_it_run(e: &Explanation) -> String {
    let mut text = format!("{}\n\n", e.design);
    if e.runs {
        text.push_str("can it run: yes\n\n");
    } else {
        text.push_str(&format!("{}\n", red("can it run: no")));
        for obstacle in &e.obstacles {
            text.push_str(&format!("  obstacle: {obstacle}\n"));
        }
        text.push('\n');
    }
    let rows: Vec<Vec<String>> = e
        .bodies
        .iter()
        .map(|body| {
            vec![
                body.body.to_owned(),
                body.mesh.clone(),
                if body.gmsh { "needed" } else { "no" }.to_owned(),
                if body.checked { "yes" } else { "no" }.to_owned(),
            ]
        })
        .collect();
    text.push_str(&table(&["body", "mesh", "gmsh", "checked"], &rows));
    if e.bodies.iter().any(|body| !body.checked) {
        text.push_str("  not meshed here, because that would take long; `check --body NAME` meshes one\n");
    }
    if let Some(gap) = &e.gap {
        text.push_str(&format!("  workpiece: {gap}\n"));
    }
    text
}

fn does_it_drive(e: &Explanation) -> String {
    let Some(shot) = &e.shot else {
        return format!("\n{}\n", red("does it drive: no, its shot cannot be computed"));
    };
    let speed = shot.mean_drive_speed;
    let speed = speed.map_or_else(String::new, |speed| format!("mean drive speed {speed:.1} m/s, "));
    let figures = format!(
        "  {speed}{:.2} g of air through the exhaust, supply {}\n",
        1e3 * shot.exhaust_mass,
        e.supply
    );
    match &e.headline {
        None => format!("\ndoes it drive: yes, {}\n{figures}", shot.text),
        Some(headline) => {
            let advice = headline
                .advice()
                .map_or_else(String::new, |advice| format!("  {advice}\n"));
            format!(
                "\n{}\n{figures}{advice}",
                red(&format!("does it drive: no, {}", headline.text))
            )
        }
    }
}

fn missing(e: &Explanation) -> String {
    let standing: Vec<String> = e
        .provenance
        .iter()
        .map(|(word, count)| format!("{count} {word}"))
        .collect();
    let mut text = String::from("\nwhat is missing: ");
    match e.unknowns.as_slice() {
        [] => text.push_str("nothing; every uncertain value that is used has a range\n"),
        unknowns => text.push_str(&format!(
            "a range of {} uncertain values, without which no study draws them:\n  {}\n",
            unknowns.len(),
            unknowns.join(", ")
        )),
    }
    text.push_str(&format!("  values: {}\n", standing.join(", ")));
    text
}

fn outside(e: &Explanation, units: Units) -> String {
    match e.outside.as_slice() {
        [] => "\nvalues outside plausible ranges: none\n".to_owned(),
        values => format!(
            "\nvalues outside plausible ranges: {}\n\n{}",
            values.len(),
            outside_table(values, units)
        ),
    }
}

fn effects(e: &Explanation, units: Units) -> String {
    let own = &e.effects;
    let row = |input: &Effect| {
        vec![
            input.key.clone(),
            format!("{:.1}", input.effect),
            input.value.clone(),
            input.range.clone(),
        ]
    };
    let notable: Vec<&Effect> = own.inputs.iter().filter(|input| input.effect >= 0.05).collect();
    let rows: Vec<Vec<String>> = notable.iter().take(LISTED).map(|input| row(input)).collect();
    let mut text = format!("\ninputs by their effect: {}\n\n", own.basis);
    let unit = own.unit;
    text.push_str(&words(
        &["input", &format!("effect {unit}"), "value", "range"],
        &rows,
        units,
    ));
    match notable.len().saturating_sub(LISTED) {
        0 => {}
        more => text.push_str(&format!("  and {more} more; --json lists all\n")),
    }
    text
}

fn to_measure(e: &Explanation, units: Units) -> String {
    let unit = e.effects.unit;
    let row = |own: &ToMeasure| {
        let measurement = &own.measurement;
        vec![
            own.key.clone(),
            format!("{:.1}", own.effect),
            measurement.minutes.to_string(),
            measurement.instrument.to_owned(),
            measurement.accuracy.to_owned(),
            measurement.how.to_owned(),
        ]
    };
    let listed = e.measure_first.iter().filter(|own| own.effect >= 0.05).take(MEASURED);
    let rows: Vec<Vec<String>> = listed.map(row).collect();
    if rows.is_empty() {
        return "\nwhat to measure first: nothing that simple means would improve\n".to_owned();
    }
    let headings = [
        "key",
        &format!("effect {unit}"),
        "minutes",
        "instrument",
        "accuracy",
        "how",
    ];
    format!("\nwhat to measure first\n\n{}", words(&headings, &rows, units))
}

fn next(e: &Explanation) -> String {
    match next_lines(&e.measure_next) {
        lines if lines.is_empty() => lines,
        lines => format!("\n{lines}"),
    }
}

fn costs(e: &Explanation) -> String {
    let rows: Vec<Vec<String>> = e
        .stages
        .iter()
        .map(|stage| {
            vec![
                stage.stage.to_owned(),
                stage.counted(),
                format!("{:.2}", stage.gigabytes),
                format!("{:.0}", stage.cpu_seconds),
            ]
        })
        .collect();
    format!(
        "\ncost of each stage that is not in the cache, estimated within a factor of about two\n\n{}",
        table(&["stage", "counts", "GB", "CPU s"], &rows)
    )
}
