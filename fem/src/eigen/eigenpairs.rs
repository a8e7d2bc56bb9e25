//! Eigenpairs with their residuals, and a refinement that reduces residuals below a limit.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{ColRef, Mat, MatRef};
use rayon::prelude::*;

use super::dense::{add_product, transpose_product};
use crate::ModalSettings;
use crate::factor::pencil::Pencil;
use crate::factor::rows::SIDES;
use crate::factor::sparse::{Room, product, product_into};

/// A mode is rigid if lambda is below this fraction of the edge, which corresponds to a frequency below 5e-5 of the
/// top.
pub(crate) const RIGID: f64 = 2.5e-9;

/// The terms of K phi may cancel down to this fraction of their size: the remainder then exceeds rounding by eight
/// digits.
const CANCELLED: f64 = 1e-6;

/// Rounding error of phi^T K phi relative to phi^T diag(K) phi; half an epsilon for sheets of 0.5 and 1 mm. A thin
/// sheet is so stiff across its thickness that the rounding of a rigid mode's lambda may exceed [`RIGID`] of the edge.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Entries of Phi^T M Phi - I below this count as rounding.
const ORTHOGONAL: f64 = 1e-14;

/// Largest number of inverse-iteration steps.
const REFINEMENTS: usize = 4;

/// Mass-normalised modes, in ascending order of lambda up to rounding.
pub(crate) struct Eigenpairs {
    pub(crate) lambda: Vec<f64>,
    pub(crate) phi: Mat<f64>,
    pub(crate) m_phi: Mat<f64>,
    /// See [`crate::ModalBasis::residuals`].
    pub(crate) residuals: Vec<f64>,
    pub(crate) rigid: Vec<bool>,
    /// Modes just above the edge, which are not part of the result.
    pub(crate) above: Option<Box<Eigenpairs>>,
    /// Upper edge of lambda.
    edge: f64,
    /// The lowest lambda of the body's elastic modes, as far as known; it scales the residuals of rigid modes.
    ceiling: f64,
}

/// Terms of the residual of a mass-normalised mode.
struct Balance {
    lambda: f64,
    rigid: bool,
    /// |K phi - lambda M phi|^2, or |K phi|^2 for a rigid mode.
    difference: f64,
    /// |M phi|^2.
    size: f64,
    /// |`parts` phi|^2, see [`CANCELLED`].
    parts: f64,
}

impl Balance {
    /// Computes the terms from the columns phi, K phi and M phi; if lambda is below `rigid` or below its own rounding
    /// error, the mode is rigid. Strain energy cannot be negative, so a negative lambda is rounding as well; the
    /// residual shows how large it is.
    fn new([phi, k_phi, m_phi]: [ColRef<'_, f64>; 3], parts: &[f64], rigid: f64) -> Self {
        let lambda: f64 = phi.iter().zip(k_phi.iter()).map(|(x, y)| x * y).sum();
        let terms = phi.iter().zip(parts).map(|(x, part)| part * x * x).sum::<f64>() / CANCELLED;
        let rigid = lambda < rigid.max(ROUNDING * terms);
        let value = if rigid { 0.0 } else { lambda };
        let mut balance = Self {
            lambda,
            rigid,
            difference: 0.0,
            size: 0.0,
            parts: 0.0,
        };
        let rows = k_phi.iter().zip(m_phi.iter()).zip(phi.iter().zip(parts));
        for ((a, b), (x, part)) in rows {
            balance.difference += (a - value * b).powi(2);
            balance.size += b.powi(2);
            balance.parts += (part * x).powi(2);
        }
        balance
    }

    /// See [`crate::ModalBasis::residuals`].
    fn residual(&self, elastic: f64) -> f64 {
        let scale = if self.rigid { elastic } else { self.lambda };
        (self.difference / (scale.powi(2) * self.size).max(self.parts)).sqrt()
    }
}

impl Eigenpairs {
    pub(crate) fn new(pencil: Pencil<'_>, mut phi: Mat<f64>, edge: f64, ceiling: f64) -> Self {
        let (n, count) = (phi.nrows(), phi.ncols());
        let mut m_phi = Mat::zeros(n, count);
        // The diagonal entry comes first in each column of the lower triangle.
        let diagonal = |row: usize| pencil.stiffness.values()[pencil.stiffness.col_offsets()[row]];
        let parts: Vec<f64> = (0..n).map(|row| CANCELLED * diagonal(row)).collect();
        // Threads share the blocks. K Phi is only needed temporarily, so there is memory for one block per thread.
        let blocks = phi.par_col_chunks_mut(SIDES).zip(m_phi.par_col_chunks_mut(SIDES));
        let balances = blocks.map_init(Room::default, |room, (mut phi, mut m_phi)| {
            product_into(pencil.mass, phi.rb(), m_phi.rb_mut(), room);
            for i in 0..phi.ncols() {
                let scale = 1.0 / dot(phi.rb(), m_phi.rb(), i).sqrt();
                phi.rb_mut().col_mut(i).iter_mut().for_each(|x| *x *= scale);
                m_phi.rb_mut().col_mut(i).iter_mut().for_each(|x| *x *= scale);
            }
            let mut k_phi = Mat::zeros(n, phi.ncols());
            product_into(pencil.stiffness, phi.rb(), k_phi.as_mut(), room);
            let balance = |c: usize| {
                let columns = [phi.rb().col(c), k_phi.col(c), m_phi.rb().col(c)];
                Balance::new(columns, &parts, RIGID * edge)
            };
            (0..phi.ncols()).map(balance).collect::<Vec<_>>()
        });
        let balances: Vec<Balance> = balances.collect::<Vec<_>>().into_iter().flatten().collect();
        let mut pairs = Self {
            lambda: balances.iter().map(|b| b.lambda).collect(),
            phi,
            m_phi,
            residuals: Vec::new(),
            rigid: balances.iter().map(|b| b.rigid).collect(),
            above: None,
            edge,
            ceiling,
        };
        let elastic = pairs.elastic();
        pairs.residuals = balances.iter().map(|b| b.residual(elastic)).collect();
        pairs
    }

