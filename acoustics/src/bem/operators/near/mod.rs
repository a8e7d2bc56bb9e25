//! Pairs of panels that touch or are close; each has its own quadrature rule.
//!
//! ```text
//! pairs of blocks -> pairs of panels too close for the far rule
//!   congruent     pairs of the same shape are integrated once
//!   choice        Sauter & Schwab for touching panels; finer product rules or subdivision for others
//!   tables, integrate     shape functions at all points of a rule; the sum over them
//!   flat          the same for triangles with constant normal and curls
//!   cached        expensive shapes, once for all frequencies
//! ```

mod cached;
mod choice;
mod congruent;
mod divide;
mod flat;
mod integrate;
mod matrices;
mod tables;

pub(crate) use matrices::PairMatrices;

use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::symmetry::Image;
use crate::bem::operators::blocks::Block;
use cached::{CachedPairs, KEPT};
use choice::{ClosePair, RATIOS, Rule, Rules};
use congruent::{Congruence, positions};
use divide::{DEPTH, HALVES, divide};
use integrate::Integrate;
use nalgebra::Vector3;
use pulp::Arch;
use rayon::prelude::*;
use std::collections::HashMap;
use tables::Sampled;

/// Smallest distance between the centres of two panels for the far rule, relative to the sum of their radii.
pub(crate) const FAR_RATIO: f64 = RATIOS[0];

/// A pair of panels that the far rule must omit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearPair {
    /// Position of the first panel in its block.
    pub(crate) e: usize,
    /// Position of the second panel in its block.
    pub(crate) f: usize,
    /// The second panel's image, as an index into [`Boundary::images`].
    pub(crate) image: usize,
    /// Its shape, as an index into [`NearField::shapes`].
    shape: u32,
}

/// Properties shared by congruent pairs.
#[derive(Debug)]
struct PairShape {
    /// The first pair of this shape.
    panels: [usize; 2],
    image: usize,
    /// Distance between the panels' centres \[m\].
    apart: f64,
    rules: Vec<Rule>,
    /// Its index among the shapes that are more expensive to integrate than to interpolate: pairs that touch, are
    /// subdivided or need a rule with many points.
    costly: Option<usize>,
    pairs: usize,
}

/// All close pairs of a surface, and the tables that they share.
#[derive(Debug)]
pub(crate) struct NearField {
    rules: Rules,
    /// Pairs for each pair of blocks, at `e_block * blocks + f_block`.
    pairs: Vec<Vec<NearPair>>,
    shapes: Vec<PairShape>,
    /// Shapes that are more expensive to integrate than to interpolate.
    costly: Vec<usize>,
    kept: Option<CachedPairs>,
    blocks: usize,
    images: Vec<Image>,
}

