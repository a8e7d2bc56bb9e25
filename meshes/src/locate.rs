//! Locates points in a mesh, and finds the weights that interpolate nodal values there.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix3, Point3, Vector2, Vector3};

use crate::{ElementRef, FaceKind, FaceRef, Mesh, MeshError};

/// Nodes and weights of a point: u(x) = sum of weights\[a\] u(nodes\[a\]). The transpose distributes a force at x to
/// the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Location {
    /// The element that contains the point.
    pub element: usize,
    /// Volume nodes.
    pub nodes: Vec<usize>,
    /// Shape-function values, summing to one.
    pub weights: Vec<f64>,
}

/// Tolerance in natural coordinates beyond the element: points on a common face belong to either element.
const SLACK: f64 = 1e-9;

impl Mesh {
    /// Finds the element that contains `point` \[m\] by Newton's method on x(xi) = point.
    ///
    /// # Errors
    /// [`MeshError::Outside`] if no element does.
    pub fn locate(&self, point: Point3<f64>) -> Result<Location, MeshError> {
        let mut nearest = f64::INFINITY;
        for (element, view) in self.elements().enumerate() {
            let distance = box_distance(view.nodes.iter().map(|&i| self.nodes[i]), point);
            nearest = nearest.min(distance);
            if distance > 0.0 {
                continue;
            }
            let (xi, shape) = invert(self, element, point);
            if view.kind.outside(xi.into()) <= SLACK {
                return Ok(Location {
                    element,
                    nodes: view.nodes.to_vec(),
                    weights: shape,
                });
            }
        }
        Err(outside(point, "the mesh".to_owned(), nearest))
    }

    /// Same as `locate`, for a point that may lie up to `off` \[m\] outside the mesh. The shape functions of the
    /// nearest element are then extrapolated, which is exact for every linear field.
    ///
    /// # Errors
    /// [`MeshError::Outside`] with the distance if the point is farther away.
    pub fn locate_within(&self, point: Point3<f64>, off: f64) -> Result<Location, MeshError> {
        let inside = self.locate(point);
        if !matches!(inside, Err(MeshError::Outside { .. })) {
            return inside;
        }
        let (mut nearest, mut best) = (f64::INFINITY, None);
        for (element, view) in self.elements().enumerate() {
            let nodes = || view.nodes.iter().map(|&i| self.nodes[i]);
            let gap = box_distance(nodes(), point);
            if gap > off {
                nearest = nearest.min(gap);
                continue;
            }
            let (xi, weights) = invert(self, element, point);
            let at = |weights: &[f64]| nodes().zip(weights).map(|(p, w)| p.coords * *w).sum::<Vector3<f64>>();
            // The map of a curved element may not reach points far outside it.
            let missed = (at(&weights) - point.coords).norm() > 1e-10 * box_size(&nodes().collect::<Vec<_>>());
            let (mut shape, mut slope) = (vec![0.0; weights.len()], vec![[0.0; 3]; weights.len()]);
            view.kind.shape(view.kind.clamped(xi.into()), &mut shape, &mut slope);
            let distance = (at(&shape) - point.coords).norm();
            if distance < nearest {
                nearest = distance;
                best = (!missed).then(|| Location {
                    element,
                    nodes: view.nodes.to_vec(),
                    weights,
                });
            }
        }
        best.filter(|_| nearest <= off)
            .ok_or_else(|| outside(point, "the mesh".to_owned(), nearest))
    }

    /// Finds the point of a face group nearest to `point`, which may be up to `tolerance` \[m\] away from the faces.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], or [`MeshError::Outside`] with the distance if no face is that near.
    pub fn locate_on(&self, group: &str, point: Point3<f64>, tolerance: f64) -> Result<Location, MeshError> {
        let mut nearest = f64::INFINITY;
        for &face in &self.group(group)?.faces {
            let nodes = self.face_nodes(face);
            let distance = box_distance(nodes.iter().map(|&i| self.nodes[i]), point);
            nearest = nearest.min(distance);
            if distance > tolerance {
                continue;
            }
            let kind = self.face_kind(face);
            let corners: Vec<Point3<f64>> = nodes.iter().map(|&i| self.nodes[i]).collect();
            let (xi, distance) = project(kind, &corners, point);
            if kind.outside(xi.into()) <= SLACK && distance <= tolerance {
                let (mut shape, mut slope) = ([0.0; 9], [[0.0; 2]; 9]);
                kind.shape(xi.into(), &mut shape, &mut slope);
                return Ok(Location {
                    element: face.element,
                    nodes: nodes.to_vec(),
                    weights: shape[..kind.nodes()].to_vec(),
                });
            }
        }
        Err(outside(point, format!("the face group \"{group}\""), nearest))
    }

