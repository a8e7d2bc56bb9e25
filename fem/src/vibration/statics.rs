//! Static equilibrium on unilateral supports.

use nalgebra::{DMatrix, DVector};

use super::error::TransientError;
use super::model::{ModalBody, Support, SupportLaw};
use super::system::add_gram;

/// Equilibrium of all bodies, with the modes of the first body first.
pub(super) struct Equilibrium {
    /// Displacements q, one vector per body.
    pub(super) displacement: Vec<Vec<f64>>,
    /// Potential energy q^T omega^2 q/2 + sum k d^2/2 - load^T q \[J\].
    pub(super) potential: f64,
    /// Number of Newton iterations.
    pub(super) iterations: usize,
    /// Fraction of the load that acts on unsupported rigid motions and is omitted.
    pub(super) unsupported: f64,
}

/// Largest fraction of the load that may act on unsupported rigid motions: a vertical load has such components in the
/// horizontal rigid modes due to rounding.
const UNSUPPORTED_LIMIT: f64 = 1e-6;

/// Unbalanced fraction of the load below which the equilibrium counts as found.
const BALANCE_LIMIT: f64 = 1e-10;

const MAX_ITERATIONS: usize = 100;

/// Minimises the potential energy E by Newton's method with an exact line search.
///
///   E(q) = q^T Omega^2 q/2 - g^T q + sum_i k_i <d_i>^2/2,   d = P^T q - gap,  <d> = max(0, d), or d where bonded.
///
/// E is convex with a continuous gradient. The Newton step is reduced to the touching supports and the rigid
/// coordinates z (the Hessian of the elastic modes e is diagonal).
///
///   [ 1/k + P_e^T Omega^-2 P_e   -P_z^T ] [ lambda ]   [ -P_e^T Omega^-2 grad_e ]
///   [ P_z                         eps   ] [ dz     ] = [ -grad_z                ],
///   dq_e = -Omega^-2 (grad_e + P_e lambda).
///
/// Rigid motions that no support resists are omitted; eps only bounds the step while too few supports touch.
pub(super) fn equilibrium(
    bodies: &[ModalBody],
    supports: &[Support],
    load: &[f64],
) -> Result<Equilibrium, TransientError> {
    let problem = Problem::new(bodies, supports, load);
    let unsupported = problem.unsupported_share();
    if unsupported > UNSUPPORTED_LIMIT {
        return Err(TransientError::NotSupported {
            body: problem.unsupported_body(bodies),
            share: unsupported,
        });
    }
    let (solution, iterations) = problem.minimise(bodies)?;
    let mut displacement = Vec::with_capacity(bodies.len());
    let mut offset = 0;
    for body in bodies {
        displacement.push(solution.q.as_slice()[offset..offset + body.modes()].to_vec());
        offset += body.modes();
    }
    Ok(Equilibrium {
        displacement,
        potential: problem.potential(&solution.q),
        iterations,
        unsupported,
    })
}

struct Problem<'a> {
    supports: &'a [Support],
    /// Modes x supports of all bodies.
    p: DMatrix<f64>,
    omega2: DVector<f64>,
    /// Modal load.
    g: DVector<f64>,
    /// Indices of rigid and elastic modes.
    rigid: Vec<usize>,
    elastic: Vec<usize>,
    /// Orthonormal basis of the rigid motions that supports resist: rigid modes x coordinates.
    held: DMatrix<f64>,
    /// z coordinates x supports.
    p_z: DMatrix<f64>,
    /// P_e^T Omega^-2 P_e.
    compliance: DMatrix<f64>,
    eps: f64,
}

struct Solution {
    q: DVector<f64>,
    d: DVector<f64>,
}

impl<'a> Problem<'a> {
    fn new(bodies: &[ModalBody], supports: &'a [Support], load: &[f64]) -> Self {
        let modes: usize = bodies.iter().map(ModalBody::modes).sum();
        let n = supports.len();
        let load = DVector::from_column_slice(load);
        let (mut p, mut omega2, mut g) = (DMatrix::zeros(modes, n), DVector::zeros(modes), DVector::zeros(modes));
        let mut offset = 0;
        for body in bodies {
            let m = body.modes();
            p.rows_mut(offset, m).copy_from(&body.supports);
            omega2.rows_mut(offset, m).copy_from_slice(&body.omega);
            g.rows_mut(offset, m).copy_from(&(&body.loads * &load));
            offset += m;
        }
        omega2.apply(|w| *w *= *w);
        let (rigid, elastic): (Vec<usize>, Vec<usize>) = (0..modes).partition(|&j| omega2[j] == 0.0);
        let mut felt = p.select_rows(&rigid);
        for (i, support) in supports.iter().enumerate() {
            felt.column_mut(i).scale_mut(support.stiffness.sqrt());
        }
        let held = range(&felt);
        let p_z = held.tr_mul(&p.select_rows(&rigid));
        let mut compliance = DMatrix::zeros(n, n);
        add_gram(
            &mut compliance,
            &p,
            |j| if omega2[j] > 0.0 { 1.0 / omega2[j] } else { 0.0 },
        );
        let eps = 1e-10 * (held.tr_mul(&felt)).norm_squared();
        Self {
            supports,
            p,
            omega2,
            g,
            rigid,
            elastic,
            held,
            p_z,
            compliance,
            eps,
        }
    }

