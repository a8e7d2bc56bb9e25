//! Pairs of panels that touch or lie close, with rules chosen pair by pair.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::blocks::Block;
use super::boundary::Boundary;
use super::panel::{MOST_NODES, PanelShape, Shape};
use super::rules::{self, Contact, Node, PairNode};
use super::symmetry::Image;
use super::trig::{combine, cross, dot, green, load, minus};
use nailnoise_meshes::FaceKind;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Gauss points a direction for pairs that touch.
const SINGULAR_ORDER: usize = 4;
/// Distance of two panels' centres, as a multiple of the sum of their radii, above which the rules of 3, 7, 12 and 25
/// points (2 x 2, 3 x 3, 4 x 4 and 5 x 5 on quadrilaterals) are taken; closer panels are divided.
const RATIOS: [f64; 4] = [2.1, 1.6, 1.2, 0.8];
/// Most divisions of panels that lie close without touching.
const DEPTH: usize = 16;

/// Shape functions at the points of a pair rule, on one side: array by array, padded to whole vectors.
#[derive(Debug)]
struct Sampled {
    padded: usize,
    nodes: usize,
    corners: usize,
    /// N_a, dN_a/dxi, dN_a/deta of the geometry, then phi_i, dphi_i/dxi, dphi_i/deta of the corner functions.
    values: Vec<f64>,
}

impl Sampled {
    fn new(kind: FaceKind, points: &[[f64; 2]]) -> Self {
        Self::repeated(kind, points, 1, points.len())
    }

    /// Each point `each` times, over and over up to `total`: one side of a product rule.
    fn repeated(kind: FaceKind, points: &[[f64; 2]], each: usize, total: usize) -> Self {
        let padded = total.next_multiple_of(8);
        let (nodes, corners) = (kind.nodes(), kind.corners());
        let mut values = vec![0.0; 3 * (nodes + corners) * padded];
        let shapes: Vec<(Shape, Shape)> = points.iter().map(|&xi| (kind.at(xi), kind.linear().at(xi))).collect();
        for q in 0..padded {
            let (shape, linear) = &shapes[(q.min(total - 1) / each) % points.len()];
            for (count, s, start) in [(nodes, shape, 0), (corners, linear, 3 * nodes)] {
                for a in 0..count {
                    values[(start + a) * padded + q] = s.n[a];
                    values[(start + count + a) * padded + q] = s.dn[a][0];
                    values[(start + 2 * count + a) * padded + q] = s.dn[a][1];
                }
            }
        }
        Self {
            padded,
            nodes,
            corners,
            values,
        }
    }
}

/// Nodes of the interpolation of costly pairs over wave number.
const KEPT: usize = 5;

/// How a pair of panels is integrated.
#[derive(Clone, Copy, Debug)]
enum Integration {
    /// By one product rule.
    Whole(Rule),
    /// Pairs that touch, are divided or need a rule of many points, see `NearField::costly`.
    Costly(u32),
}

/// A rule for two panels or their halves.
#[derive(Clone, Copy, Debug)]
enum Rule {
    /// Tables of either side and the weights, by number.
    Tables { x: u32, y: u32, weights: u32 },
    /// By dividing the panels, triangle `s` of the first and `t` of the second.
    Divided { s: u8, t: u8 },
}

/// A pair of panels that the far rule must leave out.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPair {
    /// Position of the first panel in its block.
    pub(super) e: usize,
    /// Position of the second panel in its block.
    pub(super) f: usize,
    /// The second panel's image, by its place in [`Boundary::images`].
    pub(super) image: usize,
    integration: Integration,
}

/// Matrices of one pair: rows are corner functions of the first panel, columns those of the second.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairMatrices {
    /// Integral of phi_i G phi_j.
    pub(super) s: [[Complex<f64>; 4]; 4],
    /// Integral of phi_i dG/dn_y phi_j.
    pub(super) k: [[Complex<f64>; 4]; 4],
    /// Integral of phi_i dG/dn_x phi_j.
    pub(super) kp: [[Complex<f64>; 4]; 4],
    /// Integral of G (curl phi_i . curl phi_j - k² n_x . n_y phi_i phi_j).
    pub(super) w: [[Complex<f64>; 4]; 4],
}