impl NearField {
    /// Finds all close pairs. Pairs of blocks are ordered, e <= f, and so are panels within a block.
    pub(crate) fn new(boundary: &Boundary, blocks: &[Block]) -> Self {
        let mesh = boundary.mesh();
        let spheres: Vec<(Vector3<f64>, f64)> = (0..mesh.panels.len()).map(|p| sphere(mesh, p)).collect();
        let mut field = Self {
            rules: Rules::new(),
            pairs: vec![Vec::new(); blocks.len() * blocks.len()],
            shapes: Vec::new(),
            costly: Vec::new(),
            kept: None,
            blocks: blocks.len(),
            images: boundary.images(),
        };
        let mut known: HashMap<Congruence, u32> = HashMap::new();
        let size = boundary.extents().max();
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
                for number in 0..field.images.len() {
                    let image = field.images[number];
                    let seen = |v: Vector3<f64>| Vector3::from_fn(|axis, _| boundary.mirrored(image, axis, v[axis]));
                    if (reach[i].0 - seen(reach[j].0)).norm() > reach[i].1 + reach[j].1 {
                        continue;
                    }
                    for (e, &p) in eb.panels.iter().enumerate() {
                        for (f, &q) in fb.panels.iter().enumerate().skip(if i == j { e } else { 0 }) {
                            let ((c, r), (d, s)) = (spheres[p], spheres[q]);
                            let apart = (c - seen(d)).norm();
                            let couple = ClosePair {
                                panels: [p, q],
                                image,
                                ratio: apart / (r + s),
                            };
                            if couple.ratio > RATIOS[0] {
                                continue;
                            }
                            let shape = *known
                                .entry(Congruence::of(boundary, &couple, size))
                                .or_insert_with(|| field.add(boundary, &couple, number, apart));
                            field.shapes[shape as usize].pairs += 1;
                            field.pairs[i * blocks.len() + j].push(NearPair {
                                e,
                                f,
                                image: number,
                                shape,
                            });
                        }
                    }
                }
            }
        }
        field
    }

    /// Adds the shape of a pair and returns its index.
    fn add(&mut self, boundary: &Boundary, couple: &ClosePair, image: usize, apart: f64) -> u32 {
        let rules = self.rules.of(boundary, couple);
        let cheap = matches!(rules[..], [Rule::Tables { .. }]) && couple.ratio > RATIOS[1];
        let costly = (!cheap).then(|| {
            self.costly.push(self.shapes.len());
            self.costly.len() - 1
        });
        self.shapes.push(PairShape {
            panels: couple.panels,
            image,
            apart,
            rules,
            costly,
            pairs: 0,
        });
        self.shapes.len() as u32 - 1
    }

    /// Close pairs of two blocks; the first block must not come after the second.
    pub(crate) fn pairs(&self, e_block: usize, f_block: usize) -> &[NearPair] {
        &self.pairs[e_block * self.blocks + f_block]
    }

    /// Number of close pairs.
    pub(crate) fn len(&self) -> usize {
        self.pairs.iter().map(Vec::len).sum()
    }

    /// Number of distinct shapes of close pairs.
    pub(crate) fn shapes(&self) -> usize {
        self.shapes.len()
    }

    /// Number of shapes cached by [`NearField::keep`].
    pub(crate) fn costly(&self) -> usize {
        self.costly.len()
    }

    pub(crate) fn is_kept(&self) -> bool {
        self.kept.is_some()
    }

    /// Memory needed by [`NearField::keep`] \[bytes\].
    pub(crate) fn bytes_shared(&self) -> f64 {
        (self.costly.len() * size_of::<[PairMatrices; KEPT]>()) as f64
    }

    /// Integrates the expensive shapes in advance for all wavenumbers up to `highest`.
    pub(crate) fn keep(&mut self, boundary: &Boundary, highest: f64) {
        let mut kept = CachedPairs::up_to(highest);
        let at_nodes = |&number: &usize| {
            let shape = &self.shapes[number];
            kept.at_nodes(shape.apart, |k, out| self.by_rules(boundary, k, shape, out))
        };
        kept.matrices = self.costly.par_iter().map(at_nodes).collect();
        self.kept = Some(kept);
    }

    /// The near field at one wavenumber.
    pub(crate) fn at<'a>(&'a self, boundary: &'a Boundary, k: f64) -> NearAt<'a> {
        let mut at = NearAt {
            field: self,
            boundary,
            k,
            shared: Vec::new(),
        };
        let one = |shape: &PairShape| (shape.pairs > 1).then(|| Box::new(at.evaluated(shape)));
        at.shared = self.shapes.iter().map(one).collect();
        at
    }

    fn by_rules(&self, boundary: &Boundary, k: f64, shape: &PairShape, out: &mut PairMatrices) {
        let mesh = boundary.mesh();
        let [p, q] = shape.panels;
        let image = self.images[shape.image];
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
        for rule in &shape.rules {
            match *rule {
                Rule::Tables { x, y, weights } => run(
                    &self.rules.tables[x as usize],
                    &self.rules.tables[y as usize],
                    &self.rules.weights[weights as usize],
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

/// The near field at one wavenumber; shapes shared by several pairs are integrated in advance.
pub(crate) struct NearAt<'a> {
    field: &'a NearField,
    boundary: &'a Boundary,
    k: f64,
    shared: Vec<Option<Box<PairMatrices>>>,
}

impl NearAt<'_> {
    /// Close pairs of two blocks; the first block must not come after the second.
    pub(crate) fn pairs(&self, e_block: usize, f_block: usize) -> &[NearPair] {
        self.field.pairs(e_block, f_block)
    }

    /// The matrices of one pair; they are stored in `own` if no other pair shares them.
    pub(crate) fn matrices<'b>(&'b self, pair: &NearPair, own: &'b mut PairMatrices) -> &'b PairMatrices {
        if let Some(known) = &self.shared[pair.shape as usize] {
            return known;
        }
        *own = self.evaluated(&self.field.shapes[pair.shape as usize]);
        own
    }

    fn evaluated(&self, shape: &PairShape) -> PairMatrices {
        let mut out = PairMatrices::default();
        match (shape.costly, &self.field.kept) {
            (Some(number), Some(kept)) if kept.covers(self.k) => kept.add(number, shape.apart, self.k, &mut out),
            _ => self.field.by_rules(self.boundary, self.k, shape, &mut out),
        }
        out
    }
}

/// Centre of a panel's nodes, and the radius of a sphere around it that encloses them.
pub(crate) fn sphere(mesh: &crate::bem::BoundaryMesh, p: usize) -> (Vector3<f64>, f64) {
    let nodes = mesh.panels[p].nodes();
    let corners = mesh.panels[p].corners();
    let middle = corners.iter().map(|&n| mesh.points[n].coords).sum::<Vector3<f64>>() / corners.len() as f64;
    let radius = nodes.iter().map(|&n| (mesh.points[n].coords - middle).norm());
    (middle, radius.fold(0.0, f64::max))
}
