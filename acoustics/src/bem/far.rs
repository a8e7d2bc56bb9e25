//! The far rule: all pairs of panels of two blocks that are not close, with all images and for all parities at once.
//!
//! The image q of a point reflects it along a set of axes; the normal turns along, n' = M_q n, and the surface curl gets
//! the determinant of M_q too. With the signs s_pq of a parity p, the operators need the sums
//!
//! ```text
//! G_p = sum_q s_pq G_q      Z_pc = sum_q s_pq h_q (x - M_q y)_c      h = (1 + jkr) G / r²
//! S  = G_p                  K' = -sum_c n_xc Z_pc                    K = sum_c n_yc Z_{p^c,c}
//! n_x . n_y G: sum_c n_xc n_yc G_{p^c}                               curl . curl G: sum_c G_{p^abc^c} ...
//! ```
//!
//! where p^c is the parity with the other sign across the plane of axis c: one Walsh transform over the images gives
//! all of them, so that a kernel is evaluated once for all parities and operators.
//!
//! No closures here: only functions that are always inlined take on their caller's vector features.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::blocks::{Block, C, N, W, X, fields};
use super::panel::PanelShape;
use super::rules;
use super::tile::{Buffer, Operators, Wave};
use super::trig::{dot, green, load, load3};
use nailnoise_meshes::FaceKind;
use pulp::{Simd, WithSimd};
use std::f64::consts::PI;

/// Most parities.
const PARITIES: usize = 4;
/// All four parities with respect to the planes x and y, in the order of [`super::Parity::all`].
const ALL: [usize; PARITIES] = [0, 2, 1, 3];
/// Axes that are known at run time only.
const ANY: usize = 8;

/// All pairs of panels of two blocks by the far rule, except those masked.
pub(super) struct Far<'a> {
    pub(super) wave: Wave,
    pub(super) e: &'a Block,
    pub(super) f: &'a Block,
    /// Planes of reflection, axis by axis.
    pub(super) planes: [Option<f64>; 3],
    /// Odd axes of every parity, a bit each.
    pub(super) parities: &'a [usize],
    pub(super) diagonal: bool,
    /// 0 for a pair to be left out, else 1: image by image, first panel by first panel.
    pub(super) mask: &'a [f64],
    pub(super) to: &'a mut [Operators],
}

impl WithSimd for Far<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let axes = self.axes();
        let one = self.parities.len() == 1;
        match (self.e.corners, self.f.corners) {
            (3, 3) if one && axes == 0 => self.run::<S, 3, 3, 1, 0>(simd),
            (3, 3) if one && axes == 4 => self.run::<S, 3, 3, 1, 4>(simd),
            (3, 3) => self.run::<S, 3, 3, PARITIES, ANY>(simd),
            (3, _) => self.run::<S, 3, 4, PARITIES, ANY>(simd),
            _ if axes == 7 && self.parities == ALL => self.run::<S, 4, 4, PARITIES, 7>(simd),
            _ => self.run::<S, 4, 4, PARITIES, ANY>(simd),
        }
    }
}

/// Values of the corner functions at the points of the far rule, point by point.
pub(super) fn corner_values<const E: usize>() -> [[f64; E]; E] {
    let kind = if E == 3 { FaceKind::Tri3 } else { FaceKind::Quad4 };
    let rule = rules::far(E);
    std::array::from_fn(|b| {
        let shape = kind.at(rule[b].0);
        std::array::from_fn(|j| shape.n[j])
    })
}

/// A complex number in each lane.
type Pair<V> = [V; 2];

/// Walsh transform over the images in the planes of `axes`.
#[inline(always)]
fn walsh<S: Simd>(simd: S, x: &mut [Pair<S::f64s>; 8], axes: usize) {
    for axis in 0..3 {
        let bit = 1 << axis;
        if axes & bit == 0 {
            continue;
        }
        for i in 0..8 {
            if i & bit != 0 || i & !axes != 0 {
                continue;
            }
            for part in 0..2 {
                let (u, v) = (x[i][part], x[i | bit][part]);
                x[i][part] = simd.add_f64s(u, v);
                x[i | bit][part] = simd.sub_f64s(u, v);
            }
        }
    }
}

/// sum_c n_c z_c of complex z.
#[inline(always)]
fn along<S: Simd>(simd: S, n: [S::f64s; 3], z: [Pair<S::f64s>; 3]) -> Pair<S::f64s> {
    [
        dot(simd, n, [z[0][0], z[1][0], z[2][0]]),
        dot(simd, n, [z[0][1], z[1][1], z[2][1]]),
    ]
}

/// s x of a complex x.
#[inline(always)]
fn scaled<S: Simd>(simd: S, s: S::f64s, x: Pair<S::f64s>) -> Pair<S::f64s> {
    [simd.mul_f64s(s, x[0]), simd.mul_f64s(s, x[1])]
}

#[inline(always)]
fn negative<S: Simd>(simd: S, x: Pair<S::f64s>) -> Pair<S::f64s> {
    [simd.neg_f64s(x[0]), simd.neg_f64s(x[1])]
}

