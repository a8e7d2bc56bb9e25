//! Hermitian matrices in packed single-precision storage, and their products with motions.

use super::resistance::Resistance;
use faer::Mat;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Rows are padded with zeros to full vectors.
const LANES: usize = 16;

/// Hermitian matrices of the same size. The row of each matrix contains the upper triangle by columns. If any matrix
/// has an imaginary part, the imaginary part of the upper triangle, without its diagonal, follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PackedHermitian {
    modes: usize,
    skew: bool,
    matrices: usize,
    #[serde(with = "crate::blocks")]
    values: Vec<f32>,
}

impl PackedHermitian {
    /// Number of entries in a row.
    pub(super) fn length(modes: usize, skew: bool) -> usize {
        let pairs = modes * (modes + 1) / 2;
        (pairs + if skew { pairs - modes } else { 0 }).next_multiple_of(LANES)
    }

    /// Rounds to single precision.
    pub(crate) fn new<'a>(modes: usize, matrices: impl ExactSizeIterator<Item = &'a Resistance> + Clone) -> Self {
        let skew = matrices.clone().any(|m| m.imaginary.is_some());
        let (count, stride) = (matrices.len(), Self::length(modes, skew));
        let mut values = vec![0.0; count * stride];
        for (m, row) in matrices.zip(values.chunks_exact_mut(stride.max(1))) {
            let mut row = row.iter_mut();
            let mut put = |value: f64| row.next().into_iter().for_each(|to| *to = value as f32);
            for j in 0..modes {
                m.real.column(j).iter().take(j + 1).for_each(|v| put(*v));
            }
            for (j, column) in m.imaginary.iter().flat_map(|m| m.column_iter().enumerate()) {
                column.iter().take(j).for_each(|v| put(*v));
            }
        }
        Self {
            modes,
            skew,
            matrices: count,
            values,
        }
    }

    pub(super) fn modes(&self) -> usize {
        self.modes
    }

    pub(super) fn matrices(&self) -> usize {
        self.matrices
    }

    pub(super) fn is_skew(&self) -> bool {
        self.skew
    }

    /// Number of entries in a row.
    pub(super) fn stride(&self) -> usize {
        Self::length(self.modes, self.skew)
    }

    /// One matrix.
    pub(super) fn row(&self, matrix: usize) -> &[f32] {
        &self.values[matrix * self.stride()..][..self.stride()]
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &[f32]> {
        (0..self.matrices).map(|m| self.row(m))
    }

    /// All matrices.
    pub(crate) fn unpack(&self) -> Vec<Resistance> {
        (0..self.matrices).map(|m| self.matrix(m, 1.0)).collect()
    }

    /// `factor` times one matrix.
    pub(super) fn matrix(&self, matrix: usize, factor: f64) -> Resistance {
        self.unpacked(|at| factor * f64::from(self.row(matrix)[at]))
    }

    /// `factor` times the sum of all matrices.
    pub(super) fn sum(&self, factor: f64) -> Resistance {
        let sums = self.summed();
        self.unpacked(|at| factor * sums[at])
    }

    /// The sum of all matrices as one row, without rounding.
    pub(super) fn summed(&self) -> Vec<f64> {
        summed(&self.values, self.stride())
    }

    fn unpacked(&self, value: impl Fn(usize) -> f64) -> Resistance {
        let n = self.modes;
        let mut at = 0;
        let mut triangle = |diagonal: usize, sign: f64| {
            let mut m = DMatrix::zeros(n, n);
            for j in 0..n {
                for i in 0..j + diagonal {
                    m[(j, i)] = sign * value(at);
                    m[(i, j)] = value(at);
                    at += 1;
                }
            }
            m
        };
        let real = triangle(1, 1.0);
        Resistance {
            real,
            imaginary: self.skew.then(|| triangle(0, -1.0)),
        }
    }

    /// Combines the first `count` matrices into one and leaves the others unchanged.
    pub(super) fn with_sum_of(&self, count: usize) -> Self {
        let stride = self.stride();
        let (first, others) = self.values.split_at(count.min(self.matrices) * stride);
        let mut values: Vec<f32> = summed(first, stride).into_iter().map(|v| v as f32).collect();
        values.extend(others);
        Self {
            matrices: 1 + self.matrices.saturating_sub(count),
            values,
            ..*self
        }
    }

    /// Multiplies by `factor`.
    pub(super) fn scale(&mut self, factor: f64) {
        let factor = factor as f32;
        self.values.iter_mut().for_each(|v| *v *= factor);
    }

    /// Difference from `other`: all rows, one after the other.
    pub(super) fn less(&self, other: &Self) -> Vec<f64> {
        let pairs = self.values.iter().zip(&other.values);
        pairs.map(|(a, b)| f64::from(*a) - f64::from(*b)).collect()
    }

    /// Adds rows like those of [`Self::less`], each set times its factor.
    pub(super) fn add<'a>(&mut self, terms: impl Iterator<Item = (f64, &'a [f64])>) {
        let mut sums: Vec<f64> = self.values.iter().map(|v| f64::from(*v)).collect();
        for (factor, rows) in terms {
            sums.iter_mut().zip(rows).for_each(|(sum, v)| *sum += factor * v);
        }
        self.values.iter_mut().zip(sums).for_each(|(v, sum)| *v = sum as f32);
    }

    /// Appends zero matrices up to a total of `matrices`.
    pub(super) fn add_silent(&mut self, matrices: usize) {
        self.matrices = self.matrices.max(matrices);
        self.values.resize(self.matrices * self.stride(), 0.0);
    }

    /// The sum of all matrices as one row.
    pub(super) fn sum_row(&self) -> Vec<f32> {
        self.summed().into_iter().map(|v| v as f32).collect()
    }

    /// The real part of the sum of all matrices, with both triangles.
    pub(super) fn dense(&self) -> Mat<f32> {
        let row = self.sum_row();
        Mat::from_fn(self.modes, self.modes, |i, j| {
            row[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]
        })
    }

    /// Diagonal of the sum of all matrices.
    pub(super) fn diagonal(&self, mode: usize) -> f64 {
        self.sparse_form(&[(mode, 1.0)])
    }

    /// v^T M v for the sum M of all matrices, given the nonzero entries of a real v.
    pub(super) fn sparse_form(&self, v: &[(usize, f64)]) -> f64 {
        let entry = |row: &[f32], i: usize, j: usize| f64::from(row[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]);
        let of_row = |row: &[f32]| {
            let of_pair = |(n, &(i, a)): (usize, &(usize, f64))| {
                let below: f64 = v[..n].iter().map(|&(j, b)| b * entry(row, i, j)).sum();
                a * (a * entry(row, i, i) + 2.0 * below)
            };
            v.iter().enumerate().map(of_pair).sum::<f64>()
        };
        self.rows().map(of_row).sum()
    }
}

