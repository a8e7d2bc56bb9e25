//! Eigenpairs with their residuals, and the refinement that brings these below a limit.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{ColRef, Mat, MatRef};
use rayon::prelude::*;

use super::dense::{add_product, transpose_product};
use crate::ModalSettings;
use crate::factor::pencil::Pencil;
use crate::factor::rows::SIDES;
use crate::factor::sparse::{Room, product, product_into};

/// A mode is rigid when lambda is below this fraction of the edge: its frequency is then below 5e-5 of the top.
pub(crate) const RIGID: f64 = 2.5e-9;

/// The sums of K phi may cancel down to this fraction of their terms: the remainder has eight digits more than
/// rounding.
const CANCELLED: f64 = 1e-6;

/// Rounding of phi^T K phi relative to phi^T diag(K) phi; half an epsilon in sheets of 0.5 and 1 mm. A thin sheet is so
/// stiff across its thickness that the rounding of a rigid mode's lambda may exceed [`RIGID`] of the edge.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Entries of Phi^T M Phi - I that count as rounding.
const ORTHOGONAL: f64 = 1e-14;

/// Steps of inverse iteration at most.
const REFINEMENTS: usize = 4;

/// Mass-normalised modes, lambda ascending up to rounding.
pub(crate) struct Eigenpairs {
    pub(crate) lambda: Vec<f64>,
    pub(crate) phi: Mat<f64>,
    pub(crate) m_phi: Mat<f64>,
    /// See [`crate::ModalBasis::residuals`].
    pub(crate) residuals: Vec<f64>,
    pub(crate) rigid: Vec<bool>,
    /// Modes just above the edge, not wanted themselves.
    pub(crate) above: Option<Box<Eigenpairs>>,
    /// Upper edge of lambda.
    edge: f64,
    /// The lowest lambda of an elastic mode of the body, as far as known: that of a rigid mode's residual.
    ceiling: f64,
}

/// What K phi and lambda M phi of a mass-normalised phi differ by.
struct Balance {
    lambda: f64,
    rigid: bool,
    /// |K phi - lambda M phi|^2, or |K phi|^2 of a rigid mode.
    difference: f64,
    /// |M phi|^2.
    size: f64,
    /// |`parts` phi|^2, see [`CANCELLED`].
    parts: f64,
}

impl Balance {
    /// Of the columns phi, K phi and M phi; below `rigid`, or below its own rounding, lambda is that of a rigid mode.
    /// No strain has a negative energy, so a negative lambda is rounding, too; how much of it there is, is in the
    /// residual.
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
        // The diagonal opens each column of the lower triangle.
        let diagonal = |row: usize| pencil.stiffness.values()[pencil.stiffness.col_offsets()[row]];
        let parts: Vec<f64> = (0..n).map(|row| CANCELLED * diagonal(row)).collect();
        // Threads share the blocks. K Phi is needed in passing only: it has room for one block each.
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

    /// Improves modes whose residual r = K phi - lambda M phi is above half the limit, by steps of inverse iteration
    /// with (K - sigma M)^-1, by which `solve` multiplies. It ends when none is above or a step no longer halves any,
    /// and returns how many vectors it solved for.
    ///
    /// Rounding leaves components of high modes in the Lanczos basis, which K multiplies by their frequency squared; a
    /// solve divides them by it again. In the form phi - (K - sigma M)^-1 r the solve's own rounding is relative to r,
    /// not to phi. A component of mode j is multiplied by (lambda - sigma) / (lambda_j - sigma). With sigma at the edge
    /// this reduces modes far above, with a small negative sigma all that are not in the basis. The lowest modes of a
    /// basis of several decades need the latter. Components of modes just above the edge, which the first would enlarge
    /// and the second hardly reduces, are taken out as those of the basis are. Modes that a step does not improve stay
    /// as they are.
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
            // All blocks start from the same modes, so that threads can share them.
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

    /// A step of inverse iteration for the modes `chosen`.
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

    /// Replaces those pairs `chosen` by others where `accepted`.
    fn replace(&mut self, chosen: &[usize], pairs: &Self, accepted: impl Fn(usize) -> bool) {
        for (c, &i) in chosen.iter().enumerate().filter(|(c, _)| accepted(*c)) {
            self.lambda[i] = pairs.lambda[c];
            self.rigid[i] = pairs.rigid[c];
            self.residuals[i] = pairs.residuals[c];
            self.phi.col_mut(i).copy_from(pairs.phi.col(c));
            self.m_phi.col_mut(i).copy_from(pairs.m_phi.col(c));
        }
    }

    /// Makes modes that were refined one by one orthogonal again. With Phi^T M Phi = I + E, E some 1e-8,
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
        // Modes that are orthogonal to rounding stay as they are.
        let changed: Vec<usize> = (0..u.ncols())
            .filter(|&j| u.col(j).iter().any(|u| u.is_nan() || u.abs() > ORTHOGONAL))
            .collect();
        let mut phi = Mat::from_fn(self.phi.nrows(), changed.len(), |r, c| self.phi[(r, changed[c])]);
        let u = Mat::from_fn(u.nrows(), changed.len(), |i, c| u[(i, changed[c])]);
        add_product(phi.as_mut(), -1.0, self.phi.as_ref(), u.as_ref());
        let pairs = Self::new(pencil, phi, self.edge, self.elastic());
        self.replace(&changed, &pairs, |_| true);
    }

    /// Takes out of X, whose columns approximate the modes `chosen`, the components of other modes, those above
    /// included.
    ///
    /// Mode i contains phi_j^T (K - lambda_i M) x / (lambda_j - lambda_i) of mode j. Mere orthogonalisation would not
    /// do: a high mode's own trace of a low one, invisible in its residual, would be pushed into the low mode and there
    /// weigh lambda_j / lambda_i times as much. Near-degenerate modes, where the quotient says nothing, are made
    /// orthogonal.
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

    /// Refers the residuals of rigid modes to the body's lowest elastic lambda, which may be in another sector.
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
