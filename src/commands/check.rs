//! `nailnoise check`: whether a mesh can be trusted, and what its modes will cost.

use std::f64::consts::{PI, TAU};
use std::process::ExitCode;

use clap::Args;
use nailnoise_fem::Material;
use nailnoise_meshes::{Mesh, Quality};
use serde::Serialize;

use super::bodies::Input;
use super::table::table;
use super::{print, print_json};
use crate::error::Error;
use crate::pipeline::Geometry;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,
    /// Print exactly one JSON value instead of text
    #[arg(long)]
    json: bool,
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
    parts: Vec<Part>,
    groups: Vec<Group>,
    /// Faults that make the mesh unusable.
    faults: Vec<String>,
    /// What the user should know.
    warnings: Vec<String>,
    /// Mass with lumped masses \[kg\]; none without a design.
    mass: Option<f64>,
    cost: Option<Cost>,
}

#[derive(Serialize)]
struct Part {
    name: String,
    volume: f64,
    mass: Option<f64>,
    longest_edge: f64,
    waves: Option<Waves>,
}

/// How well elements carry the shortest waves at the top frequency.
#[derive(Serialize)]
struct Waves {
    /// Frequency to which modes are computed \[Hz\].
    hz: f64,
    /// Shortest shear wave \[m\].
    shear: f64,
    /// Shortest bending wave of a wall of the mean thickness \[m\].
    bending: f64,
    /// Elements in the shorter of the two, at the longest side.
    elements: f64,
}

#[derive(Serialize)]
struct Group {
    name: String,
    faces: usize,
    /// Area \[m2\]; faces between two elements have none here.
    area: f64,
}

/// Estimates before the modes are computed; within a factor of two or so.
#[derive(Serialize)]
struct Cost {
    dofs: usize,
    modes: f64,
    gigabytes: f64,
    cpu_seconds: f64,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let loaded = arguments.input.load()?;
    let mesh = &loaded.imported.mesh;
    let quality = mesh.quality()?;
    let skin = nailnoise_meshes::Surface::of(mesh);
    let number = |element: usize| {
        loaded
            .imported
            .element_numbers
            .get(element)
            .copied()
            .unwrap_or(element as u64)
    };
    let worst_element = number(quality.worst.element);
    let geometry = loaded.body.as_ref().map(|(_, geometry)| geometry);
    let margin = loaded
        .body
        .as_ref()
        .map_or(1.0, |(design, _)| design.analysis.mode_margin);
    let volumes = mesh.part_volumes()?;
    let thickness = 2.0 * quality.volume / quality.skin_area;
    let longest = mesh.longest_edges();
    let parts = (0..volumes.len())
        .map(|part| Part {
            name: mesh.part_names[part].clone(),
            volume: volumes[part],
            mass: geometry.map(|geometry| volumes[part] * geometry.materials[part].density()),
            longest_edge: longest[part],
            waves: geometry.map(|g| waves(&g.materials[part], margin * g.top_hz, thickness, longest[part])),
        })
        .collect::<Vec<_>>();
    let groups = mesh
        .groups
        .iter()
        .map(|group| {
            let area = skin.patch(&group.name).map_or(0.0, |patch| skin.patch_area(patch));
            Group {
                name: group.name.clone(),
                faces: group.faces.len(),
                area,
            }
        })
        .collect();
    let (faults, warnings) = findings(mesh, &quality, worst_element, &parts, loaded.imported.unused_nodes);
    let result = CheckResult {
        schema: "nailnoise-check/1",
        nodes: mesh.nodes.len(),
        elements: mesh.element_count(),
        worst_element,
        unused_nodes: loaded.imported.unused_nodes,
        parts,
        groups,
        faults,
        warnings,
        mass: geometry.map(Geometry::mass).transpose()?,
        cost: geometry.map(|g| cost(g, &quality, &volumes, margin * g.top_hz, thickness)),
        quality,
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&loaded.name, &result));
    }
    Ok(ExitCode::from(if result.faults.is_empty() { 0 } else { 2 }))
}

/// Shear wave c_S / f with the slowest shear speed, and bending wave (Cremer, Heckl and Petersson, *Structure-Borne
/// Sound*, section 3.3)
///
/// ```text
/// lambda_B = sqrt(1.8 c_P t / f),   c_P = sqrt(2/(1 - nu)) c_S with nu = 0.3
/// ```
fn waves(material: &Material, hz: f64, thickness: f64, longest: f64) -> Waves {
    let c_s = material.slowest_speed();
    let shear = c_s / hz;
    let bending = (1.8 * plate_speed(c_s) * thickness / hz).sqrt();
    Waves {
        hz,
        shear,
        bending,
        elements: shear.min(bending) / longest,
    }
}

fn plate_speed(c_s: f64) -> f64 {
    (2.0_f64 / 0.7).sqrt() * c_s
}

/// Fewest quadratic elements in a wave before a frequency is off by more than a percent or so.
const FEWEST: f64 = 2.0;

