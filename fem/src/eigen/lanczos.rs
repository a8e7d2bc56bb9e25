//! Block Lanczos iteration for the negative eigenvalues of (K - sigma M)^-1 M.
//!
//! With the shift sigma at the upper edge of the frequency range, theta = sigma / (lambda - sigma) is at most -1 for
//! every lambda in \[0, sigma) and positive above. The modes sought are the negative end of the spectrum. Their number
//! is the Sturm count of the factorisation that also serves the iteration. The basis remains M-orthonormal to rounding,
//! so ghost eigenvalues do not occur. By Cauchy interlacing, the number of negative Ritz values does not exceed that of
//! negative eigenvalues. If that many have converged, none is missing (Grimes, Lewis & Simon 1994, SIAM J. Matrix Anal.
//! Appl. 15, 228-272).

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::columns::Columns;
use super::dense::{add_product, cholesky_qr, negative_pivots, symmetric_eigen, transpose_product};
use super::eigenpairs::RIGID;
use crate::FemError;
use crate::factor::sparse::{PartsRoom, Split};
use crate::factor::subtrees::PartRows;
use crate::random::Random;

/// Smallest relative distance in lambda allowed between sigma and any eigenvalue.
const GAP: f64 = 1e-5;

/// Errors below which a basis that no longer improves is passed to the refinement, whose own residuals decide.
const REFINABLE: f64 = 1e-3;

/// Number of checks without improvement after which a basis counts as stagnant.
const STAGNANT_CHECKS: usize = 2;

/// Eigenvectors with theta above this are returned as well: their lambda exceeds sigma by at most a tenth. The operator
/// amplifies rounding most along these, and the refinement needs them to remove it.
const ABOVE: f64 = 10.0;

/// Largest relative residual |B y - theta y| / theta of such an eigenvector.
const ABOVE_ERROR: f64 = 1e-7;

/// Number of restarts after which the iteration fails.
const RESTARTS: usize = 50;

/// Goal of the iteration.
pub(crate) struct Target {
    /// Number of negative eigenvalues.
    pub(crate) count: usize,
    /// Largest |r| sigma / |lambda - sigma| relative to lambda, see [`Ritz::errors`].
    pub(crate) tolerance: f64,
    /// Block size.
    pub(crate) block: usize,
    /// The largest number of basis vectors.
    pub(crate) max_vectors: usize,
}

/// Result of the iteration.
pub(crate) struct Pairs {
    /// The eigenvectors of the negative eigenvalues in ascending order of lambda, followed by those just above sigma,
    /// see [`ABOVE`]. They are one power iteration ahead of the Ritz vectors and not normalised.
    pub(crate) vectors: Mat<f64>,
    /// Number of applications of the operator to a block.
    pub(crate) steps: usize,
    /// Number of restarts.
    pub(crate) restarts: usize,
}

/// The basis V, T = V^T M B V, and the next block Q.
struct Basis<'a> {
    mass: &'a Split<'a>,
    /// The accepted vectors, followed by Q.
    v: Columns,
    /// M Q.
    m_q: Mat<f64>,
    /// M times the most recently accepted vectors, with which the next application of B overlaps by more than rounding.
    m_last: Mat<f64>,
    t: Mat<f64>,
    /// Number of accepted vectors, excluding Q.
    size: usize,
    block: usize,
    /// Number of nonzero off-diagonals of T on either side.
    band: usize,
    /// R of the last step: B V = V T + Q R E^T, where E are the columns of the identity for the last block.
    coupling: Mat<f64>,
    random: Random,
    /// The next block, while it is computed.
    w: Mat<f64>,
    room: PartsRoom,
}

/// Ritz pairs of the current basis.
struct Ritz {
    /// Ritz values, ascending.
    theta: Vec<f64>,
    s: Mat<f64>,
    /// |B y - theta y| in the M-norm.
    residual: Vec<f64>,
}

