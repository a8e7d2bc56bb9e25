//! Where forces act on a finite-element body: weights on its degrees of freedom.
//!
//! A pattern reads a displacement, d = sum w_i u_i, and its transpose spreads a force, so that force times d is work:
//! what one body does to another through the same pair of patterns neither makes nor loses energy.

use nailnoise_meshes::{FaceKind, Location, Mesh, MeshError, QuadraturePoint, Surface, SurfaceFace, gauss_legendre};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use serde::Serialize;

/// Sparse weights on the degrees of freedom 3 node + axis of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Pattern(Vec<(usize, f64)>);

/// A rectangle in a horizontal plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    /// Centre (x, y) \[m\].
    pub centre: [f64; 2],
    /// Lengths along x and y \[m\].
    pub size: [f64; 2],
    /// Height z of the plane \[m\].
    pub height: f64,
}

/// Gauss points along each side of a rectangle: enough for a patch that covers several quadratic elements.
const PATCH_POINTS: usize = 6;

/// How far a face may lie off the plane of a patch \[m\].
const PLANE_TOLERANCE: f64 = 1e-6;

impl Pattern {
    /// Mean vertical displacement (z up) of a rectangle on a face group; its transpose is a uniform pressure.
    ///
    /// # Errors
    /// [`MeshError::Outside`] when the rectangle is not wholly on the group.
    pub(super) fn patch(mesh: &Mesh, group: &str, rectangle: Rectangle) -> Result<Self, MeshError> {
        let rule = gauss_legendre(PATCH_POINTS)?;
        let mut weights = Vec::new();
        for &(eta, w_eta) in &rule {
            for &(xi, w_xi) in &rule {
                let at = |axis: usize, s: f64| rectangle.centre[axis] + 0.5 * s * rectangle.size[axis];
                let point = Point3::new(at(0, xi), at(1, eta), rectangle.height);
                let place = mesh.locate_on(group, point, PLANE_TOLERANCE)?;
                let share = 0.25 * w_xi * w_eta;
                weights.extend(
                    place
                        .nodes
                        .iter()
                        .zip(&place.weights)
                        .map(|(node, w)| (3 * node + 2, share * w)),
                );
            }
        }
        Ok(Self::gathered(weights))
    }

    /// Mean displacement along a direction of a rectangle with its own centre and sides on a face group.
    ///
    /// # Errors
    /// [`MeshError::Outside`] when the rectangle is not wholly on the group.
    pub(super) fn panel(
        mesh: &Mesh,
        group: &str,
        (centre, sides): (Point3<f64>, [Vector3<f64>; 2]),
        direction: Vector3<f64>,
    ) -> Result<Self, MeshError> {
        let rule = gauss_legendre(PATCH_POINTS)?;
        let mut weights = Vec::new();
        for &(eta, w_eta) in &rule {
            for &(xi, w_xi) in &rule {
                let point = centre + sides[0] * (0.5 * xi) + sides[1] * (0.5 * eta);
                let place = mesh.locate_on(group, point, PLANE_TOLERANCE)?;
                let share = 0.25 * w_xi * w_eta;
                for (node, w) in place.nodes.iter().zip(&place.weights) {
                    let along = (0..3).filter(|&axis| direction[axis] != 0.0);
                    weights.extend(along.map(|axis| (3 * node + axis, share * w * direction[axis])));
                }
            }
        }
        Ok(Self::gathered(weights))
    }

    /// Vertical displacement (z up) of a point inside the body.
    ///
    /// # Errors
    /// [`MeshError::Outside`] when the point is not in the mesh.
    pub(super) fn point(mesh: &Mesh, point: Point3<f64>) -> Result<Self, MeshError> {
        Self::along(mesh, point, Vector3::z())
    }

    /// Displacement of a point inside the body along a unit vector.
    ///
    /// # Errors
    /// [`MeshError::Outside`] when the point is not in the mesh.
    pub(super) fn along(mesh: &Mesh, point: Point3<f64>, direction: Vector3<f64>) -> Result<Self, MeshError> {
        Ok(Self::at(&mesh.locate(point)?, direction))
    }

    /// The same for a point that may lie outside the body by `off` \[m\].
    ///
    /// # Errors
    /// [`MeshError::Outside`] when it lies farther from the mesh.
    pub(super) fn near(mesh: &Mesh, point: Point3<f64>, direction: Vector3<f64>, off: f64) -> Result<Self, MeshError> {
        Ok(Self::at(&mesh.locate_within(point, off)?, direction))
    }

