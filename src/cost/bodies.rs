//! Estimates elements, degrees of freedom and modes of a body without meshing it.

use std::path::Path;

use nailnoise_fem::{Material, ModalCost, modes_below};
use nailnoise_meshes::{Tool, Worktable};

use super::stage::{Remedy, StageCost};
use crate::design::Design;
use crate::design::inputs::bodies::{below_hz, geometry};
use crate::error::Error;
use crate::stages::bodies::{BodyKind, MeshSource, PartMaterials};

/// Number of nodes in the tool body's mesh per square of the largest element side on its walls; 63 in the shipped mesh.
const TOOL_NODES: f64 = 63.0;

/// Number of nodes per element in a large mesh of quadratic tetrahedra, and of quadratic hexahedra.
const NODES: [f64; 2] = [1.6, 4.2];

/// Assumed surface of a body whose dimensions are only in its file \[m2\].
fn nominal_area(kind: BodyKind) -> f64 {
    match kind {
        BodyKind::Workpiece => 0.2,
        BodyKind::Worktable => 2.0,
        BodyKind::Tool => 0.3,
    }
}

/// Elements and nodes of a mesh, and for the number of modes the solids it consists of: volume \[m3\], wall thickness
/// \[m\] and index of the material.
struct Count {
    elements: f64,
    nodes: f64,
    solids: Vec<(f64, f64, usize)>,
    /// Number of independent problems into which mirror planes divide the body.
    sectors: u32,
    thin: bool,
}

/// Cost of the mesh and modes of a body.
pub(super) fn modes(design: &Design, kind: BodyKind) -> Result<StageCost, Error> {
    let geometry = geometry(design, kind, false)?;
    let count = match &geometry.mesh {
        MeshSource::Block { size, element, joint } => block(*size, *element, *joint),
        MeshSource::Worktable(table, wall) => worktable(table, *wall),
        MeshSource::Tool(tool, _) => of_tool(tool),
        MeshSource::File(file) => file_of(kind, file.element_size(), file.path()),
    };
    let materials: Vec<&Material> = match &geometry.properties.materials {
        PartMaterials::Same(material) => vec![material],
        PartMaterials::Named(named) => named.iter().map(|(_, material)| material).collect(),
    };
    let hz = below_hz(design, kind);
    let of_solid = |&(volume, thickness, material): &(f64, f64, usize)| {
        modes_below(materials[material.min(materials.len() - 1)], volume, thickness, hz)
    };
    let modes = 6.0 + count.solids.iter().map(of_solid).sum::<f64>();
    let cost = ModalCost::of(3.0 * count.nodes, modes, count.sectors, count.thin);
    let keys: &'static [Remedy] = match kind {
        BodyKind::Workpiece => &[
            ("analysis.workpiece_element", "raise"),
            ("analysis.workpiece_max_frequency", "lower"),
            ("analysis.mode_margin", "lower"),
        ],
        BodyKind::Worktable => &[
            ("analysis.worktable_element", "raise"),
            ("analysis.worktable_leg_element", "raise"),
            ("analysis.worktable_tube_element", "raise"),
            ("analysis.worktable_top_layers", "lower"),
            ("analysis.worktable_max_frequency", "lower"),
            ("analysis.mode_margin", "lower"),
        ],
        BodyKind::Tool => &[
            ("analysis.body_element", "raise"),
            ("analysis.body_max_frequency", "lower"),
            ("analysis.mode_margin", "lower"),
        ],
    };
    Ok(StageCost::of_modes(kind.modes(), count.elements, cost, keys))
}

/// Area of the tool's outer walls \[m2\].
pub(super) fn tool_area(design: &Design) -> Result<f64, Error> {
    // The file need not be read for the nominal area.
    if !design.body.mesh.is_empty() {
        return Ok(nominal_area(BodyKind::Tool));
    }
    Ok(match &geometry(design, BodyKind::Tool, false)?.mesh {
        MeshSource::Tool(tool, _) => of_tool(tool).solids.iter().map(|(volume, wall, _)| volume / wall).sum(),
        _ => nominal_area(BodyKind::Tool),
    })
}

/// Number of elements along a length.
fn along(length: f64, element: f64) -> f64 {
    (length / element).ceil().max(1.0)
}

/// Number of nodes in a grid of 20-node hexahedra: corners and midpoints of edges.
fn grid_nodes([x, y, z]: [f64; 3]) -> f64 {
    let corners = (x + 1.0) * (y + 1.0) * (z + 1.0);
    corners + x * (y + 1.0) * (z + 1.0) + (x + 1.0) * y * (z + 1.0) + (x + 1.0) * (y + 1.0) * z
}