/// The sum of consecutive rows of the given length.
fn summed(rows: &[f32], length: usize) -> Vec<f64> {
    let mut sums = vec![0.0; length];
    for row in rows.chunks_exact(length.max(1)) {
        sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += f64::from(*v));
    }
    sums
}

/// The sum of some matrices in row form, without rounding.
pub(super) fn whole(modes: usize, matrices: &[Resistance]) -> Vec<f64> {
    let pairs = modes * (modes + 1) / 2;
    let mut row = vec![0.0; pairs];
    let add = |row: &mut [f64], m: &DMatrix<f64>, diagonal: usize| {
        let entries = (0..modes).flat_map(|j| &m.as_slice()[j * modes..][..j + diagonal]);
        row.iter_mut().zip(entries).for_each(|(to, v)| *to += v);
    };
    for m in matrices {
        add(&mut row, &m.real, 1);
        if let Some(imaginary) = &m.imaginary {
            row.resize(2 * pairs - modes, 0.0);
            add(&mut row[pairs..], imaginary, 0);
        }
    }
    row
}

/// M a for the matrix in a row with or without an imaginary part.
pub(super) fn product(modes: usize, skew: bool, row: &[f64], a: &[Complex<f64>]) -> DVector<Complex<f64>> {
    let mut product = vec![Complex::default(); modes];
    let (real, imaginary) = row.split_at(row.len().min(modes * (modes + 1) / 2));
    let mut rest = real;
    for j in 0..modes {
        let column;
        (column, rest) = rest.split_at(j + 1);
        let mut sum = a[j] * column[j];
        for ((to, a_i), m) in product.iter_mut().zip(a).zip(&column[..j]) {
            *to += a[j] * *m;
            sum += a_i * *m;
        }
        product[j] += sum;
    }
    let mut rest = imaginary;
    for j in 0..if skew { modes } else { 0 } {
        let column;
        (column, rest) = rest.split_at(j);
        let mut sum = Complex::default();
        for ((to, a_i), m) in product.iter_mut().zip(a).zip(column) {
            *to += a[j] * Complex::new(0.0, *m);
            sum -= a_i * Complex::new(0.0, *m);
        }
        product[j] += sum;
    }
    DVector::from_vec(product)
}

