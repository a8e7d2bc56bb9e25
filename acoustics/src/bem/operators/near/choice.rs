//! Chooses the quadrature rule for a pair of close panels.

use super::tables::{Sampled, padded, product, product_weights, whole};
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::rules::{self, Contact, PairNode};
use crate::bem::mesh::symmetry::Image;
use nailnoise_meshes::FaceKind;
use std::collections::HashMap;

/// Gauss points per direction for touching pairs; one less in the direction away from the singularity.
const SINGULAR_ORDER: usize = 4;
/// Ratios of the distance between two panels' centres to the sum of their radii. Above them, the rules with 3, 7, 12
/// and 16 points apply (2 x 2, 3 x 3, 4 x 4 and 5 x 5 on quadrilaterals). Closer panels are subdivided.
pub(super) const RATIOS: [f64; 4] = [2.1, 1.6, 1.2, 0.8];

/// A rule for two panels or their halves.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// Indices of the tables of both sides and of the weights.
    Tables { x: u32, y: u32, weights: u32 },
    /// Subdivision of triangle `s` of the first panel and `t` of the second.
    Divided { s: u8, t: u8 },
}

/// Two panels, the second as an image, and the ratio of the distance between their centres to the sum of their radii.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosePair {
    pub(super) panels: [usize; 2],
    pub(super) image: Image,
    pub(super) ratio: f64,
}

impl ClosePair {
    /// Common corners of the two panels: bit 4a + b for corner a of the first and b of the second.
    pub(super) fn common(&self, boundary: &Boundary) -> u16 {
        let mesh = boundary.mesh();
        let [first, second] = self.panels.map(|p| mesh.panels[p].corners());
        let mut common = 0;
        for (a, &n) in first.iter().enumerate() {
            // An image's node coincides with a real one only in the planes of reflection.
            let node = boundary.node_of(n).unwrap_or(usize::MAX);
            if self.image.fixes(boundary.in_planes(node)) {
                for b in (0..second.len()).filter(|&b| second[b] == n) {
                    common |= 1 << (4 * a + b);
                }
            }
        }
        common
    }
}

/// Key of a table: kind, rule, side, order of the vertices.
type TableKey = (FaceKind, u8, bool, [u8; 3]);

/// Tables and weights of the rules, created on demand.
#[derive(Debug)]
pub(super) struct Rules {
    pub(super) tables: Vec<Sampled>,
    pub(super) weights: Vec<Vec<f64>>,
    table_of: HashMap<TableKey, u32>,
    touching: Vec<Vec<PairNode>>,
    singular_weights: [u32; 3],
    product_weights: HashMap<(usize, usize, usize), u32>,
}

/// Triangles of a panel with this many corners that share the given corner.
fn fan(corners: u8, from: u8) -> impl Iterator<Item = [u8; 3]> {
    (1..corners - 1).map(move |k| [from, (from + k) % corners, (from + k + 1) % corners])
}

impl Rules {
    pub(super) fn new() -> Self {
        let contacts = [Contact::Identical, Contact::Edge, Contact::Vertex];
        let touching: Vec<Vec<PairNode>> = contacts.map(|c| rules::sauter_schwab(c, SINGULAR_ORDER)).into();
        Self {
            tables: Vec::new(),
            weights: touching.iter().map(|r| padded(r.iter().map(|&(_, _, w)| w))).collect(),
            table_of: HashMap::new(),
            touching,
            singular_weights: [0, 1, 2],
            product_weights: HashMap::new(),
        }
    }

