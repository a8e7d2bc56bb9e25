//! Computes all modes below a frequency and proves that none is missing.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::{Mat, MatMut, MatRef};
use nalgebra_sparse::CscMatrix;
use rayon::prelude::*;

use super::dense::{add_product, symmetric_eigen, transpose_product};
use super::eigenpairs::{Eigenpairs, dot};
use super::lanczos::{Target, lanczos};
use crate::factor::pencil::Pencil;
use crate::factor::sparse::{Split, product};
use crate::factor::subtrees::PartRows;
use crate::factor::{Factor, Symbolic};
use crate::symmetry::{Sector, sectors, whole};
use crate::{FemError, ModalBasis, ModalSettings, ModalWork, Sturm, System};

/// Number of edges tried.
const ATTEMPTS: usize = 6;

/// Static corrections are solved with the shift -(2 pi f)^2, where f is this fraction of the top frequency, so that a
/// solution exists for free bodies. The shift changes the contribution of modes above the top by at most its square,
/// 1e-4.
const SHIFT_FRACTION: f64 = 0.01;

/// Called from several threads with the number of modes found and the number of modes in the sectors factorised so far;
/// both restart from zero when the edge is moved.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// Solves K phi = lambda M phi for all modes below `settings.top_hz`.
///
/// K - sigma M = L D L^T with sigma = (2 pi top)^2 gives the number of modes below the top from the signs of D. The
/// factors then serve block Lanczos on sigma (K - sigma M)^-1 M until that many modes have converged. A single
/// factorisation thus serves both the modes and the proof that none is missing. Each mode's residual is then computed
/// from K and M. If the edge coincides with a mode, it is moved up by a few parts in ten thousand.
///
/// A body with mirror planes is solved sector by sector (even or odd in each plane). This takes a fraction of the work.
/// Residuals and orthonormality are those of the assembled modes on the full matrices.
///
/// # Errors
/// [`FemError::NotPositive`], [`FemError::LoadRows`]. [`FemError::Pivot`], [`FemError::Probe`],
/// [`FemError::NotConverged`] or [`FemError::Incomplete`] if the numerics fail; an incomplete basis is never returned.
pub fn modes(system: &System, settings: &ModalSettings, progress: &Progress<'_>) -> Result<ModalBasis, FemError> {
    // Work is distributed to threads thousands of times, for less than a millisecond each. A thread outside the pool
    // would sleep after each distribution, whereas a pool thread starts at once. A waiting pool thread may do other
    // work of the pool.
    let (basis, ()) = rayon::join(|| solve(system, settings, progress), || ());
    basis
}

fn solve(system: &System, settings: &ModalSettings, progress: &Progress<'_>) -> Result<ModalBasis, FemError> {
    if !(settings.top_hz.is_finite() && settings.top_hz > 0.0) {
        return Err(FemError::NotPositive {
            what: "the top frequency [Hz]",
            value: settings.top_hz,
        });
    }
    let loads = settings.loads.as_ref();
    let loads = loads.map(|loads| system.equations.restrict(loads)).transpose()?;
    let loads = loads.map(|f| Mat::from_fn(f.nrows(), f.ncols(), |i, j| f[(i, j)]));
    let sectors = if settings.mirrors {
        sectors(system)?
    } else {
        whole(system)?
    };
    let solve = |sectors: &[Sector<'_>]| Problem::new(system, sectors, settings, loads.as_ref(), progress)?.solve();
    match solve(&sectors) {
        // The symmetry is only approximate.
        Err(FemError::Residual { .. }) if sectors.len() > 1 => solve(&whole(system)?),
        solved => solved,
    }
}

/// The sectors of a body and the settings of the solution.
struct Problem<'a> {
    system: &'a System,
    sectors: &'a [Sector<'a>],
    symbolic: Vec<Arc<Symbolic>>,
    settings: &'a ModalSettings,
    /// Loads on the equations.
    loads: Option<&'a Mat<f64>>,
    progress: &'a Progress<'a>,
}