/// Finds the `target.count` negative eigenpairs; `apply` writes sigma (K - sigma M)^-1 Z, and `progress` is called
/// after every step with the number of negative Ritz values. The dimension must exceed the count by at least five
/// blocks. None if an eigenvalue is so close to sigma that the others would lose accuracy.
pub(crate) fn lanczos(
    mass: &Split<'_>,
    target: &Target,
    mut progress: impl FnMut(usize),
    mut apply: impl FnMut(MatRef<'_, f64>, MatMut<'_, f64>, &mut PartRows),
) -> Result<Option<Pairs>, FemError> {
    let n = mass.len();
    let block = target.block.clamp(1, n);
    let limit = target.max_vectors.max(target.count + 4 * block).min(n - block);
    let mut basis = Basis::new(mass, block)?;
    let (mut steps, mut restarts, mut next_check) = (0, 0, target.count + block);
    let mut last_worst = f64::INFINITY;
    let mut stagnant = 0;
    loop {
        apply(basis.m_q.as_ref(), basis.w.as_mut(), &mut basis.room.from);
        steps += 1;
        basis.extend()?;
        let full = basis.size + block > limit;
        // Counting the negative eigenvalues of the band matrix is cheap and shows whether the full check can succeed.
        let negative = negative_pivots(basis.t.as_ref(), basis.band);
        progress(negative);
        let due = basis.size >= next_check && negative >= target.count;
        if !(full || due) {
            continue;
        }
        let ritz = basis.ritz()?;
        if ritz.norm() * GAP > 1.0 {
            return Ok(None);
        }
        let errors = ritz.errors(target.count);
        let converged = errors.iter().filter(|&&e| e <= target.tolerance).count();
        let worst = errors.iter().fold(0.0, |a: f64, &e| a.max(e));
        // The lowest modes of a basis that spans several decades reach the rounding error of the solves before the
        // tolerance. More vectors would not help; a refinement with a shift near these modes does.
        stagnant = if worst < REFINABLE && worst > 0.3 * last_worst {
            stagnant + 1
        } else {
            0
        };
        if converged == target.count || stagnant == STAGNANT_CHECKS {
            return Ok(Some(Pairs {
                vectors: basis.improved(&ritz, target.count),
                steps,
                restarts,
            }));
        }
        if full {
            if restarts == RESTARTS {
                return Err(FemError::NotConverged {
                    wanted: target.count,
                    converged,
                    vectors: basis.size,
                });
            }
            restarts += 1;
            basis.restart(&ritz, target.count + (limit - target.count) / 3);
        }
        // Errors fall by a constant factor per step. The next check is made when the current rate, or at best three
        // digits per step, would reach the tolerance.
        let pace = (last_worst / worst).log10().clamp(0.5, 3.0);
        let wait = ((worst / target.tolerance).log10() / pace).clamp(1.0, 4.0) as usize;
        last_worst = worst;
        next_check = basis.size + wait * block;
    }
}

impl Ritz {
    /// Largest |theta|.
    fn norm(&self) -> f64 {
        self.theta.iter().fold(0.0, |a: f64, t| a.max(t.abs()))
    }

    /// For each of the `count` negative pairs, the relative residual |K phi - lambda M phi| / |lambda M phi| of the
    /// improved vector, up to the difference between norms. With B phi = theta phi + r, it is
    /// |M r| sigma / (theta^2 lambda |M phi|) with theta = sigma / (lambda - sigma). For rigid modes, the lowest
    /// elastic lambda is used. A residual at the level of rounding in B counts as zero.
    fn errors(&self, count: usize) -> Vec<f64> {
        let norm = self.norm();
        let lambda = |i: usize| {
            if self.theta[i] < 0.0 {
                1.0 + 1.0 / self.theta[i]
            } else {
                f64::NAN
            }
        };
        let elastic = (0..count).map(lambda).filter(|&l| l > RIGID).fold(1.0, f64::min);
        let error = |i: usize| match self.theta[i] {
            theta if theta >= 0.0 => f64::INFINITY,
            _ if self.residual[i] < 8.0 * f64::EPSILON * norm => 0.0,
            theta => self.residual[i] / (theta * theta * lambda(i).max(elastic)),
        };
        (0..count).map(error).collect()
    }
}

