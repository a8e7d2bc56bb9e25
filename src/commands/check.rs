//! `nailnoise check`: whether a mesh can be trusted, and what its modes will cost; a design without a body is explained as
//! a whole.

use std::f64::consts::{PI, TAU};
use std::process::ExitCode;

use clap::Args;
use nailnoise_fem::Material;
use nailnoise_meshes::{Mesh, MeshError, Quality, Surface};
use nalgebra::{Matrix6x3, Vector3};
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
    /// Tied interfaces between pieces.
    ties: usize,
    parts: Vec<Part>,
    groups: Vec<Group>,
    /// Faults that make the mesh unusable.
    faults: Vec<String>,
    /// Warnings for the user.
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
    /// Mean thickness, twice the volume over the skin \[m\].
    thickness: f64,
    /// Shortest wave along the element side that is longest against it \[m\].
    shortest: f64,
    /// That side \[m\].
    side: f64,
    /// Such sides in that wave.
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
pub(super) struct Cost {
    pub(super) dofs: usize,
    pub(super) modes: f64,
    /// Independent problems that mirror planes divide the body into.
    sectors: usize,
    pub(super) gigabytes: f64,
    pub(super) cpu_seconds: f64,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    if let Some(design) = arguments.input.whole_design()? {
        return super::explain::execute(&design, arguments.json);
    }
    let loaded = arguments.input.load()?;
    let mesh = &loaded.imported.mesh;
    let quality = mesh.quality()?;
    let skin = Surface::of(mesh);
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
    let thickness = thicknesses(mesh, &skin, &volumes)?;
    let longest = mesh.longest_edges();
    let parts = (0..volumes.len())
        .map(|part| Part {
            name: mesh.part_names[part].clone(),
            volume: volumes[part],
            mass: geometry.map(|geometry| volumes[part] * geometry.materials[part].density()),
            longest_edge: longest[part],
            waves: geometry.map(|g| waves(mesh, part, &g.materials[part], margin * g.top_hz, thickness[part])),
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
    let ties = geometry.map_or(0, |geometry| geometry.attachments.ties.len());
    let (faults, warnings) = findings(
        mesh,
        &quality,
        worst_element,
        &parts,
        loaded.imported.unused_nodes,
        ties > 0,
    );
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
        mass: geometry.map(Geometry::mass).transpose()?,
        cost: geometry.map(|g| cost(g, &quality, &volumes, margin * g.top_hz, &thickness)),
        quality,
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&loaded.name, &result));
    }
    Ok(ExitCode::from(if result.faults.is_empty() { 0 } else { 2 }))
}

/// Mean thickness of the walls of each part, twice its volume over its share of the skin \[m\].
fn thicknesses(mesh: &Mesh, skin: &Surface, volumes: &[f64]) -> Result<Vec<f64>, MeshError> {
    let mut area = vec![0.0; volumes.len()];
    for point in skin.quadrature(3)? {
        area[mesh.parts[skin.faces[point.face].of.element]] += point.weight;
    }
    Ok(volumes
        .iter()
        .zip(area)
        .map(|(volume, area)| 2.0 * volume / area)
        .collect())
}

/// The shortest waves along every element side, in a solid and in a wall (Cremer, Heckl and Petersson, *Structure-Borne
/// Sound*, section 3.3),
///
/// ```text
/// lambda_S = c_S / f,   lambda_B = sqrt(1.8 c_L t / f),
/// ```
///
/// with c_S and c_L of [`speeds`] in the direction of the side, so that long elements along a grain are not taken for
/// coarse ones.
fn waves(mesh: &Mesh, part: usize, material: &Material, hz: f64, thickness: f64) -> Waves {
    let mut worst = Waves {
        hz,
        thickness,
        shortest: f64::INFINITY,
        side: 0.0,
        elements: f64::INFINITY,
    };
    for view in mesh.elements().filter(|view| view.part == part) {
        for &[a, b] in view.kind.edges() {
            let edge = mesh.nodes[view.nodes[b]] - mesh.nodes[view.nodes[a]];
            let side = edge.norm();
            let [slow, fast] = speeds(material, &(edge / side));
            let shortest = (slow / hz).min((1.8 * fast * thickness / hz).sqrt());
            if shortest / side < worst.elements {
                worst = Waves {
                    shortest,
                    side,
                    elements: shortest / side,
                    ..worst
                };
            }
        }
    }
    worst
}

