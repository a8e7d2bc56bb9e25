//! Adaptive cross approximation of the block between two distant clusters.
//!
//! ```text
//! M = [a  scale b] ~ sum_l u_l v_l^T      v_l: residual row i_l over its largest entry, in column j_l
//!                                         u_l: residual column j_l;   i_l+1: largest entry of u_l
//! ```
//!
//! (Bebendorf & Rjasanow 2003.) Regularly spaced rows sample the residual. The approximation ends when their norm is
//! small enough. If it is still large although the last cross was small, the largest of these rows is used next. This
//! detects parts of a block that the first crosses miss, such as those between perpendicular faces.
//!
//! Pressure and velocity share the crosses, because the left factors of both operators are sound fields of the same
//! sources.

use super::kernel::Kernels;
use super::points::{ClusterPoints, LANES};
use crate::bem::operators::kernel::load;
use pulp::{Simd, WithSimd};

/// Number of rows that sample the residual.
const SAMPLES: usize = 4;

/// A product of two thin matrices; each vector stores the real parts before the imaginary parts.
#[derive(Debug, Default)]
pub(super) struct Crosses {
    pub(super) rank: usize,
    /// u_l at the points of the receiving cluster, padded.
    pub(super) left: Vec<f32>,
    /// v_l: a at the points of the other cluster, then b at the points it owns, both padded.
    pub(super) right: Vec<f32>,
}

/// The block between the receivers `t` and the sources `s`.
pub(super) struct CrossedBlock<'a> {
    pub(super) kernels: &'a Kernels<'a>,
    pub(super) t: &'a ClusterPoints,
    pub(super) s: &'a ClusterPoints,
    /// Scales b to the magnitude of a.
    pub(super) scale: f32,
}

/// Squared norm of a padded vector.
fn norm_squared(v: &[f32]) -> f64 {
    let mut sums = [0f32; LANES];
    for v in v.chunks_exact(LANES) {
        sums.iter_mut().zip(v).for_each(|(sum, v)| *sum += v * v);
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
}

/// Position of the largest complex number among the first `count`, and its squared magnitude; real parts precede
/// imaginary parts.
fn largest(v: &[f32], count: usize) -> (usize, f32) {
    let (re, im) = v.split_at(v.len() / 2);
    let mut best = (0, -1.0);
    // Most chunks do not contain a new maximum.
    for start in (0..count).step_by(LANES) {
        let size = |i: usize| re[i] * re[i] + im[i] * im[i];
        let chunk = start..(start + LANES).min(count);
        let of_chunk = chunk.clone().map(size).fold(0.0, f32::max);
        if of_chunk > best.1 {
            best = (
                chunk.into_iter().find(|&i| size(i) == of_chunk).unwrap_or(start),
                of_chunk,
            );
        }
    }
    best
}

impl CrossedBlock<'_> {
    /// Length of v_l.
    pub(super) fn width(&self) -> usize {
        2 * (self.s.padded + self.s.own_padded)
    }

    fn row(&self, i: usize, to: &mut [f32]) {
        let point = (self.t.point(i), self.t.weight(i));
        self.kernels.row(point, self.s, (self.scale, self.s.own_padded), to);
    }

    /// The approximation with relative accuracy `tolerance` in the Frobenius norm.
    pub(super) fn approximate(&self, tolerance: f64) -> Crosses {
        let (t, s) = (self.t, self.s);
        let (width, height) = (self.width(), 2 * t.padded);
        let mut all = Crosses::default();
        let mut samples = Samples::new(self);
        let size = samples.size();
        if size == 0.0 {
            return all;
        }
        let square = tolerance * tolerance;
        // The squared norm of the block, estimated from the samples.
        let whole = size * t.count as f64 / samples.rows.len() as f64;
        let mut used = vec![false; t.count];
        let mut row = vec![0f32; width];
        let mut next = samples.largest(&used);
        while let Some(i) = next {
            used[i] = true;
            self.row(i, &mut row);
            let of_row = all.left_at(height, i, i + t.padded);
            subtract(&of_row, &all.right, width, 0, &mut row[..2 * s.padded]);
            subtract(&of_row, &all.right, width, 2 * s.padded, &mut row[2 * s.padded..]);
            let Some(pivot) = self.pivot(&mut row) else {
                next = samples.largest(&used);
                continue;
            };
            let start = all.left.len();
            all.left.resize(start + height, 0.0);
            let (before, column) = all.left.split_at_mut(start);
            let point = (s.point(pivot.point), s.weight(pivot.point));
            if pivot.of_velocity {
                self.kernels.column_b(point, t, self.scale, column);
            } else {
                self.kernels.column_a(point, t, column);
            }
            let at = |l: usize| pivot.places.map(|place| all.right[l * width + place]);
            let of_column: Vec<[f32; 2]> = (0..all.rank).map(at).collect();
            subtract(&of_column, before, height, 0, column);
            samples.subtract(column, &row, [t.padded, 2 * s.padded]);
            let small = norm_squared(column) * norm_squared(&row) <= square * whole;
            all.right.extend_from_slice(&row);
            all.rank += 1;
            next = match (small, samples.size() <= square * size) {
                (true, true) => None,
                (true, false) => samples.largest(&used),
                (false, _) => {
                    let (re, im) = all.left[start..].split_at(t.padded);
                    let size = |i: usize| re[i] * re[i] + im[i] * im[i];
                    let unused = (0..t.count).filter(|&i| !used[i]);
                    unused.max_by(|&a, &b| size(a).total_cmp(&size(b)).then(b.cmp(&a)))
                }
            };
        }
        all
    }

    /// Divides a residual row by its largest entry; none if the row is zero.
    fn pivot(&self, row: &mut [f32]) -> Option<Pivot> {
        let (of_a, of_b) = row.split_at(2 * self.s.padded);
        let ((a, size_a), (b, size_b)) = (largest(of_a, self.s.count), largest(of_b, self.s.own));
        let of_velocity = size_b > size_a;
        let (point, size) = if of_velocity { (b, size_b) } else { (a, size_a) };
        if size <= f32::MIN_POSITIVE {
            return None;
        }
        let (start, step) = if of_velocity {
            (2 * self.s.padded, self.s.own_padded)
        } else {
            (0, self.s.padded)
        };
        let places = [start + point, start + point + step];
        let inverse = [row[places[0]] / size, -row[places[1]] / size];
        let (of_a, of_b) = row.split_at_mut(2 * self.s.padded);
        for half in [of_a, of_b] {
            let (re, im) = half.split_at_mut(half.len() / 2);
            for (re, im) in re.iter_mut().zip(im) {
                (*re, *im) = (*re * inverse[0] - *im * inverse[1], *re * inverse[1] + *im * inverse[0]);
            }
        }
        Some(Pivot {
            point,
            of_velocity,
            places,
        })
    }
}

