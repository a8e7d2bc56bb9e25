//! Vectorised products of matrices and motions in single precision.

use super::packed::{Motions, PackedHermitian, Pairs};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use pulp::{Arch, Simd, WithSimd};

/// Number of row entries that are multiplied before the sum is continued in double precision; those of 64 motions fit
/// in the cache.
const PIECE: usize = 1024;
/// Number of matrices and motions multiplied at once, limited by the number of registers.
const ROWS: usize = 4;
const COLUMNS: usize = 3;

/// a^H M a for every matrix of every sample and all motions (times the squares of their scales), ordered by sample,
/// matrix and motion.
pub(super) fn forms(samples: &[&PackedHermitian], motions: &Motions) -> Vec<f64> {
    let rows: Vec<&[f32]> = samples.iter().flat_map(|s| s.rows()).collect();
    let mut sums = vec![0.0; rows.len() * motions.len()];
    Arch::new().dispatch(Forms {
        skew: samples.iter().any(|s| s.is_skew()),
        rows: &rows,
        motions,
        sums: &mut sums,
    });
    sums
}

struct Forms<'a> {
    skew: bool,
    rows: &'a [&'a [f32]],
    motions: &'a Motions,
    sums: &'a mut [f64],
}

impl WithSimd for Forms<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (pairs, motions) = (self.motions.pairs(self.skew), self.motions.len());
        let longest = self.rows.iter().map(|row| row.len()).max().unwrap_or(0);
        for start in (0..longest).step_by(PIECE) {
            for (group, rows) in self.rows.chunks(ROWS).enumerate() {
                // Rows without an imaginary part are shorter.
                let length = rows.iter().map(|row| row.len()).min().unwrap_or(0);
                let even = rows.iter().all(|row| row.len() == length);
                let sums = &mut self.sums[group * ROWS * motions..];
                match *rows {
                    [a, b, c, d] if even => piece(simd, [a, b, c, d], &pairs, start, motions, sums),
                    [a, b, c] if even => piece(simd, [a, b, c], &pairs, start, motions, sums),
                    [a, b] if even => piece(simd, [a, b], &pairs, start, motions, sums),
                    _ => {
                        for (row, sums) in rows.iter().zip(sums.chunks_mut(motions)) {
                            piece(simd, [*row], &pairs, start, motions, sums);
                        }
                    }
                }
            }
        }
    }
}

/// Adds the products of a section of R rows with all motions.
#[inline(always)]
fn piece<S: Simd, const R: usize>(
    simd: S,
    rows: [&[f32]; R],
    pairs: &Pairs,
    start: usize,
    motions: usize,
    sums: &mut [f64],
) {
    let end = rows[0].len().min(start + PIECE);
    if start >= end {
        return;
    }
    let rows = rows.map(|row| S::as_simd_f32s(&row[start..end]).0);
    let column = |motion: usize| S::as_simd_f32s(&pairs.row(motion)[start..end]).0;
    let mut motion = 0;
    while motion + COLUMNS <= motions {
        let columns: [&[S::f32s]; COLUMNS] = std::array::from_fn(|c| column(motion + c));
        add(simd, rows, columns, motion, motions, sums);
        motion += COLUMNS;
    }
    while motion < motions {
        add(simd, rows, [column(motion)], motion, motions, sums);
        motion += 1;
    }
}

#[inline(always)]
fn add<S: Simd, const R: usize, const C: usize>(
    simd: S,
    rows: [&[S::f32s]; R],
    columns: [&[S::f32s]; C],
    motion: usize,
    motions: usize,
    sums: &mut [f64],
) {
    let length = columns[0].len();
    let (rows, columns) = (rows.map(|row| &row[..length]), columns.map(|column| &column[..length]));
    let mut products = [[simd.splat_f32s(0.0); C]; R];
    for k in 0..length {
        let of: [S::f32s; C] = std::array::from_fn(|c| columns[c][k]);
        for r in 0..R {
            let row = rows[r][k];
            for c in 0..C {
                products[r][c] = simd.mul_add_e_f32s(row, of[c], products[r][c]);
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            sums[r * motions + motion + c] += f64::from(simd.reduce_sum_f32s(products[r][c]));
        }
    }
}

/// M a for one real matrix and all motions: real and imaginary parts, modes x motions, divided by the motions' scales.
pub(super) fn real_images(matrix: &Mat<f32>, motions: &Motions) -> [Mat<f32>; 2] {
    [0, 1].map(|part| {
        let motion = Mat::from_fn(matrix.ncols(), motions.len(), |mode, m| motions.part(m)[part][mode]);
        let mut image = Mat::zeros(matrix.nrows(), motions.len());
        matmul(
            image.as_mut(),
            Accum::Replace,
            matrix.as_ref(),
            motion.as_ref(),
            1.0,
            Par::Seq,
        );
        image
    })
}

/// M a for one matrix as a row of [`PackedHermitian`] and one motion: real and imaginary parts.
pub(super) fn image(modes: usize, skew: bool, row: &[f32], motion: &[Vec<f32>; 2]) -> [Vec<f32>; 2] {
    Arch::new().dispatch(Image {
        modes,
        skew,
        row,
        motion,
    })
}

struct Image<'a> {
    modes: usize,
    skew: bool,
    row: &'a [f32],
    motion: &'a [Vec<f32>; 2],
}

