//! Quadratic forms of covariances, which have low rank in narrow bands.

use nalgebra::DMatrix;
use rayon::prelude::*;

/// Number of rows whose forms are summed while their products are in the cache.
const ROWS: usize = 256;

/// Remaining diagonal, relative to the largest initial entry, below which the factorisation of a covariance ends.
const USED_UP: f64 = 1e-12;

/// Low-rank factor L of a symmetric, positive semidefinite C = L L^T, modes x rank, accurate to single precision
/// relative to the largest entry. It is computed by pivoted Cholesky factorisation, which ends at the rank of C. The
/// rank is low in narrow bands.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRank(DMatrix<f32>);

impl LowRank {
    /// Factorises a covariance, modes x modes.
    pub fn of(covariance: &DMatrix<f64>) -> Self {
        let (order, columns) = triangle(covariance);
        let mut factor = DMatrix::zeros(order.len(), columns.len());
        for (column, mut to) in columns.iter().zip(factor.column_iter_mut()) {
            order.iter().zip(column).for_each(|(&mode, v)| to[mode] = *v as f32);
        }
        Self(factor)
    }

    /// phi^T C phi = |L^T phi|^2 for each row phi of `shapes` and each C; the rows are read only once.
    pub fn forms(of: &[Self], shapes: &DMatrix<f32>) -> Vec<Vec<f64>> {
        let ranks: Vec<usize> = of.iter().map(|own| own.0.ncols()).collect();
        let mut all = DMatrix::<f32>::zeros(shapes.ncols(), ranks.iter().sum());
        let mut first = 0;
        for (own, rank) in of.iter().zip(&ranks) {
            all.columns_mut(first, *rank).copy_from(&own.0);
            first += rank;
        }
        let blocks: Vec<usize> = (0..shapes.nrows()).step_by(ROWS).collect();
        let of_block = |moved: &mut DMatrix<f32>, first: usize| {
            let rows = ROWS.min(shapes.nrows() - first);
            let mut moved = moved.rows_mut(0, rows);
            moved.gemm(1.0, &shapes.rows(first, rows), &all, 0.0);
            let mut columns = moved.column_iter();
            let squares = |rank: &usize| {
                let mut sums = vec![0.0; rows];
                for column in columns.by_ref().take(*rank) {
                    let moved = sums.iter_mut().zip(column.iter());
                    moved.for_each(|(sum, v)| *sum += f64::from(*v) * f64::from(*v));
                }
                sums
            };
            ranks.iter().map(squares).collect::<Vec<_>>()
        };
        let blocks: Vec<Vec<Vec<f64>>> = blocks
            .into_par_iter()
            .map_init(|| DMatrix::zeros(ROWS, all.ncols()), of_block)
            .collect();
        let gather = |own: usize| blocks.iter().flat_map(|block| block[own].iter().copied()).collect();
        (0..of.len()).map(gather).collect()
    }
}

/// phi^T C phi for each row phi of `shapes` and a symmetric, positive semidefinite C, to single precision relative to
/// the largest entry.
pub fn quadratic_forms(shapes: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let shapes = shapes.map(|v| v as f32);
    LowRank::forms(&[LowRank::of(covariance)], &shapes).swap_remove(0)
}

/// All modes in pivot order, and L in that order, column by column.
fn triangle(covariance: &DMatrix<f64>) -> (Vec<usize>, Vec<Vec<f64>>) {
    let n = covariance.nrows();
    let mut rest: Vec<f64> = covariance.diagonal().iter().copied().collect();
    let least = USED_UP * rest.iter().copied().fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..n).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for k in 0..n {
        let best = (k..n).fold(k, |best, i| if rest[order[i]] > rest[order[best]] { i } else { best });
        let pivot = order[best];
        if rest[pivot].is_nan() || rest[pivot] <= least {
            break;
        }
        order.swap(k, best);
        columns.iter_mut().for_each(|column| column.swap(k, best));
        let root = rest[pivot].sqrt();
        let mut column: Vec<f64> = order.iter().map(|&i| covariance[(i, pivot)]).collect();
        for before in &columns {
            let factor = before[k];
            column[k..]
                .iter_mut()
                .zip(&before[k..])
                .for_each(|(c, b)| *c -= factor * b);
        }
        column[..k].fill(0.0);
        column[k..].iter_mut().for_each(|c| *c /= root);
        for (&i, c) in order[k..].iter().zip(&column[k..]) {
            rest[i] -= c * c;
        }
        columns.push(column);
    }
    (order, columns)
}