fn block([x, y, z]: [f64; 3], element: f64, joint: Option<f64>) -> Count {
    let pieces = joint.map_or(vec![[x, y, z]], |height| vec![[x, y, height], [x, y, z - height]]);
    let divisions = |size: &[f64; 3]| size.map(|length| along(length, element));
    let thinnest = |size: &[f64; 3]| size.iter().copied().fold(f64::INFINITY, f64::min);
    let solid = |size: &[f64; 3]| (size.iter().product(), thinnest(size), 0);
    Count {
        elements: pieces.iter().map(|size| divisions(size).iter().product::<f64>()).sum(),
        nodes: pieces.iter().map(|size| grid_nodes(divisions(size))).sum(),
        solids: pieces.iter().map(solid).collect(),
        sectors: 4,
        thin: false,
    }
}

fn worktable(table: &Worktable, wall: Option<f64>) -> Count {
    let element = table.element_size;
    let legs = [0, 1].map(|axis| along(table.leg[axis], element));
    let top = [0, 1].map(|axis| along(table.top[axis] - 2.0 * table.leg[axis], element) + 2.0 * legs[axis]);
    let layers = table.top_layers as f64;
    let height = table.height - table.thickness;
    let levels = along(height, table.leg_element_size);
    // A tube has one element through its wall.
    let (leg_elements, leg_nodes, leg_volume, leg_wall) = match wall {
        None => (
            legs[0] * legs[1] * levels,
            grid_nodes([legs[0], legs[1], levels]),
            table.leg[0] * table.leg[1] * height,
            table.leg[0],
        ),
        Some(wall) => {
            let around = 4.0 * along(table.leg[0], table.leg_element_size);
            let volume = 4.0 * table.leg[0] * wall * height;
            (around * levels, 5.0 * around * levels, volume, wall)
        }
    };
    let top_volume = table.top[0] * table.top[1] * table.thickness;
    Count {
        elements: top[0] * top[1] * layers + 4.0 * leg_elements,
        nodes: grid_nodes([top[0], top[1], layers]) + 4.0 * leg_nodes,
        solids: vec![(top_volume, table.thickness, 0), (4.0 * leg_volume, leg_wall, 1)],
        sectors: 4,
        thin: true,
    }
}

fn of_tool(tool: &Tool) -> Count {
    let tube = |radius: f64, wall: f64, length: f64, material: usize| {
        (2.0 * std::f64::consts::PI * radius * wall * length, wall, material)
    };
    let solids = vec![
        tube(
            tool.barrel_radius(tool.sleeve_radius),
            tool.barrel_wall,
            tool.barrel_height,
            0,
        ),
        tube(tool.cap_radius, tool.cap_wall, tool.cap_height + tool.cap_radius, 0),
        tube(tool.handle_radius, tool.handle_wall, tool.handle_length, 0),
        tube(
            tool.magazine_radius,
            tool.magazine_wall,
            tool.magazine_height + tool.magazine_radius,
            0,
        ),
        tube(0.6 * tool.nose_width, tool.nose_wall, tool.nose_height, 1),
        tube(tool.sleeve_radius, tool.sleeve_wall, tool.sleeve_height, 2),
    ];
    // One element through a wall, as long as the elements are larger than the wall thickness.
    let nodes_of = |(volume, wall, _): &(f64, f64, usize)| {
        let per_square = volume / wall / (tool.size * tool.size);
        TOOL_NODES * per_square * (wall / tool.size).max(1.0)
    };
    let nodes = solids.iter().map(nodes_of).sum::<f64>();
    Count {
        elements: nodes / NODES[0],
        nodes,
        solids,
        sectors: 2,
        thin: true,
    }
}

/// A body from a file: a solid geometry is treated as walls of the nominal area, a mesh is estimated from the size of
/// its file.
fn file_of(kind: BodyKind, element: Option<f64>, path: &Path) -> Count {
    let area = nominal_area(kind);
    // A node takes about 40 bytes of text, and a quadratic element as much as three nodes.
    let nodes = element.map_or_else(|| file_length(path) / 120.0, |side| 2.5 * area / (side * side));
    let wall = 0.005;
    Count {
        elements: nodes / NODES[usize::from(kind != BodyKind::Tool)],
        nodes,
        solids: vec![(0.5 * area * wall, wall, 0)],
        sectors: 1,
        thin: true,
    }
}

/// Size of a file \[byte\]; 0 if it cannot be read, which is reported when it is read.
fn file_length(path: &Path) -> f64 {
    std::fs::metadata(path).map_or(0.0, |data| data.len() as f64)
}