impl PairMatrices {
    fn add_scaled(&mut self, factor: Complex<f64>, other: &Self) {
        let all = [
            (&mut self.s, &other.s),
            (&mut self.k, &other.k),
            (&mut self.kp, &other.kp),
            (&mut self.w, &other.w),
        ];
        for (to, from) in all {
            let entries = to.as_flattened_mut().iter_mut().zip(from.as_flattened());
            entries.for_each(|(to, from)| *to += factor * from);
        }
    }
}

/// All close pairs of a surface and the tables they share.
#[derive(Debug)]
pub(super) struct NearField {
    tables: Vec<Sampled>,
    weights: Vec<Vec<f64>>,
    /// Pairs of each pair of blocks, at `e_block * blocks + f_block`.
    pairs: Vec<Vec<NearPair>>,
    /// Pairs that cost more to integrate than to interpolate.
    costly: Vec<Costly>,
    kept: Option<Kept>,
    blocks: usize,
    images: Vec<Image>,
}

/// A pair that costs more to integrate than to interpolate.
#[derive(Debug)]
struct Costly {
    panels: [usize; 2],
    image: usize,
    /// Distance of the panels' centres \[m\].
    apart: f64,
    rules: Vec<Rule>,
}

/// Costly pairs at [`KEPT`] wave numbers.
///
/// ```text
/// M(k) = e^{-jkr_0} sum_n l_n(k) e^{jk_n r_0} M(k_n)        r_0: distance of the panels' centres
/// ```
///
/// Less the phase of r_0 the kernels vary as e^{-jk(r - r_0)} with |r - r_0| below the sum s of the panels' radii, so
/// that the error is below 2 (k_max s / 4)^N / N!: 1e-4 at six panels a wavelength, a hundredth of it as measured.
#[derive(Debug)]
struct Kept {
    highest: f64,
    nodes: [f64; KEPT],
    matrices: Vec<[PairMatrices; KEPT]>,
}

impl Kept {
    /// Barycentric weights at k of the Chebyshev nodes (they sum to one).
    fn weights(&self, k: f64) -> [f64; KEPT] {
        if let Some(hit) = self.nodes.iter().position(|node| *node == k) {
            return std::array::from_fn(|n| f64::from(u8::from(n == hit)));
        }
        let term = |n: usize| {
            let sine = (PI * (n as f64 + 0.5) / KEPT as f64).sin();
            let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * sine / (k - self.nodes[n])
        };
        let terms: [f64; KEPT] = std::array::from_fn(term);
        let sum: f64 = terms.iter().sum();
        terms.map(|t| t / sum)
    }
}

/// What identifies a table: kind, rule, side, order of the vertices.
type TableKey = (FaceKind, u8, bool, [u8; 3]);

/// Collects tables as pairs ask for them.
struct Builder {
    field: NearField,
    table_of: HashMap<TableKey, u32>,
    rules: Vec<Vec<PairNode>>,
    singular_weights: [u32; 3],
    product_weights: HashMap<(usize, usize, usize), u32>,
}