    fn rigid_load(&self) -> DVector<f64> {
        self.g.select_rows(&self.rigid)
    }

    /// Part of the load on rigid modes that no support can carry.
    fn unsupported_load(&self) -> DVector<f64> {
        let rigid = self.rigid_load();
        &rigid - &self.held * self.held.tr_mul(&rigid)
    }

    fn unsupported_share(&self) -> f64 {
        let all = self.g.norm();
        if all > 0.0 {
            self.unsupported_load().norm() / all
        } else {
            0.0
        }
    }

    fn unsupported_body(&self, bodies: &[ModalBody]) -> String {
        let mut rest = DVector::zeros(self.g.len());
        for (&j, value) in self.rigid.iter().zip(self.unsupported_load().iter()) {
            rest[j] = *value;
        }
        largest_body(bodies, &rest)
    }

    fn penetration(&self, q: &DVector<f64>) -> DVector<f64> {
        let mut d = self.p.tr_mul(q);
        for (d, support) in d.iter_mut().zip(self.supports) {
            *d -= support.gap;
        }
        d
    }

    fn touches(&self, i: usize, d: f64) -> bool {
        self.supports[i].stiffness > 0.0 && (self.supports[i].law == SupportLaw::Bonded || d > 0.0)
    }

    fn push(&self, d: &DVector<f64>) -> DVector<f64> {
        let force = |i: usize| {
            if self.touches(i, d[i]) {
                self.supports[i].stiffness * d[i]
            } else {
                0.0
            }
        };
        DVector::from_iterator(d.len(), (0..d.len()).map(force))
    }

    fn gradient(&self, s: &Solution) -> DVector<f64> {
        self.omega2.component_mul(&s.q) - &self.g + &self.p * self.push(&s.d)
    }

    fn potential(&self, q: &DVector<f64>) -> f64 {
        let d = self.penetration(q);
        0.5 * self.omega2.component_mul(q).dot(q) - self.g.dot(q) + 0.5 * self.push(&d).dot(&d)
    }

    /// Gradient excluding unsupported rigid motions.
    fn held_gradient(&self, s: &Solution) -> (DVector<f64>, DVector<f64>) {
        let gradient = self.gradient(s);
        (
            gradient.select_rows(&self.elastic),
            self.held.tr_mul(&gradient.select_rows(&self.rigid)),
        )
    }

    fn minimise(&self, bodies: &[ModalBody]) -> Result<(Solution, usize), TransientError> {
        let scale = self.g.norm();
        let q = DVector::zeros(self.g.len());
        let mut solution = Solution {
            d: self.penetration(&q),
            q,
        };
        let unbalanced = |s: &Solution| {
            let (elastic, rigid) = self.held_gradient(s);
            (elastic.norm_squared() + rigid.norm_squared()).sqrt()
        };
        // Without loads and with open gaps, the initial state is the solution; bonded or pre-stressed supports provide
        // a scale otherwise.
        let mut residual = unbalanced(&solution);
        let scale = scale.max(residual);
        for iteration in 0..MAX_ITERATIONS {
            if residual == 0.0 {
                return Ok((solution, iteration));
            }
            // The first step treats all supports as touching, which closes the gaps.
            let first = iteration == 0;
            let step = self.newton_step(&solution, first);
            let next = if first {
                self.moved(&solution, &step, 1.0)
            } else {
                self.line_search(&solution, &step)
            };
            let found = unbalanced(&next);
            // Once balanced, iterate only as long as rounding still allows the residual to decrease.
            if residual <= BALANCE_LIMIT * scale && found >= 0.5 * residual {
                return Ok((solution, iteration + 1));
            }
            (solution, residual) = (next, found);
        }
        if residual <= BALANCE_LIMIT * scale {
            return Ok((solution, MAX_ITERATIONS));
        }
        Err(TransientError::NoEquilibrium {
            body: largest_body(bodies, &self.gradient(&solution)),
            iterations: MAX_ITERATIONS,
            residual: residual / scale,
            touching: (0..solution.d.len())
                .filter(|&i| self.touches(i, solution.d[i]))
                .count(),
        })
    }

