//! Solves many small complex systems at once by GMRES (Saad & Schultz 1986), with one operator product for the vectors
//! of all systems.

use nalgebra::{Complex, DMatrix};

/// Solutions, with convergence data.
pub(super) struct Solved {
    /// One system per column.
    pub(super) solutions: DMatrix<Complex<f64>>,
    /// Largest number of products needed by any system.
    pub(super) products: usize,
    /// First system that did not converge, and its relative residual.
    pub(super) failed: Option<(usize, f64)>,
}

/// The Krylov subspace of one system.
struct Space {
    /// Index of the system.
    column: usize,
    /// Upper triangle of the rotated Hessenberg matrix, column by column.
    triangle: Vec<Vec<Complex<f64>>>,
    /// Givens rotations (c, s).
    rotations: Vec<(f64, Complex<f64>)>,
    /// Rotated right-hand side.
    side: Vec<Complex<f64>>,
    basis: Vec<Vec<Complex<f64>>>,
    norm: f64,
}

impl Space {
    /// Relative residual.
    fn residual(&self) -> f64 {
        self.side.last().map_or(0.0, |x| x.norm()) / self.norm
    }

    /// Adds the product of the operator with the last vector.
    fn extend(&mut self, mut w: Vec<Complex<f64>>) {
        let mut h = Vec::with_capacity(self.basis.len() + 1);
        for v in &self.basis {
            let dot: Complex<f64> = v.iter().zip(&w).map(|(v, w)| v.conj() * w).sum();
            w.iter_mut().zip(v).for_each(|(w, v)| *w -= dot * v);
            h.push(dot);
        }
        let norm = norm(&w);
        for (k, (c, s)) in self.rotations.iter().enumerate() {
            let (a, b) = (h[k], h[k + 1]);
            h[k] = a * *c + s * b;
            h[k + 1] = b * *c - s.conj() * a;
        }
        let last = h.len() - 1;
        let a = h[last];
        let radius = a.norm().hypot(norm).max(f64::MIN_POSITIVE);
        // [c s; -s* c] [a; norm] = [r; 0].
        let phase = if a.norm() > 0.0 {
            a / a.norm()
        } else {
            Complex::from(1.0)
        };
        let (c, s) = (a.norm() / radius, phase * (norm / radius));
        h[last] = phase * radius;
        self.triangle.push(h);
        self.rotations.push((c, s));
        let b = self.side[last];
        self.side[last] = b * c;
        self.side.push(-s.conj() * b);
        if norm > 0.0 {
            w.iter_mut().for_each(|w| *w /= norm);
        }
        self.basis.push(w);
    }

    fn solution(&self) -> Vec<Complex<f64>> {
        let n = self.triangle.len();
        let mut y = self.side[..n].to_vec();
        for i in (0..n).rev() {
            let known: Complex<f64> = (i + 1..n).map(|k| self.triangle[k][i] * y[k]).sum();
            y[i] = (y[i] - known) / self.triangle[i][i];
        }
        let mut x = vec![Complex::default(); self.basis[0].len()];
        for (v, y) in self.basis.iter().zip(&y) {
            x.iter_mut().zip(v).for_each(|(x, v)| *x += y * v);
        }
        x
    }
}

fn norm(x: &[Complex<f64>]) -> f64 {
    x.iter().map(Complex::norm_sqr).sum::<f64>().sqrt()
}

/// Solves A_k x_k = b_k for the columns of `sides`; `product` receives indices of systems and one vector for each (as
/// columns), and returns A_k times each vector.
pub(super) fn solve(
    sides: &DMatrix<Complex<f64>>,
    tolerance: f64,
    product: impl Fn(&[usize], &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>>,
) -> Solved {
    let n = sides.nrows();
    let mut solutions = DMatrix::zeros(n, sides.ncols());
    let mut active: Vec<Space> = Vec::new();
    let mut failed: Option<(usize, f64)> = None;
    for (column, b) in sides.column_iter().enumerate() {
        let b: Vec<Complex<f64>> = b.iter().copied().collect();
        let norm = norm(&b);
        if !norm.is_finite() {
            failed = failed.or(Some((column, norm)));
        } else if norm > 0.0 {
            active.push(Space {
                column,
                triangle: Vec::new(),
                rotations: Vec::new(),
                side: vec![Complex::from(norm)],
                basis: vec![b.iter().map(|b| b / norm).collect()],
                norm,
            });
        }
    }
    let mut products = 0;
    while !active.is_empty() {
        let columns: Vec<usize> = active.iter().map(|space| space.column).collect();
        let vectors = active.iter().flat_map(|space| space.basis[products].iter().copied());
        let found = product(&columns, &DMatrix::from_iterator(n, active.len(), vectors));
        products += 1;
        for (space, w) in active.iter_mut().zip(found.column_iter()) {
            space.extend(w.iter().copied().collect());
        }
        active.retain(|space| {
            let converged = space.residual() <= tolerance;
            if !converged && products < n {
                return true;
            }
            if !converged && failed.is_none_or(|(first, _)| space.column < first) {
                failed = Some((space.column, space.residual()));
            }
            solutions.column_mut(space.column).copy_from_slice(&space.solution());
            false
        });
    }
    Solved {
        solutions,
        products,
        failed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_their_systems() {
        let n = 7;
        let matrix = |k: usize| {
            DMatrix::from_fn(n, n, |i, j| {
                let own = if i == j { 2.0 } else { 0.0 };
                Complex::new(own + ((3 * i + 5 * j + k) as f64).sin(), ((i * j + k) as f64).cos())
            })
        };
        let sides = DMatrix::from_fn(n, 3, |i, k| {
            if k == 1 {
                Complex::default()
            } else {
                Complex::new(i as f64 - 2.0, k as f64 + 1.0)
            }
        });
        let solved = solve(&sides, 1e-12, |numbers, v| {
            let mut w = v.clone();
            for (column, &k) in numbers.iter().enumerate() {
                w.set_column(column, &(matrix(k) * v.column(column)));
            }
            w
        });
        assert!(solved.failed.is_none());
        for k in 0..3 {
            let left = matrix(k) * solved.solutions.column(k) - sides.column(k);
            assert!(left.norm() <= 1e-10 * (1.0 + sides.column(k).norm()), "system {k}");
        }
    }
}