/// to + s x of a complex x.
#[inline(always)]
fn add<S: Simd>(simd: S, to: &mut Pair<S::f64s>, s: S::f64s, x: Pair<S::f64s>) {
    to[0] = simd.mul_add_e_f64s(s, x[0], to[0]);
    to[1] = simd.mul_add_e_f64s(s, x[1], to[1]);
}

/// y - j beta x.
#[inline(always)]
fn coupled<S: Simd>(simd: S, beta: S::f64s, x: Pair<S::f64s>, y: Pair<S::f64s>) -> Pair<S::f64s> {
    [
        simd.mul_add_e_f64s(beta, x[1], y[0]),
        simd.negate_mul_add_e_f64s(beta, x[0], y[1]),
    ]
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, own: &[f64; 16], field: usize) -> [S::f64s; 3] {
    [
        simd.splat_f64s(own[field]),
        simd.splat_f64s(own[field + 1]),
        simd.splat_f64s(own[field + 2]),
    ]
}

/// Adds a vector of complex values to a buffer.
#[inline(always)]
fn put<S: Simd>(simd: S, buffer: &mut Buffer, row: usize, column: usize, value: Pair<S::f64s>) {
    for part in 0..2 {
        let start = buffer.start(part, row) + column;
        let to = &mut S::as_mut_simd_f64s(&mut buffer.data[start..start + S::F64_LANES]).0[0];
        *to = simd.add_f64s(*to, value[part]);
    }
}