/// Counts the modes found so far in all sectors.
struct Counter<'a> {
    found: AtomicUsize,
    count: AtomicUsize,
    progress: &'a Progress<'a>,
}

impl Counter<'_> {
    fn report(&self) {
        (self.progress)(self.found.load(Ordering::Relaxed), self.count.load(Ordering::Relaxed));
    }
}

/// The modes of a sector below the edge.
struct Solution<'a> {
    pairs: Eigenpairs,
    /// Number of modes by the Sturm count.
    count: usize,
    factor: Factor<'a>,
}

impl<'a> Problem<'a> {
    fn new(
        system: &'a System,
        sectors: &'a [Sector<'a>],
        settings: &'a ModalSettings,
        loads: Option<&'a Mat<f64>>,
        progress: &'a Progress<'a>,
    ) -> Result<Self, FemError> {
        let symbolic = sectors.par_iter().map(|sector| sector.analyse(system));
        Ok(Self {
            system,
            sectors,
            symbolic: symbolic.collect::<Result<_, _>>()?,
            settings,
            loads,
            progress,
        })
    }

    fn solve(&self) -> Result<ModalBasis, FemError> {
        let mut work = ModalWork {
            sectors: self.sectors.len(),
            factor_values: self.symbolic.iter().map(|symbolic| symbolic.values()).sum(),
            ..ModalWork::default()
        };
        let mut upper_hz = self.settings.top_hz;
        for attempt in 1..=ATTEMPTS {
            let edge = (TAU * upper_hz).powi(2);
            let Some(solutions) = self.below(edge, attempt == ATTEMPTS, &mut work)? else {
                upper_hz *= 1.0 + 1e-4 * attempt as f64;
                continue;
            };
            let limit = self.settings.residual_limit;
            let count = solutions.iter().map(|s| s.count).sum();
            let found = |s: &Solution<'_>| s.pairs.lambda.iter().filter(|&&l| l < edge).count();
            if solutions
                .iter()
                .any(|s| found(s) != s.count || s.pairs.lambda.len() != s.count)
            {
                let found = solutions.iter().map(found).sum();
                return Err(FemError::Incomplete { found, count, upper_hz });
            }
            let poor = |s: &Solution<'_>| s.pairs.residuals.iter().any(|r| r.is_nan() || *r > limit);
            let (pairs, statics) = if self.loads.is_some() || solutions.iter().any(poor) {
                self.near_zero(solutions, -(TAU * SHIFT_FRACTION * upper_hz).powi(2), &mut work)?
            } else {
                (solutions.into_iter().map(|s| s.pairs).collect(), None)
            };
            let pairs = self.together(pairs, edge);
            let residual = pairs.worst();
            if residual.is_nan() || residual > limit {
                return Err(FemError::Residual { residual, limit });
            }
            let corrections = match statics {
                Some(x) => corrections(self.system, &pairs, x)?,
                None => Corrections {
                    hz: Vec::new(),
                    shapes: Mat::new(),
                },
            };
            return Ok(basis(self.system, pairs, Sturm { upper_hz, count }, corrections, work));
        }
        Err(FemError::NoGap { upper_hz })
    }

    /// The modes below the edge, refined; none if the edge coincides with a mode of some sector.
    fn below(&self, edge: f64, last: bool, work: &mut ModalWork) -> Result<Option<Vec<Solution<'_>>>, FemError> {
        let counter = Counter {
            found: AtomicUsize::new(0),
            count: AtomicUsize::new(0),
            progress: self.progress,
        };
        let found: Vec<_> = (self.sectors, &self.symbolic)
            .into_par_iter()
            .map(|(sector, symbolic)| {
                let mut work = ModalWork::default();
                let solution = self.sector_below(sector, symbolic, edge, &counter, &mut work);
                (solution, work)
            })
            .collect();
        let mut solutions = Vec::with_capacity(self.sectors.len());
        for (solution, spent) in found {
            work.add(&spent);
            match solution {
                Err(FemError::Pivot { .. } | FemError::Probe { .. }) if !last => {}
                solution => solutions.extend(solution?),
            }
        }
        if solutions.len() < self.sectors.len() {
            return Ok(None);
        }
        let elastic = solutions.iter().map(|s| s.pairs.elastic()).fold(edge, f64::min);
        // With loads, a factor at a shift near zero will be available, which serves all modes.
        if self.loads.is_some() {
            solutions.iter_mut().for_each(|s| s.pairs.refer_to(elastic));
            return Ok(Some(solutions));
        }
        let solves = (self.sectors, &mut solutions).into_par_iter().map(|(sector, s)| {
            s.pairs.refer_to(elastic);
            self.refine(sector, &mut s.pairs, &s.factor)
        });
        work.solves += solves.sum::<usize>();
        Ok(Some(solutions))
    }

    fn refine(&self, sector: &Sector<'_>, pairs: &mut Eigenpairs, factor: &Factor<'_>) -> usize {
        pairs.refine(sector.pencil(self.system), self.settings, |x| sector.solve(factor, x))
    }

    fn sector_below<'s>(
        &self,
        sector: &Sector<'_>,
        symbolic: &'s Symbolic,
        edge: f64,
        counter: &Counter<'_>,
        work: &mut ModalWork,
    ) -> Result<Option<Solution<'s>>, FemError> {
        work.factorisations += 1;
        let factor = symbolic.symmetric(&sector.shifted(self.system, edge)?, edge, Vec::new())?;
        let Some(count) = factor.negative_eigenvalues() else {
            return Ok(None);
        };
        counter.count.fetch_add(count, Ordering::Relaxed);
        let vectors = self.find(sector, &factor, (edge, count), counter, work)?;
        Ok(vectors.map(|vectors| {
            let mut vectors = if sector.reorders() {
                sector.expand(vectors.as_ref())
            } else {
                vectors
            };
            let pairs = |vectors| Eigenpairs::new(sector.pencil(self.system), vectors, edge, edge);
            let above = (vectors.ncols() > count).then(|| {
                let above = vectors.subcols(count, vectors.ncols() - count);
                above.to_owned()
            });
            vectors.truncate(vectors.nrows(), count);
            let (mut pairs, above) = rayon::join(|| pairs(vectors), || above.map(|above| Box::new(pairs(above))));
            pairs.above = above;
            Solution { pairs, count, factor }
        }))
    }

    /// The eigenvectors of the `count` eigenvalues below the edge in ascending order, followed by some just above it;
    /// none if the edge coincides with a mode.
    fn find(
        &self,
        sector: &Sector<'_>,
        factor: &Factor<'_>,
        (edge, count): (f64, usize),
        counter: &Counter<'_>,
        work: &mut ModalWork,
    ) -> Result<Option<Mat<f64>>, FemError> {
        let (n, settings) = (sector.len(), self.settings);
        // A sector with few modes needs smaller blocks, so that its basis grows in finer steps.
        let block = settings.block.min((count / 2).next_multiple_of(4).max(4)).clamp(1, n);
        if count == 0 {
            return Ok(Some(Mat::zeros(n, 0)));
        }
        if 2 * count + 8 * block > n {
            return dense(&*sector.stiffness(self.system)?, &sector.mass, count).map(Some);
        }
        let (tolerance, max_vectors) = (settings.residual_limit / 10.0, settings.max_vectors);
        let target = Target {
            count,
            tolerance,
            block,
            max_vectors,
        };
        let mut before = 0;
        let report = |found: usize| {
            // A restart retains the converged vectors, but rounding may lose one for a step.
            counter.found.fetch_add(found.saturating_sub(before), Ordering::Relaxed);
            before = before.max(found);
            counter.report();
        };
        let mass = Split::new(&sector.mass, factor.symbolic().subtrees());
        let apply = |z: MatRef<'_, f64>, w: MatMut<'_, f64>, room: &mut PartRows| {
            factor.solve_scaled(edge, z, w, room);
        };
        let found = lanczos(&mass, &target, report, apply)?;
        Ok(found.map(|pairs| {
            work.block_steps += pairs.steps;
            work.solves += pairs.steps * block;
            work.restarts += pairs.restarts;
            pairs.vectors
        }))
    }

    /// Refines the modes again with factors at a shift just below zero, and also solves for the static response to the
    /// loads.
    fn near_zero(
        &self,
        solutions: Vec<Solution<'_>>,
        shift: f64,
        work: &mut ModalWork,
    ) -> Result<(Vec<Eigenpairs>, Option<Mat<f64>>), FemError> {
        let parts: Vec<_> = (self.sectors, &self.symbolic, solutions)
            .into_par_iter()
            .map(|(sector, symbolic, solution)| {
                let (mut pairs, storage) = (solution.pairs, solution.factor.into_storage());
                let factor = symbolic.best(&sector.shifted(self.system, shift)?, shift, storage)?;
                let of_loads = |loads: &Mat<f64>| {
                    let mut x = sector.restrict(loads.as_ref());
                    factor.solve(x.as_mut());
                    x
                };
                let (refined, response) =
                    rayon::join(|| self.refine(sector, &mut pairs, &factor), || self.loads.map(of_loads));
                Ok((pairs, refined, response))
            })
            .collect::<Result<_, FemError>>()?;
        work.factorisations += parts.len();
        let mut statics: Option<Mat<f64>> = None;
        let mut all = Vec::with_capacity(parts.len());
        for (sector, (pairs, refined, response)) in self.sectors.iter().zip(parts) {
            work.solves += refined + response.as_ref().map_or(0, Mat::ncols);
            if let Some(x) = response.map(|x| sector.expand(x.as_ref())) {
                match &mut statics {
                    Some(sum) => *sum += x,
                    None => statics = Some(x),
                }
            }
            all.push(pairs);
        }
        Ok((all, statics))
    }

    /// Combines the modes of the sectors, with residuals computed from the matrices of the body.
    fn together(&self, mut pairs: Vec<Eigenpairs>, edge: f64) -> Eigenpairs {
        if let [sector] = self.sectors
            && sector.is_whole()
            && let Some(alone) = pairs.pop()
        {
            return alone;
        }
        let (n, count) = (self.system.equations.len(), pairs.iter().map(|p| p.lambda.len()).sum());
        let mut phi = Mat::zeros(n, count);
        let mut start = 0;
        for (sector, pairs) in self.sectors.iter().zip(pairs) {
            let part = sector.expand(pairs.phi.as_ref());
            phi.subcols_mut(start, part.ncols()).copy_from(&part);
            start += part.ncols();
        }
        let pencil = Pencil {
            stiffness: &self.system.stiffness,
            mass: &self.system.mass,
        };
        Eigenpairs::new(pencil, phi, edge, edge)
    }
}