impl WithSimd for Image<'_> {
    type Output = [Vec<f32>; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let n = self.modes;
        let mut symmetric = [vec![0.0; n], vec![0.0; n]];
        let rest = triangle(simd, self.row, 1, 1.0, self.motion, &mut symmetric);
        if self.skew {
            // j M a: the real part is -M times the imaginary part of a.
            let mut skew = [vec![0.0; n], vec![0.0; n]];
            triangle(simd, rest, 0, -1.0, self.motion, &mut skew);
            let [re, im] = &mut symmetric;
            re.iter_mut().zip(&skew[1]).for_each(|(re, x)| *re -= x);
            im.iter_mut().zip(&skew[0]).for_each(|(im, x)| *im += x);
        }
        symmetric
    }
}

/// Adds the product of a matrix, given by its upper triangle (the lower one is `sign` times its transpose), to `to`;
/// returns the remainder of the row after the triangle. `diagonal` is 1 if the triangle includes the diagonal.
#[inline(always)]
fn triangle<'a, S: Simd>(
    simd: S,
    row: &'a [f32],
    diagonal: usize,
    sign: f32,
    motion: &[Vec<f32>; 2],
    to: &mut [Vec<f32>; 2],
) -> &'a [f32] {
    let [re, im] = motion;
    let [to_re, to_im] = to;
    let mut row = row;
    for j in 0..re.len() {
        let (column, behind) = row.split_at(j + diagonal);
        row = behind;
        let (a, b) = (re[j], im[j]);
        if diagonal == 1 {
            to_re[j] += column[j] * a;
            to_im[j] += column[j] * b;
        }
        let column = &column[..j];
        let (vectors, tail) = S::as_simd_f32s(column);
        let (mut dot_re, mut dot_im) = (simd.splat_f32s(0.0), simd.splat_f32s(0.0));
        let (wide_a, wide_b) = (simd.splat_f32s(a), simd.splat_f32s(b));
        let inputs = S::as_simd_f32s(&re[..j]).0.iter().zip(S::as_simd_f32s(&im[..j]).0);
        let outputs = S::as_mut_simd_f32s(&mut to_re[..j]).0.iter_mut();
        let outputs = outputs.zip(S::as_mut_simd_f32s(&mut to_im[..j]).0);
        for ((m, (x, y)), (out_x, out_y)) in vectors.iter().zip(inputs).zip(outputs) {
            dot_re = simd.mul_add_e_f32s(*m, *x, dot_re);
            dot_im = simd.mul_add_e_f32s(*m, *y, dot_im);
            *out_x = simd.mul_add_e_f32s(*m, wide_a, *out_x);
            *out_y = simd.mul_add_e_f32s(*m, wide_b, *out_y);
        }
        let (mut sum_re, mut sum_im) = (simd.reduce_sum_f32s(dot_re), simd.reduce_sum_f32s(dot_im));
        for (i, m) in (j - tail.len()..j).zip(tail) {
            sum_re += m * re[i];
            sum_im += m * im[i];
            to_re[i] += m * a;
            to_im[i] += m * b;
        }
        to_re[j] += sign * sum_re;
        to_im[j] += sign * sum_im;
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiation::packed;
    use crate::radiation::resistance::Resistance;
    use nalgebra::{Complex, DMatrix};

    /// Compared with the definition in double precision, with and without an imaginary part, for sizes that do and do
    /// not fill vectors.
    #[test]
    fn products_are_those_of_the_matrices() {
        for n in [1, 2, 7, 8, 31, 64] {
            let wave = |i: usize, j: usize| ((i * 31 + j * 17) as f64 * 0.7).sin();
            let real = DMatrix::from_fn(n, n, |i, j| wave(i.min(j), i.max(j)) + f64::from(i == j));
            let skew = DMatrix::from_fn(n, n, |i, j| wave(i + 1, j) - wave(j + 1, i));
            let motion = DMatrix::from_fn(n, 5, |i, b| 1e3 * Complex::new(wave(i, b + 3), wave(b, i + 5)));
            let motions = Motions::new(&motion);
            let matrices = [
                Resistance {
                    real: real.clone(),
                    imaginary: None,
                },
                Resistance {
                    real,
                    imaginary: Some(skew),
                },
            ];
            let samples = matrices.each_ref().map(|m| PackedHermitian::new(n, std::iter::once(m)));
            let found = forms(&samples.each_ref(), &motions);
            for (m, (matrix, packed)) in matrices.iter().zip(&samples).enumerate() {
                let whole = matrix.real.map(Complex::from)
                    + matrix
                        .imaginary
                        .as_ref()
                        .map_or(DMatrix::zeros(n, n), |m| m.map(|x| Complex::new(0.0, x)));
                let size = whole.norm();
                for (b, a) in motion.column_iter().enumerate() {
                    let (scale, exact) = (motions.scale(b), &whole * a);
                    let form = found[m * 5 + b] * scale * scale;
                    assert!(
                        (form - a.dotc(&exact).re).abs() < 1e-6 * size * a.norm_squared(),
                        "{n} {m} {b}"
                    );
                    let row: Vec<f64> = packed.summed();
                    let double = packed::product(n, packed.is_skew(), &row, a.as_slice());
                    let rounded = packed.matrix(0, 1.0);
                    let rounded = rounded.product(&DMatrix::from_column_slice(n, 1, a.as_slice()));
                    assert!(
                        (double - rounded.column(0)).norm() < 1e-13 * size * a.norm(),
                        "{n} {m} {b}"
                    );
                    let [re, im] = image(n, packed.is_skew(), packed.row(0), motions.part(b));
                    for i in 0..n {
                        let found = Complex::new(f64::from(re[i]), f64::from(im[i])) * scale;
                        assert!((found - exact[i]).norm() < 1e-6 * size * a.norm(), "{n} {m} {b} {i}");
                    }
                }
            }
        }
    }
}
