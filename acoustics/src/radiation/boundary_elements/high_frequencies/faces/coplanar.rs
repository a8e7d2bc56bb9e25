//! Groups coplanar panels into faces, and finds the walls that a face adjoins.

use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::symmetry::Image;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Largest difference between normals of one plane, and largest distance of its points from the plane relative to the
/// size of the body.
const FLAT: f64 = 1e-6;

/// A reflecting plane perpendicular to a face: a point in it, and its unit normal into the air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) at: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
}

/// Adjacent panels in one plane.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub(super) panels: Vec<usize>,
    /// Images in the mirror planes across which the face continues, beginning with the face itself.
    pub(super) images: Vec<Image>,
    pub(super) wall: Option<Wall>,
}

/// Normals and neighbours of panels.
pub(super) struct CoplanarPanels<'a> {
    boundary: &'a Boundary,
    /// Normal of each flat panel.
    pub(super) normals: Vec<Option<Vector3<f64>>>,
    /// Neighbours across edges: the panel, and a point of the edge.
    beyond: Vec<Vec<(usize, Vector3<f64>)>>,
    size: f64,
}

impl<'a> CoplanarPanels<'a> {
    pub(super) fn new(boundary: &'a Boundary) -> Self {
        let mesh = boundary.mesh();
        let size = boundary.extents().norm();
        let normal = |p: usize| {
            let panel = &mesh.panels[p];
            let at = mesh.points[panel.nodes()[0]];
            let normal = mesh.point_at(p, panel.kind().centre()).area_vector().normalize();
            let off = |&n: &usize| (mesh.points[n] - at).dot(&normal).abs();
            panel.nodes().iter().all(|n| off(n) <= FLAT * size).then_some(normal)
        };
        let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
        let mut beyond = vec![Vec::new(); mesh.panels.len()];
        for (p, panel) in mesh.panels.iter().enumerate() {
            let c = panel.corners();
            for k in 0..c.len() {
                let (a, b) = (c[k], c[(k + 1) % c.len()]);
                if let Some(q) = edges.insert((a.min(b), a.max(b)), p) {
                    let at = mesh.points[a].coords;
                    beyond[p].push((q, at));
                    beyond[q].push((p, at));
                }
            }
        }
        Self {
            boundary,
            normals: (0..mesh.panels.len()).map(normal).collect(),
            beyond,
            size,
        }
    }

    /// Groups of coplanar panels; each curved panel forms a separate group.
    pub(super) fn groups(&self) -> Vec<Vec<usize>> {
        let mut known = vec![false; self.normals.len()];
        let mut groups = Vec::new();
        for seed in 0..self.normals.len() {
            if std::mem::replace(&mut known[seed], true) {
                continue;
            }
            let (mut group, mut next) = (vec![seed], 0);
            while next < group.len() {
                let p = group[next];
                next += 1;
                for &(q, _) in &self.beyond[p] {
                    let together = self.normals[p]
                        .zip(self.normals[q])
                        .is_some_and(|(a, b)| a.dot(&b) > 1.0 - FLAT);
                    if together && !std::mem::replace(&mut known[q], true) {
                        group.push(q);
                    }
                }
            }
            groups.push(group);
        }
        groups
    }

    pub(super) fn face(&self, panels: Vec<usize>) -> Face {
        let (Some(normal), mesh) = (self.normals[panels[0]], self.boundary.mesh()) else {
            return Face {
                panels,
                images: vec![Image::default()],
                wall: None,
            };
        };
        let mut touched = 0u8;
        for panel in panels.iter().map(|&p| &mesh.panels[p]) {
            let c = panel.corners();
            let in_planes = |k: usize| {
                self.boundary
                    .node_of(c[k % c.len()])
                    .map_or(0, |n| self.boundary.in_planes(n))
            };
            (0..c.len()).for_each(|k| touched |= in_planes(k) & in_planes(k + 1));
        }
        let continues = |axis: usize| touched & (1 << axis) != 0 && normal[axis].abs() < FLAT;
        let planes = self.boundary.planes();
        let floor = planes[2].filter(|_| continues(2)).map(|z| Wall {
            at: Vector3::new(0.0, 0.0, z),
            normal: Vector3::z(),
        });
        let across = [0, 1].map(|axis| planes[axis].filter(|_| continues(axis)));
        let wall = floor.or_else(|| self.wall(&panels, normal, across.map(|plane| plane.is_some())));
        Face {
            panels,
            images: Image::all(&[across[0], across[1], None]),
            wall,
        }
    }

    /// The perpendicular face that this one adjoins, if this face lies entirely on its outer side.
    fn wall(&self, panels: &[usize], normal: Vector3<f64>, across: [bool; 2]) -> Option<Wall> {
        let mesh = self.boundary.mesh();
        let centre = |p: usize| mesh.point_at(p, mesh.panels[p].kind().centre()).position.coords;
        let neighbours = panels.iter().flat_map(|&p| &self.beyond[p]);
        let walls = neighbours.filter_map(|&(q, at)| {
            let wall = Wall {
                at,
                normal: self.normals[q]?,
            };
            let rises = (centre(q) - at).dot(&normal) > FLAT * self.size;
            let upright = wall.normal.dot(&normal).abs() < FLAT;
            let own = (0..2).all(|axis| !across[axis] || wall.normal[axis].abs() < FLAT);
            let above = |&p: &usize| {
                let corners = mesh.panels[p].corners();
                corners
                    .iter()
                    .all(|&n| (mesh.points[n].coords - at).dot(&wall.normal) >= -FLAT * self.size)
            };
            (rises && upright && own && panels.iter().all(above)).then_some(wall)
        });
        walls.into_iter().next()
    }
}
