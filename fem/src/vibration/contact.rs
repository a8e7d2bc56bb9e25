//! Support forces at the end of a step.

use super::error::TransientError;
use super::kernels::{Arch, Columns, Lane, combine, lanes, pivot};
use super::model::{Support, SupportLaw};
use super::response::Work;

/// Finds the support forces f at the end of a step, where penetrations and their rates depend on them.
///
///   d = d_free - C_d f,  d' = v_free - C_v f,  C_d = P^T diag(c1) P,  C_v = P^T diag(c2) P,
///   f_i = max(0, k_i d_i + c_i d_i')  where d_free,i > 0, else 0  (bonded: always, without the maximum).
///
/// With r = k d_free + c v_free and S = 1 + diag(k) C_d + diag(c) C_v, this is a linear complementarity problem. At the
/// points with d_free > 0 it reads f >= 0, S f >= r, f^T (S f - r) = 0. The condition is d_free > 0 instead of d > 0 to
/// make it solvable. At first contact the dashpot's force may be finite while d is still of order h. A law gated by d
/// itself then has no consistent state. The difference in d is C_d f = O(h^2).
///
/// The active set A of touching points is found by block principal pivoting: all violating points change at once, as in
/// the semismooth Newton method. The fallback is single pivots, which terminate for every P-matrix (Judice & Pires,
/// 1994, Computers Ops. Res. 21). T, the principal pivot transform of S on A, consists of inv(S_AA) and S_(not A) A
/// inv(S_AA). It is retained between steps, so a point that changes costs one rank-one update instead of a
/// factorisation.
#[derive(Debug)]
pub(super) struct ContactSolver {
    arch: Arch,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    bonded: Vec<bool>,
    original: Columns,
    pivoted: Columns,
    /// C_d above C_v, column by column.
    compliance: Columns,
    active: Vec<bool>,
    touching: Vec<usize>,
    pivots_since_rebuild: usize,
    scratch: Vec<Lane>,
    trial: Vec<Lane>,
    drop: Vec<Lane>,
    right: Vec<f64>,
    toggles: Vec<usize>,
    max_iterations: usize,
    /// Support forces.
    pub(super) force: Vec<f64>,
    /// Penetrations with these forces.
    pub(super) penetration: Vec<f64>,
    /// Rates of penetration with these forces.
    pub(super) rate: Vec<f64>,
    /// Largest |f - (k d + c d')| over touching points so far, relative to the largest force of the same step.
    pub(super) law_error: f64,
}

/// Number of rank-one updates after which the pivoted matrix is rebuilt, long before rounding accumulates.
const PIVOTS_PER_REBUILD: usize = 4096;

/// Violation of the contact law above which the pivoted matrix is rebuilt at once.
const LAW_TOLERANCE: f64 = 1e-11;

impl ContactSolver {
    /// `compliance` stores C_d above C_v; each column has 2 `lanes(n)` lanes.
    pub(super) fn new(arch: Arch, supports: &[Support], compliance: Columns, max_iterations: usize) -> Self {
        let n = supports.len();
        let height = lanes(n);
        let mut original = Columns::zeros(height, n);
        for j in 0..n {
            let source = compliance.column(j).as_flattened();
            let target = original.column_mut(j).as_flattened_mut();
            for i in 0..n {
                target[i] = supports[i].stiffness * source[i] + supports[i].damping * source[4 * height + i];
            }
            target[j] += 1.0;
        }
        Self {
            arch,
            stiffness: supports.iter().map(|s| s.stiffness).collect(),
            damping: supports.iter().map(|s| s.damping).collect(),
            bonded: supports.iter().map(|s| s.law == SupportLaw::Bonded).collect(),
            pivoted: original.clone(),
            original,
            compliance,
            active: vec![false; n],
            touching: Vec::with_capacity(n),
            pivots_since_rebuild: 0,
            scratch: vec![[0.0; 4]; height],
            trial: vec![[0.0; 4]; height],
            drop: vec![[0.0; 4]; 2 * height],
            right: vec![0.0; n],
            toggles: Vec::with_capacity(n),
            max_iterations,
            force: vec![0.0; n],
            penetration: vec![0.0; n],
            rate: vec![0.0; n],
            law_error: 0.0,
        }
    }

    /// Points that transmit force.
    pub(super) fn touching(&self) -> &[usize] {
        &self.touching
    }