    fn newton_step(&self, s: &Solution, all: bool) -> DVector<f64> {
        let (elastic, rigid) = self.held_gradient(s);
        let set: Vec<usize> = (0..s.d.len())
            .filter(|&i| self.supports[i].stiffness > 0.0 && (all || self.touches(i, s.d[i])))
            .collect();
        let relaxed = DVector::from_iterator(
            elastic.len(),
            elastic.iter().zip(&self.elastic).map(|(g, &j)| g / self.omega2[j]),
        );
        let p_e = self.p.select_rows(&self.elastic);
        let (a, z) = (set.len(), rigid.len());
        let (mut matrix, mut right) = (DMatrix::zeros(a + z, a + z), DVector::zeros(a + z));
        // Forces are scaled by the square root of k, so that all entries have the dimension of a rate.
        let root = |i: usize| self.supports[i].stiffness.sqrt();
        for (row, &i) in set.iter().enumerate() {
            for (column, &k) in set.iter().enumerate() {
                matrix[(row, column)] = root(i) * self.compliance[(i, k)] * root(k);
            }
            matrix[(row, row)] += 1.0;
            right[row] = -root(i) * p_e.column(i).dot(&relaxed);
            // While all supports count as touching, an open one is pulled closed.
            if all && !self.touches(i, s.d[i]) {
                right[row] += root(i) * s.d[i];
            }
            for c in 0..z {
                matrix[(row, a + c)] = -root(i) * self.p_z[(c, i)];
                matrix[(a + c, row)] = root(i) * self.p_z[(c, i)];
            }
        }
        for c in 0..z {
            matrix[(a + c, a + c)] = self.eps;
            right[a + c] = -rigid[c];
        }
        let solved = if right.is_empty() {
            None
        } else {
            matrix.lu().solve(&right)
        };
        let solved = solved.unwrap_or_else(|| DVector::zeros(a + z));
        let mut push = DVector::zeros(s.d.len());
        for (row, &i) in set.iter().enumerate() {
            push[i] = root(i) * solved[row];
        }
        let mut step = DVector::zeros(self.g.len());
        let change = p_e * push;
        for (row, &j) in self.elastic.iter().enumerate() {
            step[j] = -(elastic[row] + change[row]) / self.omega2[j];
        }
        let rigid = &self.held * solved.rows(a, z);
        for (row, &j) in self.rigid.iter().enumerate() {
            step[j] = rigid[row];
        }
        step
    }

    /// Minimum of E along the step: a zero of its slope, which is continuous and nondecreasing.
    fn line_search(&self, s: &Solution, step: &DVector<f64>) -> Solution {
        let drop = self.p.tr_mul(step);
        let slope = |alpha: f64| {
            let there = Solution {
                q: &s.q + step * alpha,
                d: &s.d + &drop * alpha,
            };
            self.gradient(&there).dot(step)
        };
        if slope(1.0) <= 1e-6 * slope(0.0).abs() {
            return self.moved(s, step, 1.0);
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        self.moved(s, step, 0.5 * (low + high))
    }

    fn moved(&self, s: &Solution, step: &DVector<f64>, alpha: f64) -> Solution {
        let q = &s.q + step * alpha;
        Solution {
            d: self.penetration(&q),
            q,
        }
    }
}

/// Orthonormal basis of a matrix's column space.
fn range(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    if matrix.nrows() == 0 || matrix.ncols() == 0 {
        return DMatrix::zeros(matrix.nrows(), 0);
    }
    // Eigenvectors of A A^T, whose size is the small number of rigid modes. Rounding leaves eigenvalues of 1e-16;
    // motions with a support a million times weaker than that of the others count as unsupported.
    let eigen = (matrix * matrix.transpose()).symmetric_eigen();
    let limit = 1e-12 * eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..matrix.nrows()).filter(|&k| eigen.eigenvalues[k] > limit).collect();
    eigen.eigenvectors.select_columns(&kept)
}

fn largest_body(bodies: &[ModalBody], modal: &DVector<f64>) -> String {
    let mut offset = 0;
    let mut largest = (f64::NEG_INFINITY, String::new());
    for body in bodies {
        let norm = modal.rows(offset, body.modes()).norm();
        if norm > largest.0 {
            largest = (norm, body.name.clone());
        }
        offset += body.modes();
    }
    largest.1
}
