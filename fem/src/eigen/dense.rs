//! Dense kernels for tall blocks, split into fixed row blocks so that results are bitwise independent of the number of
//! threads.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::FemError;

/// Rows per block; the split depends only on the matrix.
pub(crate) const ROWS: usize = 4096;

/// V^T W.
pub(crate) fn transpose_product(v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    let n = v.nrows();
    let pieces: Vec<Mat<f64>> = (0..n.div_ceil(ROWS))
        .into_par_iter()
        .map(|k| {
            let rows = ROWS.min(n - k * ROWS);
            let (v, w) = (v.subrows(k * ROWS, rows), w.subrows(k * ROWS, rows));
            let mut c = Mat::zeros(v.ncols(), w.ncols());
            matmul(c.as_mut(), Accum::Replace, v.transpose(), w, 1.0, Par::Seq);
            c
        })
        .collect();
    let mut sum = Mat::zeros(v.ncols(), w.ncols());
    for piece in pieces {
        sum += piece;
    }
    sum
}

/// W += alpha V C.
pub(crate) fn add_product(w: MatMut<'_, f64>, alpha: f64, v: MatRef<'_, f64>, c: MatRef<'_, f64>) {
    w.par_row_chunks_mut(ROWS).enumerate().for_each(|(k, w)| {
        let v = v.subrows(k * ROWS, w.nrows());
        matmul(w, Accum::Add, v, c, alpha, Par::Seq);
    });
}

/// Makes the columns of W M-orthonormal, given Z = M W, which is transformed likewise. Returns the upper triangular R
/// with W = Q R, computed by Cholesky QR applied twice (Yamamoto et al. 2015), or none if W is too close to rank
/// deficiency.
pub(crate) fn cholesky_qr(w: &mut Mat<f64>, z: &mut Mat<f64>) -> Option<Mat<f64>> {
    let first = cholesky_qr_once(w, z)?;
    let second = cholesky_qr_once(w, z)?;
    let mut r = Mat::zeros(first.ncols(), first.ncols());
    matmul(r.as_mut(), Accum::Replace, second, first, 1.0, Par::Seq);
    Some(r)
}

fn cholesky_qr_once(w: &mut Mat<f64>, z: &mut Mat<f64>) -> Option<Mat<f64>> {
    let gram = transpose_product(w.as_ref(), z.as_ref());
    let b = gram.ncols();
    let mut r = Mat::<f64>::zeros(b, b);
    for j in 0..b {
        for i in 0..=j {
            let mut sum = gram[(i, j)];
            for k in 0..i {
                sum -= r[(k, i)] * r[(k, j)];
            }
            if i < j {
                r[(i, j)] = sum / r[(i, i)];
            } else if sum > 1e-12 * gram[(j, j)] {
                r[(j, j)] = sum.sqrt();
            } else {
                return None;
            }
        }
    }
    let mut inverse = Mat::<f64>::zeros(b, b);
    for j in 0..b {
        inverse[(j, j)] = 1.0 / r[(j, j)];
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| r[(i, k)] * inverse[(k, j)]).sum();
            inverse[(i, j)] = -sum / r[(i, i)];
        }
    }
    for tall in [w, z] {
        tall.par_row_chunks_mut(ROWS).for_each(|mut rows| {
            let copy = rows.to_owned();
            matmul(rows.rb_mut(), Accum::Replace, copy, &inverse, 1.0, Par::Seq);
        });
    }
    Some(r)
}

/// The number of negative eigenvalues of a symmetric band matrix with `width` off-diagonals on either side, from the
/// signs of its pivots.
pub(crate) fn negative_pivots(t: MatRef<'_, f64>, width: usize) -> usize {
    let n = t.nrows();
    let mut a = t.to_owned();
    let mut negative = 0;
    for j in 0..n {
        // A zero pivot counts as positive; shifting it changes less than rounding does.
        let pivot = if a[(j, j)] == 0.0 { f64::MIN_POSITIVE } else { a[(j, j)] };
        negative += usize::from(pivot < 0.0);
        let end = (j + width + 1).min(n);
        for c in j + 1..end {
            let factor = a[(c, j)] / pivot;
            for r in c..end {
                let value = a[(r, j)];
                a[(r, c)] -= factor * value;
            }
        }
    }
    negative
}

/// Eigenvalues in ascending order, and eigenvectors, of a symmetric matrix.
pub(crate) fn symmetric_eigen(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), FemError> {
    let n = a.nrows();
    let mut values = Diag::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let request = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(request).map_err(|_| FemError::TooLarge { dofs: n })?;
    self_adjoint_evd(
        a,
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|_| FemError::NotConverged {
        wanted: n,
        converged: 0,
        vectors: n,
    })?;
    Ok((values.column_vector().iter().copied().collect(), vectors))
}
