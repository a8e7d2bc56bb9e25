//! The most time-consuming loops of a run, on lanes of four modes.
//!
//! They use the machine's vector instructions (by pulp's dispatch), but no fused multiply-add, and an order of
//! summation that does not depend on the vector width. A run therefore gives the same bits on any machine. This matters
//! because a bouncing block amplifies rounding.

use std::ops::Range;

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
pub(super) use pulp::Arch;
use pulp::{Simd, WithSimd};

use super::recurrence::Recurrence;

/// The machine's vector instructions, with at most four values per vector.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[derive(Debug, Clone, Copy)]
pub(super) struct Arch(Option<pulp::x86::V3>);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
impl Arch {
    pub(super) fn new() -> Self {
        Self(pulp::x86::V3::try_new())
    }

    #[inline(always)]
    fn dispatch<Op: WithSimd>(self, op: Op) -> Op::Output {
        match self.0 {
            Some(simd) => Simd::vectorize(simd, op),
            None => Simd::vectorize(pulp::Scalar::new(), op),
        }
    }
}

/// Four values side by side.
pub(super) type Lane = [f64; 4];

/// Number of lanes needed for `values` values.
pub(super) fn lanes(values: usize) -> usize {
    values.div_ceil(4)
}

/// Column-major matrix whose columns are padded with zeros to full lanes.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Number of lanes per column.
    pub(super) height: usize,
    pub(super) data: Vec<Lane>,
}

impl Columns {
    pub(super) fn zeros(height: usize, columns: usize) -> Self {
        Self {
            height,
            data: vec![[0.0; 4]; height * columns],
        }
    }

    pub(super) fn column(&self, k: usize) -> &[Lane] {
        &self.data[k * self.height..(k + 1) * self.height]
    }

    pub(super) fn column_mut(&mut self, k: usize) -> &mut [Lane] {
        &mut self.data[k * self.height..(k + 1) * self.height]
    }
}

/// Coefficients of all modes, as separate arrays.
#[derive(Debug, Clone)]
pub(super) struct Coefficients {
    /// a11, a12, b1, c1: factors of q, v, g at the start and g at the end of a step in q at its end.
    displacement: [Vec<Lane>; 4],
    /// a21, a22, b2, c2: likewise for v.
    velocity: [Vec<Lane>; 4],
    /// The quadratic form of the dissipation.
    dissipation: [Vec<Lane>; 10],
}

impl Coefficients {
    pub(super) fn zeros(height: usize) -> Self {
        let zeros = || vec![[0.0; 4]; height];
        Self {
            displacement: std::array::from_fn(|_| zeros()),
            velocity: std::array::from_fn(|_| zeros()),
            dissipation: std::array::from_fn(|_| zeros()),
        }
    }

    pub(super) fn set(&mut self, lane: usize, slot: usize, r: Recurrence, dissipation: [f64; 10]) {
        for (entry, value) in self.displacement.iter_mut().zip([r.a11, r.a12, r.b1, r.c1]) {
            entry[lane][slot] = value;
        }
        for (entry, value) in self.velocity.iter_mut().zip([r.a21, r.a22, r.b2, r.c2]) {
            entry[lane][slot] = value;
        }
        for (entry, value) in self.dissipation.iter_mut().zip(dissipation) {
            entry[lane][slot] = value;
        }
    }
}

/// Modal quantities during one step, all with the same number of lanes.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// q at the start of the step.
    pub(super) q: Vec<Lane>,
    /// q' at the start of the step.
    pub(super) v: Vec<Lane>,
    /// Total modal force at the start of the step, applied and contact.
    pub(super) g: Vec<Lane>,
    /// Applied modal force at the end of the step.
    pub(super) applied: Vec<Lane>,
    /// Modal force of the supports at the end of the step.
    pub(super) contact: Vec<Lane>,
    /// q at the end of the step without support forces there.
    pub(super) q_free: Vec<Lane>,
    /// q' at the end of the step without support forces there.
    pub(super) v_free: Vec<Lane>,
    /// Energy dissipated by the mode so far.
    pub(super) dissipated: Vec<Lane>,
}

