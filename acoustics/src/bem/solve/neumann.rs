//! Prescribed normal velocities in the form needed by the equations, prepared once for all frequencies.

use super::cover::CoverPatterns;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::Panel;
use crate::bem::mesh::symmetry::Parity;
use crate::bem::operators::blocks::Block;
use crate::bem::operators::tile::PatternsOnBlocks;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Complex, DMatrix};

/// Normal velocities of one parity about the mirror planes.
#[derive(Clone, Debug)]
pub struct Patterns {
    /// Their parity; even without mirror planes.
    pub parity: Parity,
    /// Corner values of every panel x patterns, see [`Boundary::project`].
    pub velocities: DMatrix<f64>,
}

impl Patterns {
    /// Patterns that are even about the mirror planes.
    pub(crate) fn even(velocities: &DMatrix<f64>) -> Self {
        Self {
            parity: Parity::default(),
            velocities: velocities.clone(),
        }
    }
}

/// The velocity patterns of one parity, and derived quantities that are the same at every frequency.
#[derive(Debug)]
pub(crate) struct NeumannData {
    patterns: Patterns,
    on_blocks: PatternsOnBlocks,
    at_points: Mat<f32>,
    moments: Moments,
    by_patch: Vec<Moments>,
    cover: Option<CoverPatterns>,
}

impl NeumannData {
    /// Prepares patterns with the surface's number of velocity values, given the integrals of phi_i phi_j over each
    /// panel. With a cover, the equations have the additional columns of [`CoverPatterns::columns`].
    pub(crate) fn new(
        (boundary, blocks): (&Boundary, &[Block]),
        masses: &[[[f64; 4]; 4]],
        patterns: Patterns,
        cover: Option<CoverPatterns>,
    ) -> Self {
        let velocities = &patterns.velocities;
        let on_blocks: Vec<Mat<f32>> = blocks.iter().map(|b| b.patterns(velocities)).collect();
        let covered = cover.as_ref().map(|cover| cover.on_covered(velocities));
        let further = |cover: &CoverPatterns, (block, own): (&Block, &Mat<f32>)| {
            let covered = covered.as_ref().map(|covered| block.patterns(covered));
            let parts = [Some(own.clone()), covered, Some(cover.on_block(block))];
            stacked(&parts.into_iter().flatten().collect::<Vec<_>>())
        };
        let in_equations: Option<Vec<Mat<f32>>> = cover
            .as_ref()
            .map(|cover| blocks.iter().zip(&on_blocks).map(|of| further(cover, of)).collect());
        let with_covered = covered.as_ref().map(|covered| {
            let modes = velocities.ncols();
            let mut both = velocities.clone().resize_horizontally(2 * modes, 0.0);
            both.columns_mut(modes, modes).copy_from(covered);
            both
        });
        Self {
            on_blocks: PatternsOnBlocks::new(patterns.parity, in_equations.as_ref().unwrap_or(&on_blocks)),
            at_points: side_by_side(&on_blocks, velocities.ncols()),
            moments: Moments::new(boundary, masses, with_covered.as_ref().unwrap_or(velocities), |_| true),
            by_patch: Moments::by_patch(boundary, masses, velocities),
            cover,
            patterns,
        }
    }

    /// Parity about the mirror planes.
    pub(crate) fn parity(&self) -> Parity {
        self.patterns.parity
    }

    /// Corner values of each panel x patterns.
    pub(crate) fn velocities(&self) -> &DMatrix<f64> {
        &self.patterns.velocities
    }

    /// The patterns themselves.
    pub(crate) fn patterns(&self) -> &Patterns {
        &self.patterns
    }

    /// Number of patterns.
    pub(crate) fn count(&self) -> usize {
        self.patterns.velocities.ncols()
    }

    /// Number of columns in the equations: the patterns, and those of a cover.
    pub(crate) fn columns(&self) -> usize {
        let cover = self.cover.as_ref();
        cover.map_or(self.count(), |cover| cover.columns(self.count()))
    }

    /// The additional patterns of a covered surface.
    pub(crate) fn cover(&self) -> Option<&CoverPatterns> {
        self.cover.as_ref()
    }

    /// Patterns at the points of all blocks, for the products with B.
    pub(crate) fn on_blocks(&self) -> &PatternsOnBlocks {
        &self.on_blocks
    }

    /// Patterns x points of all blocks, see [`at_points`].
    pub(crate) fn at_points(&self) -> &Mat<f32> {
        &self.at_points
    }

    /// int phi_i v dS over the complete surface, of the patterns and of the same on the covered part.
    pub(crate) fn moments(&self) -> &Moments {
        &self.moments
    }

    /// int phi_i v dS over each patch.
    pub(crate) fn by_patch(&self) -> &[Moments] {
        &self.by_patch
    }
}

/// int phi_i v dS for every pattern v.
#[derive(Debug)]
pub(crate) struct Moments {
    /// The unknowns at which the integrals are nonzero.
    nodes: Vec<usize>,
    /// Integrals for these unknowns x patterns.
    values: DMatrix<f64>,
}

