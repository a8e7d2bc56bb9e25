//! Finer panels of the same surface for higher frequencies.
//!
//! Triangles are bisected at their longest edges until no edge is longer than wanted. A panel whose neighbour is cut
//! at their common edge is bisected too, its longest edge first, so that no panel ends within the edge of another and
//! angles stay above half the smallest that there was (Rivara, *Int. J. Numer. Methods Eng.* 20, 745 (1984)).
//! Quadrilaterals that must be cut become two triangles before. All new points lie on the given panels: the surface
//! stays as it is, and shape functions of the given panels state their motion.

use super::gaps::{RIM_WIDTH, Rim, longest_side};
use super::panel::{BoundaryMesh, MOST_NODES, Panel, PanelShape};
use crate::checks::{InputError, positive, same_length};
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Point3, Vector3};
use std::collections::{BTreeSet, HashMap};

/// Prevents rounding from cutting edges of exactly the wanted length.
const SLACK: f64 = 1e-10;

/// A finer mesh of a surface.
#[derive(Clone, Debug)]
pub struct Subdivision {
    /// The finer mesh: the points of the given one, and behind them new ones.
    pub mesh: BoundaryMesh,
    /// The given panel that each panel is part of.
    pub parents: Vec<usize>,
    /// For each new point, the nodes of the given panel that contains it, and the shape functions there.
    added: Vec<([usize; MOST_NODES], [f64; MOST_NODES])>,
}

impl Subdivision {
    /// Displacement fields at the points of the given mesh, (3 x points) x modes, at the points of this one.
    ///
    /// # Errors
    /// [`InputError::Length`] for another number of rows.
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
    /// The same surface in panels whose corners are at most `edge` \[m\] apart along each side; panels that need not
    /// be cut stay as they are.
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn subdivided(&self, edge: f64) -> Result<Subdivision, InputError> {
        let square = (positive("length of edges [m]", edge)? * (1.0 + SLACK)).powi(2);
        Ok(self.bisected(&|_| square))
    }

    /// As [`BoundaryMesh::subdivided`], and with sides of at most half the height of a gap at its `rims`, which grow
    /// with the distance from them.
    ///
    /// If the `rims` need more panels than `most`, the panels at the rims are made wider by powers of two. `edge` alone
    /// may still give more panels than `most`.
    ///
    /// # Errors
    /// A length that is not positive.
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

    /// The same surface in panels whose sides have squares of at most `limit` of their ends \[m²\].
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

/// Largest square of the length of an edge between two points \[m²\].
type Limit<'a> = &'a dyn Fn([Point3<f64>; 2]) -> f64;

/// A triangle of the finer mesh.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// The given panel that it is part of.
    parent: usize,
    /// Points.
    corners: [usize; 3],
    /// Natural coordinates of the corners in the given panel.
    xi: [[f64; 2]; 3],
}

impl Triangle {
    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [key(a, b), key(b, c), key(c, a)]
    }
}

/// An edge, whichever panel it belongs to.
fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// Panels on the way to a finer mesh.
struct Bisection<'a> {
    given: &'a BoundaryMesh,
    points: Vec<Point3<f64>>,
    added: Vec<([usize; MOST_NODES], [f64; MOST_NODES])>,
    /// Points in the middle of edges.
    middles: HashMap<(usize, usize), usize>,
    triangles: Vec<Triangle>,
    /// Given panels of four corners that are not cut.
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

    /// Number of a triangle's longest edge; the same for every triangle at edges of equal length.
    fn longest(&self, triangle: &Triangle) -> usize {
        let edges = triangle.edges();
        let longer = |&i: &usize, &j: &usize| {
            let of = |k: usize| self.square(edges[k]);
            of(i).total_cmp(&of(j)).then(edges[i].cmp(&edges[j]))
        };
        (0..3).max_by(longer).unwrap_or(0)
    }

    /// Edges to be cut: those that are too long, and the longest edge of every triangle with a cut edge.
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
    /// whether there was one.
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

    /// Cuts a triangle at its longest edge if that is marked, and its parts at the other marked edges.
    fn bisect(&mut self, triangle: Triangle, marked: &BTreeSet<(usize, usize)>, finer: &mut Vec<Triangle>) {
        let longest = self.longest(&triangle);
        if !marked.contains(&triangle.edges()[longest]) {
            finer.push(triangle);
            return;
        }
        for half in self.halves(&triangle, longest) {
            // Of its edges only the one opposite to the new point can be marked.
            match half.edges().iter().position(|edge| marked.contains(edge)) {
                Some(edge) => finer.extend(self.halves(&half, edge)),
                None => finer.push(half),
            }
        }
    }

    /// Both parts of a triangle that is cut at an edge.
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

    /// The point in the middle of an edge, and its natural coordinates in the given panel.
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