impl<'a> Basis<'a> {
    fn new(mass: &'a Split<'a>, block: usize) -> Result<Self, FemError> {
        let n = mass.len();
        let mut random = Random::new(0x6e61_696c);
        let mut q = Mat::from_fn(n, block, |_, _| random.next());
        let mut m_q = mass.product(q.as_ref());
        let lost = FemError::NotConverged {
            wanted: block,
            converged: 0,
            vectors: 0,
        };
        cholesky_qr(&mut q, &mut m_q).ok_or(lost)?;
        let mut v = Columns::new(n);
        v.put(0, q.as_ref());
        Ok(Self {
            mass,
            v,
            m_q,
            m_last: Mat::zeros(n, 0),
            t: Mat::zeros(0, 0),
            size: 0,
            block,
            band: 2 * block - 1,
            coupling: Mat::zeros(block, block),
            random,
            w: q,
            room: PartsRoom::default(),
        })
    }

    /// Accepts Q, given W = B Q, and forms the next block.
    fn extend(&mut self) -> Result<(), FemError> {
        let (b, old) = (self.block, self.size);
        self.size += b;
        let mut t = Mat::zeros(self.size, self.size);
        t.submatrix_mut(0, 0, old, old).copy_from(&self.t);
        let mut w = std::mem::replace(&mut self.w, Mat::new());
        // Orthogonalising twice suffices: W overlaps only with the last blocks, and a pass over the complete basis
        // removes the rounding in every other direction.
        let start = old - self.m_last.ncols();
        let last = [(start..old, &self.m_last), (old..self.size, &self.m_q)];
        for (range, m_v) in last {
            let c = transpose_product(m_v.as_ref(), w.as_ref());
            self.v.add_product(range.clone(), w.as_mut(), -1.0, c.as_ref());
            accumulate(t.as_mut().submatrix_mut(range.start, old, range.len(), b), c.as_ref());
        }
        // M V of the block before last is no longer needed, so its memory is reused for M W.
        let mut z = std::mem::replace(&mut self.m_last, Mat::new());
        if z.ncols() != b {
            z = Mat::zeros(w.nrows(), b);
        }
        self.mass.product_into(w.as_ref(), z.as_mut(), &mut self.room);
        let c = self.v.transpose_product(0..self.size, z.as_ref());
        self.v.add_product(0..self.size, w.as_mut(), -1.0, c.as_ref());
        accumulate(t.as_mut().subcols_mut(old, b), c.as_ref());
        for j in old..self.size {
            for i in 0..=j {
                let mean = if i < old {
                    t[(i, j)]
                } else {
                    (t[(i, j)] + t[(j, i)]) / 2.0
                };
                t[(i, j)] = mean;
                t[(j, i)] = mean;
            }
        }
        self.t = t;
        self.mass.product_into(w.as_ref(), z.as_mut(), &mut self.room);
        self.coupling = match cholesky_qr(&mut w, &mut z) {
            Some(r) => r,
            None => self.replace(&mut w, &mut z)?,
        };
        self.v.put(self.size, w.as_ref());
        self.w = w;
        self.m_last = std::mem::replace(&mut self.m_q, z);
        Ok(())
    }