    /// The rules of two panels.
    pub(super) fn of(&mut self, boundary: &Boundary, couple: &ClosePair) -> Vec<Rule> {
        let kinds = couple.panels.map(|p| boundary.mesh().panels[p].kind());
        let mask = couple.common(boundary);
        let common = |a: u8, b: u8| mask & (1 << (4 * a + b)) != 0;
        let [m, n] = kinds.map(|k| k.corners() as u8);
        let meeting = (0..m)
            .flat_map(|a| (0..n).map(move |b| (a, b)))
            .find(|&(a, b)| common(a, b));
        let Some((at_p, at_q)) = meeting else {
            if let Some(level) = RATIOS.iter().position(|&r| couple.ratio > r) {
                return vec![self.product(kinds, level)];
            }
            let halves = (0..m - 2).flat_map(|s| (0..n - 2).map(move |t| Rule::Divided { s, t }));
            return halves.collect();
        };
        let mut rules = Vec::new();
        // If the panels are divided along diagonals through a common corner, all halves touch, so that no close pair
        // without contact remains.
        for first in fan(m, at_p) {
            for second in fan(n, at_q) {
                let shared: Vec<(u8, u8)> = first
                    .iter()
                    .flat_map(|&a| second.iter().map(move |&b| (a, b)))
                    .filter(|&(a, b)| common(a, b))
                    .collect();
                let contact = match shared.len() {
                    0 | 1 => Contact::Vertex,
                    2 => Contact::Edge,
                    _ => Contact::Identical,
                };
                let order = |triangle: &[u8; 3], common: Vec<u8>| {
                    let rest = triangle.iter().copied().filter(|c| !common.contains(c));
                    let all: Vec<u8> = common.iter().copied().chain(rest).collect();
                    [all[0], all[1], all[2]]
                };
                let x = order(&first, shared.iter().map(|s| s.0).collect());
                let y = order(&second, shared.iter().map(|s| s.1).collect());
                rules.push(self.singular(kinds, contact, [x, y]));
            }
        }
        rules
    }

    /// A rule for touching triangles with their vertices in the given order.
    fn singular(&mut self, kinds: [FaceKind; 2], contact: Contact, [x, y]: [[u8; 3]; 2]) -> Rule {
        let c = contact as usize;
        let mut table = |kind: FaceKind, side: bool, vertices: [u8; 3]| {
            let corner = vertices.map(|v| kind.natural_nodes()[v as usize]);
            let points = |r: &[PairNode]| -> Vec<[f64; 2]> {
                r.iter()
                    .map(|&(x, y, _)| {
                        let l = if side { y } else { x };
                        [0, 1].map(|d| l[0] * corner[0][d] + l[1] * corner[1][d] + l[2] * corner[2][d])
                    })
                    .collect()
            };
            *self.table_of.entry((kind, c as u8, side, vertices)).or_insert_with(|| {
                self.tables.push(Sampled::new(kind, &points(&self.touching[c])));
                self.tables.len() as u32 - 1
            })
        };
        let (x, y) = (table(kinds[0], false, x), table(kinds[1], true, y));
        // Weights refer to twice the area of the unit triangle; a half of the square is four times as large.
        let quads = kinds.iter().filter(|k| k.corners() == 4).count();
        let weights = if quads == 0 {
            self.singular_weights[c]
        } else {
            let base = self.singular_weights[c] as usize;
            *self.product_weights.entry((usize::MAX, c, quads)).or_insert_with(|| {
                let factor = 4f64.powi(quads as i32);
                let scaled = self.weights[base].iter().map(|w| w * factor).collect();
                self.weights.push(scaled);
                self.weights.len() as u32 - 1
            })
        };
        Rule::Tables { x, y, weights }
    }

    /// A product rule for panels that do not touch.
    fn product(&mut self, kinds: [FaceKind; 2], level: usize) -> Rule {
        let rules = kinds.map(|k| whole(k, level));
        let (x, y) = product(&rules);
        // How often each point of one side is repeated depends on the number of points of the other.
        let key = |side: usize| {
            let other = kinds[1 - side].corners() as u8;
            (kinds[side], 100 + level as u8, side == 1, [other, 0, 0])
        };
        let mut table = |side: usize, points: &[[f64; 2]]| {
            *self.table_of.entry(key(side)).or_insert_with(|| {
                self.tables.push(Sampled::new(kinds[side], points));
                self.tables.len() as u32 - 1
            })
        };
        let (x, y) = (table(0, &x), table(1, &y));
        let weights = *self
            .product_weights
            .entry((level, kinds[0].corners(), kinds[1].corners()))
            .or_insert_with(|| {
                self.weights.push(product_weights(&rules));
                self.weights.len() as u32 - 1
            });
        Rule::Tables { x, y, weights }
    }
}