/// Halves of a quadrilateral, by corners; the first is also the triangle itself.
const HALVES: [[u8; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// Triangles of a panel with so many corners, all with the given corner.
fn fan(corners: u8, from: u8) -> impl Iterator<Item = [u8; 3]> {
    (1..corners - 1).map(move |k| [from, (from + k) % corners, (from + k + 1) % corners])
}

impl NearField {
    /// Finds all close pairs. Blocks come in pairs e <= f; within a block, panels too.
    pub(super) fn new(boundary: &Boundary, blocks: &[Block]) -> Self {
        let mesh = boundary.mesh();
        let spheres: Vec<(Vector3<f64>, f64)> = (0..mesh.panels.len()).map(|p| sphere(mesh, p)).collect();
        let mut builder = Builder::new(blocks.len(), boundary.images());
        let around = |b: &Block| {
            let middle = b.panels.iter().map(|&p| spheres[p].0).sum::<Vector3<f64>>() / b.panels.len() as f64;
            let reach = b
                .panels
                .iter()
                .map(|&p| (spheres[p].0 - middle).norm() + RATIOS[0] * spheres[p].1);
            (middle, reach.fold(0.0, f64::max))
        };
        let reach: Vec<(Vector3<f64>, f64)> = blocks.iter().map(around).collect();
        for (i, eb) in blocks.iter().enumerate() {
            for (j, fb) in blocks.iter().enumerate().skip(i) {
                for number in 0..builder.field.images.len() {
                    let image = builder.field.images[number];
                    let seen = |v: Vector3<f64>| Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, v[axis]));
                    if (reach[i].0 - seen(reach[j].0)).norm() > reach[i].1 + reach[j].1 {
                        continue;
                    }
                    let mut pairs = std::mem::take(&mut builder.field.pairs[i * blocks.len() + j]);
                    for (e, &p) in eb.panels.iter().enumerate() {
                        for (f, &q) in fb.panels.iter().enumerate().skip(if i == j { e } else { 0 }) {
                            let ((c, r), (d, s)) = (spheres[p], spheres[q]);
                            let ratio = (c - seen(d)).norm() / (r + s);
                            if ratio > RATIOS[0] {
                                continue;
                            }
                            let rules = builder.rules_of(boundary, [p, q], image, ratio);
                            let integration = match rules[..] {
                                [one @ Rule::Tables { .. }] if ratio > RATIOS[1] => Integration::Whole(one),
                                _ => {
                                    let apart = (c - seen(d)).norm();
                                    builder.field.costly.push(Costly {
                                        panels: [p, q],
                                        image: number,
                                        apart,
                                        rules,
                                    });
                                    Integration::Costly(builder.field.costly.len() as u32 - 1)
                                }
                            };
                            pairs.push(NearPair {
                                e,
                                f,
                                image: number,
                                integration,
                            });
                        }
                    }
                    builder.field.pairs[i * blocks.len() + j] = pairs;
                }
            }
        }
        builder.field
    }

    /// Close pairs of two blocks, the first not after the second.
    pub(super) fn pairs(&self, e_block: usize, f_block: usize) -> &[NearPair] {
        &self.pairs[e_block * self.blocks + f_block]
    }

    /// Number of pairs integrated one by one.
    pub(super) fn len(&self) -> usize {
        self.pairs.iter().map(Vec::len).sum()
    }

    /// Number of pairs that [`NearField::keep`] keeps.
    pub(super) fn costly(&self) -> usize {
        self.costly.len()
    }

    pub(super) fn is_kept(&self) -> bool {
        self.kept.is_some()
    }

    /// Memory of [`NearField::keep`] \[bytes\].
    pub(super) fn bytes_kept(&self) -> f64 {
        (self.costly.len() * size_of::<[PairMatrices; KEPT]>()) as f64
    }

    /// Integrates the costly pairs once for all wave numbers up to `highest`.
    pub(super) fn keep(&mut self, boundary: &Boundary, highest: f64) {
        let node = |n: usize| 0.5 * highest * (1.0 - (PI * (n as f64 + 0.5) / KEPT as f64).cos());
        let nodes: [f64; KEPT] = std::array::from_fn(node);
        let at_nodes = |pair: &Costly| {
            nodes.map(|k| {
                let (mut raw, mut turned) = (PairMatrices::default(), PairMatrices::default());
                self.by_rules(boundary, k, pair.panels, pair.image, &pair.rules, &mut raw);
                turned.add_scaled(Complex::from_polar(1.0, k * pair.apart), &raw);
                turned
            })
        };
        self.kept = Some(Kept {
            highest,
            nodes,
            matrices: self.costly.par_iter().map(at_nodes).collect(),
        });
    }

    /// The matrices of one pair at the wave number `k`.
    pub(super) fn integrate(
        &self,
        boundary: &Boundary,
        k: f64,
        panels: [usize; 2],
        pair: &NearPair,
        out: &mut PairMatrices,
    ) {
        match (pair.integration, &self.kept) {
            (Integration::Costly(number), Some(kept)) if k <= kept.highest * (1.0 + 1e-9) => {
                let turn = Complex::from_polar(1.0, -k * self.costly[number as usize].apart);
                for (weight, matrices) in kept.weights(k).iter().zip(&kept.matrices[number as usize]) {
                    out.add_scaled(turn * weight, matrices);
                }
            }
            (Integration::Costly(number), _) => {
                let rules = &self.costly[number as usize].rules;
                self.by_rules(boundary, k, panels, pair.image, rules, out);
            }
            (Integration::Whole(rule), _) => self.by_rules(boundary, k, panels, pair.image, &[rule], out),
        }
    }

    fn by_rules(
        &self,
        boundary: &Boundary,
        k: f64,
        [p, q]: [usize; 2],
        image: usize,
        rules: &[Rule],
        out: &mut PairMatrices,
    ) {
        let mesh = boundary.mesh();
        let image = self.images[image];
        let x_nodes = positions(boundary, p, self.images[0]);
        let y_nodes = positions(boundary, q, image);
        let mut run = |x: &Sampled, y: &Sampled, weights: &[f64]| {
            let task = Integrate {
                k,
                x,
                y,
                weights,
                x_nodes: &x_nodes,
                y_nodes: &y_nodes,
                sign: image.handedness(),
                out,
            };
            Arch::new().dispatch(task);
        };
        for rule in rules {
            match *rule {
                Rule::Tables { x, y, weights } => run(
                    &self.tables[x as usize],
                    &self.tables[y as usize],
                    &self.weights[weights as usize],
                ),
                Rule::Divided { s, t } => {
                    let start = [(p, s), (q, t)].map(|(panel, half)| {
                        let kind = mesh.panels[panel].kind();
                        (kind, HALVES[half as usize].map(|c| kind.natural_nodes()[c as usize]))
                    });
                    divide(start, [&x_nodes, &y_nodes], DEPTH, &mut run);
                }
            }
        }
    }
}

