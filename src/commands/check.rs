//! `nailnoise check`: checks a mesh and estimates the cost of its modes; a design without a chosen body is explained in
//! full.

use std::path::PathBuf;

use clap::Args;
use nailnoise_fem::{ModalCost, ShortestWave, wall_thicknesses};
use nailnoise_meshes::{Mesh, Quality};
use serde::Serialize;

use super::table::numbers;
use super::{Shown, Status, bodies::Input, print_json, surface_records, warn};
use crate::design::inputs;
use crate::design::inputs::recorded_surfaces::SurfaceMeasure;
use crate::error::Error;
use crate::stages::bodies::{Origin, SIDES_PER_WAVE as FEWEST};
use crate::tables::fixed;
use crate::units::Units;
use crate::wording;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise check my-tool.toml" => "whether it runs and drives, what is missing, and what to measure first",
    "nailnoise check my-tool.toml --body tool" => "the mesh of a body: quality, surfaces, missing inputs of a run",
    "nailnoise check my-tool.toml --body tool --record-surfaces tool-surfaces.toml" =>
        "records the surfaces of a body from a file, so that a changed file is refused",
    "nailnoise check my-tool.toml --drawing tool.svg" => "which key is which length: the tool drawn to scale",
    "nailnoise check housing.msh" => "a mesh of your own",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,
    /// Draw the tool at the dimensions of the design, every key at its place, in place of the check; of an assembly,
    /// its network [default FILE: out/NAME/drawing.svg, out/NAME/network.svg]
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with = "body",
        value_parser = super::drawing::svg_path)]
    drawing: Option<Option<PathBuf>>,
    /// Print exactly one JSON value instead of text
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    shown: Shown,
    /// If no study states it, compute the effect of each input on the total level, one at a time over its range:
    /// minutes
    #[arg(long, conflicts_with = "body")]
    effects: bool,
    /// Write area, centre and mean normal of the body's surfaces to a new TOML file. Appended to the design, a changed
    /// file whose surfaces have moved is refused
    #[arg(long, value_name = "FILE", requires = "body")]
    record_surfaces: Option<PathBuf>,
}

/// Layout of `check --json`.
#[derive(Serialize)]
struct CheckResult {
    schema: &'static str,
    nodes: usize,
    elements: usize,
    quality: Quality,
    /// Number of the worst element in its file.
    worst_element: u64,
    unused_nodes: usize,
    /// Number of tied interfaces between pieces.
    ties: usize,
    parts: Vec<MeshPart>,
    groups: Vec<Group>,
    /// Faults that make the mesh unusable.
    faults: Vec<String>,
    /// Warnings for the user.
    warnings: Vec<String>,
    /// File to which the surfaces were recorded.
    recorded: Option<PathBuf>,
    /// Mass including lumped masses \[kg\]; none without a design.
    mass: Option<f64>,
    cost: Option<ModalCost>,
}

#[derive(Serialize)]
struct MeshPart {
    name: String,
    volume: f64,
    mass: Option<f64>,
    longest_edge: f64,
    waves: Option<ShortestWave>,
}

