//! The skin of a mesh: the faces at which a body makes contact and radiates.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap};

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::points;
use crate::{FaceKind, FaceNodes, FaceRef, Mesh, MeshError};

/// The outer faces of a mesh with outward normals, and the volume node of each surface node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Node positions \[m\].
    #[serde(with = "points")]
    pub points: Vec<Point3<f64>>,
    /// The volume node of each point; its components in nodal vectors are at 3 `volume_nodes[i]` + axis.
    pub volume_nodes: Vec<usize>,
    /// The outer faces.
    pub faces: Vec<SurfaceFace>,
    /// Names of the patches: the mesh's face groups, and `unnamed` if an outer face belongs to none.
    pub patches: Vec<String>,
}

/// One face of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SurfaceFace {
    /// Its shape.
    pub kind: FaceKind,
    /// Its nodes, indices into [`Surface::points`], ordered for an outward normal: corners, then mid-side nodes, then
    /// the centre.
    pub nodes: FaceNodes,
    /// Its patch, an index into [`Surface::patches`].
    pub patch: usize,
    /// The face of the volume element behind it.
    pub of: FaceRef,
}

/// A quadrature point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// Index of the face it lies on.
    pub face: usize,
    /// Position \[m\].
    pub position: Point3<f64>,
    /// Outward unit normal.
    pub normal: Vector3<f64>,
    /// Area it represents \[m^2\].
    pub weight: f64,
    /// Values of the face's shape functions at the point, in the order of [`SurfaceFace::nodes`]; zero beyond its
    /// nodes.
    pub shape: [f64; 9],
}