impl Builder {
    fn new(blocks: usize, images: Vec<Image>) -> Self {
        let contacts = [Contact::Identical, Contact::Edge, Contact::Vertex];
        let rules: Vec<Vec<PairNode>> = contacts.map(|c| rules::sauter_schwab(c, SINGULAR_ORDER)).into();
        let weights = rules.iter().map(|r| padded(r.iter().map(|&(_, _, w)| w))).collect();
        Self {
            field: NearField {
                tables: Vec::new(),
                weights,
                pairs: vec![Vec::new(); blocks * blocks],
                costly: Vec::new(),
                kept: None,
                blocks,
                images,
            },
            table_of: HashMap::new(),
            rules,
            singular_weights: [0, 1, 2],
            product_weights: HashMap::new(),
        }
    }

    /// The rules of two panels at a distance of `ratio` times the sum of their radii.
    fn rules_of(&mut self, boundary: &Boundary, [p, q]: [usize; 2], image: Image, ratio: f64) -> Vec<Rule> {
        let mesh = boundary.mesh();
        let kinds = [mesh.panels[p].kind(), mesh.panels[q].kind()];
        let node = |panel: usize, corner: u8| {
            let n = boundary
                .node_of(mesh.panels[panel].corners()[corner as usize])
                .unwrap_or(usize::MAX);
            // An image's node coincides with a real one in the planes of reflection only.
            image.fixes(boundary.in_planes(n)).then_some(n)
        };
        let common = |a: u8, b: u8| node(p, a).is_some() && node(p, a) == node(q, b);
        let [m, n] = kinds.map(|k| k.corners() as u8);
        let meeting = (0..m)
            .flat_map(|a| (0..n).map(move |b| (a, b)))
            .find(|&(a, b)| common(a, b));
        let Some((at_p, at_q)) = meeting else {
            if let Some(level) = RATIOS.iter().position(|&r| ratio > r) {
                return vec![self.product(kinds, level)];
            }
            let halves = (0..m - 2).flat_map(|s| (0..n - 2).map(move |t| Rule::Divided { s, t }));
            return halves.collect();
        };
        let mut rules = Vec::new();
        // Halves along the diagonals from a common corner all touch: none is left that is close and does not.
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

    /// A rule for triangles that touch, with their vertices in the given order.
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
                self.field.tables.push(Sampled::new(kind, &points(&self.rules[c])));
                self.field.tables.len() as u32 - 1
            })
        };
        let (x, y) = (table(kinds[0], false, x), table(kinds[1], true, y));
        // Weights refer to the unit triangle's double area; a half of the square measures four times as much.
        let quads = kinds.iter().filter(|k| k.corners() == 4).count();
        let weights = if quads == 0 {
            self.singular_weights[c]
        } else {
            let base = self.singular_weights[c] as usize;
            *self.product_weights.entry((usize::MAX, c, quads)).or_insert_with(|| {
                let factor = 4f64.powi(quads as i32);
                let scaled = self.field.weights[base].iter().map(|w| w * factor).collect();
                self.field.weights.push(scaled);
                self.field.weights.len() as u32 - 1
            })
        };
        Rule::Tables { x, y, weights }
    }

    /// A product rule for panels that do not touch.
    fn product(&mut self, kinds: [FaceKind; 2], level: usize) -> Rule {
        let rules = kinds.map(|k| whole(k, level));
        let (x, y) = product(&rules);
        // Both sides' points depend on how many the other has.
        let key = |side: usize| {
            let other = kinds[1 - side].corners() as u8;
            (kinds[side], 100 + level as u8, side == 1, [other, 0, 0])
        };
        let mut table = |side: usize, points: &[[f64; 2]]| {
            *self.table_of.entry(key(side)).or_insert_with(|| {
                self.field.tables.push(Sampled::new(kinds[side], points));
                self.field.tables.len() as u32 - 1
            })
        };
        let (x, y) = (table(0, &x), table(1, &y));
        let weights = *self
            .product_weights
            .entry((level, kinds[0].corners(), kinds[1].corners()))
            .or_insert_with(|| {
                self.field.weights.push(product_weights(&rules));
                self.field.weights.len() as u32 - 1
            });
        Rule::Tables { x, y, weights }
    }
}

