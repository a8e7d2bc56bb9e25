//! Load vectors of a finite-element body: weights on its degrees of freedom.
//!
//! A load vector b extracts a displacement d = b . u and distributes a force F as b F, so that F d is work. If two
//! bodies exchange a force through one pair of load vectors, energy is conserved.

use nailnoise_meshes::{FaceKind, Mesh, MeshError, QuadraturePoint, Surface, SurfaceFace, gauss_legendre};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use serde::Serialize;

/// Sparse weights on the degrees of freedom 3 node + axis of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadVector(Vec<(usize, f64)>);

/// A plane rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Centre \[m\].
    pub centre: Point3<f64>,
    /// Two perpendicular sides \[m\].
    pub sides: [Vector3<f64>; 2],
}

impl Rectangle {
    /// Creates a rectangle in the plane z = `centre.z` with the given side lengths along x and y \[m\].
    pub fn horizontal(centre: Point3<f64>, [length, width]: [f64; 2]) -> Self {
        Self {
            centre,
            sides: [Vector3::x() * length, Vector3::y() * width],
        }
    }
}

/// Number of Gauss points along each side of a rectangle: enough for a patch that covers several quadratic elements.
const RECTANGLE_POINTS: usize = 6;

/// Largest distance of a face from the plane of a rectangle \[m\].
const PLANE_TOLERANCE: f64 = 1e-6;

impl LoadVector {
    /// Mean displacement along `direction` over a rectangle on a face group; the transpose is a uniform traction.
    ///
    /// # Errors
    /// [`MeshError::Outside`] unless the entire rectangle lies on the group.
    pub fn rectangle(
        mesh: &Mesh,
        group: &str,
        rectangle: &Rectangle,
        direction: Vector3<f64>,
    ) -> Result<Self, MeshError> {
        let Rectangle { centre, sides } = rectangle;
        let rule = gauss_legendre(RECTANGLE_POINTS);
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
        Ok(Self::summed(weights))
    }

    /// Displacement along a unit vector of a point that may be up to `reach` \[m\] outside the mesh.
    ///
    /// # Errors
    /// [`MeshError::Outside`] if it is farther away.
    pub fn point(mesh: &Mesh, point: Point3<f64>, direction: Vector3<f64>, reach: f64) -> Result<Self, MeshError> {
        let place = mesh.locate_within(point, reach)?;
        let of_node = |(&node, &w): (&usize, &f64)| [0, 1, 2].map(|axis| (3 * node + axis, w * direction[axis]));
        Ok(Self::summed(
            place.nodes.iter().zip(&place.weights).flat_map(of_node).collect(),
        ))
    }

    /// Mean displacement along a unit vector over the part of a patch where `inside` is true; the transpose is a
    /// uniform traction with a total force of 1. `None` if no point of the patch is inside.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], with the available names.
    pub fn traction(
        surface: &Surface,
        patch: &str,
        direction: Vector3<f64>,
        inside: impl Fn(&Point3<f64>) -> bool,
    ) -> Result<Option<Self>, MeshError> {
        let points = points_on(surface, &[patch], inside)?;
        let area: f64 = points.iter().map(|point| point.weight).sum();
        let weights = spread(surface, &points, |_| direction / area);
        Ok((area > 0.0).then(|| Self::summed(weights)))
    }

    /// Mean displacement along a unit vector of the surface within a radius \[m\] of a point; `None` if no face is that
    /// near.
    ///
    /// # Errors
    /// None for a valid mesh.
    pub fn disc(
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
        Ok((area > 0.0).then(|| Self::summed(weights)))
    }

    /// Volume swept into the body by the parts of patches where `inside` is true, per unit of displacement \[m2\]; the
    /// transpose is the force of a unit pressure there.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], with the available names.
    pub fn pressure(
        surface: &Surface,
        patches: &[&str],
        inside: impl Fn(&Point3<f64>) -> bool,
    ) -> Result<Self, MeshError> {
        let points = points_on(surface, patches, inside)?;
        Ok(Self::summed(spread(surface, &points, |point| -point.normal)))
    }

