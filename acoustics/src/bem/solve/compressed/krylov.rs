//! Block GMRES for many right-hand sides, as generalised conjugate residuals.
//!
//! ```text
//! Z = independent residuals, made orthonormal and preconditioned      A Z = Q T, Q orthonormal
//! R <- R - Q Q^H R                                                                X = Z T^-1 Q^H B
//! ```
//!
//! All right-hand sides share one subspace. A direction is omitted if no residual exceeds the tolerance in it.
//! Dependent patterns, and patterns that converge early, therefore cost nothing. The residual is recomputed at the end.

use super::operator::Compressed;
use super::schwarz::Schwarz;
use crate::bem::error::BemError;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::Complex;

/// Largest number of steps.
const STEPS: usize = 200;
/// Largest number of columns in the subspace, as a multiple of the right-hand sides, before a restart.
const COLUMNS: usize = 30;
/// Directions are added until the remainder of every residual is below this fraction of it; smaller remainders do not
/// pay off because one step reduces the residual less.
const PART: f64 = 0.25;
/// A remainder below this fraction of the tolerance also suffices.
const SHARE: f64 = 0.3;

type C32 = Complex<f32>;
type C64 = Complex<f64>;

/// A solution in progress.
pub(super) struct Krylov<'a> {
    matrix: &'a Compressed,
    schwarz: &'a Schwarz,
    held: &'a [bool],
    tolerance: f64,
    /// Number of steps taken.
    steps: usize,
}

/// The subspace: Z, Q and T.
struct Space {
    z: Vec<Mat<C32>>,
    q: Vec<Mat<C32>>,
    /// Columns of T: products of all earlier Q, and of the current one, with A Z.
    t: Vec<Vec<Mat<C32>>>,
    /// Q^H R at each step.
    c: Vec<Mat<C32>>,
}

impl<'a> Krylov<'a> {
    /// Unknowns marked in `held` are zero.
    pub(super) fn new(matrix: &'a Compressed, schwarz: &'a Schwarz, held: &'a [bool], tolerance: f64) -> Self {
        Self {
            matrix,
            schwarz,
            held,
            tolerance,
            steps: 0,
        }
    }

    /// D^-1/2 A D^-1/2 x, for x that is zero at the fixed unknowns.
    fn apply(&self, x: &Mat<C32>) -> Mat<C32> {
        let mut y = x.clone();
        self.scale(&mut y);
        let mut y = self.matrix.times(y.as_ref());
        self.scale(&mut y);
        y
    }

    /// D^-1/2 x, with zeros at the fixed unknowns.
    fn scale(&self, x: &mut Mat<C32>) {
        for column in 0..x.ncols() {
            let values = x.col_as_slice_mut(column).iter_mut();
            for ((x, scale), held) in values.zip(&self.schwarz.scale).zip(self.held) {
                *x = if *held { C32::default() } else { *x * *scale as f32 };
            }
        }
    }

    /// Solves for the right-hand sides, unknowns x patterns.
    ///
    /// # Errors
    /// [`BemError::NotConverged`].
    pub(super) fn solve(&mut self, right: &Mat<C64>) -> Result<Mat<C64>, BemError> {
        let (n, patterns) = right.shape();
        let scaled = |i: usize| if self.held[i] { 0.0 } else { self.schwarz.scale[i] };
        let size = |m: usize| {
            (0..n)
                .map(|i| (right[(i, m)] * scaled(i)).norm_sqr())
                .sum::<f64>()
                .sqrt()
        };
        let sizes: Vec<f64> = (0..patterns).map(size).collect();
        let inverse: Vec<f64> = sizes.iter().map(|s| if *s > 0.0 { 1.0 / s } else { 0.0 }).collect();
        let b = Mat::from_fn(n, patterns, |i, m| single(right[(i, m)] * (scaled(i) * inverse[m])));
        let mut x = Mat::<C32>::zeros(n, patterns);
        let mut residual = b.clone();
        let mut worst = largest(&residual);
        while worst > self.tolerance {
            if self.steps >= STEPS {
                return Err(BemError::NotConverged {
                    residual: worst,
                    tolerance: self.tolerance,
                    steps: self.steps,
                });
            }
            let space = self.build(&mut residual, 0.9 * self.tolerance);
            space.add_solution(&mut x);
            residual = &b - self.apply(&x);
            worst = largest(&residual);
        }
        Ok(Mat::from_fn(n, patterns, |i, m| {
            let x = C64::new(f64::from(x[(i, m)].re), f64::from(x[(i, m)].im));
            x * (scaled(i) * sizes[m])
        }))
    }

