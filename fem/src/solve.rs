//! All modes below a frequency, with the proof that none is missing.

use std::f64::consts::TAU;

use faer::{Mat, MatRef, Scale};
use nalgebra::DMatrix;

use crate::dense::{add_product, symmetric_eigen, transpose_product};
use crate::factor::{Factor, Symbolic};
use crate::lanczos::{Target, lanczos};
use crate::sparse::{product, shifted};
use crate::{Corrections, FemError, ModalBasis, ModalSettings, ModalWork, Sturm, System};

/// Edges tried.
const ATTEMPTS: usize = 6;

/// Static corrections are solved with the shift -(2 pi f)^2 with this fraction of the top frequency for f, so that free
/// bodies have a solution; it changes what modes above the top contribute by its square, 1e-4, at most.
const SHIFT_FRACTION: f64 = 0.01;

/// A mode is rigid when lambda is below this fraction of the edge: its frequency is then below 5e-5 of the top.
pub(crate) const RIGID: f64 = 2.5e-9;

/// Solves K phi = lambda M phi for all modes below `settings.top_hz`.
///
/// K - sigma M = L D L^T with sigma = (2 pi top)^2 gives the number of modes below, by the signs of D, and then drives
/// block Lanczos on sigma (K - sigma M)^-1 M until that many have converged: one factorisation for the modes and for
/// the proof that none is missing. Each mode's residual is then taken anew from K and M. Should the edge fall on a
/// mode, it is moved up by a few parts in ten thousand.
///
/// # Errors
/// [`FemError::NotPositive`], [`FemError::LoadRows`]; [`FemError::Pivot`], [`FemError::Probe`],
/// [`FemError::NotConverged`] or [`FemError::Incomplete`] when the numerics fail, never a basis with a mode missing.
pub fn modes(system: &System, settings: &ModalSettings) -> Result<ModalBasis, FemError> {
    let (k, m) = (&system.stiffness, &system.mass);
    let mut upper_hz = settings.top_hz;
    if !(upper_hz.is_finite() && upper_hz > 0.0) {
        return Err(FemError::NotPositive {
            what: "the top frequency [Hz]",
            value: upper_hz,
        });
    }
    let loads = settings
        .loads
        .as_ref()
        .map(|loads| system.equations.restrict(loads))
        .transpose()?;
    let symbolic = Symbolic::new(k)?;
    let mut work = ModalWork {
        factor_values: symbolic.values(),
        ..ModalWork::default()
    };
    let mut storage = Vec::new();
    for attempt in 1..=ATTEMPTS {
        let edge = (TAU * upper_hz).powi(2);
        work.factorisations += 1;
        let factor = match symbolic.indefinite(&shifted(k, m, edge), edge, storage) {
            Ok(factor) => factor,
            Err(FemError::Pivot { .. } | FemError::Probe { .. }) if attempt < ATTEMPTS => {
                upper_hz *= 1.0 + 1e-4 * attempt as f64;
                storage = Vec::new();
                continue;
            }
            Err(error) => return Err(error),
        };
        let Some(count) = factor.negative_eigenvalues() else {
            return Err(FemError::NoGap { upper_hz });
        };
        let Some(vectors) = find(system, settings, &factor, edge, count, &mut work)? else {
            upper_hz *= 1.0 + 1e-4 * attempt as f64;
            storage = factor.into_storage();
            continue;
        };
        let mut modes = Modes::new(system, vectors, edge);
        let limit = settings.residual_limit;
        work.solves += modes.refine(system, &factor, edge, limit / 2.0, settings.block)?;
        storage = factor.into_storage();
        let found = modes.lambda.iter().filter(|&&l| l < edge).count();
        if found != count || modes.lambda.len() != count {
            return Err(FemError::Incomplete { found, count, upper_hz });
        }
        let mut corrections = Corrections {
            hz: Vec::new(),
            shapes: DMatrix::zeros(system.equations.dofs(), 0),
        };
        if loads.is_some() || modes.worst() > limit {
            let shift = -(TAU * SHIFT_FRACTION * upper_hz).powi(2);
            let factor = symbolic.best(&shifted(k, m, shift), shift, storage)?;
            work.factorisations += 1;
            work.solves += modes.refine(system, &factor, edge, limit / 2.0, settings.block)?;
            if let Some(loads) = &loads {
                work.solves += loads.ncols();
                corrections = modes.corrections(system, &factor, loads)?;
            }
        }
        let residual = modes.worst();
        if residual.is_nan() || residual > limit {
            return Err(FemError::Residual { residual, limit });
        }
        return Ok(modes.basis(system, Sturm { upper_hz, count }, corrections, work));
    }
    Err(FemError::NoGap { upper_hz })
}