#[derive(Serialize)]
struct Group {
    name: String,
    faces: usize,
    /// Area \[m2\], excluding faces between two elements.
    area: f64,
    /// Centroid \[m\].
    centre: Option<[f64; 3]>,
    /// Integral of the outward unit normal over the surface, divided by the area.
    normal: Option<[f64; 3]>,
    /// Origin of its name: the file, the design, or a guess from its shape.
    origin: &'static str,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.input.start_threads()?;
    if let Some(tool) = arguments.input.assembled()? {
        let path = arguments.input.path();
        if tool.has_design
            && let Some(design) = arguments.input.whole_design()?
        {
            inputs::sensors::transducers(&design)?;
            inputs::assembly::cycle(&design)?;
        } else {
            warn(&tool);
        }
        return match &arguments.drawing {
            Some(file) => super::assembly::draw(&tool, path, file.as_deref(), arguments.json),
            None => {
                let status = super::assembly::check(&tool, path, arguments.json, arguments.shown)?;
                tool.check_start()?;
                Ok(status)
            }
        };
    }
    let design = arguments.input.whole_design()?;
    if let Some(file) = &arguments.drawing {
        let design = design.ok_or_else(|| Error::DrawingOfMesh {
            path: arguments.input.path().to_owned(),
        })?;
        return super::drawing::execute(&design, file.as_deref(), arguments.json);
    }
    if let Some(design) = design {
        let asked = super::explain::Asked {
            memory: arguments.input.memory(),
            json: arguments.json,
            effects: arguments.effects,
            shown: arguments.shown,
        };
        return super::explain::execute(&design, &asked);
    }
    if let Some(path) = &arguments.record_surfaces {
        surface_records::refuse(path, &arguments.input)?;
    }
    let loaded = arguments.input.load(true)?;
    let mesh = &loaded.imported.mesh;
    let quality = mesh.quality()?;
    let measures = SurfaceMeasure::of_mesh(mesh)?;
    let number = |element: usize| {
        loaded
            .imported
            .element_numbers
            .get(element)
            .copied()
            .unwrap_or(element as u64)
    };
    let worst_element = number(quality.worst.element);
    let body = loaded.body.as_ref();
    let volumes = mesh.part_volumes()?;
    let thickness = wall_thicknesses(mesh)?;
    let longest = mesh.longest_edges();
    let parts = (0..volumes.len())
        .map(|part| MeshPart {
            name: mesh.part_names[part].clone(),
            volume: volumes[part],
            mass: body.map(|(meshed, _)| volumes[part] * meshed.materials[part].density()),
            longest_edge: longest[part],
            waves: body
                .map(|(meshed, hz)| ShortestWave::of_part(mesh, part, &meshed.materials[part], *hz, thickness[part])),
        })
        .collect::<Vec<_>>();
    let groups = mesh
        .groups
        .iter()
        .map(|group| {
            let measure = measures.iter().find(|measure| measure.name == group.name);
            let found = body.and_then(|(meshed, _)| meshed.surfaces.iter().find(|found| found.name == group.name));
            Group {
                name: group.name.clone(),
                faces: group.faces.len(),
                area: measure.map_or(0.0, |measure| measure.area),
                centre: measure.map(|measure| measure.centre.into()),
                normal: measure.map(|measure| measure.normal.into()),
                origin: found.map_or("file", |found| match found.origin {
                    Origin::Design => "design",
                    Origin::Guess => "guess",
                }),
            }
        })
        .collect();
    let ties = body.map_or(0, |(meshed, _)| meshed.attachments.ties.len());
    // Pieces of a body are checked together with the other preflight checks.
    let (mut faults, mut warnings) = findings(
        mesh,
        &quality,
        worst_element,
        &parts,
        loaded.imported.unused_nodes,
        ties > 0 || !loaded.problems.is_empty(),
    );
    faults.extend(loaded.problems.iter().map(Error::in_words_with_place));
    warnings.extend(loaded.imported.notes.iter().cloned());
    if let Some((design, kind)) = &loaded.design {
        warnings.extend(surface_records::idle(design, *kind));
    }
    let recorded = match (&arguments.record_surfaces, &loaded.design) {
        (Some(path), Some((design, kind))) => {
            surface_records::write(path, design, *kind, &measures)?;
            Some(path.clone())
        }
        _ => None,
    };
    let result = CheckResult {
        schema: "nailnoise-check/1",
        nodes: mesh.nodes.len(),
        elements: mesh.element_count(),
        worst_element,
        unused_nodes: loaded.imported.unused_nodes,
        ties,
        parts,
        groups,
        faults,
        warnings,
        recorded,
        mass: body.map(|(meshed, _)| meshed.mass()).transpose()?,
        cost: body
            .map(|(meshed, hz)| ModalCost::estimate(mesh, &meshed.materials, &quality, *hz))
            .transpose()?,
        quality,
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        arguments
            .shown
            .print(&text(&loaded.name, &result, arguments.shown.units))?;
    }
    Ok(Status::from(if result.faults.is_empty() { 0 } else { 2 }))
}

fn findings(
    mesh: &Mesh,
    quality: &Quality,
    worst: u64,
    parts: &[MeshPart],
    unused: usize,
    tied: bool,
) -> (Vec<String>, Vec<String>) {
    let (mut faults, mut warnings) = (Vec::new(), Vec::new());
    if quality.inverted > 0 {
        faults.push(format!(
            "{} elements are inverted or flat; the worst is element {worst} with the Jacobian {:.3e} m3",
            quality.inverted, quality.worst.determinant
        ));
    }
    if quality.open_edges > 0 {
        faults.push(format!(
            "{} edges of the skin are open or wrongly oriented",
            quality.open_edges
        ));
    }
    if quality.skin_volume <= 0.0 {
        faults.push("the skin is inside out".to_owned());
    }
    if quality.poor > quality.inverted {
        warnings.push(format!(
            "{} elements have Jacobian ratios below {}; strains at their worst corners are wrong",
            quality.poor - quality.inverted,
            nailnoise_meshes::POOR
        ));
    }
    if quality.pieces > 1 && !tied {
        warnings.push(format!(
            "{} pieces share no node; each moves by itself, with 6 rigid modes of its own, unless surfaces NAME_slave \
             and NAME_master tie them",
            quality.pieces
        ));
    }
    if quality.coincident_nodes > 0 && !tied {
        warnings.push(format!(
            "{} nodes coincide with another node: a crack, unless intended (gmsh: Coherence Mesh)",
            quality.coincident_nodes
        ));
    }
    if unused > 0 {
        warnings.push(format!(
            "{unused} nodes of the file belong to no volume element and are ignored"
        ));
    }
    if mesh.groups.is_empty() {
        warnings.push("no named surface: the body cannot be clamped, loaded or brought into contact".to_owned());
    }
    for part in parts {
        if let Some(waves) = part.waves.as_ref().filter(|waves| waves.elements < FEWEST) {
            warnings.push(format!(
                "{}: {:.1} elements in the shortest wave ({:.0} mm at {:.0} Hz, along a side of {:.0} mm), fewer than \
                 {FEWEST}: refine to {:.0} mm",
                part.name,
                waves.elements,
                waves.shortest * 1e3,
                waves.hz,
                waves.side * 1e3,
                waves.shortest / FEWEST * 1e3
            ));
        }
    }
    (faults, warnings)
}