/// The diagonal of one matrix in a row.
pub(super) fn diagonal(modes: usize, row: &[f64]) -> impl Iterator<Item = f64> {
    (0..modes).map(|i| row[i * (i + 3) / 2])
}

/// Visits all entries of the Hermitian matrix in a row, each divided by the square roots of `scale` for its two modes.
/// The arguments are how often the entry occurs in the matrix, and its square. Real parts come first, then imaginary
/// ones.
pub(super) fn scaled_squares(scale: &[f64], row: &[f64], mut visit: impl FnMut(f64, f64)) {
    let mut entries = row.iter();
    for diagonal in [1, 0] {
        for (j, sj) in scale.iter().enumerate() {
            for ((i, si), entry) in scale[..j + diagonal].iter().enumerate().zip(&mut entries) {
                visit(if i == j { 1.0 } else { 2.0 }, entry * entry / (si * sj));
            }
        }
    }
}

/// `factor` times the sum of some consecutive rows.
pub(super) fn sum_of_rows(rows: &[f64], count: usize, factor: f64) -> Vec<f64> {
    let length = rows.len() / count.max(1);
    let mut sum = vec![0.0; length];
    for row in rows.chunks_exact(length.max(1)) {
        sum.iter_mut().zip(row).for_each(|(sum, v)| *sum += factor * v);
    }
    sum
}

/// Motions in single precision, each scaled by its largest amplitude.
pub(super) struct Motions {
    modes: usize,
    /// Amplitudes in the first half, and phases advanced by a quarter period in the second: real and imaginary parts of
    /// each motion.
    parts: Vec<[Vec<f32>; 2]>,
    scale: Vec<f64>,
}

impl Motions {
    /// Converts the columns of `motion`.
    pub(super) fn new(motion: &DMatrix<Complex<f64>>) -> Self {
        let (mut parts, mut scale) = (Vec::new(), Vec::new());
        for a in motion.column_iter() {
            // Comparisons are used instead of `f64::max`, which handles NaN and therefore needs several instructions.
            let largest = a.iter().fold([0.0f64; 2], |[re, im], a| {
                let (x, y) = (a.re.abs(), a.im.abs());
                [if x > re { x } else { re }, if y > im { y } else { im }]
            });
            let largest = largest[0].max(largest[1]);
            let inverse = if largest > 0.0 { 1.0 / largest } else { 0.0 };
            parts.push([
                a.iter().map(|a| (a.re * inverse) as f32).collect(),
                a.iter().map(|a| (a.im * inverse) as f32).collect(),
            ]);
            scale.push(largest);
        }
        Self {
            modes: motion.nrows(),
            parts,
            scale,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    pub(super) fn part(&self, motion: usize) -> &[Vec<f32>; 2] {
        &self.parts[motion]
    }

    /// Largest amplitude of a motion, by which its parts are divided.
    pub(super) fn scale(&self, motion: usize) -> f64 {
        self.scale[motion]
    }

    /// a_i* a_j for all pairs in the order of the rows of [`PackedHermitian`] matrices, with both triangles combined,
    /// by motion.
    #[inline(always)]
    pub(super) fn pairs(&self, skew: bool) -> Pairs {
        let stride = PackedHermitian::length(self.modes, skew);
        let mut values = vec![0.0; stride * self.len()];
        for ([re, im], row) in self.parts.iter().zip(values.chunks_exact_mut(stride.max(1))) {
            let mut at = 0;
            for (j, (a, b)) in re.iter().zip(im).enumerate() {
                let column = &mut row[at..=at + j];
                for ((to, x), y) in column.iter_mut().zip(re).zip(im) {
                    *to = 2.0 * (x * a + y * b);
                }
                column[j] *= 0.5;
                at += j + 1;
            }
            for (j, (a, b)) in re.iter().zip(im).enumerate().take(if skew { self.modes } else { 0 }) {
                for ((to, x), y) in row[at..at + j].iter_mut().zip(re).zip(im) {
                    *to = 2.0 * (y * a - x * b);
                }
                at += j;
            }
        }
        Pairs { stride, values }
    }
}

/// See [`Motions::pairs`].
pub(super) struct Pairs {
    stride: usize,
    values: Vec<f32>,
}

impl Pairs {
    pub(super) fn row(&self, motion: usize) -> &[f32] {
        &self.values[motion * self.stride..][..self.stride]
    }
}
