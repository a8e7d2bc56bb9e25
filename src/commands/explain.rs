//! `nailnoise check DESIGN`: what a design rests on and what it will cost, before it is run.

use std::collections::BTreeMap;
use std::process::ExitCode;

use nailnoise_fem::ModalCost;
use serde::Serialize;

use super::check::modal_cost;
use super::table::table;
use super::{print, print_json};
use crate::chain;
use crate::cost::{self, MemoryLimit, StageCost};
use crate::design::inputs::bodies as inputs;
use crate::design::inputs::radiation::workpiece;
use crate::design::{Design, Entry, Provenance};
use crate::error::Error;
use crate::stages::bodies::{BodyKind, MeshSource};
use crate::stages::radiation::{WorkpieceRadiation, describe_gap};
use crate::wording::rounded;

/// Estimates in the table.
const LISTED: usize = 20;

/// Degrees of freedom up to which the bodies are meshed and checked here \[-\]: a million take 7 s and 1.6 GB.
const MESHED: f64 = 1e6;

/// How much longer gmsh takes for a degree of freedom than the built-in meshers.
const GMSH: f64 = 8.0;

/// Layout of `check DESIGN --json`.
#[derive(Serialize)]
struct Explanation {
    schema: &'static str,
    design: String,
    digest: String,
    /// Number of values of each provenance.
    provenance: BTreeMap<&'static str, usize>,
    /// Estimates with their ranges, widest first.
    estimates: Vec<Estimate>,
    /// Estimates, and values without a source, that have no range: their uncertainty is unknown.
    unknowns: Vec<String>,
    shot: Shot,
    bodies: Vec<BodyPlan>,
    /// Estimated cost of each stage that is not kept, from the design alone.
    stages: Vec<StageCost>,
    /// The thin gap below the workpiece, and the error of its panels; null where there is none.
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
    /// Width of the range over the value, where the value is not zero.
    relative: Option<f64>,
    source: String,
}

/// Outcome of the shot: the cycle is fast enough to be computed here.
#[derive(Serialize)]
struct Shot {
    outcome: nailnoise_dynamics::Outcome,
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
    /// Whether it was meshed and checked; a large body is left to the run.
    checked: bool,
}

pub(super) fn execute(design: &Design, memory: MemoryLimit, json: bool) -> Result<ExitCode, Error> {
    let stages = cost::of_run(design)?;
    cost::refuse(design, &stages, memory)?;
    let explanation = explain(design, stages)?;
    // Meshes change the costs of their modes.
    cost::refuse(design, &explanation.stages, memory)?;
    if json {
        print_json(&explanation)?;
    } else {
        print(&text(&explanation))?;
    }
    Ok(ExitCode::from(if explanation.obstacles.is_empty() { 0 } else { 2 }))
}

fn explain(design: &Design, mut stages: Vec<StageCost>) -> Result<Explanation, Error> {
    let entries = design.entries();
    let mut provenance = BTreeMap::new();
    for entry in &entries {
        *provenance.entry(entry.provenance.as_str()).or_insert(0) += 1;
    }
    let record = chain::cycle(design)?;
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
                // The mesh is there by now.
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
    Ok(Explanation {
        schema: "nailnoise-check-design/1",
        design: design.name().to_owned(),
        digest: design.digest(),
        provenance,
        estimates: estimates(&entries),
        unknowns: unknowns(&entries),
        shot: Shot {
            outcome: record.outcome,
            mean_drive_speed: record.summary.mean_drive_speed,
            penetration: record.summary.penetration,
            exhaust_mass: record.summary.exhaust_mass,
        },
        bodies,
        stages,
        gap: gap(design)?,
        obstacles,
    })
}

/// Error of the panels below a workpiece near the floor, where its radiation is by boundary elements. That of a user's mesh
/// is known when it is read.
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

fn estimates(entries: &[Entry]) -> Vec<Estimate> {
    let mut estimates: Vec<Estimate> = entries
        .iter()
        .filter(|entry| matches!(entry.provenance, Provenance::Estimated | Provenance::Scaled))
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
    estimates
}

fn unknowns(entries: &[Entry]) -> Vec<String> {
    let open = |entry: &&Entry| {
        let unsure = match entry.provenance {
            Provenance::Estimated | Provenance::Scaled => true,
            Provenance::Design => entry.source.is_empty(),
            _ => false,
        };
        let number = serde_json::to_value(&entry.value).is_ok_and(|value| value.is_number());
        // The place of a surface names it and is no uncertain quantity.
        let place = entry.key.starts_with("surfaces.");
        unsure && number && !place && entry.range.is_none()
    };
    entries.iter().filter(open).map(|entry| entry.key.clone()).collect()
}

fn text(e: &Explanation) -> String {
    let number = |value: f64| rounded(value, 4, 1e6);
    let mut text = format!("{}\n\n", e.design);
    let standing: Vec<String> = e
        .provenance
        .iter()
        .map(|(word, count)| format!("{count} {word}"))
        .collect();
    text.push_str(&format!("  values: {}\n", standing.join(", ")));
    text.push_str(&format!(
        "  the shot: {}, {}penetration {:.1} mm, {:.2} g of air through the exhaust\n\n",
        e.shot.outcome.name().replace('_', " "),
        e.shot
            .mean_drive_speed
            .map_or_else(String::new, |speed| format!("mean drive speed {speed:.1} m/s, ")),
        1e3 * e.shot.penetration,
        1e3 * e.shot.exhaust_mass,
    ));
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
    text.push_str("\n  cost of each stage, estimated within a factor of about two\n\n");
    text.push_str(&table(&["stage", "counts", "GB", "CPU s"], &rows));
    text.push_str("  costs apply to what is not in the cache\n");
    if !e.estimates.is_empty() {
        text.push_str("\n  estimates, the least certain first (SI)\n\n");
        let rows: Vec<Vec<String>> = e
            .estimates
            .iter()
            .take(LISTED)
            .map(|estimate| {
                vec![
                    estimate.key.clone(),
                    format!("{} {}", number(estimate.value), estimate.unit),
                    format!("{} .. {}", number(estimate.range[0]), number(estimate.range[1])),
                    estimate.source.clone(),
                ]
            })
            .collect();
        text.push_str(&table(&["key", "value", "range", "source"], &rows));
        if e.estimates.len() > LISTED {
            text.push_str(&format!(
                "  and {} more; --json lists all\n",
                e.estimates.len() - LISTED
            ));
        }
    }
    if !e.unknowns.is_empty() {
        text.push_str(&format!(
            "\n  unknown uncertainty: {} have no range: {}\n",
            e.unknowns.len(),
            e.unknowns.join(", ")
        ));
    }
    if let Some(gap) = &e.gap {
        text.push_str(&format!("\n  workpiece: {gap}\n"));
    }
    for obstacle in &e.obstacles {
        text.push_str(&format!("\n  obstacle: {obstacle}\n"));
    }
    text
}
