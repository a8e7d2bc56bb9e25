//! Refines the panels of a surface for higher frequencies.
//!
//! Triangles are bisected at their longest edges until no edge is too long. If a panel's neighbour is cut at their
//! common edge, the panel is bisected as well, at its longest edge first. The mesh thus remains conforming, and angles
//! stay above half the smallest initial angle (Rivara, *Int. J. Numer. Methods Eng.* 20, 745 (1984)). Quadrilaterals
//! that must be cut are first divided into two triangles. All new points lie on the original panels: the surface is
//! unchanged, and the shape functions of the original panels give their motion.

use super::gaps::{RIM_WIDTH, Rim, longest_side};
use super::panel::{BoundaryMesh, MOST_NODES, Panel, PanelShape};
use crate::checks::{InputError, positive, same_length};
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Point3, Vector3};
use std::collections::{BTreeSet, HashMap};

/// Prevents rounding from cutting edges of exactly the allowed length.
const SLACK: f64 = 1e-10;

/// A finer mesh of a surface.
#[derive(Clone, Debug)]
pub struct Subdivision {
    /// The finer mesh: the original points, followed by new ones.
    pub mesh: BoundaryMesh,
    /// The original panel that contains each panel.
    pub parents: Vec<usize>,
    /// For each new point, the nodes of the original panel that contains it, and the shape functions there.
    added: Vec<([usize; MOST_NODES], [f64; MOST_NODES])>,
}

impl Subdivision {
    /// Maps displacement fields, (3 x points) x modes, from the points of the original mesh to those of this one.
    ///
    /// # Errors
    /// [`InputError::Length`] if the number of rows is wrong.
    pub fn fields(&self, given: &DMatrix<f64>) -> Result<DMatrix<f64>, InputError> {
        let known = self.mesh.points.len() - self.added.len();
        same_length("rows of the displacements", given.nrows(), 3 * known)?;
        let mut fields = given.clone().resize_vertically(3 * self.mesh.points.len(), 0.0);
        for (mut to, from) in fields.column_iter_mut().zip(given.column_iter()) {
            for (number, (nodes, n)) in self.added.iter().enumerate() {
                for axis in 0..3 {
                    let terms = nodes.iter().zip(n).map(|(node, n)| n * from[3 * node + axis]);
                    to[3 * (known + number) + axis] = terms.sum();
                }
            }
        }
        Ok(fields)
    }
}

impl BoundaryMesh {
    /// The same surface with panels whose sides are at most `edge` \[m\] long, corner to corner; panels that need not
    /// be cut are unchanged.
    ///
    /// # Errors
    /// If `edge` is not positive.
    pub fn subdivided(&self, edge: f64) -> Result<Subdivision, InputError> {
        let square = (positive("length of edges [m]", edge)? * (1.0 + SLACK)).powi(2);
        Ok(self.bisected(&|_| square))
    }

    /// Same as [`BoundaryMesh::subdivided`], with sides of at most half the height of a gap at its `rims`, growing with
    /// the distance from them.
    ///
    /// If the `rims` require more than `most` panels, the panels at the rims are widened by powers of two. The limit
    /// `edge` may still lead to more than `most` panels.
    ///
    /// # Errors
    /// If `edge` is not positive.
    pub fn subdivided_fine_at(&self, edge: f64, rims: &[Rim], most: usize) -> Result<Subdivision, InputError> {
        let plain = self.subdivided(edge)?;
        if rims.is_empty() {
            return Ok(plain);
        }
        let plain = plain.mesh.panels.len();
        let mut width = RIM_WIDTH;
        loop {
            let limit = |ends: [Point3<f64>; 2]| (edge.min(longest_side(rims, ends, width)) * (1.0 + SLACK)).powi(2);
            let finer = self.bisected(&limit);
            if finer.mesh.panels.len() <= most.max(plain) {
                return Ok(finer);
            }
            width *= 2.0;
        }
    }

