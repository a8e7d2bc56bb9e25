//! The loops in which a run spends its time, on lanes of four modes.
//!
//! They are compiled for the vector instructions that the machine has (pulp's dispatch) but written without fused
//! multiply-add and with a fixed order of summation, so that every machine gives the same bits: a bouncing block amplifies
//! rounding, and its result should still be reproducible.

use std::ops::Range;

use pulp::Arch;

use super::recurrence::Recurrence;

/// Four values side by side.
pub(super) type Lane = [f64; 4];

/// Number of lanes that hold `values`.
pub(super) fn lanes(values: usize) -> usize {
    values.div_ceil(4)
}

/// Column-major matrix whose columns are padded with zeros to whole lanes.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Lanes of one column.
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

/// Coefficients of four modes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coefficients {
    a11: Lane,
    a12: Lane,
    a21: Lane,
    a22: Lane,
    b1: Lane,
    c1: Lane,
    b2: Lane,
    c2: Lane,
    dissipation: [Lane; 10],
}

impl Coefficients {
    pub(super) const ZERO: Self = Self {
        a11: [0.0; 4],
        a12: [0.0; 4],
        a21: [0.0; 4],
        a22: [0.0; 4],
        b1: [0.0; 4],
        c1: [0.0; 4],
        b2: [0.0; 4],
        c2: [0.0; 4],
        dissipation: [[0.0; 4]; 10],
    };

    pub(super) fn set(&mut self, lane: usize, r: Recurrence, dissipation: [f64; 10]) {
        self.a11[lane] = r.a11;
        self.a12[lane] = r.a12;
        self.a21[lane] = r.a21;
        self.a22[lane] = r.a22;
        self.b1[lane] = r.b1;
        self.c1[lane] = r.c1;
        self.b2[lane] = r.b2;
        self.c2[lane] = r.c2;
        for (entry, value) in self.dissipation.iter_mut().zip(dissipation) {
            entry[lane] = value;
        }
    }
}

/// Modal quantities of one step, all of the same number of lanes.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// q at the start of the step.
    pub(super) q: Vec<Lane>,
    /// q' at the start of the step.
    pub(super) v: Vec<Lane>,
    /// Modal force at the start of the step, applied and contact.
    pub(super) g: Vec<Lane>,
    /// Applied modal force at the end of the step.
    pub(super) applied: Vec<Lane>,
    /// Modal force of the supports at the end of the step.
    pub(super) contact: Vec<Lane>,
    /// q at the end of the step as it would be without support forces there.
    pub(super) q_free: Vec<Lane>,
    /// The same of q'.
    pub(super) v_free: Vec<Lane>,
    /// Energy dissipated in the mode so far.
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

/// q_free = a11 q + a12 v + b1 g + c1 applied, and v_free likewise.
pub(super) fn predict(arch: Arch, coefficients: &[Coefficients], s: &mut State) {
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn run(c: &[Coefficients], q: &[Lane], v: &[Lane], g: &[Lane], f: &[Lane], qf: &mut [Lane], vf: &mut [Lane]) {
        let n = c.len();
        let (q, v, g, f, qf, vf) = (&q[..n], &v[..n], &g[..n], &f[..n], &mut qf[..n], &mut vf[..n]);
        for i in 0..n {
            let c = &c[i];
            for l in 0..4 {
                qf[i][l] = (c.a11[l] * q[i][l] + c.a12[l] * v[i][l]) + (c.b1[l] * g[i][l] + c.c1[l] * f[i][l]);
                vf[i][l] = (c.a21[l] * q[i][l] + c.a22[l] * v[i][l]) + (c.b2[l] * g[i][l] + c.c2[l] * f[i][l]);
            }
        }
    }
    arch.dispatch(
        #[inline(always)]
        || run(coefficients, &s.q, &s.v, &s.g, &s.applied, &mut s.q_free, &mut s.v_free),
    );
}

/// Ends the step with the contact forces found: q, v, g at its end, and what it dissipated.
pub(super) fn finish(arch: Arch, coefficients: &[Coefficients], s: &mut State) {
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn run(
        c: &[Coefficients],
        q: &mut [Lane],
        v: &mut [Lane],
        g: &mut [Lane],
        (applied, contact): (&[Lane], &[Lane]),
        (qf, vf): (&[Lane], &[Lane]),
        dissipated: &mut [Lane],
    ) {
        let n = c.len();
        let (q, v, g, dissipated) = (&mut q[..n], &mut v[..n], &mut g[..n], &mut dissipated[..n]);
        let (applied, contact, qf, vf) = (&applied[..n], &contact[..n], &qf[..n], &vf[..n]);
        for i in 0..n {
            let c = &c[i];
            let d = &c.dissipation;
            for l in 0..4 {
                let (x1, x2, x3, x4) = (q[i][l], v[i][l], g[i][l], applied[i][l] + contact[i][l]);
                let row_1 = x1 * ((d[0][l] * x1 + d[1][l] * x2) + (d[2][l] * x3 + d[3][l] * x4));
                let row_2 = x2 * ((d[4][l] * x2 + d[5][l] * x3) + d[6][l] * x4);
                let row_3 = x3 * (d[7][l] * x3 + d[8][l] * x4);
                let row_4 = d[9][l] * (x4 * x4);
                dissipated[i][l] += (row_1 + row_2) + (row_3 + row_4);
                q[i][l] = qf[i][l] + c.c1[l] * contact[i][l];
                v[i][l] = vf[i][l] + c.c2[l] * contact[i][l];
                g[i][l] = x4;
            }
        }
    }
    arch.dispatch(
        #[inline(always)]
        || {
            run(
                coefficients,
                &mut s.q,
                &mut s.v,
                &mut s.g,
                (&s.applied, &s.contact),
                (&s.q_free, &s.v_free),
                &mut s.dissipated,
            );
        },
    );
}