    /// Improves modes whose residual r = K phi - lambda M phi exceeds half the limit, by inverse iteration with (K -
    /// sigma M)^-1, which `solve` applies. It stops when no residual exceeds that value or a step no longer halves any
    /// of them, and returns the number of vectors solved for.
    ///
    /// Rounding leaves components of high modes in the Lanczos basis, which K multiplies by the square of their
    /// frequency; a solve divides by it again. In the form phi - (K - sigma M)^-1 r, the rounding error of the solve is
    /// relative to r instead of phi. The component of mode j is multiplied by (lambda - sigma) / (lambda_j - sigma).
    /// With sigma at the edge, this reduces modes far above the edge; with a small negative sigma, it reduces all modes
    /// not in the basis. A basis over several decades needs the negative sigma for its lowest modes. Components of
    /// modes just above the edge are removed explicitly, because the first shift would amplify them and the second
    /// hardly reduces them. Components of the basis are removed too. A mode that a step does not improve remains
    /// unchanged.
    pub(crate) fn refine(
        &mut self,
        pencil: Pencil<'_>,
        settings: &ModalSettings,
        solve: impl Fn(&mut Mat<f64>) + Sync,
    ) -> usize {
        let limit = settings.residual_limit / 2.0;
        let mut solves = 0;
        for _ in 0..REFINEMENTS {
            let poor: Vec<usize> = (0..self.lambda.len()).filter(|&i| self.residuals[i] > limit).collect();
            let before: Vec<f64> = poor.iter().map(|&i| self.residuals[i]).collect();
            // All blocks start from the same modes, so that they can be processed in parallel.
            let steps: Vec<Self> = poor
                .par_chunks(SIDES)
                .map(|chosen| self.step(pencil, chosen, &solve))
                .collect();
            for (chosen, refined) in poor.chunks(SIDES).zip(steps) {
                let better = |c: usize, i: usize| refined.residuals[c] < self.residuals[i];
                let better: Vec<bool> = chosen.iter().enumerate().map(|(c, &i)| better(c, i)).collect();
                self.replace(chosen, &refined, |c| better[c]);
            }
            solves += poor.len();
            if poor
                .iter()
                .zip(before)
                .all(|(&i, before)| self.residuals[i] > 0.5 * before)
            {
                break;
            }
        }
        if solves > 0 {
            self.orthogonalise(pencil);
        }
        solves
    }

    /// One step of inverse iteration for the modes `chosen`.
    fn step(&self, pencil: Pencil<'_>, chosen: &[usize], solve: &impl Fn(&mut Mat<f64>)) -> Self {
        let n = self.phi.nrows();
        let phi = Mat::from_fn(n, chosen.len(), |r, c| self.phi[(r, chosen[c])]);
        let mut x = product(pencil.stiffness, phi.as_ref());
        for (c, &i) in chosen.iter().enumerate() {
            let lambda = self.lambda[i];
            for (x, m_phi) in x.col_mut(c).iter_mut().zip(self.m_phi.col(i).iter()) {
                *x -= lambda * m_phi;
            }
        }
        solve(&mut x);
        x = phi - x;
        self.purge(pencil, &mut x, chosen);
        Self::new(pencil, x, self.edge, self.elastic())
    }

