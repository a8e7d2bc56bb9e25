//! Eigenpairs with their residuals, and the refinement that brings these below a limit.

use faer::{Mat, MatRef};
use nalgebra_sparse::CscMatrix;

use crate::ModalSettings;
use crate::dense::{add_product, transpose_product};
use crate::factor::Factor;
use crate::sparse::product;

/// A mode is rigid when lambda is below this fraction of the edge: its frequency is then below 5e-5 of the top.
pub(crate) const RIGID: f64 = 2.5e-9;

/// The sums of K phi may cancel down to this fraction of their terms: what is left has eight digits more than rounding.
const CANCELLED: f64 = 1e-6;

/// The matrices of K phi = lambda M phi.
#[derive(Clone, Copy)]
pub(crate) struct Pencil<'a> {
    pub(crate) stiffness: &'a CscMatrix<f64>,
    pub(crate) mass: &'a CscMatrix<f64>,
}

/// Mass-normalised modes, lambda ascending up to rounding.
pub(crate) struct Eigenpairs {
    pub(crate) lambda: Vec<f64>,
    pub(crate) phi: Mat<f64>,
    pub(crate) m_phi: Mat<f64>,
    /// See [`crate::ModalBasis::residuals`].
    pub(crate) residuals: Vec<f64>,
    pub(crate) rigid: Vec<bool>,
    /// Upper edge of lambda.
    edge: f64,
    /// The lowest lambda of an elastic mode of the body, as far as known: that of a rigid mode's residual.
    ceiling: f64,
}

impl Eigenpairs {
    pub(crate) fn new(pencil: Pencil<'_>, mut phi: Mat<f64>, edge: f64, ceiling: f64) -> Self {
        let mut m_phi = product(pencil.mass, phi.as_ref());
        for i in 0..phi.ncols() {
            let scale = 1.0 / dot(phi.as_ref(), m_phi.as_ref(), i).sqrt();
            phi.col_mut(i).iter_mut().for_each(|x| *x *= scale);
            m_phi.col_mut(i).iter_mut().for_each(|x| *x *= scale);
        }
        let k_phi = product(pencil.stiffness, phi.as_ref());
        let lambda: Vec<f64> = (0..phi.ncols()).map(|i| dot(phi.as_ref(), k_phi.as_ref(), i)).collect();
        let rigid: Vec<bool> = lambda.iter().map(|l| l.abs() < RIGID * edge).collect();
        let mut pairs = Self {
            lambda,
            phi,
            m_phi,
            residuals: Vec::new(),
            rigid,
            edge,
            ceiling,
        };
        let elastic = pairs.elastic();
        pairs.residuals = (0..pairs.lambda.len())
            .map(|i| {
                let lambda = pairs.lambda[i];
                let (value, scale) = if pairs.rigid[i] {
                    (0.0, elastic)
                } else {
                    (lambda, lambda)
                };
                let (mut difference, mut size, mut parts) = (0.0, 0.0, 0.0);
                for (row, (a, b)) in k_phi.col(i).iter().zip(pairs.m_phi.col(i).iter()).enumerate() {
                    difference += (a - value * b).powi(2);
                    size += (scale * b).powi(2);
                    // The diagonal opens each column of the lower triangle.
                    let diagonal = pencil.stiffness.values()[pencil.stiffness.col_offsets()[row]];
                    parts += (CANCELLED * diagonal * pairs.phi[(row, i)]).powi(2);
                }
                (difference / size.max(parts)).sqrt()
            })
            .collect();
        pairs
    }

    /// Takes modes whose residual r = K phi - lambda M phi is above half the limit through one step of inverse iteration with
    /// the factor of K - sigma M, and says how many.
    ///
    /// Rounding leaves components of high modes in the Lanczos basis, which K multiplies by their frequency squared; a
    /// solve divides them by it again. In the form phi - (K - sigma M)^-1 r the solve's own rounding is relative to r,
    /// not to phi. A component of mode j is multiplied by (lambda - sigma) / (lambda_j - sigma): with sigma at the edge
    /// that serves modes far above, with a small negative sigma all that are not in the basis, which the lowest modes
    /// of a basis of several decades need.
    pub(crate) fn refine(&mut self, pencil: Pencil<'_>, factor: &Factor<'_>, settings: &ModalSettings) -> usize {
        let limit = settings.residual_limit / 2.0;
        let poor: Vec<usize> = (0..self.lambda.len()).filter(|&i| self.residuals[i] > limit).collect();
        for chosen in poor.chunks(settings.block.max(1)) {
            let rows = self.phi.nrows();
            let phi = Mat::from_fn(rows, chosen.len(), |r, c| self.phi[(r, chosen[c])]);
            let mut x = product(pencil.stiffness, phi.as_ref());
            for (c, &i) in chosen.iter().enumerate() {
                let lambda = self.lambda[i];
                for (x, m_phi) in x.col_mut(c).iter_mut().zip(self.m_phi.col(i).iter()) {
                    *x -= lambda * m_phi;
                }
            }
            factor.solve(x.as_mut());
            x = phi - x;
            self.purge(pencil, &mut x, chosen);
            let refined = Self::new(pencil, x, self.edge, self.elastic());
            for (c, &i) in chosen.iter().enumerate() {
                self.lambda[i] = refined.lambda[c];
                self.rigid[i] = refined.rigid[c];
                self.residuals[i] = refined.residuals[c];
                self.phi.col_mut(i).copy_from(refined.phi.col(c));
                self.m_phi.col_mut(i).copy_from(refined.m_phi.col(c));
            }
        }
        if !poor.is_empty() {
            self.orthogonalise(pencil);
        }
        poor.len()
    }