/// Uses a dense method for small models, where half of all modes are sought. With M = U D U^T and S = U D^-1/2, the
/// modes are S times the eigenvectors of S^T K S.
fn dense(stiffness: &CscMatrix<f64>, mass: &CscMatrix<f64>, count: usize) -> Result<Mat<f64>, FemError> {
    let n = mass.nrows();
    let identity: Mat<f64> = Mat::identity(n, n);
    let (d, mut s) = symmetric_eigen(product(mass, identity.as_ref()).as_ref())?;
    for (j, d) in d.iter().enumerate() {
        s.col_mut(j).iter_mut().for_each(|x| *x /= d.sqrt());
    }
    let reduced = transpose_product(s.as_ref(), product(stiffness, s.as_ref()).as_ref());
    let (_, y) = symmetric_eigen(reduced.as_ref())?;
    let mut phi = Mat::zeros(n, count);
    add_product(phi.as_mut(), 1.0, s.as_ref(), y.subcols(0, count));
    Ok(phi)
}

/// Residual vectors: the contribution of the modes above the edge to the response to each load.
///
/// The vector x = A^-1 f with A = K - sigma M, after subtracting the modes (x - Phi Phi^T M x), is the sum over the
/// omitted modes of phi phi^T f / (lambda - sigma). This is the static response if |sigma| is far below their lambda,
/// and it exists for free bodies too. The Rayleigh-Ritz problem in the span of all x orthogonalises the set and yields
/// its frequencies.
fn corrections(system: &System, pairs: &Eigenpairs, mut x: Mat<f64>) -> Result<Corrections, FemError> {
    let before: Vec<f64> = {
        let m_x = product(&system.mass, x.as_ref());
        (0..x.ncols()).map(|i| dot(x.as_ref(), m_x.as_ref(), i)).collect()
    };
    for _ in 0..2 {
        let c = transpose_product(pairs.m_phi.as_ref(), x.as_ref());
        add_product(x.as_mut(), -1.0, pairs.phi.as_ref(), c.as_ref());
    }
    let m_x = product(&system.mass, x.as_ref());
    // If the modes carry a load completely, only rounding remains, which is not a shape.
    let kept: Vec<(usize, f64)> = (0..x.ncols())
        .map(|i| (i, dot(x.as_ref(), m_x.as_ref(), i)))
        .filter(|&(i, norm)| norm > 1e-20 * before[i] && norm > 0.0)
        .collect();
    let [x, m_x] = [x, m_x].map(|x| Mat::from_fn(x.nrows(), kept.len(), |i, j| x[(i, kept[j].0)] / kept[j].1.sqrt()));
    let x = independent(&x, transpose_product(x.as_ref(), m_x.as_ref()).as_ref())?;
    let stiffness = product(&system.stiffness, x.as_ref());
    let reduced = transpose_product(x.as_ref(), stiffness.as_ref());
    let (lambda, s) = symmetric_eigen(reduced.as_ref())?;
    let mut shapes = Mat::zeros(x.nrows(), lambda.len());
    add_product(shapes.as_mut(), 1.0, x.as_ref(), s.as_ref());
    let hz = lambda.iter().map(|l| l.max(0.0).sqrt() / TAU).collect();
    Ok(Corrections { hz, shapes })
}

