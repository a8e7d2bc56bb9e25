//! Preconditioner of overlapping inverses of the leaves' own equations (restricted additive Schwarz method, Cai &
//! Sarkis 1999).
//!
//! The eigenvalues of 1/2 - K + alpha W lie between 1/2 and 1 for surface waves longer than the acoustic wavelength,
//! but grow with the wavenumber for shorter waves. The latter decay within a panel or two, so they are determined by
//! the equations of a leaf and its surroundings.

use super::Equations;
use super::clusters::ClusterTree;
use super::near::NearPairs;
use super::operator::{Compressed, by_columns, map_in_parallel};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::Complex;
use std::ops::Range;

/// Number of panel layers around a leaf included in its equations.
const OVERLAP: usize = 2;

/// The inverses, and the scale of the unknowns.
#[derive(Debug)]
pub(super) struct Schwarz {
    /// d^-1/2 at each position, where d is the area of the unknown's function.
    pub(super) scale: Vec<f64>,
    parts: Vec<Part>,
}

/// The rows of a leaf in the inverse of the equations of its surroundings.
#[derive(Debug)]
struct Part {
    rows: Range<usize>,
    columns: Vec<usize>,
    inverse: Mat<Complex<f32>>,
}

impl Schwarz {
    /// Creates the preconditioner of the scaled matrix D^-1/2 A D^-1/2 without the positions in `held`.
    pub(super) fn new(
        equations: &Equations<'_>,
        tree: &ClusterTree,
        near: &NearPairs,
        matrix: &Compressed,
        held: &[bool],
    ) -> Self {
        let places = tree.places();
        let mut areas = vec![0.0; places.len()];
        let mut neighbours = vec![Vec::new(); places.len()];
        for (panel, mass) in equations.boundary.mesh().panels.iter().zip(equations.masses) {
            let corners = panel.corners().iter();
            let nodes = corners.filter_map(|&c| equations.boundary.node_of(c));
            let at: Vec<usize> = nodes.map(|node| places[node]).collect();
            for (&row, mass) in at.iter().zip(mass) {
                areas[row] += mass.iter().sum::<f64>();
                neighbours[row].extend(&at);
            }
        }
        let scale: Vec<f64> = areas.iter().map(|area| area.powf(-0.5)).collect();
        let parts = map_in_parallel(tree.leaves.clone(), |leaf| {
            let rows = tree.clusters[leaf].first..tree.clusters[leaf].end;
            let mut columns: Vec<usize> = rows.clone().collect();
            let mut before = 0;
            for _ in 0..OVERLAP {
                let mut next: Vec<usize> = columns[before..]
                    .iter()
                    .flat_map(|&c| &neighbours[c])
                    .copied()
                    .collect();
                next.sort_unstable();
                next.dedup();
                next.retain(|place| !columns.contains(place));
                before = columns.len();
                columns.extend(next);
            }
            let size = columns.len();
            let entry = |i: usize, j: usize| {
                let (row, column) = (columns[i], columns[j]);
                if held[row] || held[column] {
                    return Complex::new(f64::from(u8::from(i == j)), 0.0);
                }
                let entry = near.entry(tree.order[row], tree.order[column], &matrix.dense);
                Complex::new(f64::from(entry.re), f64::from(entry.im)) * (scale[row] * scale[column])
            };
            let inverse = Mat::from_fn(size, size, entry).partial_piv_lu().inverse();
            let single = |i: usize, j: usize| Complex::new(inverse[(i, j)].re as f32, inverse[(i, j)].im as f32);
            Part {
                inverse: Mat::from_fn(rows.len(), size, single),
                rows,
                columns,
            }
        });
        Self { scale, parts }
    }

    /// The preconditioner times `x`.
    pub(super) fn times(&self, x: MatRef<'_, Complex<f32>>) -> Mat<Complex<f32>> {
        by_columns(x, |x| {
            let mut product = Mat::zeros(x.nrows(), x.ncols());
            for part in &self.parts {
                let own = Mat::from_fn(part.columns.len(), x.ncols(), |i, m| x[(part.columns[i], m)]);
                matmul(
                    product.as_mut().subrows_mut(part.rows.start, part.rows.len()),
                    Accum::Replace,
                    part.inverse.as_ref(),
                    own.as_ref(),
                    Complex::new(1.0, 0.0),
                    Par::Seq,
                );
            }
            product
        })
    }
}