    /// Same as [`Self::pressure`] for several regions of the same patches.
    ///
    /// # Errors
    /// Same as [`Self::pressure`].
    pub fn pressures(
        surface: &Surface,
        patches: &[&str],
        regions: &[impl Fn(&Point3<f64>) -> bool],
    ) -> Result<Vec<Self>, MeshError> {
        let wanted = numbers(surface, patches)?;
        let points = points_in(surface, |face| wanted.contains(&face.patch), regions)?;
        let of_region = |points: Vec<QuadraturePoint>| Self::summed(spread(surface, &points, |point| -point.normal));
        Ok(points.into_iter().map(of_region).collect())
    }

    /// The zero vector.
    pub fn zero() -> Self {
        Self(Vec::new())
    }

    /// Whether all weights are zero.
    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// The sum of two load vectors.
    pub fn plus(&self, other: &Self) -> Self {
        Self::summed(self.0.iter().chain(&other.0).copied().collect())
    }

    /// The load vector in the opposite direction.
    pub fn reversed(&self) -> Self {
        Self(self.0.iter().map(|&(dof, w)| (dof, -w)).collect())
    }

    /// Converts to a dense column over all `dofs` = 3 nodes degrees of freedom.
    pub fn dense(&self, dofs: usize) -> DVector<f64> {
        let mut column = DVector::zeros(dofs);
        for &(dof, weight) in &self.0 {
            column[dof] = weight;
        }
        column
    }

    /// The displacement that it extracts from each mode, one value per column of `shapes` (dofs x modes).
    pub fn participation(&self, shapes: &DMatrix<f64>) -> DVector<f64> {
        DVector::from_iterator(
            shapes.ncols(),
            shapes
                .column_iter()
                .map(|shape| self.0.iter().map(|&(dof, weight)| weight * shape[dof]).sum()),
        )
    }

