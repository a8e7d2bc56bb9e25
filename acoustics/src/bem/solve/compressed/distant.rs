//! Blocks between distant clusters, and their contribution to the right-hand sides.

use super::clusters::{ClusterTree, Partition};
use super::cross::CrossedBlock;
use super::kernel::Kernels;
use super::operator::{LowRank, map_in_parallel};
use super::points::{ClusterPoints, PanelPoints};
use crate::bem::mesh::boundary::Boundary;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::Complex;

/// Number of blocks whose contributions to the right-hand sides are in memory at a time.
const BATCH: usize = 256;

/// The quadrature points around all clusters.
#[derive(Debug)]
pub(super) struct DistantBlocks {
    points: PanelPoints,
    of_cluster: Vec<ClusterPoints>,
}

impl DistantBlocks {
    pub(super) fn new(boundary: &Boundary, tree: &ClusterTree) -> Self {
        let points = PanelPoints::new(boundary, tree);
        let of_cluster = map_in_parallel(tree.clusters.iter().collect(), |c| points.of_cluster(tree, c));
        Self { points, of_cluster }
    }

    pub(super) fn points(&self) -> &PanelPoints {
        &self.points
    }

    /// Approximates the distant blocks with relative accuracy `tolerance`, and adds their contribution to the
    /// right-hand sides (unknowns x patterns, real and imaginary part) for `velocities`, the patterns at all points
    /// (points x patterns).
    pub(super) fn assemble(
        &self,
        (tree, partition): (&ClusterTree, &Partition),
        kernels: &Kernels<'_>,
        tolerance: f64,
        velocities: MatRef<'_, f32>,
        right: &mut [Mat<f64>; 2],
    ) -> Vec<LowRank> {
        let mut all = Vec::with_capacity(partition.distant.len());
        for batch in partition.distant.chunks(BATCH) {
            let found = map_in_parallel(batch.iter().collect(), |&pair| {
                self.block(tree, pair, kernels, tolerance, velocities)
            });
            for (block, flows) in found {
                let mut product = Mat::zeros(block.left.nrows(), velocities.ncols());
                let one = Complex::new(1.0, 0.0);
                matmul(
                    product.as_mut(),
                    Accum::Replace,
                    block.left.as_ref(),
                    flows.as_ref(),
                    one,
                    Par::Seq,
                );
                for m in 0..velocities.ncols() {
                    for (i, &node) in tree.order[block.rows.clone()].iter().enumerate() {
                        right[0][(node, m)] += f64::from(product[(i, m)].re);
                        right[1][(node, m)] += f64::from(product[(i, m)].im);
                    }
                }
                all.push(block);
            }
        }
        all
    }

    /// A block, and the right factor of B times the patterns.
    fn block(
        &self,
        tree: &ClusterTree,
        pair: [usize; 2],
        kernels: &Kernels<'_>,
        tolerance: f64,
        velocities: MatRef<'_, f32>,
    ) -> (LowRank, Mat<Complex<f32>>) {
        let [rows, columns] = pair.map(|c| &tree.clusters[c]);
        let [t, s] = pair.map(|c| &self.of_cluster[c]);
        // Pressure and velocity fields have similar magnitudes if b is multiplied by the wavenumber or, in the near
        // field, by the inverse distance.
        let scale = kernels.wave.k.max(1.0 / rows.distance(columns)) as f32;
        let crossed = CrossedBlock { kernels, t, s, scale };
        let (crosses, length) = (crossed.approximate(tolerance), crossed.width());
        let rank = crosses.rank;
        let block = LowRank {
            rows: rows.first..rows.end,
            columns: columns.first..columns.end,
            left: t.test(&crosses.left, 2 * t.padded),
            right: s.test(&crosses.right, length),
        };
        let own = s.own_rows(velocities);
        let mut flows = Mat::zeros(rank, velocities.ncols());
        let mut product = Mat::<f32>::zeros(rank, velocities.ncols());
        for part in 0..2 {
            let start = 2 * s.padded + part * s.own_padded;
            let v = crosses.right.get(start..).unwrap_or_default();
            if rank == 0 || s.own == 0 {
                continue;
            }
            let v = MatRef::from_column_major_slice_with_stride(v, s.own, rank, length);
            matmul(
                product.as_mut(),
                Accum::Replace,
                v.transpose(),
                own,
                1.0 / scale,
                Par::Seq,
            );
            for m in 0..velocities.ncols() {
                for l in 0..rank {
                    let to: &mut Complex<f32> = &mut flows[(l, m)];
                    *(if part == 0 { &mut to.re } else { &mut to.im }) = product[(l, m)];
                }
            }
        }
        (block, flows)
    }
}