impl State {
    pub(super) fn rest(height: usize) -> Self {
        let zero = vec![[0.0; 4]; height];
        Self {
            q: zero.clone(),
            v: zero.clone(),
            g: zero.clone(),
            applied: zero.clone(),
            contact: zero.clone(),
            q_free: zero.clone(),
            v_free: zero.clone(),
            dissipated: zero,
        }
    }
}

/// Views lanes of four values as the machine's vectors (of one, two or four values).
#[inline(always)]
fn vectors<S: Simd>(lanes: &[Lane]) -> &[S::f64s] {
    // Longer vectors would miss the end of an odd number of lanes.
    const {
        assert!(
            size_of::<S::f64s>() <= size_of::<Lane>(),
            "a vector holds more than a lane"
        )
    };
    S::as_simd_f64s(lanes.as_flattened()).0
}

/// Mutable version of `vectors`.
#[inline(always)]
fn vectors_mut<S: Simd>(lanes: &mut [Lane]) -> &mut [S::f64s] {
    const {
        assert!(
            size_of::<S::f64s>() <= size_of::<Lane>(),
            "a vector holds more than a lane"
        )
    };
    S::as_mut_simd_f64s(lanes.as_flattened_mut()).0
}

/// sum_k c_k[i] x_k; the first two and the last two terms are added first.
#[inline(always)]
fn weighted<S: Simd>(simd: S, c: &[&[S::f64s]; 4], i: usize, x: [S::f64s; 4]) -> S::f64s {
    let first = simd.add_f64s(simd.mul_f64s(c[0][i], x[0]), simd.mul_f64s(c[1][i], x[1]));
    let second = simd.add_f64s(simd.mul_f64s(c[2][i], x[2]), simd.mul_f64s(c[3][i], x[3]));
    simd.add_f64s(first, second)
}

/// q_free = a11 q + a12 v + b1 g + c1 applied, and v_free likewise.
pub(super) fn predict(arch: Arch, coefficients: &Coefficients, state: &mut State) {
    struct Predict<'a>(&'a Coefficients, &'a mut State);
    impl WithSimd for Predict<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(c, s) = self;
            let [a11, a12, b1, c1] = &c.displacement;
            let [a21, a22, b2, c2] = &c.velocity;
            let (q, v) = (vectors::<S>(&s.q), vectors::<S>(&s.v));
            let (g, f) = (vectors::<S>(&s.g), vectors::<S>(&s.applied));
            let (q_free, v_free) = (vectors_mut::<S>(&mut s.q_free), vectors_mut::<S>(&mut s.v_free));
            let n = q_free.len();
            let to_q = [
                &vectors::<S>(a11)[..n],
                &vectors::<S>(a12)[..n],
                &vectors::<S>(b1)[..n],
                &vectors::<S>(c1)[..n],
            ];
            let to_v = [
                &vectors::<S>(a21)[..n],
                &vectors::<S>(a22)[..n],
                &vectors::<S>(b2)[..n],
                &vectors::<S>(c2)[..n],
            ];
            let (q, v, g, f, v_free) = (&q[..n], &v[..n], &g[..n], &f[..n], &mut v_free[..n]);
            for i in 0..n {
                let x = [q[i], v[i], g[i], f[i]];
                q_free[i] = weighted(simd, &to_q, i, x);
                v_free[i] = weighted(simd, &to_v, i, x);
            }
        }
    }
    arch.dispatch(Predict(coefficients, state));
}