    /// Sets penetrations and rates of a given state, and the forces that the law gives there.
    pub(super) fn start(&mut self, penetration: &[f64], rate: &[f64]) {
        self.penetration.copy_from_slice(penetration);
        self.rate.copy_from_slice(rate);
        for i in 0..self.force.len() {
            let force = self.stiffness[i] * penetration[i] + self.damping[i] * rate[i];
            let push = if penetration[i] > 0.0 { force.max(0.0) } else { 0.0 };
            self.force[i] = if self.bonded[i] { force } else { push };
        }
    }

    /// Solves for the forces at the end of a step, at `time`.
    pub(super) fn solve(
        &mut self,
        free: &[f64],
        free_rate: &[f64],
        time: f64,
        work: &mut Work,
    ) -> Result<(), TransientError> {
        let n = self.force.len();
        let mut scale: f64 = 0.0;
        self.toggles.clear();
        for i in 0..n {
            self.right[i] = self.stiffness[i] * free[i] + self.damping[i] * free_rate[i];
            let gate = self.bonded[i] || free[i] > 0.0;
            if gate {
                scale = scale.max(self.right[i].abs());
            }
            // An open point cannot transmit force; a bonded point always does.
            if self.active[i] != gate && (self.active[i] || self.bonded[i]) {
                self.toggles.push(i);
            }
        }
        self.change(work);
        if !scale.is_finite() {
            return Err(TransientError::NotFinite { time });
        }
        self.search(free, scale, time, work)?;
        let mut error = self.apply(free, free_rate);
        if error > LAW_TOLERANCE && self.pivots_since_rebuild > 0 {
            self.rebuild(work);
            self.search(free, scale, time, work)?;
            error = self.apply(free, free_rate);
        }
        self.law_error = self.law_error.max(error);
        Ok(())
    }

    /// Pivots until every point satisfies the law.
    fn search(&mut self, free: &[f64], scale: f64, time: f64, work: &mut Work) -> Result<(), TransientError> {
        const BLOCK_TRIALS: usize = 10;
        let tolerance = 1e-14 * scale;
        let (mut fewest, mut trials) = (usize::MAX, BLOCK_TRIALS);
        for iteration in 0.. {
            self.touching.clear();
            self.touching.extend((0..self.active.len()).filter(|&i| self.active[i]));
            self.toggles.clear();
            let all = 0..self.trial.len();
            combine(
                self.arch,
                &self.pivoted,
                all,
                &self.touching,
                &self.right,
                &mut self.trial,
            );
            let trial = self.trial.as_flattened();
            for i in 0..self.active.len() {
                let violates = if self.active[i] {
                    trial[i] < -tolerance
                } else {
                    free[i] > 0.0 && self.right[i] - trial[i] > tolerance
                };
                if violates && !self.bonded[i] {
                    self.toggles.push(i);
                }
            }
            if self.toggles.is_empty() {
                return Ok(());
            }
            work.contact_iterations += 1;
            if iteration >= self.max_iterations {
                return Err(TransientError::ContactNotConverged {
                    time,
                    iterations: iteration,
                    violations: self.toggles.len(),
                    supports: self.active.len(),
                });
            }
            if self.toggles.len() < fewest {
                (fewest, trials) = (self.toggles.len(), BLOCK_TRIALS);
            } else if trials > 0 {
                trials -= 1;
            } else {
                // Murty's rule: change only the last violating index; this cannot cycle.
                let last = self.toggles[self.toggles.len() - 1];
                self.toggles.clear();
                self.toggles.push(last);
            }
            self.change(work);
        }
        Ok(())
    }

    /// Computes forces, penetrations and rates from the trial; returns the violation of the law.
    fn apply(&mut self, free: &[f64], free_rate: &[f64]) -> f64 {
        self.force.fill(0.0);
        self.penetration.copy_from_slice(free);
        self.rate.copy_from_slice(free_rate);
        if self.touching.is_empty() {
            return 0.0;
        }
        let trial = self.trial.as_flattened();
        for &i in &self.touching {
            self.force[i] = if self.bonded[i] { trial[i] } else { trial[i].max(0.0) };
        }
        let all = 0..self.drop.len();
        combine(
            self.arch,
            &self.compliance,
            all,
            &self.touching,
            &self.force,
            &mut self.drop,
        );
        let drop = self.drop.as_flattened();
        let half = drop.len() / 2;
        for i in 0..self.force.len() {
            self.penetration[i] -= drop[i];
            self.rate[i] -= drop[half + i];
        }
        let (mut error, mut largest): (f64, f64) = (0.0, 0.0);
        for &i in &self.touching {
            let law = self.stiffness[i] * self.penetration[i] + self.damping[i] * self.rate[i];
            error = error.max((self.force[i] - law).abs());
            largest = largest.max(self.right[i].abs());
        }
        if largest > 0.0 { error / largest } else { 0.0 }
    }

