//! Hermitian roots of radiation resistances, which convert modal velocities into signals whose sum of squares is the
//! power.

use super::resistance::Resistance;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::traits::ComplexField;
use faer::traits::math_utils::{mul_real, real};
use faer::{Accum, Mat, Par, unzip, zip};
use nalgebra::{Complex, DMatrix};

/// Coupling between two modes below this fraction of their mean resistance is neglected, and resistances below this
/// fraction of the largest are raised to it. Stored matrices are rounded to this precision.
const NOTHING: f64 = f32::EPSILON as f64;

/// The Hermitian root of a resistance, S = S^H >= 0 with S^2 = R; its imaginary part is antisymmetric.
///
/// Unlike sorted eigenvectors, it is a smooth function of R and can be interpolated over frequency. Negative
/// eigenvalues, caused by rounding or interpolation, are set to zero. Groups of uncoupled modes, for example of
/// different parity, have separate roots.
pub(super) fn hermitian_root(resistance: &Resistance) -> Resistance {
    let mut root = Resistance {
        real: DMatrix::zeros(resistance.real.nrows(), resistance.real.ncols()),
        imaginary: resistance
            .imaginary
            .as_ref()
            .map(|m| DMatrix::zeros(m.nrows(), m.ncols())),
    };
    for group in independent(resistance) {
        let n = group.len();
        match (&resistance.imaginary, &mut root.imaginary) {
            (Some(imaginary), Some(to)) => {
                let at = |i: usize, j: usize| (group[i], group[j]);
                let entry = |i, j| Complex::new(resistance.real[at(i, j)], imaginary[at(i, j)]);
                let found = root_of(Mat::from_fn(n, n, entry));
                for (i, j) in pairs(n) {
                    root.real[at(i, j)] = found[(i, j)].re;
                    to[at(i, j)] = found[(i, j)].im;
                }
            }
            _ => {
                let found = root_of(Mat::from_fn(n, n, |i, j| resistance.real[(group[i], group[j])]));
                for (i, j) in pairs(n) {
                    root.real[(group[i], group[j])] = found[(i, j)];
                }
            }
        }
    }
    root
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |j| (0..n).map(move |i| (i, j)))
}

/// Groups of modes that are not coupled to each other, see [`NOTHING`].
fn independent(resistance: &Resistance) -> Vec<Vec<usize>> {
    let n = resistance.real.nrows();
    let least = NOTHING * resistance.real.diagonal().iter().copied().fold(0.0, f64::max);
    let size: Vec<f64> = resistance.real.diagonal().iter().map(|r| r.max(least).sqrt()).collect();
    let exchange = |i: usize, j: usize| {
        let limit = NOTHING * size[i] * size[j];
        let part = |m: &DMatrix<f64>| m[(i, j)].abs();
        let parts = [part(&resistance.real), resistance.imaginary.as_ref().map_or(0.0, part)];
        parts.iter().any(|part| part.is_nan() || *part > limit)
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut left: Vec<usize> = (0..n).collect();
    while let Some(first) = left.pop() {
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&j) = group.get(next) {
            left.retain(|&i| {
                let joins = exchange(i, j);
                if joins {
                    group.push(i);
                }
                !joins
            });
            next += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// U max(D, 0)^{1/2} U^H for the matrix U D U^H; NaN if the eigenvalues of an invalid matrix do not converge.
fn root_of<T: ComplexField<Real = f64>>(whole: Mat<T>) -> Mat<T> {
    let n = whole.nrows();
    let mut values = Diag::<T>::zeros(n);
    let mut vectors = Mat::<T>::zeros(n, n);
    let request = self_adjoint_evd_scratch::<T>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let found = self_adjoint_evd(
        whole.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(request)),
        Default::default(),
    );
    let mut scaled = vectors.clone();
    for (column, value) in scaled.col_iter_mut().zip(values.column_vector().iter()) {
        let root = if found.is_ok() {
            real(value).max(0.0).sqrt()
        } else {
            f64::NAN
        };
        zip!(column).for_each(|unzip!(x)| *x = mul_real(x, &root));
    }
    let mut root = Mat::zeros(n, n);
    matmul(
        root.as_mut(),
        Accum::Replace,
        scaled.as_ref(),
        vectors.as_ref().adjoint(),
        T::one_impl(),
        Par::Seq,
    );
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Modes that alternate between two parities, some of which hardly radiate; with and without an imaginary part.
    #[test]
    fn the_square_of_a_root_is_the_resistance() {
        let n = 12;
        let field = DMatrix::from_fn(2 * n, n, |i, j| {
            let size = 10f64.powi(-((j / 4) as i32));
            let alike = i % 2 == j % 2;
            if alike {
                size * ((i * 7 + j * 3) as f64 * 0.37).sin()
            } else {
                0.0
            }
        });
        let shifted = DMatrix::from_fn(2 * n, n, |i, j| field[(i, j)] * (0.3 * (i + j) as f64).cos());
        for phase in [0.0, 0.7] {
            let skew = field.transpose() * &shifted * phase;
            let resistance = Resistance {
                real: field.transpose() * &field + shifted.transpose() * &shifted * (phase * phase),
                imaginary: (phase > 0.0).then(|| &skew - skew.transpose()),
            };
            let root = hermitian_root(&resistance);
            let whole = |r: &Resistance| {
                let imaginary = |i, j| r.imaginary.as_ref().map_or(0.0, |m| m[(i, j)]);
                DMatrix::from_fn(n, n, |i, j| Complex::new(r.real[(i, j)], imaginary(i, j)))
            };
            let (exact, root) = (whole(&resistance), whole(&root));
            let off = &root * &root - &exact;
            for (i, j) in pairs(n) {
                let size = (exact[(i, i)].re * exact[(j, j)].re).sqrt();
                assert!(
                    off[(i, j)].norm() < 1e-9 * size,
                    "{i} {j}: {:e}",
                    off[(i, j)].norm() / size
                );
                assert!((root[(i, j)] - root[(j, i)].conj()).norm() < 1e-14);
            }
            assert_eq!(independent(&resistance).len(), 2);
        }
    }
}