impl Far<'_> {
    fn axes(&self) -> usize {
        (0..3).filter(|&c| self.planes[c].is_some()).map(|c| 1 << c).sum()
    }

    /// `P`: one parity, or up to four; `AXES`: axes of reflection, or [`ANY`].
    #[inline(always)]
    fn run<S: Simd, const E: usize, const F: usize, const P: usize, const AXES: usize>(self, simd: S) {
        let axes = if AXES == ANY { self.axes() } else { AXES };
        let count = match (P, AXES) {
            (1, _) => 1,
            (_, 7) => PARITIES,
            _ => self.parities.len(),
        };
        let zero = simd.splat_f64s(0.0);
        let one = simd.splat_f64s(1.0);
        let k = simd.splat_f64s(self.wave.k);
        let minus_k2 = simd.splat_f64s(-self.wave.k * self.wave.k);
        let beta = simd.splat_f64s(self.wave.coupling);
        let unit = simd.splat_f64s(0.25 / PI);
        let mut twice = [zero; 3];
        for c in 0..3 {
            twice[c] = simd.splat_f64s(2.0 * self.planes[c].unwrap_or(0.0));
        }
        let (phi_e, phi_f) = (corner_values::<E>(), corner_values::<F>());
        let (panels, we, wf) = (self.e.panels.len(), self.e.width, self.f.width);
        let lanes = S::F64_LANES;
        for e in 0..panels {
            // Position, vector area, area and curls of this panel's points.
            let mut own = [[0.0; 16]; E];
            for (a, own) in own.iter_mut().enumerate() {
                for (field, value) in own.iter_mut().enumerate().take(fields(E)) {
                    *value = self.e.points[(a * fields(E) + field) * we + e];
                }
            }
            for chunk in 0..wf / lanes {
                let at = chunk * lanes;
                // A and its transpose from corner to corner, B from points to corners, without the curls.
                let mut sums = [[[[[zero; 2]; F]; E]; 2]; P];
                let mut flows = [[[[zero; 2]; F]; E]; P];
                let mut curls = [[[[zero; 2]; F]; E]; P];
                for a in 0..E {
                    let (x, n) = (splat3(simd, &own[a], X), splat3(simd, &own[a], N));
                    let w = simd.splat_f64s(own[a][W]);
                    let mut rows = [[[[zero; 2]; F]; 3]; P];
                    let mut turned = [[[[zero; 2]; F]; 3]; P];
                    for b in 0..F {
                        let start = b * fields(F) * wf + at;
                        let y = load3::<S>(&self.f.points, start + X * wf, wf);
                        let v = load3::<S>(&self.f.points, start + N * wf, wf);
                        let u = load::<S>(&self.f.points, start + W * wf);
                        let (mut d, mut squares, mut nn) = ([[zero; 2]; 3], [[zero; 2]; 3], [zero; 3]);
                        for c in 0..3 {
                            d[c][0] = simd.sub_f64s(x[c], y[c]);
                            d[c][1] = simd.sub_f64s(simd.add_f64s(x[c], y[c]), twice[c]);
                            squares[c][0] = simd.mul_f64s(d[c][0], d[c][0]);
                            squares[c][1] = simd.mul_f64s(d[c][1], d[c][1]);
                            nn[c] = simd.mul_f64s(minus_k2, simd.mul_f64s(n[c], v[c]));
                        }
                        let mut g = [[zero; 2]; 8];
                        let mut z = [[[zero; 2]; 8]; 3];
                        let mut image = 0;
                        for q in 0..8 {
                            if q & !axes != 0 {
                                continue;
                            }
                            let bits = [q & 1, (q >> 1) & 1, q >> 2];
                            let m = load::<S>(self.mask, (image * panels + e) * wf + at);
                            image += 1;
                            // Masked pairs are put at a distance of a metre and more: they may coincide.
                            let away = simd.sub_f64s(one, m);
                            let plane = simd.add_f64s(squares[0][bits[0]], squares[1][bits[1]]);
                            let r2 = simd.add_f64s(plane, simd.add_f64s(squares[2][bits[2]], away));
                            let [g_re, g_im, h_re, h_im] = green(simd, r2, k, simd.mul_f64s(m, unit));
                            g[q] = [g_re, g_im];
                            for c in 0..3 {
                                let d = d[c][bits[c]];
                                z[c][q] = [simd.mul_f64s(h_re, d), simd.mul_f64s(h_im, d)];
                            }
                        }
                        walsh(simd, &mut g, axes);
                        walsh(simd, &mut z[0], axes);
                        walsh(simd, &mut z[1], axes);
                        walsh(simd, &mut z[2], axes);
                        let areas = simd.mul_f64s(w, u);
                        let less_u = simd.neg_f64s(u);
                        for p in 0..count {
                            let s = if AXES == 7 { ALL[p] } else { self.parities[p] };
                            let other = [s ^ (1 & axes), s ^ (2 & axes), s ^ (4 & axes)];
                            let back = along(simd, n, [z[0][s], z[1][s], z[2][s]]);
                            let there = along(simd, v, [z[0][other[0]], z[1][other[1]], z[2][other[2]]]);
                            let (back, there) = (scaled(simd, less_u, back), scaled(simd, w, there));
                            let mass = along(simd, nn, [g[other[0]], g[other[1]], g[other[2]]]);
                            let single = scaled(simd, areas, g[s]);
                            let forward = coupled(simd, beta, mass, negative(simd, there));
                            let backward = coupled(simd, beta, mass, negative(simd, back));
                            let flow = coupled(simd, beta, back, single);
                            let flow_back = coupled(simd, beta, there, single);
                            for j in 0..F {
                                let phi = simd.splat_f64s(phi_f[b][j]);
                                add(simd, &mut rows[p][0][j], phi, forward);
                                if !self.diagonal {
                                    add(simd, &mut rows[p][1][j], phi, backward);
                                    add(simd, &mut rows[p][2][j], phi, flow_back);
                                }
                            }
                            for i in 0..E {
                                add(simd, &mut flows[p][i][b], simd.splat_f64s(phi_e[a][i]), flow);
                            }
                        }
                        for j in 0..F - 1 {
                            let curl = load3::<S>(&self.f.points, start + (C + 3 * j) * wf, wf);
                            for p in 0..count {
                                let s = if AXES == 7 { ALL[p] } else { self.parities[p] };
                                for c in 0..3 {
                                    let turn = s ^ axes ^ ((1 << c) & axes);
                                    add(simd, &mut turned[p][c][j], curl[c], g[turn]);
                                }
                            }
                        }
                    }
                    for p in 0..count {
                        for i in 0..E {
                            let phi = simd.splat_f64s(phi_e[a][i]);
                            for j in 0..F {
                                add(simd, &mut sums[p][0][i][j], phi, rows[p][0][j]);
                                if !self.diagonal {
                                    add(simd, &mut sums[p][1][i][j], phi, rows[p][1][j]);
                                }
                            }
                        }
                        for i in 0..E - 1 {
                            let curl = splat3(simd, &own[a], C + 3 * i);
                            for j in 0..F - 1 {
                                for c in 0..3 {
                                    add(simd, &mut curls[p][i][j], curl[c], turned[p][c][j]);
                                }
                            }
                        }
                        if !self.diagonal {
                            for j in 0..F {
                                let to = &mut self.to[p].b_back;
                                put(simd, to, a * we + e, j * wf + at, rows[p][2][j]);
                            }
                        }
                    }
                }
                for p in 0..count {
                    // The curls of all corner functions add up to zero.
                    for part in 0..2 {
                        for i in 0..E - 1 {
                            for j in 0..F - 1 {
                                let value = curls[p][i][j][part];
                                curls[p][i][F - 1][part] = simd.sub_f64s(curls[p][i][F - 1][part], value);
                                curls[p][E - 1][j][part] = simd.sub_f64s(curls[p][E - 1][j][part], value);
                                curls[p][E - 1][F - 1][part] = simd.add_f64s(curls[p][E - 1][F - 1][part], value);
                            }
                        }
                    }
                    let to = &mut self.to[p];
                    for i in 0..E {
                        let row = self.e.local[e][i];
                        for j in 0..F {
                            let (column, curl) = (j * wf + at, curls[p][i][j]);
                            put(
                                simd,
                                &mut to.a,
                                row,
                                column,
                                coupled(simd, beta, curl, sums[p][0][i][j]),
                            );
                            put(simd, &mut to.b, row, column, flows[p][i][j]);
                            if !self.diagonal {
                                let back = coupled(simd, beta, curl, sums[p][1][i][j]);
                                put(simd, &mut to.a_back, row, column, back);
                            }
                        }
                    }
                }
            }
        }
    }
}