    fn at(place: &Location, direction: Vector3<f64>) -> Self {
        let of_node = |(&node, &w): (&usize, &f64)| [0, 1, 2].map(|axis| (3 * node + axis, w * direction[axis]));
        Self::gathered(place.nodes.iter().zip(&place.weights).flat_map(of_node).collect())
    }

    /// Mean displacement along a unit vector of the part of a patch where `inside` holds; its transpose is a uniform
    /// traction of total force 1. `None` where no point of the patch is inside.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`] with the names there are.
    pub(super) fn traction(
        surface: &Surface,
        patch: &str,
        direction: Vector3<f64>,
        inside: impl Fn(&Point3<f64>) -> bool,
    ) -> Result<Option<Self>, MeshError> {
        let points = points_on(surface, &[patch], inside)?;
        let area: f64 = points.iter().map(|point| point.weight).sum();
        let weights = spread(surface, &points, |_| direction / area);
        Ok((area > 0.0).then(|| Self::gathered(weights)))
    }

    /// Mean displacement along a unit vector of the surface within a distance of a point. `None` where there is none of it.
    ///
    /// # Errors
    /// None for a valid mesh.
    pub(super) fn foot(
        surface: &Surface,
        (centre, radius): (Point3<f64>, f64),
        direction: Vector3<f64>,
    ) -> Result<Option<Self>, MeshError> {
        let inside = |p: &Point3<f64>| (p - centre).norm() < radius;
        let near = |face: &SurfaceFace| {
            let (low, high) = face.nodes.iter().map(|&node| surface.points[node]).fold(
                (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
                |(low, high), p| (low.inf(&p), high.sup(&p)),
            );
            let gap = (low - centre).sup(&(centre - high));
            gap.sup(&Vector3::zeros()).norm() < radius
        };
        let points = points_where(surface, near, inside)?;
        let area: f64 = points.iter().map(|point| point.weight).sum();
        let weights = spread(surface, &points, |_| direction / area);
        Ok((area > 0.0).then(|| Self::gathered(weights)))
    }

    /// Volume that the parts of patches where `inside` holds sweep into the body, per unit of displacement \[m2\]; its
    /// transpose is the force of a unit of pressure there.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`] with the names there are.
    pub(super) fn pressure(
        surface: &Surface,
        patches: &[&str],
        inside: impl Fn(&Point3<f64>) -> bool,
    ) -> Result<Self, MeshError> {
        let points = points_on(surface, patches, inside)?;
        Ok(Self::gathered(spread(surface, &points, |point| -point.normal)))
    }

    /// The same for several regions of the same patches.
    ///
    /// # Errors
    /// As [`Pattern::pressure`].
    pub(super) fn pressures(
        surface: &Surface,
        patches: &[&str],
        regions: &[impl Fn(&Point3<f64>) -> bool],
    ) -> Result<Vec<Self>, MeshError> {
        let wanted = numbers(surface, patches)?;
        let points = points_in(surface, |face| wanted.contains(&face.patch), regions)?;
        let pattern = |points: Vec<QuadraturePoint>| Self::gathered(spread(surface, &points, |point| -point.normal));
        Ok(points.into_iter().map(pattern).collect())
    }

    /// The pattern that reads nothing.
    pub(super) fn nothing() -> Self {
        Self(Vec::new())
    }

    /// Whether it reads nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.0.is_empty()
    }

    /// The sum of two patterns.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self::gathered(self.0.iter().chain(&other.0).copied().collect())
    }

    /// The pattern in the opposite direction.
    pub(super) fn reversed(&self) -> Self {
        Self(self.0.iter().map(|&(dof, w)| (dof, -w)).collect())
    }

    /// As a column over all degrees of freedom.
    pub(super) fn dense(&self, dofs: usize) -> DVector<f64> {
        let mut column = DVector::zeros(dofs);
        for &(dof, weight) in &self.0 {
            column[dof] = weight;
        }
        column
    }

    /// Value of the pattern for every mode: `shapes` is dofs x modes.
    pub(super) fn of_modes(&self, shapes: &DMatrix<f64>) -> DVector<f64> {
        DVector::from_iterator(
            shapes.ncols(),
            shapes
                .column_iter()
                .map(|shape| self.0.iter().map(|&(dof, weight)| weight * shape[dof]).sum()),
        )
    }

    /// Adds up what falls on the same degree of freedom, in rising order.
    fn gathered(mut weights: Vec<(usize, f64)>) -> Self {
        weights.sort_by_key(|&(dof, _)| dof);
        let mut sums: Vec<(usize, f64)> = Vec::new();
        for (dof, weight) in weights {
            match sums.last_mut() {
                Some((last, sum)) if *last == dof => *sum += weight,
                _ => sums.push((dof, weight)),
            }
        }
        Self(sums)
    }
}