impl Moments {
    /// Computes the integrals for each patch.
    pub(crate) fn by_patch(boundary: &Boundary, masses: &[[[f64; 4]; 4]], velocities: &DMatrix<f64>) -> Vec<Self> {
        let mesh = boundary.mesh();
        let numbers = mesh.panels.iter().map(|p| p.patch + 1);
        let patches = numbers.max().unwrap_or(0).max(mesh.patches.len());
        let of_patch = |patch: usize| Self::new(boundary, masses, velocities, |panel| panel.patch == patch);
        (0..patches).map(of_patch).collect()
    }

    /// Computes the integrals over some of the panels.
    fn new(
        boundary: &Boundary,
        masses: &[[[f64; 4]; 4]],
        velocities: &DMatrix<f64>,
        among: impl Fn(&Panel) -> bool,
    ) -> Self {
        let mut rows = vec![None; boundary.nodes()];
        let (mut nodes, mut pieces, mut first) = (Vec::new(), Vec::new(), 0);
        for (panel, mass) in boundary.mesh().panels.iter().zip(masses) {
            if among(panel) {
                let row = |node: usize| {
                    *rows[node].get_or_insert_with(|| {
                        nodes.push(node);
                        nodes.len() - 1
                    })
                };
                let own: Vec<usize> = boundary.unknowns_of(panel).map(row).collect();
                pieces.push((first, own, mass));
            }
            first += panel.corners().len();
        }
        let mut values = DMatrix::zeros(nodes.len(), velocities.ncols());
        for (mut to, v) in values.column_iter_mut().zip(velocities.column_iter()) {
            let v = v.as_slice();
            for (first, own, mass) in &pieces {
                let corners = &v[*first..first + own.len()];
                for (&row, mass) in own.iter().zip(*mass) {
                    to[row] += corners.iter().zip(mass).map(|(v, mass)| v * mass).sum::<f64>();
                }
            }
        }
        Self { nodes, values }
    }

    /// Adds the integrals times `factor` to right-hand sides, unknowns x patterns.
    pub(crate) fn add_to(&self, factor: f64, to: &mut Mat<f64>) {
        for (m, moments) in self.values.column_iter().enumerate() {
            let to = to.col_as_slice_mut(m);
            for (&node, moment) in self.nodes.iter().zip(moments.iter()) {
                to[node] += factor * moment;
            }
        }
    }

    /// `factor` int v_i p_j dS for pressures at all unknowns, unknowns x patterns.
    pub(crate) fn impedance(&self, factor: f64, pressure: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let (modes, columns) = (self.values.ncols(), pressure.ncols());
        // Real parts of all columns, then imaginary parts.
        let mut parts = Mat::<f64>::zeros(self.nodes.len(), 2 * columns);
        for (j, p) in pressure.column_iter().enumerate() {
            let p = p.as_slice();
            let values = |part: fn(&Complex<f64>) -> f64| self.nodes.iter().map(move |&node| part(&p[node]));
            for (column, part) in [(j, values(|z| z.re)), (columns + j, values(|z| z.im))] {
                parts
                    .col_as_slice_mut(column)
                    .iter_mut()
                    .zip(part)
                    .for_each(|(to, p)| *to = p);
            }
        }
        let moments = MatRef::from_column_major_slice(self.values.as_slice(), self.nodes.len(), modes);
        let mut z = Mat::<f64>::zeros(modes, 2 * columns);
        matmul(
            z.as_mut(),
            Accum::Replace,
            moments.transpose(),
            parts.as_ref(),
            factor,
            Par::Seq,
        );
        DMatrix::from_fn(modes, columns, |i, j| Complex::new(z[(i, j)], z[(i, columns + j)]))
    }
}

/// Patterns at the points of the far rule, patterns x points: by block, with the panel index fastest.
pub(crate) fn at_points(blocks: &[Block], velocities: &DMatrix<f64>) -> Mat<f32> {
    let on_blocks: Vec<Mat<f32>> = blocks.iter().map(|b| b.patterns(velocities)).collect();
    side_by_side(&on_blocks, velocities.ncols())
}

/// Concatenates matrices with the same columns.
fn stacked(all: &[Mat<f32>]) -> Mat<f32> {
    let columns = all.first().map_or(0, Mat::ncols);
    let mut joined = Mat::zeros(all.iter().map(Mat::nrows).sum(), columns);
    let mut first = 0;
    for one in all {
        joined.as_mut().subrows_mut(first, one.nrows()).copy_from(one);
        first += one.nrows();
    }
    joined
}

/// Concatenates matrices of `rows` rows.
fn side_by_side(all: &[Mat<f32>], rows: usize) -> Mat<f32> {
    let mut joined = Mat::zeros(rows, all.iter().map(Mat::ncols).sum());
    let mut first = 0;
    for one in all {
        joined.as_mut().subcols_mut(first, one.ncols()).copy_from(one);
        first += one.ncols();
    }
    joined
}