/// The eigenvectors of the `count` eigenvalues below the edge, ascending; none when the edge falls on a mode.
fn find(
    system: &System,
    settings: &ModalSettings,
    factor: &Factor<'_>,
    edge: f64,
    count: usize,
    work: &mut ModalWork,
) -> Result<Option<Mat<f64>>, FemError> {
    let n = system.equations.len();
    let block = settings.block.clamp(1, n);
    if count == 0 {
        return Ok(Some(Mat::zeros(n, 0)));
    }
    if 2 * count + 8 * block > n {
        return dense(system, count).map(Some);
    }
    let (tolerance, max_vectors) = (settings.residual_limit / 10.0, settings.max_vectors);
    let target = Target {
        count,
        tolerance,
        block,
        max_vectors,
    };
    let found = lanczos(&system.mass, &target, |z| {
        let mut x = z.clone();
        factor.solve(x.as_mut());
        x *= Scale(edge);
        Ok(x)
    })?;
    Ok(found.map(|pairs| {
        work.block_steps += pairs.steps;
        work.solves += pairs.steps * block;
        work.restarts += pairs.restarts;
        pairs.vectors
    }))
}

/// All of a model so small that the modes wanted are half of what there is: with M = U D U^T and S = U D^-1/2 the
/// eigenvectors of S^T K S, times S.
fn dense(system: &System, count: usize) -> Result<Mat<f64>, FemError> {
    let n = system.equations.len();
    let identity: Mat<f64> = Mat::identity(n, n);
    let (d, mut s) = symmetric_eigen(product(&system.mass, identity.as_ref()).as_ref())?;
    for (j, d) in d.iter().enumerate() {
        s.col_mut(j).iter_mut().for_each(|x| *x /= d.sqrt());
    }
    let reduced = transpose_product(s.as_ref(), product(&system.stiffness, s.as_ref()).as_ref());
    let (_, y) = symmetric_eigen(reduced.as_ref())?;
    let mut phi = Mat::zeros(n, count);
    add_product(phi.as_mut(), 1.0, s.as_ref(), y.subcols(0, count));
    Ok(phi)
}

/// Mass-normalised modes on the equations, lambda ascending up to rounding.
struct Modes {
    lambda: Vec<f64>,
    phi: Mat<f64>,
    m_phi: Mat<f64>,
    residuals: Vec<f64>,
    rigid: Vec<bool>,
}

impl Modes {
    fn new(system: &System, mut phi: Mat<f64>, edge: f64) -> Self {
        let mut m_phi = product(&system.mass, phi.as_ref());
        for i in 0..phi.ncols() {
            let scale = 1.0 / dot(phi.as_ref(), m_phi.as_ref(), i).sqrt();
            phi.col_mut(i).iter_mut().for_each(|x| *x *= scale);
            m_phi.col_mut(i).iter_mut().for_each(|x| *x *= scale);
        }
        let k_phi = product(&system.stiffness, phi.as_ref());
        let lambda: Vec<f64> = (0..phi.ncols()).map(|i| dot(phi.as_ref(), k_phi.as_ref(), i)).collect();
        let rigid: Vec<bool> = lambda.iter().map(|l| l.abs() < RIGID * edge).collect();
        let mut modes = Self {
            lambda,
            phi,
            m_phi,
            residuals: Vec::new(),
            rigid,
        };
        let elastic = modes.elastic(edge);
        modes.residuals = (0..modes.lambda.len())
            .map(|i| {
                let lambda = modes.lambda[i];
                let (value, scale) = if modes.rigid[i] {
                    (0.0, elastic)
                } else {
                    (lambda, lambda)
                };
                let (mut difference, mut size) = (0.0, 0.0);
                for (a, b) in k_phi.col(i).iter().zip(modes.m_phi.col(i).iter()) {
                    difference += (a - value * b).powi(2);
                    size += (scale * b).powi(2);
                }
                (difference / size).sqrt()
            })
            .collect();
        modes
    }