impl Surface {
    /// Extracts the skin of `mesh`: the faces that belong to only one element, in the order of the elements.
    pub fn of(mesh: &Mesh) -> Self {
        let every = |visit: &mut dyn FnMut(FaceRef, [usize; 4])| {
            for (element, view) in mesh.elements().enumerate() {
                for (face, local) in view.kind.faces().iter().enumerate() {
                    // For triangles the last entry remains unused.
                    let mut corners = [usize::MAX; 4];
                    let count = view.kind.face_kind(face).corners();
                    for (corner, &node) in corners.iter_mut().zip(&local[..count]) {
                        *corner = view.nodes[node];
                    }
                    corners.sort_unstable();
                    visit(FaceRef { element, face }, corners);
                }
            }
        };
        // After sorting, a face shared by two elements appears in adjacent entries.
        let mut all = Vec::new();
        every(&mut |_, corners| all.push((corners, all.len())));
        let mut is_outer = vec![false; all.len()];
        all.sort_unstable();
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, number)] = same {
                is_outer[*number] = true;
            }
        }
        drop(all);
        let mut is_outer = is_outer.into_iter();
        let mut patches: Vec<String> = mesh.groups.iter().map(|g| g.name.clone()).collect();
        let patch_of: HashMap<FaceRef, usize> = mesh
            .groups
            .iter()
            .enumerate()
            .flat_map(|(p, g)| g.faces.iter().map(move |&f| (f, p)))
            .collect();
        let mut surface = Self {
            points: Vec::new(),
            volume_nodes: Vec::new(),
            faces: Vec::new(),
            patches: Vec::new(),
        };
        let mut point_of = vec![None; mesh.nodes.len()];
        every(&mut |of, _| {
            if is_outer.next() != Some(true) {
                return;
            }
            let patch = patch_of.get(&of).copied().unwrap_or(mesh.groups.len());
            let nodes = mesh.face_nodes(of).map(|node| {
                *point_of[node].get_or_insert_with(|| {
                    surface.points.push(mesh.nodes[node]);
                    surface.volume_nodes.push(node);
                    surface.points.len() - 1
                })
            });
            surface.faces.push(SurfaceFace {
                kind: mesh.face_kind(of),
                nodes,
                patch,
                of,
            });
        });
        if surface.faces.iter().any(|f| f.patch == mesh.groups.len()) {
            patches.push("unnamed".to_owned());
        }
        surface.patches = patches;
        surface
    }

    /// Index of a patch by name.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], with the available names.
    pub fn patch(&self, name: &str) -> Result<usize, MeshError> {
        self.patches
            .iter()
            .position(|p| p == name)
            .ok_or_else(|| MeshError::UnknownGroup {
                name: name.to_owned(),
                known: self.patches.join(", "),
            })
    }

    /// Quadrature points of degree 2n - 1 on every face in turn: n x n Gauss points on quadrilaterals; see
    /// [`FaceKind::rule`] for triangles.
    ///
    /// With the tangents t = dx/dxi, the normal is t_1 x t_2 / |t_1 x t_2| and the weight w_i w_j |t_1 x t_2|.
    ///
    /// # Errors
    /// [`MeshError::GaussPoints`] unless 1 <= n <= 9 (10 without triangles).
    pub fn quadrature(&self, n: usize) -> Result<Vec<QuadraturePoint>, MeshError> {
        let mut rules = BTreeMap::new();
        let mut points = Vec::with_capacity(self.faces.len() * n * n);
        for (face, f) in self.faces.iter().enumerate() {
            let rule = match rules.entry(f.kind) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(f.kind.rule(n)?),
            };
            for &(xi, weight) in rule.iter() {
                let mut point = self.point_at(face, xi);
                point.weight *= weight;
                points.push(point);
            }
        }
        Ok(points)
    }

    /// The point of a face at natural coordinates `xi`; its weight is just the area factor |t_1 x t_2|.
    pub fn point_at(&self, face: usize, xi: [f64; 2]) -> QuadraturePoint {
        let f = &self.faces[face];
        let (mut shape, mut slope) = ([0.0; 9], [[0.0; 2]; 9]);
        f.kind.shape(xi, &mut shape, &mut slope);
        let (mut x, mut t1, mut t2) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        for (a, &node) in f.nodes.iter().enumerate() {
            let p = self.points[node].coords;
            x += shape[a] * p;
            t1 += slope[a][0] * p;
            t2 += slope[a][1] * p;
        }
        let normal = t1.cross(&t2);
        let weight = normal.norm();
        QuadraturePoint {
            face,
            position: Point3::from(x),
            normal: normal / weight,
            weight,
            shape,
        }
    }

    /// Area of the complete surface \[m^2\].
    pub fn area(&self) -> f64 {
        self.fold(|point| point.weight)
    }

    /// Area of one patch \[m^2\].
    pub fn patch_area(&self, patch: usize) -> f64 {
        self.fold(|point| {
            if self.faces[point.face].patch == patch {
                point.weight
            } else {
                0.0
            }
        })
    }

    /// Centroid of one patch \[m\]; none for a patch without faces.
    pub fn patch_centre(&self, patch: usize) -> Option<Point3<f64>> {
        let points = self.quadrature(2).ok()?;
        let own = points.iter().filter(|point| self.faces[point.face].patch == patch);
        let (area, moment) = own.fold((0.0, Vector3::zeros()), |(area, moment), point| {
            (area + point.weight, moment + point.weight * point.position.coords)
        });
        (area > 0.0).then(|| Point3::from(moment / area))
    }

    /// The enclosed volume by the divergence theorem, V = 1/3 closed integral of x . n dS \[m^3\]. It is meaningful if
    /// the surface [is closed](Self::open_edges), and negative if the faces point inwards.
    pub fn volume(&self) -> f64 {
        self.fold(|point| point.position.coords.dot(&point.normal) * point.weight / 3.0)
    }

    /// Number of edges that do not join two faces of consistent orientation: 0 for a closed, consistently oriented
    /// surface.
    pub fn open_edges(&self) -> usize {
        let mut balance: HashMap<(usize, usize), i32> = HashMap::new();
        for face in &self.faces {
            let corners = face.kind.corners();
            for k in 0..corners {
                let (a, b) = (face.nodes[k], face.nodes[(k + 1) % corners]);
                *balance.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        balance.values().filter(|&&b| b != 0).count()
    }

    fn fold(&self, value: impl Fn(&QuadraturePoint) -> f64) -> f64 {
        // Three points per direction integrate the Jacobian of a plane quadratic face exactly.
        self.quadrature(3)
            .map_or(f64::NAN, |points| points.iter().map(value).sum())
    }
}