    /// Extends a subspace until all columns of the residual are below the tolerance or it becomes too large.
    fn build(&mut self, residual: &mut Mat<C32>, tolerance: f64) -> Space {
        let mut space = Space {
            z: Vec::new(),
            q: Vec::new(),
            t: Vec::new(),
            c: Vec::new(),
        };
        let most = COLUMNS * residual.ncols();
        let mut columns = 0;
        while largest(residual) > tolerance && self.steps < STEPS && columns < most {
            let z = independent(residual, SHARE * tolerance);
            let mut z = self.schwarz.times(z.as_ref());
            for column in 0..z.ncols() {
                let values = z.col_as_slice_mut(column).iter_mut();
                values
                    .zip(self.held)
                    .filter(|(_, held)| **held)
                    .for_each(|(z, _)| *z = C32::default());
            }
            let mut w = self.apply(&z);
            let mut t = Vec::with_capacity(space.q.len() + 1);
            for q in &space.q {
                let share = product(q.as_ref(), w.as_ref());
                subtract(&mut w, q, &share);
                t.push(share);
            }
            let (q, own) = orthonormal(w);
            t.push(own);
            let c = product(q.as_ref(), residual.as_ref());
            subtract(residual, &q, &c);
            columns += z.ncols();
            self.steps += 1;
            space.z.push(z);
            space.q.push(q);
            space.t.push(t);
            space.c.push(c);
        }
        space
    }
}

impl Space {
    /// Adds Z T^-1 C to `x`.
    fn add_solution(mut self, x: &mut Mat<C32>) {
        for step in (0..self.z.len()).rev() {
            let y = solve_upper(&self.t[step][step], &self.c[step]);
            for before in 0..step {
                let (earlier, _) = self.c.split_at_mut(step);
                subtract(&mut earlier[before], &self.t[step][before], &y);
            }
            let one = C32::new(1.0, 0.0);
            matmul(x.as_mut(), Accum::Add, self.z[step].as_ref(), y.as_ref(), one, Par::Seq);
        }
    }
}

fn single(z: C64) -> C32 {
    C32::new(z.re as f32, z.im as f32)
}

/// Largest norm of a column.
fn largest(x: &Mat<C32>) -> f64 {
    let norm = |m: usize| {
        x.col_as_slice(m)
            .iter()
            .map(|x| f64::from(x.norm_sqr()))
            .sum::<f64>()
            .sqrt()
    };
    (0..x.ncols()).map(norm).fold(0.0, f64::max)
}

/// q^H w.
fn product(q: MatRef<'_, C32>, w: MatRef<'_, C32>) -> Mat<C32> {
    let mut share = Mat::zeros(q.ncols(), w.ncols());
    matmul(
        share.as_mut(),
        Accum::Replace,
        q.adjoint(),
        w,
        C32::new(1.0, 0.0),
        Par::Seq,
    );
    share
}

/// w - q share.
fn subtract(w: &mut Mat<C32>, q: &Mat<C32>, share: &Mat<C32>) {
    matmul(
        w.as_mut(),
        Accum::Add,
        q.as_ref(),
        share.as_ref(),
        C32::new(-1.0, 0.0),
        Par::Seq,
    );
}

/// The Gram matrix of the columns in double precision.
fn gram(x: &Mat<C32>) -> Mat<C64> {
    const ROWS: usize = 1024;
    let mut gram = Mat::zeros(x.ncols(), x.ncols());
    for first in (0..x.nrows()).step_by(ROWS) {
        let rows = ROWS.min(x.nrows() - first);
        let part = Mat::from_fn(rows, x.ncols(), |i, j| {
            let x = x[(first + i, j)];
            C64::new(f64::from(x.re), f64::from(x.im))
        });
        matmul(
            gram.as_mut(),
            Accum::Add,
            part.adjoint(),
            part.as_ref(),
            C64::new(1.0, 0.0),
            Par::Seq,
        );
    }
    gram
}