    /// Finds weights that interpolate at `point` with the shape functions of the element behind the nearest face of a
    /// group, extrapolated beyond the face if necessary; linear fields are reproduced exactly. If an element is too
    /// curved to reach the point, its tangent at the face is used instead. If several faces are equally near, for
    /// example because the foot point lies on their common edge, the weights are averaged over their elements, so that
    /// a symmetric mesh has symmetric weights. Nodes with zero weight are omitted.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], or [`MeshError::Outside`] if no face is within `tolerance` \[m\] or the elements
    /// behind the nearest faces are singular there.
    pub fn locate_near(&self, group: &str, point: Point3<f64>, tolerance: f64) -> Result<Location, MeshError> {
        let (mut nearest, mut nearest_box) = (f64::INFINITY, f64::INFINITY);
        let mut near: Vec<(FaceRef, Vector2<f64>)> = Vec::new();
        for &face in &self.group(group)?.faces {
            let nodes = self.face_nodes(face);
            let gap = box_distance(nodes.iter().map(|&i| self.nodes[i]), point);
            nearest_box = nearest_box.min(gap);
            let corners: Vec<Point3<f64>> = nodes.iter().map(|&i| self.nodes[i]).collect();
            let size = box_size(&corners);
            let same = SLACK * size;
            if gap > tolerance.min(nearest + same) {
                continue;
            }
            let kind = self.face_kind(face);
            let (xi, distance) = project(kind, &corners, point);
            // If the foot point lies beyond the edge of the face, the distance is estimated from the size of the face.
            let distance = distance.max(kind.outside(xi.into()).max(0.0) * size);
            if distance < nearest - same {
                near.clear();
            }
            if distance <= nearest + same {
                nearest = nearest.min(distance);
                near.push((face, xi));
            }
        }
        let place = || format!("the face group \"{group}\"");
        let Some(&(FaceRef { element, .. }, _)) = near.first() else {
            return Err(outside(point, place(), nearest_box));
        };
        if nearest > tolerance {
            return Err(outside(point, place(), nearest));
        }
        let carried = |&(face, xi): &(FaceRef, Vector2<f64>)| {
            let view = self.element(face.element);
            let by_element = Some(invert(self, face.element, point).1).filter(|shape| self.carries(view, shape, point));
            let by_tangent = || {
                self.tangent(face, xi, point)
                    .filter(|shape| self.carries(view, shape, point))
            };
            Some((view.nodes, by_element.or_else(by_tangent)?))
        };
        let carried: Vec<(&[usize], Vec<f64>)> = near.iter().filter_map(carried).collect();
        if carried.is_empty() {
            return Err(outside(point, place(), nearest));
        }
        let mut weights = BTreeMap::<usize, f64>::new();
        for (&node, weight) in carried.iter().flat_map(|(nodes, shape)| nodes.iter().zip(shape)) {
            *weights.entry(node).or_insert(0.0) += weight / carried.len() as f64;
        }
        weights.retain(|_, weight| weight.abs() > 1e-13);
        Ok(Location {
            element,
            nodes: weights.keys().copied().collect(),
            weights: weights.into_values().collect(),
        })
    }

    /// Whether the weights of an element's nodes reproduce a point. Weights from Newton's method may not do so outside
    /// a strongly curved element.
    fn carries(&self, element: ElementRef<'_>, weights: &[f64], point: Point3<f64>) -> bool {
        let at = |(&node, weight): (&usize, &f64)| self.nodes[node].coords * *weight;
        let x: Vector3<f64> = element.nodes.iter().zip(weights).map(at).sum();
        let size = box_size(&element.nodes.iter().map(|&i| self.nodes[i]).collect::<Vec<_>>());
        (x - point.coords).norm() <= 1e-10 * size
    }

