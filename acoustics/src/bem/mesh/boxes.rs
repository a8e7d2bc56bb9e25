use super::gaps::{LEAST_HEIGHT, RIM_WIDTH, Rim};
use super::panel::{BoundaryMesh, Panel};
use nailnoise_meshes::{FaceKind, MeshError, subdivide};
use nalgebra::Point3;
use serde::Serialize;
use std::collections::HashMap;

/// Smallest number of panels between two grid lines. The pressure varies strongly near edges; with a single panel
/// across the side of a plate, the power of in-plane motion is underestimated by 6 %.
const LEAST: f64 = 2.0;

/// An axis-aligned box that is part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SolidBox {
    /// Corner with the smallest coordinates \[m\].
    pub low: [f64; 3],
    /// Corner with the largest coordinates \[m\].
    pub high: [f64; 3],
    /// Index of the part it belongs to.
    pub part: usize,
}

/// A side of a part, with an outward normal along or against an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Index of the part.
    pub part: usize,
    /// Axis of the normal.
    pub axis: usize,
    /// Whether the normal points along the axis.
    pub upper: bool,
}

impl BoundaryMesh {
    /// The surface of a union of boxes as rectangles with sides of at most `edge` \[m\], excluding contact areas
    /// between boxes. Grid lines run through every side of every box, with at least two rectangles between adjacent
    /// lines.
    ///
    /// For a body that is symmetric about planes or stands on a floor, only the part above those `planes` \[m\] is
    /// meshed. `patch` returns the index of a side's patch in `patches`.
    ///
    /// # Errors
    /// [`MeshError`] unless all sides and `edge` are positive.
    pub fn of_boxes(
        boxes: &[SolidBox],
        planes: [Option<f64>; 3],
        edge: f64,
        patches: Vec<String>,
        patch: impl Fn(Side) -> usize,
    ) -> Result<Self, MeshError> {
        Self::of_boxes_fine_at(boxes, planes, (edge, &[]), patches, patch)
    }

    /// Same as [`BoundaryMesh::of_boxes`], with a finer grid near the `rims` of gaps. The first rectangle is half as
    /// wide as the gap is high. The width doubles from each rectangle to the next.
    ///
    /// # Errors
    /// Same as [`BoundaryMesh::of_boxes`].
    pub fn of_boxes_fine_at(
        boxes: &[SolidBox],
        planes: [Option<f64>; 3],
        (edge, rims): (f64, &[Rim]),
        patches: Vec<String>,
        patch: impl Fn(Side) -> usize,
    ) -> Result<Self, MeshError> {
        let mut lines: [Vec<f64>; 3] = Default::default();
        for (axis, line) in lines.iter_mut().enumerate() {
            *line = grid_line(boxes, axis, planes[axis], (edge, rims))?;
        }
        let cells = [0, 1, 2].map(|axis| lines[axis].len() - 1);
        let part_of = |cell: [usize; 3]| {
            let centre = [0, 1, 2].map(|a| 0.5 * (lines[a][cell[a]] + lines[a][cell[a] + 1]));
            let holds = |b: &&SolidBox| (0..3).all(|a| b.low[a] < centre[a] && centre[a] < b.high[a]);
            boxes.iter().find(holds).map(|b| b.part)
        };
        let mut mesh = Self {
            patches,
            ..Self::default()
        };
        let mut point_of: HashMap<[usize; 3], usize> = HashMap::new();
        let all = (0..cells[2]).flat_map(|k| (0..cells[1]).flat_map(move |j| (0..cells[0]).map(move |i| [i, j, k])));
        for cell in all {
            let Some(part) = part_of(cell) else { continue };
            for axis in 0..3 {
                for upper in [false, true] {
                    let beyond = if upper {
                        (cell[axis] + 1 < cells[axis]).then(|| cell[axis] + 1)
                    } else {
                        cell[axis].checked_sub(1)
                    };
                    let covered = match beyond {
                        Some(index) => {
                            let mut next = cell;
                            next[axis] = index;
                            part_of(next).is_some()
                        }
                        None => !upper && planes[axis].is_some(),
                    };
                    if covered {
                        continue;
                    }
                    let nodes = corners(cell, axis, upper).map(|corner| {
                        *point_of.entry(corner).or_insert_with(|| {
                            let at = [0, 1, 2].map(|a| lines[a][corner[a]]);
                            mesh.points.push(Point3::from(at));
                            mesh.points.len() - 1
                        })
                    });
                    let side = Side { part, axis, upper };
                    mesh.panels.extend(Panel::new(FaceKind::Quad4, &nodes, patch(side)));
                }
            }
        }
        Ok(mesh)
    }
}