/// Orthonormal columns that span those of `x`, except for remainders smaller than [`PART`] of each column or than
/// `smallest`, from the pivoted Cholesky factorisation of the Gram matrix.
fn independent(x: &Mat<C32>, smallest: f64) -> Mat<C32> {
    let mut rest = gram(x);
    let n = rest.nrows();
    let allowed: Vec<f64> = (0..n)
        .map(|i| (PART * PART * rest[(i, i)].re).max(smallest * smallest))
        .collect();
    let mut chosen: Vec<usize> = Vec::new();
    // Columns of the factor L, with all n rows.
    let mut factor: Vec<Vec<C64>> = Vec::new();
    for _ in 0..n {
        let open = (0..n).filter(|&i| rest[(i, i)].re > allowed[i] && !chosen.contains(&i));
        let Some(pivot) = open.max_by(|&a, &b| rest[(a, a)].re.total_cmp(&rest[(b, b)].re).then(b.cmp(&a))) else {
            break;
        };
        let size = rest[(pivot, pivot)].re;
        let root = size.sqrt();
        let column: Vec<C64> = (0..n).map(|i| rest[(i, pivot)] / root).collect();
        for j in 0..n {
            let other = column[j].conj();
            for (rest, l) in rest.col_as_slice_mut(j).iter_mut().zip(&column) {
                *rest -= l * other;
            }
        }
        chosen.push(pivot);
        factor.push(column);
    }
    let rank = chosen.len();
    // G = L L^H of the chosen columns; X L^-H is orthonormal.
    let upper = Mat::from_fn(rank, rank, |i, j| {
        if i <= j {
            factor[i][chosen[j]].conj()
        } else {
            C64::default()
        }
    });
    let selected = Mat::from_fn(x.nrows(), rank, |i, j| x[(i, chosen[j])]);
    times_inverse(&selected, &upper)
}

/// x = Q T with orthonormal columns Q and T upper triangular.
fn orthonormal(x: Mat<C32>) -> (Mat<C32>, Mat<C32>) {
    let n = x.ncols();
    let mut total = Mat::<C64>::identity(n, n);
    let mut q = x;
    // Repeated once, because the condition number of the Gram matrix is the square of that of the columns.
    for _ in 0..2 {
        let rest = gram(&q);
        let mut upper = Mat::<C64>::zeros(n, n);
        for i in 0..n {
            for j in i..n {
                let inner: C64 = (0..i).map(|l| upper[(l, i)].conj() * upper[(l, j)]).sum();
                let value = rest[(i, j)] - inner;
                upper[(i, j)] = if i == j {
                    C64::new(value.re.max(f64::MIN_POSITIVE).sqrt(), 0.0)
                } else {
                    value / upper[(i, i)]
                };
            }
        }
        q = times_inverse(&q, &upper);
        total = &upper * &total;
    }
    (q, Mat::from_fn(n, n, |i, j| single(total[(i, j)])))
}

/// x times the inverse of an upper triangular matrix.
fn times_inverse(x: &Mat<C32>, upper: &Mat<C64>) -> Mat<C32> {
    let n = upper.nrows();
    let mut inverse = Mat::<C64>::zeros(n, n);
    for j in 0..n {
        inverse[(j, j)] = upper[(j, j)].inv();
        for i in (0..j).rev() {
            let inner: C64 = (i + 1..=j).map(|l| upper[(i, l)] * inverse[(l, j)]).sum();
            inverse[(i, j)] = -inner / upper[(i, i)];
        }
    }
    let inverse = Mat::from_fn(n, n, |i, j| single(inverse[(i, j)]));
    let mut result = Mat::zeros(x.nrows(), n);
    matmul(
        result.as_mut(),
        Accum::Replace,
        x.as_ref(),
        inverse.as_ref(),
        C32::new(1.0, 0.0),
        Par::Seq,
    );
    result
}

/// Solves an upper triangular system.
fn solve_upper(upper: &Mat<C32>, right: &Mat<C32>) -> Mat<C32> {
    let n = upper.nrows();
    let mut y = right.clone();
    for m in 0..y.ncols() {
        let y = y.col_as_slice_mut(m);
        for i in (0..n).rev() {
            let inner: C32 = (i + 1..n).map(|l| upper[(i, l)] * y[l]).sum();
            y[i] = (y[i] - inner) / upper[(i, i)];
        }
    }
    y
}