    /// Weights with which the nodes of the element behind a face extrapolate to `point`, from the value and gradient at
    /// natural coordinates of the face; none if the map is singular there.
    fn tangent(&self, face: FaceRef, xi: Vector2<f64>, point: Point3<f64>) -> Option<Vec<f64>> {
        let view = self.element(face.element);
        let (mut on_face, mut unused) = ([0.0; 9], [[0.0; 2]; 9]);
        self.face_kind(face).shape(xi.into(), &mut on_face, &mut unused);
        let natural = view.kind.natural_nodes();
        let corners = view.kind.faces()[face.face].iter().zip(on_face);
        let foot: Vector3<f64> = corners
            .map(|(&node, weight)| Vector3::from(natural[node]) * weight)
            .sum();
        let n = view.kind.nodes();
        let (mut shape, mut slope) = (vec![0.0; n], vec![[0.0; 3]; n]);
        view.kind.shape(view.kind.clamped(foot.into()), &mut shape, &mut slope);
        let (x, jacobian) = position(self, view, &shape, &slope);
        let step = jacobian.lu().solve(&(point.coords - x))?;
        let at_point = |(value, slope): (&f64, &[f64; 3])| value + Vector3::from(*slope).dot(&step);
        Some(shape.iter().zip(&slope).map(at_point).collect())
    }
}

/// The position of natural coordinates in an element, and its derivatives with respect to them.
fn position(mesh: &Mesh, view: ElementRef<'_>, shape: &[f64], slope: &[[f64; 3]]) -> (Vector3<f64>, Matrix3<f64>) {
    let (mut x, mut jacobian) = (Vector3::zeros(), Matrix3::zeros());
    for ((&node, value), slope) in view.nodes.iter().zip(shape).zip(slope) {
        let p = mesh.nodes[node].coords;
        x += p * *value;
        jacobian += p * Vector3::from(*slope).transpose();
    }
    (x, jacobian)
}

/// Diagonal of the bounding box of points \[m\].
fn box_size(points: &[Point3<f64>]) -> f64 {
    let (low, high) = points.iter().fold(
        (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
        |(low, high), p| (low.inf(p), high.sup(p)),
    );
    (high - low).norm()
}

/// Natural coordinates at which an element's map x(xi) equals `point`, by Newton's method, with the shape functions
/// there. For points far outside, the result is not a solution and also lies far outside.
fn invert(mesh: &Mesh, element: usize, point: Point3<f64>) -> (Vector3<f64>, Vec<f64>) {
    let view = mesh.element(element);
    let n = view.kind.nodes();
    let (mut shape, mut slope) = (vec![0.0; n], vec![[0.0; 3]; n]);
    let mut xi = Vector3::from(view.kind.centre());
    for _ in 0..25 {
        view.kind.shape(xi.into(), &mut shape, &mut slope);
        let (x, jacobian) = position(mesh, view, &shape, &slope);
        let Some(step) = jacobian.lu().solve(&(x - point.coords)) else {
            break;
        };
        xi -= step;
        if step.amax() < 1e-13 {
            break;
        }
    }
    view.kind.shape(xi.into(), &mut shape, &mut slope);
    (xi, shape)
}

/// Natural coordinates of the foot of the perpendicular from `point` to a face, and its length, by the Gauss-Newton
/// method.
pub(crate) fn project(kind: FaceKind, corners: &[Point3<f64>], point: Point3<f64>) -> (Vector2<f64>, f64) {
    let (mut shape, mut slope) = ([0.0; 9], [[0.0; 2]; 9]);
    let mut xi = Vector2::from(kind.centre());
    let mut off = Vector3::zeros();
    for _ in 0..25 {
        kind.shape(xi.into(), &mut shape, &mut slope);
        off = -point.coords;
        let mut t = [Vector3::zeros(); 2];
        for (a, p) in corners.iter().enumerate() {
            off += shape[a] * p.coords;
            for k in 0..2 {
                t[k] += slope[a][k] * p.coords;
            }
        }
        let normal = Matrix2::from_fn(|i, j| t[i].dot(&t[j]));
        let Some(step) = normal.lu().solve(&Vector2::new(t[0].dot(&off), t[1].dot(&off))) else {
            break;
        };
        xi -= step;
        if step.amax() < 1e-13 {
            break;
        }
    }
    (xi, off.norm())
}

/// Distance from a point to the bounding box of nodes \[m\]; 0 inside or within rounding.
fn box_distance(nodes: impl Iterator<Item = Point3<f64>>, point: Point3<f64>) -> f64 {
    let (low, high) = nodes.fold(
        (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])),
        |(low, high), p| (low.inf(&p), high.sup(&p)),
    );
    let slack = SLACK * (high - low).norm();
    let gap = (low - point)
        .sup(&(point - high))
        .map(|g| if g <= slack { 0.0 } else { g });
    gap.norm()
}

fn outside(point: Point3<f64>, place: String, distance: f64) -> MeshError {
    MeshError::Outside {
        x: point.x,
        y: point.y,
        z: point.z,
        place,
        distance,
    }
}