/// The rule of a level on a whole panel; the first level is the far rule.
fn whole(kind: FaceKind, level: usize) -> Vec<Node> {
    match (kind.corners(), level) {
        (3, 0) => rules::triangle(3),
        (3, 1) => rules::triangle(7),
        (3, 2) => rules::triangle(12),
        (3, _) => rules::collapsed(5),
        (_, level) => rules::square(level + 2),
    }
}

fn product(rules: &[Vec<Node>; 2]) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    rules[0]
        .iter()
        .flat_map(|&(x, _)| rules[1].iter().map(move |&(y, _)| (x, y)))
        .unzip()
}

fn product_weights(rules: &[Vec<Node>; 2]) -> Vec<f64> {
    padded(
        rules[0]
            .iter()
            .flat_map(|&(_, w)| rules[1].iter().map(move |&(_, v)| w * v)),
    )
}

fn padded(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = weights.collect();
    all.resize(all.len().next_multiple_of(8), 0.0);
    all
}

/// Centre of a panel's nodes, and the radius around it that holds them.
fn sphere(mesh: &super::BoundaryMesh, p: usize) -> (Vector3<f64>, f64) {
    let nodes = mesh.panels[p].nodes();
    let corners = mesh.panels[p].corners();
    let middle = corners.iter().map(|&n| mesh.points[n].coords).sum::<Vector3<f64>>() / corners.len() as f64;
    let radius = nodes.iter().map(|&n| (mesh.points[n].coords - middle).norm());
    (middle, radius.fold(0.0, f64::max))
}

/// Node positions of a panel's image.
fn positions(boundary: &Boundary, p: usize, image: Image) -> [[f64; 3]; MOST_NODES] {
    let mesh = boundary.mesh();
    let mut all = [[0.0; 3]; MOST_NODES];
    for (slot, &n) in all.iter_mut().zip(mesh.panels[p].nodes()) {
        let x = mesh.points[n];
        *slot = [0, 1, 2].map(|axis| boundary.mirrored(image, axis, x[axis]));
    }
    all
}