fn findings(mesh: &Mesh, quality: &Quality, worst: u64, parts: &[Part], unused: usize) -> (Vec<String>, Vec<String>) {
    let (mut faults, mut warnings) = (Vec::new(), Vec::new());
    if quality.inverted > 0 {
        faults.push(format!(
            "{} elements are inverted or flat; the worst is element {worst} with the Jacobian {:.3e} m3",
            quality.inverted, quality.worst.determinant
        ));
    }
    if quality.open_edges > 0 {
        faults.push(format!(
            "{} edges of the skin are open or run the wrong way round",
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
    if quality.pieces > 1 {
        warnings.push(format!(
            "{} pieces share no node; each moves by itself, with 6 rigid modes of its own",
            quality.pieces
        ));
    }
    if quality.coincident_nodes > 0 {
        warnings.push(format!(
            "{} nodes lie on another node: a crack, unless it is meant (gmsh: Coherence Mesh)",
            quality.coincident_nodes
        ));
    }
    if unused > 0 {
        warnings.push(format!(
            "{unused} nodes of the file are used by no volume element; they are left out"
        ));
    }
    if mesh.groups.is_empty() {
        warnings.push("no named surface: nothing can be clamped, loaded or touched".to_owned());
    }
    for part in parts {
        if let Some(waves) = part.waves.as_ref().filter(|waves| waves.elements < FEWEST) {
            warnings.push(format!(
                "{}: {:.1} elements in the shortest wave ({:.0} mm at {:.0} Hz), fewer than {FEWEST}: refine to {:.0} mm",
                part.name,
                waves.elements,
                waves.shear.min(waves.bending) * 1e3,
                waves.hz,
                waves.shear.min(waves.bending) / FEWEST * 1e3
            ));
        }
    }
    (faults, warnings)
}

/// What the modes will cost.
///
/// Modes by the larger of the leading terms for solids (Dupuis, Mazo and Onsager 1960) and for plates (Courant and
/// Hilbert), N = V w^3 / (6 pi^2) sum 1/c^3 and N = A w sqrt(12)/(4 pi c_P t). The factor of a nested dissection holds
/// 28 n^(4/3) values for a compact body (measured at 61 000 degrees of freedom), and takes about 3 L^2/n operations.
fn cost(geometry: &Geometry, quality: &Quality, volumes: &[f64], hz: f64, thickness: f64) -> Cost {
    let omega = TAU * hz;
    let n = 3.0 * geometry.mesh.nodes.len() as f64;
    let of_part = |(volume, material): (&f64, &Material)| {
        let c = |k: usize| (material.stiffness()[(k, k)] / material.density()).sqrt();
        let sum: f64 = (0..3)
            .map(|k| c(k).powi(-3) / 3.0 + 2.0 * c(k + 3).powi(-3) / 3.0)
            .sum();
        let solid = volume * omega.powi(3) / (6.0 * PI * PI) * sum;
        let plate = volume / thickness * omega * 12f64.sqrt() / (2.0 * TAU * plate_speed(c(5)) * thickness);
        solid.max(plate)
    };
    let modes = 6.0 + volumes.iter().zip(&geometry.materials).map(of_part).sum::<f64>();
    // Thin walls separate at fewer nodes: their factor grows as n log n.
    let thin = quality.skin_area * quality.longest_edge > 3.0 * quality.volume;
    let factor = if thin {
        9.0 * n * n.log2()
    } else {
        28.0 * n.powf(4.0 / 3.0)
    };
    let vectors = 2.0 * modes + 64.0;
    const RATE: f64 = 4e9; // operations a second and core
    let operations = 2.0 * 3.0 * factor * factor / n + 4.0 * factor * vectors + 4.0 * n * vectors * vectors;
    Cost {
        dofs: n as usize,
        modes,
        gigabytes: 8.0 * (2.0 * factor + 2.0 * n * vectors) / 1e9,
        cpu_seconds: operations / RATE,
    }
}

fn text(name: &str, result: &CheckResult) -> String {
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
    line("pieces", q.pieces.to_string());
    line(
        "element sides",
        format!("{:.2} to {:.1} mm", q.shortest_edge * 1e3, q.longest_edge * 1e3),
    );
    if let Some(mass) = result.mass {
        line("mass", format!("{mass:.3} kg with what is lumped on it"));
    }
    if let Some(cost) = &result.cost {
        line(
            "modes will cost",
            format!(
                "about {:.1} GB and {:.0} CPU s: {} degrees of freedom, some {:.0} modes",
                cost.gigabytes, cost.cpu_seconds, cost.dofs, cost.modes
            ),
        );
    }
    let cell = |value: Option<f64>, digits: usize| value.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"));
    let rows: Vec<Vec<String>> = result
        .parts
        .iter()
        .map(|part| {
            let waves = part.waves.as_ref();
            vec![
                part.name.clone(),
                format!("{:.1}", part.volume * 1e6),
                cell(part.mass, 3),
                format!("{:.1}", part.longest_edge * 1e3),
                cell(waves.map(|w| w.shear.min(w.bending) * 1e3), 0),
                cell(waves.map(|w| w.elements), 1),
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
    text.push_str(&table(&headings, &rows));
    let rows: Vec<Vec<String>> = result
        .groups
        .iter()
        .map(|group| {
            vec![
                group.name.clone(),
                group.faces.to_string(),
                format!("{:.1}", group.area * 1e4),
            ]
        })
        .collect();
    text.push('\n');
    text.push_str(&table(&["surface", "faces", "cm2"], &rows));
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