/// Slowest and fastest plane wave in the direction n \[m/s\]: rho c^2 are the eigenvalues of Christoffel's matrix
/// Gamma_ik = C_ijkl n_j n_l (Auld, *Acoustic Fields and Waves in Solids*, section 7.C).
fn speeds(material: &Material, n: &Vector3<f64>) -> [f64; 2] {
    // Strain of the displacement e_k e^(j n.x), in the order xx, yy, zz, yz, xz, xy.
    let strain = Matrix6x3::new(
        n.x, 0.0, 0.0, //
        0.0, n.y, 0.0, //
        0.0, 0.0, n.z, //
        0.0, n.z, n.y, //
        n.z, 0.0, n.x, //
        n.y, n.x, 0.0,
    );
    let christoffel = strain.transpose() * material.stiffness() * strain / material.density();
    let squares = christoffel.symmetric_eigenvalues();
    [squares.min().sqrt(), squares.max().sqrt()]
}

/// Longitudinal speed of a plate for a shear speed, c_P = sqrt(2/(1 - nu)) c_S with nu = 0.3.
fn plate_speed(c_s: f64) -> f64 {
    (2.0_f64 / 0.7).sqrt() * c_s
}

/// Fewest quadratic elements in a wave before a frequency is off by more than a percent or so.
const FEWEST: f64 = 2.0;

fn findings(
    mesh: &Mesh,
    quality: &Quality,
    worst: u64,
    parts: &[Part],
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

/// Cost of the modes of a body up to `margin` times its top frequency.
pub(super) fn cost_of(geometry: &Geometry, margin: f64) -> Result<Cost, Error> {
    let mesh = &geometry.mesh;
    let (quality, volumes) = (mesh.quality()?, mesh.part_volumes()?);
    let thickness = thicknesses(mesh, &Surface::of(mesh), &volumes)?;
    Ok(cost(geometry, &quality, &volumes, margin * geometry.top_hz, &thickness))
}

/// Cost of the modes.
///
/// Modes by the larger of the leading terms for solids (Dupuis, Mazo and Onsager 1960) and for plates (Courant and
/// Hilbert), N = V w^3 / (6 pi^2) sum 1/c^3 and N = A w sqrt(12)/(4 pi c_P t). With n degrees of freedom the factor L of
/// a nested dissection holds 28 n^(4/3) values for a compact body and 28 n lg2 n for thin walls; Lanczos takes s = 4 N
/// solves and keeps as many vectors. The work is 6 L^2/n operations for two factors, 4 L s to solve, 4 n s^2 to keep the
/// vectors orthogonal. Mirror planes divide n and N by the number of sectors, which is how often the work is then done.
fn cost(geometry: &Geometry, quality: &Quality, volumes: &[f64], hz: f64, thickness: &[f64]) -> Cost {
    let omega = TAU * hz;
    let n = 3.0 * geometry.mesh.nodes.len() as f64;
    let of_part = |((volume, thickness), material): ((&f64, &f64), &Material)| {
        let c = |k: usize| (material.stiffness()[(k, k)] / material.density()).sqrt();
        let sum: f64 = (0..3)
            .map(|k| c(k).powi(-3) / 3.0 + 2.0 * c(k + 3).powi(-3) / 3.0)
            .sum();
        let solid = volume * omega.powi(3) / (6.0 * PI * PI) * sum;
        let plate = volume / thickness * omega * 12f64.sqrt() / (2.0 * TAU * plate_speed(c(5)) * thickness);
        solid.max(EDGES * plate)
    };
    let parts = volumes.iter().zip(thickness).zip(&geometry.materials);
    let modes = 6.0 + parts.map(of_part).sum::<f64>();
    let thin = quality.skin_area * quality.longest_edge > 3.0 * quality.volume;
    let planes = nailnoise_fem::mirror_planes(&geometry.mesh, &geometry.materials);
    let sectors = f64::from(1 << planes);
    let m = n / sectors;
    let factor = 28.0 * if thin { m * m.log2() } else { m.powf(4.0 / 3.0) };
    let vectors = 4.0 * modes / sectors + 64.0;
    let operations = 6.0 * factor * factor / m + 4.0 * factor * vectors + 4.0 * m * vectors * vectors;
    Cost {
        dofs: n as usize,
        modes,
        sectors: 1 << planes,
        gigabytes: (8.0 * sectors * (factor + m * vectors) + 8.0 * factor + SPARSE * n) / 1e9,
        cpu_seconds: sectors * operations / RATE,
    }
}

/// Share of the modes of a large plate that narrow walls have, whose edges hold them (0.51 on the tool body, 0.55 on the
/// steel tables).
const EDGES: f64 = 0.55;

/// Stiffness and mass \[byte a degree of freedom\].
const SPARSE: f64 = 2e3;

/// Operations a second and core, measured on block, tables and tool body: 16e9 to 22e9 on an x86-64 of 2022.
const RATE: f64 = 18e9;

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
                cell(waves.map(|w| w.shortest * 1e3), 0),
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