/// A triangle in the natural coordinates of a panel.
type Part = (FaceKind, [[f64; 2]; 3]);

/// Halves the longest side of the larger triangle until the two are far enough apart for the 12-point rule: slender
/// triangles lose their length first.
fn divide(
    parts: [Part; 2],
    nodes: [&[[f64; 3]; MOST_NODES]; 2],
    depth: usize,
    run: &mut impl FnMut(&Sampled, &Sampled, &[f64]),
) {
    let place = |(kind, _): Part, nodes: &[[f64; 3]; MOST_NODES], xi: [f64; 2]| {
        let shape = kind.at(xi);
        let mut x = Vector3::zeros();
        for (n, p) in shape.n.iter().zip(nodes).take(kind.nodes()) {
            x += Vector3::from(*p) * *n;
        }
        x
    };
    let sphere = |side: usize| {
        let v = parts[side].1;
        let middle = [0, 1].map(|d| (v[0][d] + v[1][d] + v[2][d]) / 3.0);
        let centre = place(parts[side], nodes[side], middle);
        let reach = v.map(|xi| (place(parts[side], nodes[side], xi) - centre).norm());
        (centre, reach.into_iter().fold(0.0, f64::max))
    };
    let ((c, r), (d, s)) = (sphere(0), sphere(1));
    if depth == 0 || (c - d).norm() > RATIOS[2] * (r + s) {
        let rule = |(_, v): Part| -> Vec<Node> {
            let area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1]);
            let map = |(l, w): Node| {
                let at = |d: usize| v[0][d] + l[0] * (v[1][d] - v[0][d]) + l[1] * (v[2][d] - v[0][d]);
                ([at(0), at(1)], w * area.abs())
            };
            rules::triangle(12).into_iter().map(map).collect()
        };
        let rules = parts.map(rule);
        let points = |side: usize| -> Vec<[f64; 2]> { rules[side].iter().map(|&(xi, _)| xi).collect() };
        let [m, n] = [0, 1].map(|side| rules[side].len());
        let tables = [
            Sampled::repeated(parts[0].0, &points(0), n, m * n),
            Sampled::repeated(parts[1].0, &points(1), 1, m * n),
        ];
        run(&tables[0], &tables[1], &product_weights(&rules));
        return;
    }
    let side = usize::from(s > r);
    let v = parts[side].1;
    let corners = v.map(|xi| place(parts[side], nodes[side], xi));
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let (a, b, opposite) = (v[longest], v[(longest + 1) % 3], v[(longest + 2) % 3]);
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    for piece in [[a, middle, opposite], [middle, b, opposite]] {
        let mut next = parts;
        next[side].1 = piece;
        divide(next, nodes, depth - 1, run);
    }
}

struct Integrate<'a> {
    k: f64,
    x: &'a Sampled,
    y: &'a Sampled,
    weights: &'a [f64],
    x_nodes: &'a [[f64; 3]; MOST_NODES],
    y_nodes: &'a [[f64; 3]; MOST_NODES],
    /// -1 for a second panel that is reflected once or thrice: mirrored tangents turn its normal inward.
    sign: f64,
    out: &'a mut PairMatrices,
}

/// One side of a pair at a vector of points.
struct Side<V, const E: usize> {
    x: [V; 3],
    normal: [V; 3],
    area: V,
    phi: [V; E],
    curl: [[V; 3]; E],
}