    /// Takes modes whose residual r = K phi - lambda M phi is above `limit` through one step of inverse iteration with
    /// the factor of K - sigma M, and says how many.
    ///
    /// Rounding leaves components of high modes in the Lanczos basis, which K multiplies by their frequency squared; a
    /// solve divides them by it again. In the form phi - (K - sigma M)^-1 r the solve's own rounding is relative to r,
    /// not to phi. A component of mode j is multiplied by (lambda - sigma) / (lambda_j - sigma): with sigma at the edge
    /// that serves modes far above, with a small negative sigma all that are not in the basis, which the lowest modes
    /// of a basis of several decades need.
    fn refine(
        &mut self,
        system: &System,
        factor: &Factor<'_>,
        edge: f64,
        limit: f64,
        block: usize,
    ) -> Result<usize, FemError> {
        let poor: Vec<usize> = (0..self.lambda.len()).filter(|&i| self.residuals[i] > limit).collect();
        for chosen in poor.chunks(block.max(1)) {
            let rows = self.phi.nrows();
            let phi = Mat::from_fn(rows, chosen.len(), |r, c| self.phi[(r, chosen[c])]);
            let mut x = product(&system.stiffness, phi.as_ref());
            for (c, &i) in chosen.iter().enumerate() {
                let lambda = self.lambda[i];
                for (x, m_phi) in x.col_mut(c).iter_mut().zip(self.m_phi.col(i).iter()) {
                    *x -= lambda * m_phi;
                }
            }
            factor.solve(x.as_mut());
            x = phi - x;
            self.purge(system, &mut x, chosen);
            let refined = Self::new(system, x, edge);
            for (c, &i) in chosen.iter().enumerate() {
                // The residual of a rigid mode refers to the first elastic one, which may not be in this chunk.
                let elastic = self.elastic(edge);
                let of_chunk = refined.elastic(edge);
                let scale = if refined.rigid[c] { of_chunk / elastic } else { 1.0 };
                self.lambda[i] = refined.lambda[c];
                self.rigid[i] = refined.rigid[c];
                self.residuals[i] = refined.residuals[c] * scale;
                self.phi.col_mut(i).copy_from(refined.phi.col(c));
                self.m_phi.col_mut(i).copy_from(refined.m_phi.col(c));
            }
        }
        if !poor.is_empty() {
            self.orthogonalise(system, edge);
        }
        Ok(poor.len())
    }

    /// Makes modes that were refined one by one orthogonal again: with Phi^T M Phi = I + E, E some 1e-8,
    ///
    /// ```text
    /// Phi <- Phi (I - U),   U_ij = E_ij for lambda_i < lambda_j,   U_ii = E_ii / 2,
    /// ```
    ///
    /// leaves E^2. Of two modes the higher one is changed: a trace of the lower weighs less than its own size in the
    /// higher one's residual, the reverse would weigh lambda_j / lambda_i times as much.
    fn orthogonalise(&mut self, system: &System, edge: f64) {
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
        *self = Self::new(system, phi, edge);
    }

