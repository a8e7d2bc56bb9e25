//! Transfers normal velocities between two meshes of the same surface.

use super::curved::{Curved, Nearest};
use super::projection::ALIKE;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Vector3};
use std::collections::HashMap;

/// Largest distance of a point of one mesh from the other, relative to the longest edge of its panel: triangles cut the
/// corners of a curved surface.
const OFF_SURFACE: f64 = 0.1;

/// Largest relative difference between the two areas.
const AREA: f64 = 1e-2;

/// Corners closer than this fraction of the longest edge count as the same.
const SAME_CORNER: f64 = 1e-6;

/// Position of a point on the other mesh: index of the first velocity value of a triangle, and the triangle's corner
/// functions.
type Place = (usize, [f64; 3]);

impl Boundary {
    /// Transfers normal velocities from `other`, another triangle mesh of the same surface (corner values of its panels
    /// x patterns, see [`Boundary::project`]), to this one. Each point takes the velocity at the nearest point of a
    /// panel with a similar normal; panels common to both meshes keep their values. None if the surfaces differ or any
    /// panel is not a triangle.
    pub fn interpolate_from(&self, other: &Self, velocities: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let triangles = |boundary: &Self| boundary.velocity_values() == 3 * boundary.mesh().panels.len();
        let area = |boundary: &Self| {
            (0..boundary.mesh().panels.len())
                .map(|p| boundary.mesh().panel_area(p))
                .sum::<f64>()
        };
        let matching = triangles(self)
            && triangles(other)
            && velocities.nrows() == other.velocity_values()
            && self.mirrors() == other.mirrors()
            && self.floor() == other.floor()
            && (area(self) / area(other) - 1.0).abs() <= AREA;
        if !matching {
            return None;
        }
        let unit = SAME_CORNER * self.mesh().longest_edge();
        let known: HashMap<[[i64; 3]; 3], usize> = (0..other.mesh().panels.len())
            .map(|p| (other.corner_cells(p, unit).0, p))
            .collect();
        let curved = (0..other.mesh().panels.len()).flat_map(|p| Curved::of(other.mesh(), p));
        let surface = Nearest::new(curved.map(|(_, curved)| curved).collect());
        let mut same = true;
        let mut row = vec![0.0; velocities.ncols()];
        let on_this = self.project(velocities.ncols(), |p, xi, point, values| {
            let (cells, order) = self.corner_cells(p, unit);
            let place = match known.get(&cells) {
                Some(&q) => {
                    let (theirs, n) = (other.corner_cells(q, unit).1, FaceKind::Tri3.at(xi).n);
                    let mut of_corner = [0.0; 3];
                    (0..3).for_each(|rank| of_corner[theirs[rank]] = n[order[rank]]);
                    Some((3 * q, of_corner))
                }
                None => self.place_on(&surface, p, (point.position.coords, point.area_vector().normalize())),
            };
            let Some((first, n)) = place else {
                same = false;
                return values.fill(0.0);
            };
            row.fill(0.0);
            for (corner, n) in n.into_iter().enumerate() {
                let of_corner = velocities.row(first + corner);
                row.iter_mut().zip(of_corner.iter()).for_each(|(to, v)| *to += n * v);
            }
            values.copy_from_slice(&row);
        });
        same.then_some(on_this)
    }

    /// The position on another mesh nearest to a point of a panel with this normal; none if it is too far away.
    fn place_on(&self, surface: &Nearest, panel: usize, (at, normal): (Vector3<f64>, Vector3<f64>)) -> Option<Place> {
        let found = surface.find(&at, |n| n.dot(&normal) > ALIKE)?;
        let n = FaceKind::Tri3.at(found.xi).n;
        let near = (found.position - at).norm() <= OFF_SURFACE * self.longest_side(panel);
        near.then(|| (3 * found.triangle, [n[0], n[1], n[2]]))
    }

    /// Largest distance between two corners of a triangle \[m\].
    fn longest_side(&self, panel: usize) -> f64 {
        let [a, b, c] = self.corners_of(panel);
        (b - a).norm().max((c - b).norm()).max((a - c).norm())
    }

    fn corners_of(&self, panel: usize) -> [Vector3<f64>; 3] {
        let corners = self.mesh().panels[panel].corners();
        [0, 1, 2].map(|k| self.mesh().points[corners[k]].coords)
    }

    /// Grid cells of the given size that contain the corners of a triangle, in sorted order, with the corresponding
    /// corner indices.
    fn corner_cells(&self, panel: usize, unit: f64) -> ([[i64; 3]; 3], [usize; 3]) {
        let cell = |x: &Vector3<f64>| [0, 1, 2].map(|axis| (x[axis] / unit).round() as i64);
        let cells = self.corners_of(panel).map(|x| cell(&x));
        let mut order = [0, 1, 2];
        order.sort_by_key(|&k| cells[k]);
        (order.map(|k| cells[k]), order)
    }
}