    fn change(&mut self, work: &mut Work) {
        for index in 0..self.toggles.len() {
            let k = self.toggles[index];
            self.active[k] = !self.active[k];
            pivot(self.arch, &mut self.pivoted, k, &mut self.scratch);
        }
        work.contact_changes += self.toggles.len();
        self.pivots_since_rebuild += self.toggles.len();
        if self.pivots_since_rebuild > PIVOTS_PER_REBUILD {
            self.rebuild(work);
        }
    }

    fn rebuild(&mut self, work: &mut Work) {
        self.pivoted.data.copy_from_slice(&self.original.data);
        for k in (0..self.active.len()).filter(|&k| self.active[k]) {
            pivot(self.arch, &mut self.pivoted, k, &mut self.scratch);
        }
        self.pivots_since_rebuild = 0;
        work.factorisations += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// C_d and C_v as Gram matrices of random modes, which couple the points more strongly than a real step.
    fn compliance(n: usize, random: &mut Random) -> Columns {
        let mut joined = Columns::zeros(2 * lanes(n), n);
        for half in 0..2 {
            let modes: Vec<Vec<f64>> = (0..2 * n).map(|_| (0..n).map(|_| random.next()).collect()).collect();
            for k in 0..n {
                let column = joined.column_mut(k).as_flattened_mut();
                let start = half * column.len() / 2;
                for i in 0..n {
                    column[start + i] = modes.iter().map(|m| m[i] * m[k]).sum::<f64>() / n as f64;
                }
            }
        }
        joined
    }

    #[test]
    fn forces_obey_the_law_through_thousands_of_changing_states() {
        let n = 23;
        let mut random = Random::new(7);
        let supports: Vec<Support> = (0..n)
            .map(|i| Support {
                stiffness: 1.5 + random.next(),
                damping: 0.7 * (1.1 + random.next()),
                gap: 0.0,
                law: if i % 9 == 4 {
                    SupportLaw::Bonded
                } else {
                    SupportLaw::Unilateral
                },
            })
            .collect();
        let mut solver = ContactSolver::new(Arch::new(), &supports, compliance(n, &mut random), 200);
        let mut work = Work::default();
        for trial in 0..2000 {
            let free: Vec<f64> = (0..n).map(|_| random.next()).collect();
            let rate: Vec<f64> = (0..n).map(|_| 2.0 * random.next()).collect();
            solver.solve(&free, &rate, 0.0, &mut work).unwrap();
            for i in 0..n {
                let linear = supports[i].stiffness * solver.penetration[i] + supports[i].damping * solver.rate[i];
                let law = match supports[i].law {
                    SupportLaw::Bonded => linear,
                    SupportLaw::Unilateral => {
                        if free[i] > 0.0 {
                            linear.max(0.0)
                        } else {
                            0.0
                        }
                    }
                };
                assert!((solver.force[i] - law).abs() < 1e-10, "trial {trial}, support {i}");
            }
        }
        assert!(work.factorisations > 0 && work.contact_changes > 4096, "{work:?}");
        assert!(solver.law_error < 1e-9, "{:e}", solver.law_error);
    }

    #[test]
    fn too_few_iterations_are_an_error_with_the_time() {
        let n = 23;
        let mut random = Random::new(11);
        let support = Support {
            stiffness: 1.0,
            damping: 1.0,
            gap: 0.0,
            law: SupportLaw::Unilateral,
        };
        let mut solver = ContactSolver::new(Arch::new(), &vec![support; n], compliance(n, &mut random), 0);
        let found = solver.solve(&vec![1.0; n], &vec![1.0; n], 0.25, &mut Work::default());
        assert!(matches!(
            found,
            Err(TransientError::ContactNotConverged {
                time: 0.25,
                supports: 23,
                ..
            })
        ));
    }
}
