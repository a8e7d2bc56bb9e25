//! Equations of a large surface with a compressed matrix, solved by a block Krylov method.
//!
//! ```text
//! clusters  unknowns bisected in space; pairs of clusters divide the matrix into near and distant blocks
//! points    quadrature points of the far rule around each cluster
//! kernel    rows and columns of a distant block
//! cross     its approximation by adaptive cross approximation, M ~ sum_l u_l v_l^T
//! near      near blocks, from the same tiles and rules as the dense matrix
//! operator  product of all blocks with many columns
//! schwarz   preconditioner: overlapping inverses of the leaves
//! krylov    block GMRES for all patterns at once
//! ```
//!
//! At a fixed number of panels per wavelength, memory grows about as N^1.5 and time as N^1.3, compared with N² and N³
//! for the dense matrix.

mod clusters;
mod cross;
mod distant;
mod equations;
mod kernel;
mod krylov;
mod near;
mod operator;
mod points;
mod schwarz;

use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::symmetry::Parity;
use crate::bem::operators::blocks::Block;
use clusters::{ClusterTree, Partition};
use distant::DistantBlocks;
pub(crate) use equations::Equations;
use faer::Mat;
use kernel::{Images, Kernels};
use krylov::Krylov;
use nalgebra::{Complex, DMatrix};
use near::NearPairs;
use operator::{Compressed, Dense};
use schwarz::Schwarz;

/// Relative accuracy of the compressed matrix and of its solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// Accuracy of every distant block in the Frobenius norm.
    pub(crate) block: f64,
    /// Residual of every pattern relative to its right-hand side.
    pub(crate) residual: f64,
}

/// A surface divided into clusters, for all frequencies.
#[derive(Debug)]
pub(crate) struct CompressedSurface {
    tree: ClusterTree,
    partition: Partition,
    near: NearPairs,
    distant: DistantBlocks,
    /// Index of the first corner value of each panel of the mesh.
    first_value: Vec<usize>,
}

impl CompressedSurface {
    pub(crate) fn new(boundary: &Boundary, blocks: &[Block]) -> Self {
        let tree = ClusterTree::new(boundary);
        let partition = tree.partition();
        let distant = DistantBlocks::new(boundary, &tree);
        let corners = boundary.mesh().panels.iter().map(|p| p.corners().len());
        let first_value = corners.scan(0, |next, corners| {
            *next += corners;
            Some(*next - corners)
        });
        Self {
            first_value: first_value.collect(),
            near: NearPairs::new(&tree, &partition, blocks, distant.points().owners()),
            distant,
            tree,
            partition,
        }
    }

    /// Pressure, unknowns x patterns, for every parity: `factor` times the inverse of 1/2 - K + alpha W times (S +
    /// alpha (1/2 + K')) v.
    ///
    /// # Errors
    /// [`BemError::NotConverged`].
    pub(crate) fn solve(
        &self,
        equations: &Equations<'_>,
        patterns: &[(Parity, &DMatrix<f64>)],
        factor: Complex<f64>,
        accuracy: Accuracy,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        let Equations { boundary, wave, .. } = *equations;
        let mut found = Vec::with_capacity(patterns.len());
        let near = self.near.assemble(equations, patterns);
        let range = |c: usize| self.tree.clusters[c].first..self.tree.clusters[c].end;
        for (&(parity, velocities), near) in patterns.iter().zip(near) {
            let mut right = near.right;
            let dense = self
                .partition
                .near
                .iter()
                .zip(near.blocks)
                .map(|(&[t, s], matrix)| Dense {
                    rows: range(t),
                    columns: range(s),
                    matrix,
                });
            let images = Images::new(
                equations.images,
                parity,
                boundary.planes(),
                &self.distant.points().middle,
            );
            let kernels = Kernels { wave, images: &images };
            let at_points = self.distant.points().of_patterns(&self.first_value, velocities);
            let mut matrix = Compressed {
                unknowns: self.tree.order.len(),
                dense: dense.collect(),
                low_rank: self.distant.assemble(
                    (&self.tree, &self.partition),
                    &kernels,
                    accuracy.block,
                    at_points.as_ref(),
                    &mut right,
                ),
            };
            self.add_jump(equations, velocities, &mut matrix, &mut right);
            let held = |&node: &usize| parity.vanishes(boundary.in_planes(node));
            let held: Vec<bool> = self.tree.order.iter().map(held).collect();
            let [re, im] = &right;
            let right = Mat::from_fn(re.nrows(), re.ncols(), |place, m| {
                let node = self.tree.order[place];
                Complex::new(re[(node, m)], im[(node, m)])
            });
            let schwarz = Schwarz::new(equations, &self.tree, &self.near, &matrix, &held);
            let x = Krylov::new(&matrix, &schwarz, &held, accuracy.residual).solve(&right)?;
            let mut pressure = DMatrix::zeros(x.nrows(), x.ncols());
            for (place, &node) in self.tree.order.iter().enumerate() {
                for m in 0..x.ncols() {
                    pressure[(node, m)] = factor * x[(place, m)];
                }
            }
            found.push(pressure);
        }
        Ok(found)
    }

    /// Adds the terms with 1/2 on both sides.
    fn add_jump(
        &self,
        equations: &Equations<'_>,
        velocities: &DMatrix<f64>,
        matrix: &mut Compressed,
        right: &mut [Mat<f64>; 2],
    ) {
        let panels = equations.boundary.mesh().panels.iter();
        for ((panel, mass), &first) in panels.zip(equations.masses).zip(&self.first_value) {
            let corners = panel.corners().iter();
            let nodes: Vec<usize> = corners.filter_map(|&c| equations.boundary.node_of(c)).collect();
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    let half = 0.5 * mass[i][j];
                    self.near.add_entry(row, column, half as f32, &mut matrix.dense);
                    for m in 0..velocities.ncols() {
                        // alpha is imaginary.
                        right[1][(row, m)] -= half * equations.wave.coupling * velocities[(first + j, m)];
                    }
                }
            }
        }
    }
}