/// Cells along each side of a face when only a part of it counts: its edge is found to a thirtieth of an element.
const CELLS: usize = 16;

/// Points of patches where `inside` holds, each with its area: on a fine grid of every face, exact for none and all of it.
fn points_on(
    surface: &Surface,
    patches: &[&str],
    inside: impl Fn(&Point3<f64>) -> bool,
) -> Result<Vec<QuadraturePoint>, MeshError> {
    let wanted = numbers(surface, patches)?;
    points_where(surface, |face| wanted.contains(&face.patch), inside)
}

/// Numbers of patches by name.
fn numbers(surface: &Surface, patches: &[&str]) -> Result<Vec<usize>, MeshError> {
    patches.iter().map(|name| surface.patch(name)).collect()
}

/// Points of the faces that are wanted where `inside` holds, as in [`points_on`].
fn points_where(
    surface: &Surface,
    wanted: impl Fn(&SurfaceFace) -> bool,
    inside: impl Fn(&Point3<f64>) -> bool,
) -> Result<Vec<QuadraturePoint>, MeshError> {
    Ok(points_in(surface, wanted, &[inside])?.pop().unwrap_or_default())
}

/// The same for several regions: every face is divided once.
fn points_in(
    surface: &Surface,
    wanted: impl Fn(&SurfaceFace) -> bool,
    regions: &[impl Fn(&Point3<f64>) -> bool],
) -> Result<Vec<Vec<QuadraturePoint>>, MeshError> {
    let mut found = vec![Vec::new(); regions.len()];
    for (index, face) in surface.faces.iter().enumerate() {
        if !wanted(face) {
            continue;
        }
        let at = |rule: Vec<([f64; 2], f64)>| {
            rule.into_iter().map(move |(xi, weight)| {
                let mut point = surface.point_at(index, xi);
                point.weight *= weight;
                point
            })
        };
        let mut divided: Option<Vec<QuadraturePoint>> = None;
        for (inside, found) in regions.iter().zip(&mut found) {
            if face.nodes.iter().all(|&node| inside(&surface.points[node])) {
                found.extend(at(face.kind.rule(4)?));
            } else {
                let divided = divided.get_or_insert_with(|| at(grid(face.kind)).collect());
                found.extend(divided.iter().filter(|point| inside(&point.position)));
            }
        }
    }
    Ok(found)
}

/// Centroids of equal cells of a face in natural coordinates, with their areas there.
fn grid(kind: FaceKind) -> Vec<([f64; 2], f64)> {
    let n = CELLS as f64;
    let mut cells = Vec::with_capacity(CELLS * CELLS);
    for i in 0..CELLS {
        for j in 0..CELLS {
            let (x, y) = (i as f64, j as f64);
            if kind.corners() == 4 {
                let at = |k: f64| 2.0 * (k + 0.5) / n - 1.0;
                cells.push(([at(x), at(y)], 4.0 / (n * n)));
                continue;
            }
            let area = 0.5 / (n * n);
            if i + j < CELLS {
                cells.push(([(x + 1.0 / 3.0) / n, (y + 1.0 / 3.0) / n], area));
            }
            if i + j + 1 < CELLS {
                cells.push(([(x + 2.0 / 3.0) / n, (y + 2.0 / 3.0) / n], area));
            }
        }
    }
    cells
}