impl Crosses {
    /// Values of every u_l at the positions of a real and an imaginary part.
    fn left_at(&self, height: usize, re: usize, im: usize) -> Vec<[f32; 2]> {
        let at = |l: usize| [self.left[l * height + re], self.left[l * height + im]];
        (0..self.rank).map(at).collect()
    }
}

/// The largest entry of a residual row.
struct Pivot {
    /// Its point in the second cluster.
    point: usize,
    /// Whether it belongs to b.
    of_velocity: bool,
    /// Positions of its real and imaginary part in v_l.
    places: [usize; 2],
}

/// Regularly spaced rows of the residual.
struct Samples {
    rows: Vec<usize>,
    residuals: Vec<f32>,
    width: usize,
}

impl Samples {
    fn new(block: &CrossedBlock<'_>) -> Self {
        let (count, width) = (block.t.count, block.width());
        let samples = SAMPLES.min(count);
        let rows: Vec<usize> = (0..samples).map(|q| (2 * q + 1) * count / (2 * samples)).collect();
        let mut residuals = vec![0f32; samples * width];
        for (&i, row) in rows.iter().zip(residuals.chunks_exact_mut(width)) {
            block.row(i, row);
        }
        Self { rows, residuals, width }
    }

    /// Squared norm.
    fn size(&self) -> f64 {
        norm_squared(&self.residuals)
    }

    /// The unused row with the largest norm.
    fn largest(&self, used: &[bool]) -> Option<usize> {
        let norms = self.residuals.chunks_exact(self.width).map(norm_squared);
        let unused = self.rows.iter().copied().zip(norms).filter(|&(row, _)| !used[row]);
        unused.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
    }

    /// Subtracts a cross; in the column, imaginary parts begin at `imaginary`, and in the row, b begins at `of_b`.
    fn subtract(&mut self, column: &[f32], row: &[f32], [imaginary, of_b]: [usize; 2]) {
        for (&i, residual) in self.rows.iter().zip(self.residuals.chunks_exact_mut(self.width)) {
            let c = [[column[i], column[imaginary + i]]];
            subtract(&c, row, self.width, 0, &mut residual[..of_b]);
            subtract(&c, row, self.width, of_b, &mut residual[of_b..]);
        }
    }
}

/// Subtracts from `to` the sum of c_l times the vectors at `l * step + offset`; real parts precede imaginary parts.
fn subtract(c: &[[f32; 2]], vectors: &[f32], step: usize, offset: usize, to: &mut [f32]) {
    pulp::Arch::new().dispatch(Subtract {
        c,
        vectors,
        step,
        offset,
        to,
    });
}

struct Subtract<'a> {
    c: &'a [[f32; 2]],
    vectors: &'a [f32],
    step: usize,
    offset: usize,
    to: &'a mut [f32],
}

impl WithSimd for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let half = self.to.len() / 2;
        let (to_re, to_im) = self.to.split_at_mut(half);
        for at in (0..half).step_by(S::F32_LANES) {
            let to_re = &mut S::as_mut_simd_f32s(&mut to_re[at..at + S::F32_LANES]).0[0];
            let to_im = &mut S::as_mut_simd_f32s(&mut to_im[at..at + S::F32_LANES]).0[0];
            let (mut re, mut im) = (*to_re, *to_im);
            for (l, c) in self.c.iter().enumerate() {
                let start = l * self.step + self.offset + at;
                let (v_re, v_im) = (load::<S>(self.vectors, start), load::<S>(self.vectors, start + half));
                let (c_re, c_im) = (simd.splat_f32s(c[0]), simd.splat_f32s(c[1]));
                re = simd.negate_mul_add_e_f32s(c_re, v_re, re);
                re = simd.mul_add_e_f32s(c_im, v_im, re);
                im = simd.negate_mul_add_e_f32s(c_re, v_im, im);
                im = simd.negate_mul_add_e_f32s(c_im, v_re, im);
            }
            (*to_re, *to_im) = (re, im);
        }
    }
}