#[inline(always)]
fn side<S: Simd, const E: usize>(
    simd: S,
    table: &Sampled,
    at: usize,
    nodes: &[[f64; 3]; MOST_NODES],
    sign: f64,
) -> Side<S::f64s, E> {
    let zero = simd.splat_f64s(0.0);
    let offset = at * S::F64_LANES;
    let (nodes_count, step) = (table.nodes, table.padded);
    let mut sums = [[zero; 3]; 3];
    for a in 0..nodes_count {
        let node = nodes[a];
        let p = [
            simd.splat_f64s(node[0]),
            simd.splat_f64s(node[1]),
            simd.splat_f64s(node[2]),
        ];
        for m in 0..3 {
            let n = load::<S>(&table.values, (m * nodes_count + a) * step + offset);
            for c in 0..3 {
                sums[m][c] = simd.mul_add_e_f64s(n, p[c], sums[m][c]);
            }
        }
    }
    let [x, t1, t2] = sums;
    let sign = simd.splat_f64s(sign);
    let normal = cross(simd, sign, t1, t2);
    let mut side = Side {
        x,
        normal,
        area: simd.sqrt_f64s(dot(simd, normal, normal)),
        phi: [zero; E],
        curl: [[zero; 3]; E],
    };
    for i in 0..E {
        let start = (3 * nodes_count + i) * step + offset;
        side.phi[i] = load::<S>(&table.values, start);
        let d1 = load::<S>(&table.values, start + E * step);
        let d2 = load::<S>(&table.values, start + 2 * E * step);
        side.curl[i] = combine(simd, sign, [d1, d2], t2, t1);
    }
    side
}

impl WithSimd for Integrate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match (self.x.corners, self.y.corners) {
            (3, 3) => self.run::<S, 3, 3>(simd),
            (3, _) => self.run::<S, 3, 4>(simd),
            (_, 3) => self.run::<S, 4, 3>(simd),
            _ => self.run::<S, 4, 4>(simd),
        }
    }
}

impl Integrate<'_> {
    #[inline(always)]
    fn run<S: Simd, const E: usize, const F: usize>(self, simd: S) {
        let zero = simd.splat_f64s(0.0);
        let k = simd.splat_f64s(self.k);
        let k2 = simd.splat_f64s(self.k * self.k);
        // s, k, kp, w; real and imaginary.
        let mut sums = [[[[zero; F]; E]; 2]; 4];
        for at in 0..self.weights.len() / S::F64_LANES {
            let w = load::<S>(self.weights, at * S::F64_LANES);
            let x = side::<S, E>(simd, self.x, at, self.x_nodes, 1.0);
            let y = side::<S, F>(simd, self.y, at, self.y_nodes, self.sign);
            let d = minus(simd, x.x, y.x);
            let scale = simd.mul_f64s(w, simd.splat_f64s(0.25 / PI));
            let [g_re, g_im, h_re, h_im] = green(simd, dot(simd, d, d), k, scale);
            let areas = simd.mul_f64s(x.area, y.area);
            let dn_y = simd.mul_f64s(dot(simd, d, y.normal), x.area);
            let dn_x = simd.neg_f64s(simd.mul_f64s(dot(simd, d, x.normal), y.area));
            let nn = simd.mul_f64s(k2, dot(simd, x.normal, y.normal));
            let (g, h) = ([g_re, g_im], [h_re, h_im]);
            for i in 0..E {
                let mut rows = [[zero; 3]; 2];
                for part in 0..2 {
                    let (g, h) = (simd.mul_f64s(g[part], x.phi[i]), simd.mul_f64s(h[part], x.phi[i]));
                    rows[part] = [simd.mul_f64s(g, areas), simd.mul_f64s(h, dn_y), simd.mul_f64s(h, dn_x)];
                }
                for j in 0..F {
                    let mass = simd.mul_f64s(x.phi[i], y.phi[j]);
                    let curls = simd.negate_mul_add_e_f64s(nn, mass, dot(simd, x.curl[i], y.curl[j]));
                    for part in 0..2 {
                        for m in 0..3 {
                            sums[m][part][i][j] = simd.mul_add_e_f64s(rows[part][m], y.phi[j], sums[m][part][i][j]);
                        }
                        sums[3][part][i][j] = simd.mul_add_e_f64s(g[part], curls, sums[3][part][i][j]);
                    }
                }
            }
        }
        let out = self.out;
        for (m, matrix) in [&mut out.s, &mut out.k, &mut out.kp, &mut out.w]
            .into_iter()
            .enumerate()
        {
            for i in 0..E {
                for j in 0..F {
                    let re = simd.reduce_sum_f64s(sums[m][0][i][j]);
                    let im = simd.reduce_sum_f64s(sums[m][1][i][j]);
                    matrix[i][j] += Complex::new(re, im);
                }
            }
        }
    }
}