/// Static corrections on the free degrees of freedom, see [`ModalBasis::corrections`].
struct Corrections {
    hz: Vec<f64>,
    shapes: Mat<f64>,
}

fn basis(system: &System, pairs: Eigenpairs, sturm: Sturm, corrections: Corrections, work: ModalWork) -> ModalBasis {
    let mut order: Vec<usize> = (0..pairs.lambda.len()).collect();
    order.sort_by(|&a, &b| pairs.lambda[a].total_cmp(&pairs.lambda[b]));
    let hz = |i: usize| {
        if pairs.rigid[i] {
            0.0
        } else {
            pairs.lambda[i].max(0.0).sqrt() / TAU
        }
    };
    let modes = order.len();
    let shape = |j: usize| match order.get(j) {
        Some(&mode) => pairs.phi.col(mode),
        None => corrections.shapes.col(j - modes),
    };
    let (shapes, orthonormality) = rayon::join(
        || system.equations.expanded(modes + corrections.hz.len(), shape),
        || pairs.orthonormality(),
    );
    ModalBasis {
        dofs: system.equations.len(),
        hz: order.iter().map(|&i| hz(i)).collect(),
        shapes,
        residuals: order.iter().map(|&i| pairs.residuals[i]).collect(),
        rigid: order.iter().map(|&i| pairs.rigid[i]).collect(),
        orthonormality,
        sturm,
        corrections: corrections.hz,
        work,
    }
}

/// An M-orthonormal basis of the span of X from its Gram matrix X^T M X; dependent directions are dropped.
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