/// Completes the step with the contact forces found: q, v, g at its end, and the dissipation.
pub(super) fn finish(arch: Arch, coefficients: &Coefficients, state: &mut State) {
    struct Finish<'a>(&'a Coefficients, &'a mut State);
    impl WithSimd for Finish<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(c, s) = self;
            let (mul, add) = (S::mul_f64s, S::add_f64s);
            let (q, v, g) = (
                vectors_mut::<S>(&mut s.q),
                vectors_mut::<S>(&mut s.v),
                vectors_mut::<S>(&mut s.g),
            );
            let n = q.len();
            let (v, g) = (&mut v[..n], &mut g[..n]);
            let dissipated = &mut vectors_mut::<S>(&mut s.dissipated)[..n];
            let (applied, contact) = (&vectors::<S>(&s.applied)[..n], &vectors::<S>(&s.contact)[..n]);
            let (q_free, v_free) = (&vectors::<S>(&s.q_free)[..n], &vectors::<S>(&s.v_free)[..n]);
            let (c1, c2) = (
                &vectors::<S>(&c.displacement[3])[..n],
                &vectors::<S>(&c.velocity[3])[..n],
            );
            let d = &c.dissipation;
            let row_1 = [
                vectors::<S>(&d[0]),
                vectors::<S>(&d[1]),
                vectors::<S>(&d[2]),
                vectors::<S>(&d[3]),
            ];
            let row_2 = [vectors::<S>(&d[4]), vectors::<S>(&d[5]), vectors::<S>(&d[6])];
            let row_3 = [vectors::<S>(&d[7]), vectors::<S>(&d[8]), vectors::<S>(&d[9])];
            let row_1 = [&row_1[0][..n], &row_1[1][..n], &row_1[2][..n], &row_1[3][..n]];
            let row_2 = [&row_2[0][..n], &row_2[1][..n], &row_2[2][..n]];
            let row_3 = [&row_3[0][..n], &row_3[1][..n], &row_3[2][..n]];
            for i in 0..n {
                let x = [q[i], v[i], g[i], add(simd, applied[i], contact[i])];
                let by_q = mul(simd, x[0], weighted(simd, &row_1, i, x));
                let v_and_g = add(simd, mul(simd, row_2[0][i], x[1]), mul(simd, row_2[1][i], x[2]));
                let by_v = mul(simd, x[1], add(simd, v_and_g, mul(simd, row_2[2][i], x[3])));
                let by_g = mul(
                    simd,
                    x[2],
                    add(simd, mul(simd, row_3[0][i], x[2]), mul(simd, row_3[1][i], x[3])),
                );
                let last = mul(simd, row_3[2][i], mul(simd, x[3], x[3]));
                let lost = add(simd, add(simd, by_q, by_v), add(simd, by_g, last));
                dissipated[i] = add(simd, dissipated[i], lost);
                q[i] = add(simd, q_free[i], mul(simd, c1[i], contact[i]));
                v[i] = add(simd, v_free[i], mul(simd, c2[i], contact[i]));
                g[i] = x[3];
            }
        }
    }
    arch.dispatch(Finish(coefficients, state));
}

/// out = sum over k in `which` of scale_k column_k, for the lanes `range`.
pub(super) fn combine(
    arch: Arch,
    columns: &Columns,
    range: Range<usize>,
    which: &[usize],
    scale: &[f64],
    out: &mut [Lane],
) {
    struct Four<'a>(&'a mut [Lane], [&'a [Lane]; 4], [f64; 4]);
    impl WithSimd for Four<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(out, c, s) = self;
            let out = vectors_mut::<S>(out);
            let n = out.len();
            let (c0, c1, c2, c3) = (
                vectors::<S>(c[0]),
                vectors::<S>(c[1]),
                vectors::<S>(c[2]),
                vectors::<S>(c[3]),
            );
            let c = [&c0[..n], &c1[..n], &c2[..n], &c3[..n]];
            let s = [
                simd.splat_f64s(s[0]),
                simd.splat_f64s(s[1]),
                simd.splat_f64s(s[2]),
                simd.splat_f64s(s[3]),
            ];
            for (i, out) in out.iter_mut().enumerate() {
                *out = simd.add_f64s(*out, weighted(simd, &c, i, s));
            }
        }
    }
    struct One<'a>(&'a mut [Lane], &'a [Lane], f64);
    impl WithSimd for One<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(out, c, s) = self;
            let s = simd.splat_f64s(s);
            for (out, c) in vectors_mut::<S>(out).iter_mut().zip(vectors::<S>(c)) {
                *out = simd.add_f64s(*out, simd.mul_f64s(s, *c));
            }
        }
    }
    let out = &mut out[range.clone()];
    out.fill([0.0; 4]);
    let cut = |k: usize| &columns.column(k)[range.clone()];
    let (quads, rest) = which.as_chunks::<4>();
    for &[a, b, c, d] in quads {
        arch.dispatch(Four(
            out,
            [cut(a), cut(b), cut(c), cut(d)],
            [scale[a], scale[b], scale[c], scale[d]],
        ));
    }
    for &k in rest {
        arch.dispatch(One(out, cut(k), scale[k]));
    }
}

