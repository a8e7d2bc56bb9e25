//! The mass matrix of the unknowns, which the matrix approaches on a plane, as its preconditioner.

use crate::bem::mesh::boundary::Boundary;
use faer::Mat;
use nalgebra::Complex;
use std::collections::BTreeMap;

/// Steps of Chebyshev's iteration. The mass matrix over its row sums has its eigenvalues between 1/4 and 1 on triangles,
/// between 1/9 and 1 on quadrilaterals.
const STEPS: usize = 6;
const LOWEST: f64 = 1.0 / 9.0;

/// M scaled with the row sums d: D^-1/2 M D^-1/2, in the order of places.
#[derive(Debug)]
pub(super) struct Mass {
    /// d^-1/2.
    pub(super) scale: Vec<f64>,
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl Mass {
    /// From the integrals of phi_i phi_j over every panel.
    pub(super) fn new(boundary: &Boundary, masses: &[[[f64; 4]; 4]], places: &[usize]) -> Self {
        let mut rows = vec![BTreeMap::<u32, f64>::new(); places.len()];
        for (panel, mass) in boundary.mesh().panels.iter().zip(masses) {
            let corners = panel.corners().iter();
            let at: Vec<usize> = corners
                .filter_map(|&c| boundary.node_of(c))
                .map(|n| places[n])
                .collect();
            for (i, &row) in at.iter().enumerate() {
                for (j, &column) in at.iter().enumerate() {
                    *rows[row].entry(column as u32).or_default() += mass[i][j];
                }
            }
        }
        let scale: Vec<f64> = rows.iter().map(|r| r.values().sum::<f64>().powf(-0.5)).collect();
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for (i, row) in rows.into_iter().enumerate() {
            for (j, m) in row {
                columns.push(j);
                values.push((m * scale[i] * scale[j as usize]) as f32);
            }
            starts.push(columns.len());
        }
        Self {
            scale,
            starts,
            columns,
            values,
        }
    }

    /// Approximately the inverse of the scaled matrix times `x`, by Chebyshev's iteration.
    pub(super) fn solve(&self, x: &Mat<Complex<f32>>) -> Mat<Complex<f32>> {
        let (centre, radius) = (0.5 * (1.0 + LOWEST), 0.5 * (1.0 - LOWEST));
        let mut result = Mat::zeros(x.nrows(), x.ncols());
        let mut step = vec![Complex::<f32>::default(); x.nrows()];
        for column in 0..x.ncols() {
            let (b, y): (_, &mut [Complex<f32>]) = (x.col_as_slice(column), result.col_as_slice_mut(column));
            let mut rho = radius / centre;
            for (step, (y, b)) in step.iter_mut().zip(y.iter_mut().zip(b)) {
                *step = *b * (1.0 / centre) as f32;
                *y = *step;
            }
            for _ in 1..STEPS {
                let next = 1.0 / (2.0 * centre / radius - rho);
                let (of_step, of_rest) = ((next * rho) as f32, (2.0 * next / radius) as f32);
                for i in 0..y.len() {
                    let entries = self.starts[i]..self.starts[i + 1];
                    let mut rest = b[i];
                    for (&j, &m) in self.columns[entries.clone()].iter().zip(&self.values[entries]) {
                        rest -= y[j as usize] * m;
                    }
                    step[i] = step[i] * of_step + rest * of_rest;
                }
                y.iter_mut().zip(&step).for_each(|(y, step)| *y += step);
                rho = next;
            }
        }
        result
    }
}