    /// Replaces the pairs `chosen` by others for which `accepted` is true.
    fn replace(&mut self, chosen: &[usize], pairs: &Self, accepted: impl Fn(usize) -> bool) {
        for (c, &i) in chosen.iter().enumerate().filter(|(c, _)| accepted(*c)) {
            self.lambda[i] = pairs.lambda[c];
            self.rigid[i] = pairs.rigid[c];
            self.residuals[i] = pairs.residuals[c];
            self.phi.col_mut(i).copy_from(pairs.phi.col(c));
            self.m_phi.col_mut(i).copy_from(pairs.m_phi.col(c));
        }
    }

    /// Restores the orthogonality of modes that were refined separately. With Phi^T M Phi = I + E, where E is about
    /// 1e-8,
    ///
    /// ```text
    /// Phi <- Phi (I - U),   U_ij = E_ij for lambda_i < lambda_j,   U_ii = E_ii / 2,
    /// ```
    ///
    /// leaves an error of E^2. Of two modes, the higher one is changed. A component of the lower mode increases the
    /// residual of the higher one by less than its size. The reverse would be weighted by lambda_j / lambda_i.
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
        // Modes that are already orthogonal to rounding are left unchanged.
        let changed: Vec<usize> = (0..u.ncols())
            .filter(|&j| u.col(j).iter().any(|u| u.is_nan() || u.abs() > ORTHOGONAL))
            .collect();
        let mut phi = Mat::from_fn(self.phi.nrows(), changed.len(), |r, c| self.phi[(r, changed[c])]);
        let u = Mat::from_fn(u.nrows(), changed.len(), |i, c| u[(i, changed[c])]);
        add_product(phi.as_mut(), -1.0, self.phi.as_ref(), u.as_ref());
        let pairs = Self::new(pencil, phi, self.edge, self.elastic());
        self.replace(&changed, &pairs, |_| true);
    }

    /// Removes the components of other modes, including those above the edge, from X, whose columns approximate the
    /// modes `chosen`.
    ///
    /// The component of mode j in mode i is phi_j^T (K - lambda_i M) x / (lambda_j - lambda_i). Orthogonalisation is
    /// not sufficient. A component of a low mode in a high one is invisible in the residual of the high mode.
    /// Orthogonalisation would transfer it to the low mode, where it is weighted by lambda_j / lambda_i. Nearly
    /// degenerate modes, for which the quotient is meaningless, are orthogonalised.
    fn purge(&self, pencil: Pencil<'_>, x: &mut Mat<f64>, chosen: &[usize]) {
        let k_x = product(pencil.stiffness, x.as_ref());
        let traces = |of: &Self| {
            let by_k = transpose_product(of.phi.as_ref(), k_x.as_ref());
            let by_m = transpose_product(of.m_phi.as_ref(), x.as_ref());
            Mat::from_fn(of.lambda.len(), chosen.len(), |j, column| {
                let i = chosen[column];
                let (distance, m_j) = (of.lambda[j] - self.lambda[i], by_m[(j, column)]);
                let near = distance.abs() < 1e-3 * of.lambda[j].abs().max(self.lambda[i].abs());
                if std::ptr::eq(of, self) && i == j {
                    0.0
                } else if near || (self.rigid[i] && of.rigid[j]) {
                    m_j
                } else {
                    (by_k[(j, column)] - self.lambda[i] * m_j) / distance
                }
            })
        };
        let above = self.above.as_deref();
        let sets: Vec<_> = [Some(self), above]
            .into_iter()
            .flatten()
            .map(|of| (of, traces(of)))
            .collect();
        for (of, c) in sets {
            add_product(x.as_mut(), -1.0, of.phi.as_ref(), c.as_ref());
        }
    }

    /// The largest residual, or NaN if any is NaN.
    pub(crate) fn worst(&self) -> f64 {
        self.residuals.iter().fold(
            0.0,
            |a: f64, &b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) },
        )
    }

    /// The lowest lambda of an elastic mode, or the ceiling if that is lower.
    pub(crate) fn elastic(&self) -> f64 {
        let elastic = self.lambda.iter().zip(&self.rigid).filter(|(_, rigid)| !**rigid);
        elastic.map(|(l, _)| *l).fold(self.ceiling, f64::min)
    }

    /// Scales the residuals of rigid modes by the body's lowest elastic lambda, which may be in another sector.
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