fn text(name: &str, result: &CheckResult, units: Units) -> String {
    let q = &result.quality;
    let mut text = format!("{name}: {} nodes, {} elements\n\n", result.nodes, result.elements);
    let mut line = |what: &str, value: String| text.push_str(&format!("  {what:<22}{value}\n"));
    line(
        "worst element",
        format!(
            "{}, Jacobian {:.3e} m3, ratio {:.3}; {} inverted, {} below {}",
            result.worst_element,
            q.worst.determinant,
            q.worst.ratio,
            q.inverted,
            q.poor,
            nailnoise_meshes::POOR
        ),
    );
    line(
        "skin",
        if q.open_edges == 0 {
            format!("closed and outward, {:.4} m2", q.skin_area)
        } else {
            format!("{} open edges", q.open_edges)
        },
    );
    line(
        "pieces",
        format!("{}{}", q.pieces, if result.ties > 0 { ", tied" } else { "" }),
    );
    line(
        "element sides",
        format!("{:.2} to {:.1} mm", q.shortest_edge * 1e3, q.longest_edge * 1e3),
    );
    if let Some(mass) = result.mass {
        line("mass", format!("{mass:.3} kg including lumped masses"));
    }
    if let Some(cost) = &result.cost {
        line(
            "cost of modes",
            format!(
                "about {:.1} GB and {:.0} CPU s: {} degrees of freedom, about {:.0} modes, {}",
                cost.gigabytes,
                cost.cpu_seconds,
                cost.dofs,
                cost.modes,
                match cost.sectors {
                    1 => "no mirror plane".to_owned(),
                    sectors => format!("in {sectors} sectors by mirror planes"),
                }
            ),
        );
    }
    let rows: Vec<Vec<String>> = result
        .parts
        .iter()
        .map(|part| {
            let waves = part.waves.as_ref();
            vec![
                part.name.clone(),
                format!("{:.1}", part.volume * 1e6),
                fixed(part.mass, 3),
                format!("{:.1}", part.longest_edge * 1e3),
                fixed(waves.map(|w| w.shortest * 1e3), 0),
                fixed(waves.map(|w| w.elements), 1),
            ]
        })
        .collect();
    text.push('\n');
    let headings = [
        "part",
        "cm3",
        "kg",
        "longest side mm",
        "shortest wave mm",
        "elements in it",
    ];
    text.push_str(&numbers(&headings, &rows, units));
    let rows: Vec<Vec<String>> = result
        .groups
        .iter()
        .map(|group| {
            vec![
                group.name.clone(),
                group.faces.to_string(),
                format!("{:.1}", group.area * 1e4),
                vector(group.centre.map(|centre| centre.map(|c| 1e3 * c)), 1),
                vector(group.normal, 2),
                group.origin.to_owned(),
            ]
        })
        .collect();
    text.push('\n');
    text.push_str(&numbers(
        &["surface", "faces", "cm2", "centre mm", "mean normal", "named by"],
        &rows,
        units,
    ));
    if let Some(path) = &result.recorded {
        text.push_str(&format!(
            "\n  surfaces recorded in {}: append it to the design, in place of earlier records of this body\n",
            path.display()
        ));
    }
    for fault in &result.faults {
        text.push_str(&format!("\n  fault: {fault}"));
    }
    for warning in &result.warnings {
        text.push_str(&format!("\n  warning: {warning}"));
    }
    if !(result.faults.is_empty() && result.warnings.is_empty()) {
        text.push('\n');
    }
    text
}

/// A vector with this number of decimals.
fn vector(vector: Option<[f64; 3]>, decimals: usize) -> String {
    vector.map_or_else(
        || "-".to_owned(),
        |vector| {
            let [x, y, z] = vector.map(|c| wording::fixed(c, decimals));
            format!("({x}, {y}, {z})")
        },
    )
}