/// out_a = sum over modes of a_j row_j and out_b likewise, for the lanes `range` of the modes; `rows` has one column
/// per mode. The loop runs over modes, not over products, so nothing is summed across a vector and its width does not
/// matter.
pub(super) fn project(
    arch: Arch,
    rows: &Columns,
    (a, b): (&[Lane], &[Lane]),
    (out_a, out_b): (&mut [Lane], &mut [Lane]),
) {
    struct Project<'a>(&'a Columns, &'a [Lane], &'a [Lane], &'a mut [Lane], &'a mut [Lane]);
    impl WithSimd for Project<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(rows, a, b, out_a, out_b) = self;
            let (out_a, out_b) = (vectors_mut::<S>(out_a), vectors_mut::<S>(out_b));
            let n = out_a.len();
            let out_b = &mut out_b[..n];
            for (quad, (a, b)) in rows.data.chunks_exact(4 * rows.height).zip(a.iter().zip(b)) {
                let (c0, rest) = vectors::<S>(quad).split_at(n);
                let (c1, rest) = rest.split_at(n);
                let (c2, c3) = rest.split_at(n);
                let c = [c0, c1, c2, &c3[..n]];
                let a = [
                    simd.splat_f64s(a[0]),
                    simd.splat_f64s(a[1]),
                    simd.splat_f64s(a[2]),
                    simd.splat_f64s(a[3]),
                ];
                let b = [
                    simd.splat_f64s(b[0]),
                    simd.splat_f64s(b[1]),
                    simd.splat_f64s(b[2]),
                    simd.splat_f64s(b[3]),
                ];
                for i in 0..n {
                    out_a[i] = simd.add_f64s(out_a[i], weighted(simd, &c, i, a));
                    out_b[i] = simd.add_f64s(out_b[i], weighted(simd, &c, i, b));
                }
            }
        }
    }
    out_a.fill([0.0; 4]);
    out_b.fill([0.0; 4]);
    if rows.height > 0 {
        arch.dispatch(Project(rows, a, b, out_a, out_b));
    }
}

/// Exchanges argument and value of index k in y = T x with T square (principal pivot):
///
///   T_kk' = 1/T_kk, T_kj' = -T_kj/T_kk, T_ik' = T_ik/T_kk, T_ij' = T_ij - T_ik T_kj/T_kk.
pub(super) fn pivot(arch: Arch, t: &mut Columns, k: usize, scratch: &mut [Lane]) {
    struct Pivot<'a>(&'a mut Columns, usize, &'a mut [Lane]);
    impl WithSimd for Pivot<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(t, k, scratch) = self;
            let (lane, slot) = (k / 4, k % 4);
            scratch.copy_from_slice(t.column(k));
            let p = scratch[lane][slot];
            for (j, column) in t.data.chunks_exact_mut(t.height).enumerate() {
                if j == k {
                    for entry in column.as_flattened_mut() {
                        *entry /= p;
                    }
                    column[lane][slot] = 1.0 / p;
                } else {
                    let factor = column[lane][slot] / p;
                    let minus = simd.splat_f64s(-factor);
                    for (entry, c) in vectors_mut::<S>(column).iter_mut().zip(vectors::<S>(scratch)) {
                        *entry = simd.add_f64s(*entry, simd.mul_f64s(minus, *c));
                    }
                    column[lane][slot] = -factor;
                }
            }
        }
    }
    arch.dispatch(Pivot(t, k, scratch));
}

/// Sum of a lane, in the order used by the vector kernels.
#[inline(always)]
fn total(lane: Lane) -> f64 {
    (lane[0] + lane[2]) + (lane[1] + lane[3])
}

/// Sum over lanes of w a^2/2.
pub(super) fn half_squares(w: Option<&[Lane]>, a: &[Lane]) -> f64 {
    let mut sum = [0.0; 4];
    for (i, a) in a.iter().enumerate() {
        for l in 0..4 {
            sum[l] += w.map_or(1.0, |w| w[i][l]) * a[l] * a[l];
        }
    }
    0.5 * total(sum)
}

/// Sum over lanes.
pub(super) fn sum(a: &[Lane]) -> f64 {
    let mut sum = [0.0; 4];
    for a in a {
        for l in 0..4 {
            sum[l] += a[l];
        }
    }
    total(sum)
}