    /// The same surface with panels whose squared side lengths do not exceed `limit`, a function of the ends of a side
    /// \[m²\].
    fn bisected(&self, limit: Limit<'_>) -> Subdivision {
        let mut bisection = Bisection {
            given: self,
            points: self.points.clone(),
            added: Vec::new(),
            middles: HashMap::new(),
            triangles: Vec::new(),
            quadrilaterals: Vec::new(),
        };
        for (number, panel) in self.panels.iter().enumerate() {
            match panel.corners() {
                &[a, b, c] => {
                    let natural = panel.kind().natural_nodes();
                    let corners = [a, b, c];
                    let xi = [natural[0], natural[1], natural[2]];
                    bisection.triangles.push(Triangle {
                        parent: number,
                        corners,
                        xi,
                    });
                }
                _ => bisection.quadrilaterals.push(number),
            }
        }
        bisection.run(limit);
        bisection.result()
    }
}

/// Largest squared length of an edge between two points \[m²\].
type Limit<'a> = &'a dyn Fn([Point3<f64>; 2]) -> f64;

/// A triangle of the finer mesh.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// The original panel that contains it.
    parent: usize,
    /// Point indices.
    corners: [usize; 3],
    /// Natural coordinates of the corners in the original panel.
    xi: [[f64; 2]; 3],
}

impl Triangle {
    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [key(a, b), key(b, c), key(c, a)]
    }
}

/// Identifies an edge independently of the panel.
fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// Panels during refinement.
struct Bisection<'a> {
    given: &'a BoundaryMesh,
    points: Vec<Point3<f64>>,
    added: Vec<([usize; MOST_NODES], [f64; MOST_NODES])>,
    /// Midpoints of edges.
    middles: HashMap<(usize, usize), usize>,
    triangles: Vec<Triangle>,
    /// Original quadrilaterals that are not cut.
    quadrilaterals: Vec<usize>,
}