    /// Sums the weights of each degree of freedom and sorts them.
    fn summed(mut weights: Vec<(usize, f64)>) -> Self {
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

/// Number of cells along each side of a partly covered face; they resolve the edge of a region to a thirtieth of an
/// element.
const CELLS: usize = 16;

/// Quadrature points of patches where `inside` is true, with a fine grid on partly covered faces.
fn points_on(
    surface: &Surface,
    patches: &[&str],
    inside: impl Fn(&Point3<f64>) -> bool,
) -> Result<Vec<QuadraturePoint>, MeshError> {
    let wanted = numbers(surface, patches)?;
    points_where(surface, |face| wanted.contains(&face.patch), inside)
}

/// Indices of patches by name.
fn numbers(surface: &Surface, patches: &[&str]) -> Result<Vec<usize>, MeshError> {
    patches.iter().map(|name| surface.patch(name)).collect()
}

/// Same as [`points_on`] for the faces selected by `wanted`.
fn points_where(
    surface: &Surface,
    wanted: impl Fn(&SurfaceFace) -> bool,
    inside: impl Fn(&Point3<f64>) -> bool,
) -> Result<Vec<QuadraturePoint>, MeshError> {
    Ok(points_in(surface, wanted, &[inside])?.pop().unwrap_or_default())
}

/// Same as [`points_where`] for several regions; every face is subdivided only once.
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

/// Centroids of equal cells of a face in natural coordinates, with their areas in these coordinates.
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

/// Weights of the integral of N_a v over points, where v is per unit area.
fn spread(
    surface: &Surface,
    points: &[QuadraturePoint],
    value: impl Fn(&QuadraturePoint) -> Vector3<f64>,
) -> Vec<(usize, f64)> {
    let mut weights = Vec::new();
    let mut at_nodes: Vec<Vector3<f64>> = Vec::new();
    // Summed by face, because a face may have hundreds of points.
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
    #![allow(clippy::unwrap_used)]

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
    fn a_rectangle_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let rectangle = Rectangle::horizontal(Point3::new(0.03, -0.01, 0.1), [0.11, 0.05]);
        let load = LoadVector::rectangle(&mesh, "top", &rectangle, Vector3::z()).unwrap();
        let field = |p: &Point3<f64>| 1.0 + 2.0 * p.x - 3.0 * p.y;
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            if dof % 3 == 2 { field(&mesh.nodes[dof / 3]) } else { 9.0 }
        });
        let expected = field(&Point3::new(0.03, -0.01, 0.1));
        assert!((load.participation(&u)[0] - expected).abs() < 1e-12);
        assert!((load.reversed().participation(&u)[0] + expected).abs() < 1e-12);
        assert!((load.dense(u.nrows()).dot(&u.column(0)) - expected).abs() < 1e-12);
    }

    #[test]
    fn an_upright_rectangle_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let centre = Point3::new(0.2, 0.01, 0.05);
        let sides = [Vector3::y() * 0.1, Vector3::z() * 0.06];
        let load = LoadVector::rectangle(
            &mesh,
            "x_max",
            &Rectangle { centre, sides },
            Vector3::new(0.0, -2.0, 1.0),
        )
        .unwrap();
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            let p = mesh.nodes[dof / 3];
            [7.0, p.y + 2.0 * p.z, 3.0 * p.y][dof % 3]
        });
        let expected = -2.0 * (centre.y + 2.0 * centre.z) + 3.0 * centre.y;
        assert!((load.participation(&u)[0] - expected).abs() < 1e-12);
    }

    #[test]
    fn traction_on_a_disc_reads_a_linear_displacement_at_its_centre() {
        let mesh = mesh();
        let surface = Surface::of(&mesh);
        let (centre, radius) = (Point3::new(0.03, -0.01, 0.1), 0.04);
        let inside = |p: &Point3<f64>| (p - centre).norm() < radius;
        let load = LoadVector::traction(&surface, "top", Vector3::z(), inside)
            .unwrap()
            .unwrap();
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 1, |dof, _| {
            let p = &mesh.nodes[dof / 3];
            if dof % 3 == 2 { 1.0 + 2.0 * p.x - 3.0 * p.y } else { 9.0 }
        });
        let expected = 1.0 + 2.0 * centre.x - 3.0 * centre.y;
        assert!(
            (load.participation(&u)[0] - expected).abs() < 1e-3,
            "{}",
            load.participation(&u)[0]
        );
        let disc = LoadVector::disc(&surface, (centre, radius), Vector3::z())
            .unwrap()
            .unwrap();
        assert!((disc.participation(&u)[0] - expected).abs() < 1e-3);
        let beside = Point3::new(0.0, 0.0, 0.2);
        assert!(
            LoadVector::disc(&surface, (beside, radius), Vector3::z())
                .unwrap()
                .is_none()
        );
        assert!(
            LoadVector::traction(&surface, "top", Vector3::z(), |_| false)
                .unwrap()
                .is_none()
        );
        assert!(LoadVector::traction(&surface, "lid", Vector3::z(), |_| true).is_err());
    }

    #[test]
    fn pressure_on_a_whole_skin_sweeps_the_change_of_volume_and_moves_nothing() {
        let mesh = mesh();
        let surface = Surface::of(&mesh);
        let every: Vec<&str> = surface.patches.iter().map(String::as_str).collect();
        let load = LoadVector::pressure(&surface, &every, |_| true).unwrap();
        // Columns: uniform contraction by 1, and translation along x.
        let u = DMatrix::from_fn(3 * mesh.nodes.len(), 2, |dof, column| match column {
            0 => -mesh.nodes[dof / 3][dof % 3] / 3.0,
            _ => f64::from(dof % 3 == 0),
        });
        let swept = load.participation(&u);
        assert!((swept[0] - 0.4 * 0.15 * 0.1).abs() < 1e-15 && swept[1].abs() < 1e-15);
        let twice = load.plus(&load);
        assert!((twice.participation(&u)[0] - 2.0 * swept[0]).abs() < 1e-15);
    }

    #[test]
    fn a_point_outside_is_refused() {
        assert!(matches!(
            LoadVector::point(&mesh(), Point3::new(0.0, 0.0, 0.2), Vector3::z(), 0.0),
            Err(MeshError::Outside { .. })
        ));
    }
}