/// Grid lines across an axis: all sides of boxes above the plane, with subdivided intervals.
fn grid_line(
    boxes: &[SolidBox],
    axis: usize,
    plane: Option<f64>,
    (edge, rims): (f64, &[Rim]),
) -> Result<Vec<f64>, MeshError> {
    let mut ends = Vec::with_capacity(2 * boxes.len() + 1);
    for b in boxes {
        let value = b.high[axis] - b.low[axis];
        if !(value.is_finite() && value > 0.0) {
            return Err(MeshError::Dimension {
                what: "a side of a box",
                value,
            });
        }
        ends.extend([b.low[axis], b.high[axis]]);
    }
    ends.extend(plane);
    ends.sort_by(f64::total_cmp);
    let tolerance = 1e-9 * (ends.last().unwrap_or(&0.0) - ends.first().unwrap_or(&0.0)).max(edge);
    ends.dedup_by(|a, b| *a - *b <= tolerance);
    if let Some(plane) = plane {
        ends.retain(|end| *end >= plane - tolerance);
    }
    let mut line: Vec<f64> = ends.first().copied().into_iter().collect();
    for pair in ends.windows(2) {
        let first = [pair[0], pair[1]].map(|end| width_at(rims, axis, end, tolerance));
        stretch(
            &mut line,
            [pair[0], pair[1]],
            edge.min((pair[1] - pair[0]) / LEAST),
            first,
        )?;
    }
    match line.len() {
        0 | 1 => Err(MeshError::Dimension {
            what: "the part of the boxes above the planes",
            value: 0.0,
        }),
        _ => Ok(line),
    }
}

/// Width of the rectangles next to a grid line \[m\]: half the height of the lowest gap with its rim there.
fn width_at(rims: &[Rim], axis: usize, at: f64, tolerance: f64) -> f64 {
    let there = |rim: &&Rim| rim.ends.iter().all(|end| (end[axis] - at).abs() <= tolerance);
    let widths = rims
        .iter()
        .filter(there)
        .map(|rim| RIM_WIDTH * rim.height.max(LEAST_HEIGHT));
    widths.fold(f64::INFINITY, f64::min)
}

/// Adds the grid lines of an interval. The rectangles at its ends have the widths `first`. Each further one is twice as
/// wide as the one before, up to a width of `edge` \[m\].
fn stretch(line: &mut Vec<f64>, [from, to]: [f64; 2], edge: f64, first: [f64; 2]) -> Result<(), MeshError> {
    let graded = first.iter().filter(|width| **width < edge).count();
    let room = (to - from) / graded.max(1) as f64;
    let mut edge = edge;
    let widths = first.map(|first| {
        let (mut widths, mut sum, mut width) = (Vec::new(), 0.0, first);
        while width < edge && sum + 2.0 * width <= room {
            widths.push(width);
            sum += width;
            width *= 2.0;
        }
        (widths, sum, width)
    });
    for (_, _, next) in &widths {
        edge = edge.min(*next);
    }
    let [(low, before, _), (high, behind, _)] = widths;
    for width in low {
        line.push(line.last().unwrap_or(&from) + width);
    }
    line.extend(subdivide(from + before, to - behind, edge)?);
    for width in high.into_iter().rev() {
        line.push(line.last().unwrap_or(&to) + width);
    }
    if behind > 0.0 {
        line.pop();
        line.push(to);
    }
    Ok(())
}

/// Grid indices of the corners of a cell's side, ordered for an outward normal.
fn corners(cell: [usize; 3], axis: usize, upper: bool) -> [[usize; 3]; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut order = [(0, 0), (1, 0), (1, 1), (0, 1)];
    if !upper {
        order.swap(1, 3);
    }
    order.map(|(a, b)| {
        let mut corner = cell;
        corner[axis] += usize::from(upper);
        corner[u] += a;
        corner[v] += b;
        corner
    })
}