/// out = sum over k in `which` of scale_k column_k, on the lanes `range`.
pub(super) fn combine(
    arch: Arch,
    columns: &Columns,
    range: Range<usize>,
    which: &[usize],
    scale: &[f64],
    out: &mut [Lane],
) {
    #[inline(always)]
    fn four(out: &mut [Lane], c: [&[Lane]; 4], s: [f64; 4]) {
        let n = out.len();
        let [c0, c1, c2, c3] = c.map(|c| &c[..n]);
        for i in 0..n {
            for l in 0..4 {
                out[i][l] += (s[0] * c0[i][l] + s[1] * c1[i][l]) + (s[2] * c2[i][l] + s[3] * c3[i][l]);
            }
        }
    }
    #[inline(always)]
    fn one(out: &mut [Lane], c: &[Lane], s: f64) {
        let c = &c[..out.len()];
        for (out, c) in out.iter_mut().zip(c) {
            for l in 0..4 {
                out[l] += s * c[l];
            }
        }
    }
    let out = &mut out[range.clone()];
    out.fill([0.0; 4]);
    arch.dispatch(
        #[inline(always)]
        || {
            let (quads, rest) = which.as_chunks::<4>();
            for quad in quads {
                four(
                    out,
                    quad.map(|k| &columns.column(k)[range.clone()]),
                    quad.map(|k| scale[k]),
                );
            }
            for &k in rest {
                one(out, &columns.column(k)[range.clone()], scale[k]);
            }
        },
    );
}

/// Adds to a_k and b_k, for k in `which`, the products of column k with the vectors a and b, on the lanes `range`.
pub(super) fn project(
    arch: Arch,
    columns: &Columns,
    range: Range<usize>,
    which: &[usize],
    (a, b): (&[Lane], &[Lane]),
    (out_a, out_b): (&mut [f64], &mut [f64]),
) {
    #[inline(always)]
    fn product<const N: usize>(c: [&[Lane]; N], a: &[Lane], b: &[Lane]) -> [(f64, f64); N] {
        let n = a.len();
        let c = c.map(|c| &c[..n]);
        let b = &b[..n];
        let (mut sum_a, mut sum_b) = ([[0.0; 4]; N], [[0.0; 4]; N]);
        for i in 0..n {
            let (a, b) = (a[i], b[i]);
            for k in 0..N {
                let c = c[k][i];
                for l in 0..4 {
                    sum_a[k][l] += c[l] * a[l];
                    sum_b[k][l] += c[l] * b[l];
                }
            }
        }
        std::array::from_fn(|k| (total(sum_a[k]), total(sum_b[k])))
    }
    let (a, b) = (&a[range.clone()], &b[range.clone()]);
    arch.dispatch(
        #[inline(always)]
        || {
            let (quads, rest) = which.as_chunks::<4>();
            for quad in quads {
                let sums = product(quad.map(|k| &columns.column(k)[range.clone()]), a, b);
                for (&k, (x, y)) in quad.iter().zip(sums) {
                    out_a[k] += x;
                    out_b[k] += y;
                }
            }
            for &k in rest {
                let [(x, y)] = product([&columns.column(k)[range.clone()]], a, b);
                out_a[k] += x;
                out_b[k] += y;
            }
        },
    );
}

/// Exchanges argument and value of index k of the square matrix y = T x (principal pivot):
///
///   T_kk' = 1/T_kk, T_kj' = -T_kj/T_kk, T_ik' = T_ik/T_kk, T_ij' = T_ij - T_ik T_kj/T_kk.
pub(super) fn pivot(arch: Arch, t: &mut Columns, k: usize, scratch: &mut [Lane]) {
    #[inline(always)]
    fn run(t: &mut Columns, k: usize, scratch: &mut [Lane]) {
        let (lane, slot) = (k / 4, k % 4);
        scratch.copy_from_slice(t.column(k));
        let p = scratch[lane][slot];
        for (j, column) in t.data.chunks_exact_mut(t.height).enumerate() {
            if j == k {
                for entry in column.iter_mut() {
                    for l in 0..4 {
                        entry[l] /= p;
                    }
                }
                column[lane][slot] = 1.0 / p;
            } else {
                let factor = column[lane][slot] / p;
                for (entry, c) in column.iter_mut().zip(scratch.iter()) {
                    for l in 0..4 {
                        entry[l] -= factor * c[l];
                    }
                }
                column[lane][slot] = -factor;
            }
        }
    }
    arch.dispatch(
        #[inline(always)]
        || run(t, k, scratch),
    );
}

/// Sum of a lane in the order that the vector kernels use.
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