/// Weights of the integral of N_a v over points, v per unit area.
fn spread(
    surface: &Surface,
    points: &[QuadraturePoint],
    value: impl Fn(&QuadraturePoint) -> Vector3<f64>,
) -> Vec<(usize, f64)> {
    let mut weights = Vec::new();
    let mut at_nodes: Vec<Vector3<f64>> = Vec::new();
    // Summed face by face: a face may have hundreds of points.
    for of_face in points.chunk_by(|a, b| a.face == b.face) {
        let nodes = &surface.faces[of_face[0].face].nodes;
        at_nodes.clear();
        at_nodes.resize(nodes.len(), Vector3::zeros());
        for point in of_face {
            let v = value(point) * point.weight;
            for (sum, &share) in at_nodes.iter_mut().zip(&point.shape) {
                *sum += v * share;
            }
        }
        for (&node, sum) in nodes.iter().zip(&at_nodes) {
            let first = 3 * surface.volume_nodes[node];
            let along = (0..3).filter(|&axis| sum[axis] != 0.0);
            weights.extend(along.map(|axis| (first + axis, sum[axis])));
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_meshes::{Block, block};

    fn mesh() -> Mesh {
        block(&Block {
            size: [0.4, 0.15, 0.1],
            divisions: [7, 3, 2],
            origin: [-0.2, -0.075, 0.0],
        })
        .unwrap()
    }

    #[test]
    fn a_patch_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let rectangle = Rectangle {
            centre: [0.03, -0.01],
            size: [0.11, 0.05],
            height: 0.1,
        };
        let pattern = Pattern::patch(&mesh, "top", rectangle).unwrap();
        let field = |p: &Point3<f64>| 1.0 + 2.0 * p.x - 3.0 * p.y;
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            if dof % 3 == 2 { field(&mesh.nodes[dof / 3]) } else { 9.0 }
        });
        let expected = field(&Point3::new(0.03, -0.01, 0.1));
        assert!((pattern.of_modes(&u)[0] - expected).abs() < 1e-12);
        assert!((pattern.reversed().of_modes(&u)[0] + expected).abs() < 1e-12);
        assert!((pattern.dense(u.nrows()).dot(&u.column(0)) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_panel_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let centre = Point3::new(0.2, 0.01, 0.05);
        let sides = [Vector3::y() * 0.1, Vector3::z() * 0.06];
        let pattern = Pattern::panel(&mesh, "x_max", (centre, sides), Vector3::new(0.0, -2.0, 1.0)).unwrap();
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            let p = mesh.nodes[dof / 3];
            [7.0, p.y + 2.0 * p.z, 3.0 * p.y][dof % 3]
        });
        let expected = -2.0 * (centre.y + 2.0 * centre.z) + 3.0 * centre.y;
        assert!((pattern.of_modes(&u)[0] - expected).abs() < 1e-12);
    }

    #[test]
    fn traction_on_a_disc_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let surface = Surface::of(&mesh);
        let (centre, radius) = (Point3::new(0.03, -0.01, 0.1), 0.04);
        let inside = |p: &Point3<f64>| (p - centre).norm() < radius;
        let pattern = Pattern::traction(&surface, "top", Vector3::z(), inside)
            .unwrap()
            .unwrap();
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            let p = &mesh.nodes[dof / 3];
            if dof % 3 == 2 { 1.0 + 2.0 * p.x - 3.0 * p.y } else { 9.0 }
        });
        let expected = 1.0 + 2.0 * centre.x - 3.0 * centre.y;
        assert!(
            (pattern.of_modes(&u)[0] - expected).abs() < 1e-3,
            "{}",
            pattern.of_modes(&u)[0]
        );
        let foot = Pattern::foot(&surface, (centre, radius), Vector3::z())
            .unwrap()
            .unwrap();
        assert!((foot.of_modes(&u)[0] - expected).abs() < 1e-3);
        let beside = Point3::new(0.0, 0.0, 0.2);
        assert!(
            Pattern::foot(&surface, (beside, radius), Vector3::z())
                .unwrap()
                .is_none()
        );
        assert!(
            Pattern::traction(&surface, "top", Vector3::z(), |_| false)
                .unwrap()
                .is_none()
        );
        assert!(Pattern::traction(&surface, "lid", Vector3::z(), |_| true).is_err());
    }

    #[test]
    fn pressure_on_a_whole_skin_sweeps_the_change_of_volume_and_moves_nothing() {
        let mesh = mesh();
        let surface = Surface::of(&mesh);
        let every: Vec<&str> = surface.patches.iter().map(String::as_str).collect();
        let pattern = Pattern::pressure(&surface, &every, |_| true).unwrap();
        // Columns: uniform shrinking by 1, shift along x.
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 2, |dof, column| match column {
            0 => -mesh.nodes[dof / 3][dof % 3] / 3.0,
            _ => f64::from(dof % 3 == 0),
        });
        let swept = pattern.of_modes(&u);
        assert!((swept[0] - 0.4 * 0.15 * 0.1).abs() < 1e-15 && swept[1].abs() < 1e-15);
        let twice = pattern.plus(&pattern);
        assert!((twice.of_modes(&u)[0] - 2.0 * swept[0]).abs() < 1e-15);
    }

    #[test]
    fn a_point_outside_is_refused() {
        assert!(matches!(
            Pattern::point(&mesh(), Point3::new(0.0, 0.0, 0.2)),
            Err(MeshError::Outside { .. })
        ));
    }
}
