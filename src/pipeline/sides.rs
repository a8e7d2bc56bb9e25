//! Sand at the sides of the block: cells in which it holds them, each in three directions.

use nailnoise_fem::supports::{RectangularBase, Sand};
use nailnoise_fem::transient::{Support, SupportLaw};
use nailnoise_fem::{LoadVector, Rectangle};
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::{Point3, Vector3};

use crate::design::{Design, SupportKind};
use crate::error::Error;

/// Cells along a side and up it; the waves that sand carries at the sides are longer than the block is thick.
const ALONG: usize = 5;
const UP: usize = 2;

/// A cell of a side.
struct Cell {
    group: &'static str,
    place: Rectangle,
    /// Outward normal, up, and along the side.
    directions: [Vector3<f64>; 3],
    area: f64,
}

/// Whether the sand holds the sides.
fn is_held(design: &Design) -> bool {
    design.support.kind == SupportKind::Sandbox && design.support.sand.side_contact > 0.0
}

fn cells(design: &Design) -> Vec<Cell> {
    let block = &design.workpiece;
    let half = [0.5 * block.length, 0.5 * block.width];
    let height = block.thickness;
    let mut cells = Vec::new();
    let faces = [
        ("x_min", -Vector3::x(), Vector3::y(), half[0], block.width),
        ("x_max", Vector3::x(), Vector3::y(), half[0], block.width),
        ("y_min", -Vector3::y(), Vector3::x(), half[1], block.length),
        ("y_max", Vector3::y(), Vector3::x(), half[1], block.length),
    ];
    for (group, normal, along, distance, length) in faces {
        let (wide, tall) = (length / ALONG as f64, height / UP as f64);
        for row in 0..UP {
            for column in 0..ALONG {
                let across = (column as f64 + 0.5) * wide - 0.5 * length;
                let up = (row as f64 + 0.5) * tall;
                cells.push(Cell {
                    group,
                    place: Rectangle {
                        centre: Point3::from(normal * distance + along * across + Vector3::z() * up),
                        sides: [along * wide, Vector3::z() * tall],
                    },
                    directions: [normal, Vector3::z(), along],
                    area: wide * tall,
                });
            }
        }
    }
    cells
}

/// Displacements that the sand at the sides resists; none where it does not hold them.
///
/// # Errors
/// [`MeshError`] where the workpiece's mesh has no such sides.
pub(super) fn load_vectors(design: &Design, mesh: &Mesh) -> Result<Vec<LoadVector>, MeshError> {
    if !is_held(design) {
        return Ok(Vec::new());
    }
    let of_cell = |cell: &Cell| {
        let along = |&direction: &Vector3<f64>| LoadVector::rectangle(mesh, cell.group, &cell.place, direction);
        cell.directions.iter().map(along).collect::<Result<Vec<_>, _>>()
    };
    let all: Result<Vec<_>, _> = cells(design).iter().map(of_cell).collect();
    Ok(all?.concat())
}

/// Springs and dashpots of these displacements: those of the base per area, times the share of the sides that is held.
///
/// They act both ways: the sand's own weight presses it on the sides, and what a small motion takes off that pressure is
/// as much as it adds on its way back.
pub(super) fn supports(design: &Design) -> Result<Vec<Support>, Error> {
    if !is_held(design) {
        return Ok(Vec::new());
    }
    let s = &design.support.sand;
    let sand = Sand::new(s.shear_modulus, s.density, s.poisson_ratio)?;
    let base = RectangularBase::new(design.workpiece.length, design.workpiece.width)?;
    let (along, across) = base.shear_bedding(&sand);
    let shear = 0.5 * (along + across);
    let of_cell = |cell: &Cell| {
        let area = s.side_contact * cell.area;
        let support = |stiffness: f64, dashpot: f64| Support {
            stiffness: stiffness * area,
            damping: dashpot * area,
            gap: 0.0,
            law: SupportLaw::Bonded,
        };
        let tangential = support(shear, sand.shear_dashpot());
        [
            support(base.normal_bedding(&sand), sand.normal_dashpot()),
            tangential,
            tangential,
        ]
    };
    Ok(cells(design).iter().flat_map(of_cell).collect())
}
