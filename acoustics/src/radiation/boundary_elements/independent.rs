use super::combination::Combination;
use super::mesh_range::MeshRange;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::solve::neumann::Patterns;

use nalgebra::DMatrix;

/// Relative amplitude below which a mode counts as a combination of the other patterns of a parity.
const RANK: f64 = 1e-6;

/// Modes with linearly independent patterns of a parity, and the combinations that represent all modes.
pub(crate) struct Independent {
    /// Their indices.
    pub(crate) modes: Vec<usize>,
    /// Combinations that represent all modes.
    pub(crate) combination: Combination,
}

impl Independent {
    /// The patterns of these modes only.
    pub(crate) fn of(&self, patterns: &Patterns) -> Patterns {
        Patterns {
            parity: patterns.parity,
            velocities: patterns.velocities.select_columns(&self.modes),
        }
    }
}

/// Selects independent modes by pivoted Cholesky factorisation of the patterns' Gram matrix, with every mode scaled by
/// its complete pattern.
pub(crate) fn independent(level: &MeshRange) -> Vec<Independent> {
    let weights = weights(level.problem.boundary());
    let grams: Vec<DMatrix<f64>> = level.patterns.iter().map(|p| gram(&p.velocities, &weights)).collect();
    let modes = grams.first().map_or(0, DMatrix::ncols);
    let scale: Vec<f64> = (0..modes)
        .map(|m| {
            grams
                .iter()
                .map(|g| g[(m, m)])
                .sum::<f64>()
                .sqrt()
                .max(f64::MIN_POSITIVE)
        })
        .collect();
    grams.iter().map(|gram| pivoted(gram, &scale)).collect()
}

/// Area attributed to each corner of each panel \[m2\], in the order of the velocity values.
pub(crate) fn weights(boundary: &Boundary) -> Vec<f64> {
    let mesh = boundary.mesh();
    let mut weights = Vec::with_capacity(boundary.velocity_values());
    for (p, panel) in mesh.panels.iter().enumerate() {
        let corners = panel.corners().len();
        weights.extend(std::iter::repeat_n(mesh.panel_area(p) / corners as f64, corners));
    }
    weights
}

/// Gram matrix V^T W V of the columns of V with the weights W of its rows.
pub(crate) fn gram(values: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    // nalgebra's `tr_mul` works column by column, whereas its product is blocked.
    values.transpose() * weighted(values, weights)
}

/// Multiplies each row by its weight.
pub(crate) fn weighted(values: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let mut weighted = values.clone();
    for mut column in weighted.column_iter_mut() {
        column.iter_mut().zip(weights).for_each(|(v, w)| *v *= w);
    }
    weighted
}

fn pivoted(gram: &DMatrix<f64>, scale: &[f64]) -> Independent {
    let n = scale.len();
    let mut rest: Vec<f64> = (0..n).map(|m| gram[(m, m)] / (scale[m] * scale[m])).collect();
    // Rows of the factor, in pivot order.
    let (mut pivots, mut rows) = (Vec::<usize>::new(), Vec::<Vec<f64>>::new());
    while let Some(pivot) = (0..n).max_by(|&a, &b| rest[a].total_cmp(&rest[b]).then(b.cmp(&a))) {
        if rest[pivot].is_nan() || rest[pivot] <= RANK * RANK {
            break;
        }
        let root = rest[pivot].sqrt();
        let row: Vec<f64> = (0..n)
            .map(|m| {
                let known: f64 = rows.iter().map(|r| r[pivot] * r[m]).sum();
                (gram[(pivot, m)] / (scale[pivot] * scale[m]) - known) / root
            })
            .collect();
        for (left, value) in rest.iter_mut().zip(&row) {
            *left -= value * value;
        }
        rest[pivot] = 0.0;
        pivots.push(pivot);
        rows.push(row);
    }
    // Patterns X D = (X D)_P T' with T' = L_P^-1 L^T, where L_P is the triangle of the pivots. Modes with a negligible
    // component of this parity are omitted, like negligible pivots.
    let r = pivots.len();
    let present = |m: &usize| gram[(*m, *m)] > (RANK * scale[*m]).powi(2) && !pivots.contains(m);
    let dependent: Vec<usize> = (0..n).filter(present).collect();
    let mut of_dependent = DMatrix::zeros(r, dependent.len());
    for (&m, mut column) in dependent.iter().zip(of_dependent.column_iter_mut()) {
        for i in (0..r).rev() {
            let known: f64 = (i + 1..r).map(|k| rows[i][pivots[k]] * column[k]).sum();
            column[i] = (rows[i][m] - known) / rows[i][pivots[i]];
        }
        for i in 0..r {
            column[i] *= scale[m] / scale[pivots[i]];
        }
    }
    Independent {
        combination: Combination::new(n, pivots.clone(), dependent, of_dependent),
        modes: pivots,
    }
}