    /// Makes modes that were refined one by one orthogonal again: with Phi^T M Phi = I + E, E some 1e-8,
    ///
    /// ```text
    /// Phi <- Phi (I - U),   U_ij = E_ij for lambda_i < lambda_j,   U_ii = E_ii / 2,
    /// ```
    ///
    /// leaves E^2. Of two modes the higher one is changed: a trace of the lower weighs less than its own size in the
    /// higher one's residual, the reverse would weigh lambda_j / lambda_i times as much.
    fn orthogonalise(&mut self, pencil: Pencil<'_>) {
        let gram = transpose_product(self.phi.as_ref(), self.m_phi.as_ref());
        let lower = |i: usize, j: usize| (self.lambda[i], i) < (self.lambda[j], j);
        let u = Mat::from_fn(gram.nrows(), gram.ncols(), |i, j| {
            if i == j {
                0.5 * (gram[(i, i)] - 1.0)
            } else if lower(i, j) {
                0.5 * (gram[(i, j)] + gram[(j, i)])
            } else {
                0.0
            }
        });
        let mut phi = self.phi.clone();
        add_product(phi.as_mut(), -1.0, self.phi.as_ref(), u.as_ref());
        *self = Self::new(pencil, phi, self.edge, self.ceiling);
    }

    /// Takes out of X, whose columns approximate the modes `chosen`, what it holds of other modes of the basis.
    ///
    /// Mode i holds phi_j^T (K - lambda_i M) x / (lambda_j - lambda_i) of mode j. Mere orthogonalisation would not do:
    /// a high mode's own trace of a low one, invisible in its residual, would be pushed into the low mode and there
    /// weigh lambda_j / lambda_i times as much. Near-degenerate modes, where the quotient says nothing, are made
    /// orthogonal.
    fn purge(&self, pencil: Pencil<'_>, x: &mut Mat<f64>, chosen: &[usize]) {
        let by_k = transpose_product(self.phi.as_ref(), product(pencil.stiffness, x.as_ref()).as_ref());
        let by_m = transpose_product(self.m_phi.as_ref(), x.as_ref());
        let c = Mat::from_fn(self.lambda.len(), chosen.len(), |j, column| {
            let i = chosen[column];
            let (distance, m_j) = (self.lambda[j] - self.lambda[i], by_m[(j, column)]);
            let near = distance.abs() < 1e-3 * self.lambda[j].abs().max(self.lambda[i].abs());
            if i == j {
                0.0
            } else if near || (self.rigid[i] && self.rigid[j]) {
                m_j
            } else {
                (by_k[(j, column)] - self.lambda[i] * m_j) / distance
            }
        });
        add_product(x.as_mut(), -1.0, self.phi.as_ref(), c.as_ref());
    }

    /// The largest residual, or NaN if one is.
    pub(crate) fn worst(&self) -> f64 {
        self.residuals.iter().fold(
            0.0,
            |a: f64, &b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) },
        )
    }

    /// The lowest lambda of an elastic mode, or the ceiling when there is none below it.
    pub(crate) fn elastic(&self) -> f64 {
        let elastic = self.lambda.iter().zip(&self.rigid).filter(|(_, rigid)| !**rigid);
        elastic.map(|(l, _)| *l).fold(self.ceiling, f64::min)
    }

    /// Refers the residuals of rigid modes to the body's lowest elastic lambda, which another sector may hold.
    pub(crate) fn refer_to(&mut self, elastic: f64) {
        let before = self.elastic();
        self.ceiling = elastic.min(self.ceiling);
        let ratio = before / self.elastic();
        for (residual, _) in self.residuals.iter_mut().zip(&self.rigid).filter(|(_, rigid)| **rigid) {
            *residual *= ratio;
        }
    }

    /// Largest entry of |Phi^T M Phi - I|.
    pub(crate) fn orthonormality(&self) -> f64 {
        let gram = transpose_product(self.phi.as_ref(), self.m_phi.as_ref());
        (0..gram.ncols())
            .flat_map(|j| (0..gram.nrows()).map(move |i| (i, j)))
            .map(|(i, j)| (gram[(i, j)] - f64::from(u8::from(i == j))).abs())
            .fold(0.0, f64::max)
    }
}
pub(crate) fn dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>, column: usize) -> f64 {
    a.col(column).iter().zip(b.col(column).iter()).map(|(x, y)| x * y).sum()
}