    /// Orthonormalises a W whose columns are nearly dependent. This means that an invariant subspace has been found;
    /// random directions replace those that vanished.
    fn replace(&mut self, w: &mut Mat<f64>, z: &mut Mat<f64>) -> Result<Mat<f64>, FemError> {
        let (b, original) = (self.block, w.clone());
        let norm = |x: &Mat<f64>, m_x: &Mat<f64>| transpose_product(x.as_ref(), m_x.as_ref())[(0, 0)].max(0.0).sqrt();
        let mut q: Mat<f64> = Mat::zeros(w.nrows(), 0);
        let scale = (0..b).map(|j| original.col(j).norm_l2()).fold(0.0, f64::max);
        for j in 0..b {
            let mut column = original.subcols(j, 1).to_owned();
            let mut done = column.norm_l2() <= 1e-10 * scale;
            if done {
                column.col_mut(0).iter_mut().for_each(|x| *x = self.random.next());
                done = false;
            }
            for _ in 0..5 {
                let before = norm(&column, &self.mass.product(column.as_ref()));
                for _ in 0..2 {
                    let c = self
                        .v
                        .transpose_product(0..self.size, self.mass.product(column.as_ref()).as_ref());
                    self.v.add_product(0..self.size, column.as_mut(), -1.0, c.as_ref());
                    let c = transpose_product(q.as_ref(), self.mass.product(column.as_ref()).as_ref());
                    add_product(column.as_mut(), -1.0, q.as_ref(), c.as_ref());
                }
                let after = norm(&column, &self.mass.product(column.as_ref()));
                if after > 1e-3 * before {
                    column *= faer::Scale(1.0 / after);
                    done = true;
                    break;
                }
                column.col_mut(0).iter_mut().for_each(|x| *x = self.random.next());
            }
            if !done {
                return Err(FemError::NotConverged {
                    wanted: b,
                    converged: j,
                    vectors: self.size,
                });
            }
            q.resize_with(w.nrows(), j + 1, |i, _| column[(i, 0)]);
        }
        *z = self.mass.product(q.as_ref());
        let r = transpose_product(z.as_ref(), original.as_ref());
        *w = q;
        Ok(r)
    }

    fn ritz(&self) -> Result<Ritz, FemError> {
        let (m, b) = (self.size, self.block);
        let (theta, s) = symmetric_eigen(self.t.as_ref())?;
        let last = &self.coupling * s.subrows(m - b, b);
        let residual = (0..m).map(|i| last.col(i).norm_l2()).collect();
        Ok(Ritz { theta, s, residual })
    }

    /// The Ritz vectors after one more application of the operator, B y / theta = y + Q R s_last / theta, which is
    /// available at no cost (Ericsson & Ruhe 1980, Math. Comp. 35, 1251-1268); lambda ascends as theta descends from
    /// -1.
    fn improved(self, ritz: &Ritz, count: usize) -> Mat<f64> {
        let (m, b) = (self.size, self.block);
        let above = (0..ritz.theta.len())
            .rev()
            .take_while(|&i| ritz.theta[i] > ABOVE)
            .filter(|&i| ritz.residual[i] < ABOVE_ERROR * ritz.theta[i]);
        let chosen: Vec<usize> = (0..count).rev().chain(above).collect();
        let mut s = Mat::zeros(m + b, chosen.len());
        for (i, &from) in chosen.iter().enumerate() {
            s.col_mut(i).subrows_mut(0, m).copy_from(ritz.s.col(from));
            let last = &self.coupling * ritz.s.col(from).subrows(m - b, b);
            for k in 0..b {
                s[(m + k, i)] = last[k] / ritz.theta[from];
            }
        }
        self.v.into_product(s.as_ref())
    }

    /// Retains the lowest Ritz vectors and the next block (thick restart, Wu & Simon 2000).
    fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let (m, b) = (self.size, self.block);
        let mut kept = Mat::zeros(self.m_q.nrows(), keep);
        self.v.add_product(0..m, kept.as_mut(), 1.0, ritz.s.subcols(0, keep));
        let next = self.v.columns(m..m + b);
        self.v.put(0, kept.as_ref());
        self.v.put(keep, next.as_ref());
        self.size = keep;
        self.m_last = self.mass.product(kept.as_ref());
        self.band = self.band.max(keep + b);
        self.t = Mat::from_fn(keep, keep, |i, j| if i == j { ritz.theta[i] } else { 0.0 });
    }
}

/// T += C.
fn accumulate(mut t: MatMut<'_, f64>, c: MatRef<'_, f64>) {
    for j in 0..c.ncols() {
        for (t, c) in t.rb_mut().col_mut(j).iter_mut().zip(c.col(j).iter()) {
            *t += c;
        }
    }
}