    /// Takes out of X, whose columns approximate the modes `chosen`, what it holds of other modes of the basis.
    ///
    /// Mode i holds phi_j^T (K - lambda_i M) x / (lambda_j - lambda_i) of mode j. Mere orthogonalisation would not do:
    /// a high mode's own trace of a low one, invisible in its residual, would be pushed into the low mode and there
    /// weigh lambda_j / lambda_i times as much. Near-degenerate modes, where the quotient says nothing, are made
    /// orthogonal.
    fn purge(&self, system: &System, x: &mut Mat<f64>, chosen: &[usize]) {
        let by_k = transpose_product(self.phi.as_ref(), product(&system.stiffness, x.as_ref()).as_ref());
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
    fn worst(&self) -> f64 {
        self.residuals.iter().fold(
            0.0,
            |a: f64, &b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) },
        )
    }

    /// The lowest lambda of an elastic mode, or the edge when there is none.
    fn elastic(&self, edge: f64) -> f64 {
        self.lambda
            .iter()
            .zip(&self.rigid)
            .filter(|(_, r)| !**r)
            .map(|(l, _)| *l)
            .fold(edge, f64::min)
    }

    /// Largest entry of |Phi^T M Phi - I|.
    fn orthonormality(&self) -> f64 {
        let gram = transpose_product(self.phi.as_ref(), self.m_phi.as_ref());
        (0..gram.ncols())
            .flat_map(|j| (0..gram.nrows()).map(move |i| (i, j)))
            .map(|(i, j)| (gram[(i, j)] - f64::from(u8::from(i == j))).abs())
            .fold(0.0, f64::max)
    }

    /// Residual vectors: what the modes above contribute to the response to each load.
    ///
    /// x = A^-1 f with A = K - sigma M, freed of the modes by x - Phi Phi^T M x, is the sum over the modes left out of
    /// phi phi^T f / (lambda - sigma): the static response for |sigma| far below their lambda, and defined for free
    /// bodies too. The Rayleigh-Ritz problem in the span of all x makes the set orthogonal and gives its frequencies.
    fn corrections(&self, system: &System, factor: &Factor<'_>, loads: &DMatrix<f64>) -> Result<Corrections, FemError> {
        let mut x = Mat::from_fn(loads.nrows(), loads.ncols(), |i, j| loads[(i, j)]);
        factor.solve(x.as_mut());
        let before: Vec<f64> = {
            let m_x = product(&system.mass, x.as_ref());
            (0..x.ncols()).map(|i| dot(x.as_ref(), m_x.as_ref(), i)).collect()
        };
        for _ in 0..2 {
            let c = transpose_product(self.m_phi.as_ref(), x.as_ref());
            add_product(x.as_mut(), -1.0, self.phi.as_ref(), c.as_ref());
        }
        let m_x = product(&system.mass, x.as_ref());
        // A load that the modes carry alone leaves rounding, which is not a shape.
        let kept: Vec<(usize, f64)> = (0..x.ncols())
            .map(|i| (i, dot(x.as_ref(), m_x.as_ref(), i)))
            .filter(|&(i, norm)| norm > 1e-20 * before[i] && norm > 0.0)
            .collect();
        let x = Mat::from_fn(x.nrows(), kept.len(), |i, j| x[(i, kept[j].0)] / kept[j].1.sqrt());
        let m_x = product(&system.mass, x.as_ref());
        let x = independent(&x, transpose_product(x.as_ref(), m_x.as_ref()).as_ref())?;
        let stiffness = product(&system.stiffness, x.as_ref());
        let reduced = transpose_product(x.as_ref(), stiffness.as_ref());
        let (lambda, s) = symmetric_eigen(reduced.as_ref())?;
        let mut shapes = Mat::zeros(x.nrows(), lambda.len());
        add_product(shapes.as_mut(), 1.0, x.as_ref(), s.as_ref());
        let hz = lambda.iter().map(|l| l.max(0.0).sqrt() / TAU).collect();
        Ok(Corrections {
            hz,
            shapes: expand(system, shapes.as_ref()),
        })
    }

    fn basis(self, system: &System, sturm: Sturm, corrections: Corrections, work: ModalWork) -> ModalBasis {
        let mut order: Vec<usize> = (0..self.lambda.len()).collect();
        order.sort_by(|&a, &b| self.lambda[a].total_cmp(&self.lambda[b]));
        let hz = |i: usize| {
            if self.rigid[i] {
                0.0
            } else {
                self.lambda[i].sqrt() / TAU
            }
        };
        let sorted = Mat::from_fn(self.phi.nrows(), order.len(), |i, j| self.phi[(i, order[j])]);
        ModalBasis {
            dofs: system.equations.len(),
            hz: order.iter().map(|&i| hz(i)).collect(),
            shapes: expand(system, sorted.as_ref()),
            residuals: order.iter().map(|&i| self.residuals[i]).collect(),
            rigid: order.iter().map(|&i| self.rigid[i]).collect(),
            orthonormality: self.orthonormality(),
            sturm,
            corrections,
            work,
        }
    }
}

/// An M-orthonormal basis of the span of X from its Gram matrix X^T M X; directions that depend on others are dropped.
fn independent(x: &Mat<f64>, gram: MatRef<'_, f64>) -> Result<Mat<f64>, FemError> {
    let (values, vectors) = symmetric_eigen(gram)?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len()).filter(|&i| values[i] > 1e-10 * largest).collect();
    let s = Mat::from_fn(x.ncols(), kept.len(), |i, j| {
        vectors[(i, kept[j])] / values[kept[j]].sqrt()
    });
    let mut basis = Mat::zeros(x.nrows(), kept.len());
    add_product(basis.as_mut(), 1.0, x.as_ref(), s.as_ref());
    Ok(basis)
}

fn dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>, column: usize) -> f64 {
    a.col(column).iter().zip(b.col(column).iter()).map(|(x, y)| x * y).sum()
}

fn expand(system: &System, columns: MatRef<'_, f64>) -> DMatrix<f64> {
    system
        .equations
        .expand(&DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| {
            columns[(i, j)]
        }))
}