impl Bisection<'_> {
    /// Bisects until the squares of all edges are at most `limit`.
    fn run(&mut self, limit: Limit<'_>) {
        loop {
            let marked = self.marked(limit);
            if self.cut_quadrilaterals(&marked, limit) {
                continue;
            }
            if marked.is_empty() {
                return;
            }
            let mut finer = Vec::with_capacity(2 * self.triangles.len());
            for triangle in std::mem::take(&mut self.triangles) {
                self.bisect(triangle, &marked, &mut finer);
            }
            self.triangles = finer;
        }
    }

    fn is_long(&self, (a, b): (usize, usize), limit: Limit<'_>) -> bool {
        self.square((a, b)) > limit([self.points[a], self.points[b]])
    }

    fn square(&self, (a, b): (usize, usize)) -> f64 {
        (self.points[a] - self.points[b]).norm_squared()
    }

    /// Index of a triangle's longest edge; consistent between triangles for edges of equal length.
    fn longest(&self, triangle: &Triangle) -> usize {
        let edges = triangle.edges();
        let longer = |&i: &usize, &j: &usize| {
            let of = |k: usize| self.square(edges[k]);
            of(i).total_cmp(&of(j)).then(edges[i].cmp(&edges[j]))
        };
        (0..3).max_by(longer).unwrap_or(0)
    }

    /// Edges to cut: those that are too long, and the longest edge of every triangle that has an edge to cut.
    fn marked(&self, limit: Limit<'_>) -> BTreeSet<(usize, usize)> {
        let all = self.triangles.iter().flat_map(Triangle::edges);
        let mut marked: BTreeSet<(usize, usize)> = all.filter(|&edge| self.is_long(edge, limit)).collect();
        loop {
            let before = marked.len();
            for triangle in &self.triangles {
                let edges = triangle.edges();
                if edges.iter().any(|edge| marked.contains(edge)) {
                    marked.insert(edges[self.longest(triangle)]);
                }
            }
            if marked.len() == before {
                return marked;
            }
        }
    }

    /// Splits every quadrilateral with a cut or overlong edge into two triangles, along its shorter diagonal. Returns
    /// whether there was any.
    fn cut_quadrilaterals(&mut self, marked: &BTreeSet<(usize, usize)>, limit: Limit<'_>) -> bool {
        let before = self.quadrilaterals.len();
        for number in std::mem::take(&mut self.quadrilaterals) {
            let panel = &self.given.panels[number];
            let (c, natural) = (panel.corners(), panel.kind().natural_nodes());
            let cut = (0..4)
                .map(|k| key(c[k], c[(k + 1) % 4]))
                .any(|edge| marked.contains(&edge) || self.is_long(edge, limit));
            if !cut {
                self.quadrilaterals.push(number);
                continue;
            }
            let halves = if self.square((c[0], c[2])) <= self.square((c[1], c[3])) {
                [[0, 1, 2], [0, 2, 3]]
            } else {
                [[0, 1, 3], [1, 2, 3]]
            };
            self.triangles.extend(halves.map(|half| Triangle {
                parent: number,
                corners: half.map(|k: usize| c[k]),
                xi: half.map(|k| natural[k]),
            }));
        }
        self.quadrilaterals.len() < before
    }

    /// Cuts a triangle at its longest edge if marked, and the resulting triangles at their marked edges.
    fn bisect(&mut self, triangle: Triangle, marked: &BTreeSet<(usize, usize)>, finer: &mut Vec<Triangle>) {
        let longest = self.longest(&triangle);
        if !marked.contains(&triangle.edges()[longest]) {
            finer.push(triangle);
            return;
        }
        for half in self.halves(&triangle, longest) {
            // Of its edges, only the one opposite the new point can be marked.
            match half.edges().iter().position(|edge| marked.contains(edge)) {
                Some(edge) => finer.extend(self.halves(&half, edge)),
                None => finer.push(half),
            }
        }
    }

    /// The two halves of a triangle cut at an edge.
    fn halves(&mut self, triangle: &Triangle, edge: usize) -> [Triangle; 2] {
        let [a, b] = [edge, (edge + 1) % 3];
        let (at, xi) = self.middle(triangle, [a, b]);
        let with = |replaced: usize| {
            let mut half = *triangle;
            (half.corners[replaced], half.xi[replaced]) = (at, xi);
            half
        };
        [with(b), with(a)]
    }

    /// The midpoint of an edge, and its natural coordinates in the original panel.
    fn middle(&mut self, triangle: &Triangle, [a, b]: [usize; 2]) -> (usize, [f64; 2]) {
        let xi = [0, 1].map(|axis| 0.5 * (triangle.xi[a][axis] + triangle.xi[b][axis]));
        let edge = key(triangle.corners[a], triangle.corners[b]);
        if let Some(&known) = self.middles.get(&edge) {
            return (known, xi);
        }
        let panel = &self.given.panels[triangle.parent];
        let shape = panel.kind().at(xi);
        let mut nodes = [panel.nodes()[0]; MOST_NODES];
        nodes[..panel.nodes().len()].copy_from_slice(panel.nodes());
        let terms = nodes
            .iter()
            .zip(shape.n)
            .map(|(&node, n)| n * self.given.points[node].coords);
        let number = self.points.len();
        self.points.push(Point3::from(terms.sum::<Vector3<f64>>()));
        self.added.push((nodes, shape.n));
        self.middles.insert(edge, number);
        (number, xi)
    }

    fn result(mut self) -> Subdivision {
        let (mut panels, mut parents) = (Vec::new(), Vec::new());
        for &number in &self.quadrilaterals {
            panels.push(self.given.panels[number]);
            parents.push(number);
        }
        for triangle in std::mem::take(&mut self.triangles) {
            let parent = self.given.panels[triangle.parent];
            parents.push(triangle.parent);
            if parent.corners() == triangle.corners {
                panels.push(parent);
                continue;
            }
            let mut nodes = triangle.corners.to_vec();
            let mut kind = FaceKind::Tri3;
            if parent.nodes().len() > parent.corners().len() {
                kind = FaceKind::Tri6;
                nodes.extend([[0, 1], [1, 2], [2, 0]].map(|edge| self.middle(&triangle, edge).0));
            }
            panels.extend(Panel::new(kind, &nodes, parent.patch));
        }
        Subdivision {
            mesh: BoundaryMesh {
                points: self.points,
                panels,
                patches: self.given.patches.clone(),
            },
            parents,
            added: self.added,
        }
    }
}
