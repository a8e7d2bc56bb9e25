//! The far rule: all pairs of panels of two blocks that are not close, for all images and all parities at once.
//!
//! The image q of a point is its reflection along a set of axes. Its normal is reflected as well, n' = M_q n, and the
//! surface curl is multiplied by the determinant of M_q. With the signs s_pq of a parity p, the operators need sums
//! over the images. Below, p^c is parity p with the sign across the plane of axis c reversed.
//!
//! ```text
//! S:  sum_q s_pq G_q      K:  sum_q s_pq dG_q/dn'_y      K':  sum_q s_pq dG_q/dn_x      n_x . n'_y G: sum_q s_pq ...
//! curl . curl' G: sum_c curl_c curl_c sum_q s_{p^abc^c,q} G_q
//! ```
//!
//! The inputs of A, B and their transposes are combined image by image, and a single Walsh transform over the images
//! yields all parities. Each kernel is therefore evaluated only once for all parities and operators. Sums over the
//! points of two panels then give the values at the corners.
//!
//! In single precision with positions relative to the middle of a block, a kernel's error is 1e-6, a hundredth of the
//! quadrature error.
//!
//! Closures are avoided, because only functions that are always inlined inherit the vector features of their caller.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::blocks::{Block, C, N, W, X, fields};
use super::kernel::{APART, green, load, load3};
use super::wave::{Buffer, Operators, Wave};
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use nailnoise_meshes::FaceKind;
use pulp::{Simd, WithSimd};
use std::f64::consts::PI;

/// Largest number of parities.
const PARITIES: usize = 4;
/// All four parities with respect to the planes x and y, in the order of [`crate::bem::Parity::all`].
const ALL: [usize; PARITIES] = [0, 2, 1, 3];
/// Axes known only at run time.
const ANY: usize = 8;

/// All pairs of panels of two blocks, except masked ones, evaluated by the far rule.
pub(crate) struct Far<'a> {
    pub(crate) wave: Wave,
    pub(crate) e: &'a Block,
    pub(crate) f: &'a Block,
    /// Planes of reflection by axis.
    pub(crate) planes: [Option<f64>; 3],
    /// Odd axes of each parity, one bit each.
    pub(crate) parities: &'a [usize],
    pub(crate) diagonal: bool,
    /// 0 for pairs to be omitted, else 1: by image, then by panel of the first block.
    pub(crate) mask: &'a [f32],
    pub(crate) to: &'a mut [Operators],
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

/// Values of the corner functions at the points of the far rule, by point.
pub(crate) fn corner_values<const E: usize>() -> [[f64; E]; E] {
    let kind = if E == 3 { FaceKind::Tri3 } else { FaceKind::Quad4 };
    let rule = rules::far(E);
    std::array::from_fn(|b| {
        let shape = kind.at(rule[b].0);
        std::array::from_fn(|j| shape.n[j])
    })
}

/// A point of the first panel.
#[derive(Clone, Copy, Default)]
struct Own {
    /// x minus the centre of the second block, and x minus the centre of its image, by axis.
    from: [[f32; 2]; 3],
    normal: [f32; 3],
    /// Area divided by 4 pi.
    area: f32,
    /// Curls of all corner functions except the last, divided by area.
    curls: [[f32; 3]; 3],
}

impl Own {
    fn new<const E: usize>(far: &Far<'_>, e: usize, a: usize) -> Self {
        let block = far.e;
        let get = |field: usize| block.points[(a * fields(E) + field) * block.width + e];
        let area = get(W);
        let mut own = Self {
            area: (area / (4.0 * PI)) as f32,
            ..Self::default()
        };
        for c in 0..3 {
            let (x, middle) = (get(X + c), far.f.middle[c]);
            own.from[c] = [x - middle, x + middle - 2.0 * far.planes[c].unwrap_or(0.0)].map(|d| d as f32);
            own.normal[c] = (get(N + c) / area) as f32;
            for j in 0..E - 1 {
                own.curls[j][c] = (get(C + 3 * j + c) / area) as f32;
            }
        }
        own
    }
}

/// A complex number in each lane.
type Pair<V> = [V; 2];
/// Values between all points of two panels, real and imaginary part.
type Between<V, const E: usize, const F: usize> = [[[V; F]; E]; 2];

/// The Walsh transform along one axis, over the images in the planes of `axes`.
#[inline(always)]
fn butterflies<S: Simd, const BIT: usize, const N: usize>(simd: S, x: &mut [Pair<S::f32s>; N], axes: usize) {
    if axes & BIT == 0 {
        return;
    }
    for i in 0..N {
        if i & BIT == 0 && i & !axes == 0 {
            for part in 0..2 {
                let (u, v) = (x[i][part], x[i | BIT][part]);
                x[i][part] = simd.add_f32s(u, v);
                x[i | BIT][part] = simd.sub_f32s(u, v);
            }
        }
    }
}

/// The sums over the images for fields that are even about the floor, for all parities.
#[inline(always)]
fn even<S: Simd>(simd: S, x: &[Pair<S::f32s>; 8], axes: usize) -> [Pair<S::f32s>; PARITIES] {
    let mut sums = [x[0], x[1], x[2], x[3]];
    if axes & 4 != 0 {
        for q in 0..PARITIES {
            for part in 0..2 {
                sums[q][part] = simd.add_f32s(x[q][part], x[q | 4][part]);
            }
        }
    }
    butterflies::<S, 2, PARITIES>(simd, &mut sums, axes);
    butterflies::<S, 1, PARITIES>(simd, &mut sums, axes);
    sums
}

/// Sum of the axes' contributions for one image.
#[inline(always)]
fn of_image<S: Simd>(simd: S, x: &[[S::f32s; 2]; 3], bits: [usize; 3]) -> S::f32s {
    simd.add_f32s(simd.add_f32s(x[0][bits[0]], x[1][bits[1]]), x[2][bits[2]])
}

/// y + j s x.
#[inline(always)]
fn turned<S: Simd>(simd: S, s: S::f32s, x: Pair<S::f32s>, y: Pair<S::f32s>) -> Pair<S::f32s> {
    [
        simd.negate_mul_add_e_f32s(s, x[1], y[0]),
        simd.mul_add_e_f32s(s, x[0], y[1]),
    ]
}

#[inline(always)]
fn scaled<S: Simd>(simd: S, s: S::f32s, x: Pair<S::f32s>) -> Pair<S::f32s> {
    [simd.mul_f32s(s, x[0]), simd.mul_f32s(s, x[1])]
}

/// sum_a phi[a][i] values[a] for every i.
#[inline(always)]
fn to_corners<S: Simd, const E: usize>(simd: S, phi: &[[f32; E]; E], values: [S::f32s; E]) -> [S::f32s; E] {
    let mut sums = [simd.splat_f32s(0.0); E];
    for i in 0..E {
        sums[i] = simd.mul_f32s(simd.splat_f32s(phi[0][i]), values[0]);
        for a in 1..E {
            sums[i] = simd.mul_add_e_f32s(simd.splat_f32s(phi[a][i]), values[a], sums[i]);
        }
    }
    sums
}

/// Transforms the first index from points to corners: i, b.
#[inline(always)]
fn first_to_corners<S: Simd, const E: usize, const F: usize>(
    simd: S,
    phi: &[[f32; E]; E],
    values: &[[S::f32s; F]; E],
) -> [[S::f32s; F]; E] {
    let mut result = [[simd.splat_f32s(0.0); F]; E];
    for b in 0..F {
        let mut column = [simd.splat_f32s(0.0); E];
        for a in 0..E {
            column[a] = values[a][b];
        }
        let column = to_corners(simd, phi, column);
        for i in 0..E {
            result[i][b] = column[i];
        }
    }
    result
}

/// Adds a vector of values to one part of a buffer.
#[inline(always)]
fn put<S: Simd>(simd: S, buffer: &mut Buffer, part: usize, row: usize, column: usize, value: S::f32s) {
    let start = buffer.start(part, row) + column;
    let to = &mut S::as_mut_simd_f32s(&mut buffer.data[start..start + S::F32_LANES]).0[0];
    *to = simd.add_f32s(*to, value);
}

impl Far<'_> {
    fn axes(&self) -> usize {
        (0..3).filter(|&c| self.planes[c].is_some()).map(|c| 1 << c).sum()
    }

    /// Odd axes of a parity; none without mirror planes.
    #[inline(always)]
    fn parity<const AXES: usize>(&self, p: usize) -> usize {
        match AXES {
            0 | 4 => 0,
            7 => ALL[p],
            _ => self.parities[p],
        }
    }

    /// `P`: the number of parities, up to four; `AXES`: axes of reflection, or [`ANY`].
    #[inline(always)]
    fn run<S: Simd, const E: usize, const F: usize, const P: usize, const AXES: usize>(self, simd: S) {
        let axes = if AXES == ANY { self.axes() } else { AXES };
        let count = match (P, AXES) {
            (1, _) => 1,
            (_, 7) => PARITIES,
            _ => self.parities.len(),
        };
        let zero = simd.splat_f32s(0.0);
        let k = simd.splat_f32s(self.wave.k as f32);
        let beta = simd.splat_f32s(self.wave.coupling as f32);
        let minus_beta = simd.splat_f32s(-self.wave.coupling as f32);
        let mass = simd.splat_f32s((self.wave.coupling * self.wave.k * self.wave.k) as f32);
        let apart = simd.splat_f32s(APART);
        let phi_e = corner_values::<E>().map(|row| row.map(|v| v as f32));
        let phi_f = corner_values::<F>().map(|row| row.map(|v| v as f32));
        let (panels, we, wf) = (self.e.panels.len(), self.e.width, self.f.width);
        let lanes = S::F32_LANES;
        // A and its transpose, and B and its transpose without the curls, for each parity; and G for every combination
        // of images.
        let mut kernels = [[[[[zero; F]; E]; 2]; 4]; P];
        let mut potentials = [[[[zero; F]; E]; 2]; 8];
        // The same for one pair of points, by image.
        let mut values = [[[zero; 2]; 8]; 4];
        let mut potential = [[zero; 2]; 8];
        let (mut numbers, mut images) = ([0; 8], 0);
        for q in 0..8 {
            if q & !axes == 0 {
                numbers[images] = q;
                images += 1;
            }
        }
        let images = if AXES == ANY { images } else { 1 << AXES.count_ones() };
        for e in 0..panels {
            let mut own = [Own::default(); E];
            for a in 0..E {
                own[a] = Own::new::<E>(&self, e, a);
            }
            for chunk in 0..wf / lanes {
                let at = chunk * lanes;
                for a in 0..E {
                    let own = &own[a];
                    for b in 0..F {
                        let start = b * fields(F) * wf + at;
                        let y = load3::<S>(&self.f.single, start + X * wf, wf);
                        let v = load3::<S>(&self.f.single, start + N * wf, wf);
                        let areas = load::<S>(&self.f.single, start + W * wf);
                        let areas = simd.mul_f32s(simd.splat_f32s(own.area), areas);
                        // Squared distance, (x - y) . n_x, -(x - y) . n_y and n_x . n_y, by axis.
                        let (mut squares, mut on_x) = ([[zero; 2]; 3], [[zero; 2]; 3]);
                        let (mut on_y, mut normals) = ([[zero; 2]; 3], [[zero; 2]; 3]);
                        for c in 0..3 {
                            let n = simd.splat_f32s(own.normal[c]);
                            let d = [
                                simd.sub_f32s(simd.splat_f32s(own.from[c][0]), y[c]),
                                simd.add_f32s(simd.splat_f32s(own.from[c][1]), y[c]),
                            ];
                            let nv = simd.mul_f32s(simd.mul_f32s(mass, n), v[c]);
                            normals[c] = [nv, simd.neg_f32s(nv)];
                            on_y[c] = [simd.neg_f32s(simd.mul_f32s(v[c], d[0])), simd.mul_f32s(v[c], d[1])];
                            for side in 0..2 {
                                squares[c][side] = simd.mul_f32s(d[side], d[side]);
                                on_x[c][side] = simd.mul_f32s(n, d[side]);
                            }
                        }
                        for side in 0..2 {
                            squares[2][side] = simd.add_f32s(squares[2][side], apart);
                        }
                        for image in 0..images {
                            let q = match AXES {
                                0 => 0,
                                4 => 4 * image,
                                7 => image,
                                _ => numbers[image],
                            };
                            let bits = [q & 1, (q >> 1) & 1, q >> 2];
                            let m = load::<S>(self.mask, (image * panels + e) * wf + at);
                            let r2 = of_image::<S>(simd, &squares, bits);
                            let [g_re, g_im, h_re, h_im] = green(simd, r2, k, simd.mul_f32s(m, areas));
                            let (g, h) = ([g_re, g_im], [h_re, h_im]);
                            let to_x = scaled(simd, of_image::<S>(simd, &on_x, bits), h);
                            let to_y = scaled(simd, of_image::<S>(simd, &on_y, bits), h);
                            let nn = of_image::<S>(simd, &normals, bits);
                            values[0][q] = turned(simd, nn, g, to_y);
                            values[1][q] = turned(simd, nn, g, to_x);
                            values[2][q] = turned(simd, beta, to_x, g);
                            values[3][q] = turned(simd, beta, to_y, g);
                            potential[q] = g;
                        }
                        butterflies::<S, 4, 8>(simd, &mut potential, axes);
                        butterflies::<S, 2, 8>(simd, &mut potential, axes);
                        butterflies::<S, 1, 8>(simd, &mut potential, axes);
                        for q in 0..8 {
                            if q & !axes == 0 {
                                for part in 0..2 {
                                    potentials[q][part][a][b] = potential[q][part];
                                }
                            }
                        }
                        for m in 0..4 {
                            let sums = even(simd, &values[m], axes);
                            for p in 0..count {
                                let s = self.parity::<AXES>(p);
                                for part in 0..2 {
                                    kernels[p][m][part][a][b] = sums[s][part];
                                }
                            }
                        }
                    }
                }
                for p in 0..count {
                    let s = self.parity::<AXES>(p);
                    let mut curls: Between<S::f32s, E, F> = [[[zero; F]; E]; 2];
                    for part in 0..2 {
                        for c in 0..3 {
                            let g = &potentials[s ^ axes ^ ((1 << c) & axes)][part];
                            for j in 0..F - 1 {
                                let mut rows = [zero; E];
                                for b in 0..F {
                                    let field = b * fields(F) + C + 3 * j + c;
                                    let curl = load::<S>(&self.f.single, field * wf + at);
                                    for a in 0..E {
                                        rows[a] = simd.mul_add_e_f32s(curl, g[a][b], rows[a]);
                                    }
                                }
                                for i in 0..E - 1 {
                                    for a in 0..E {
                                        let curl = simd.splat_f32s(own[a].curls[i][c]);
                                        curls[part][i][j] = simd.mul_add_e_f32s(curl, rows[a], curls[part][i][j]);
                                    }
                                }
                            }
                        }
                        // The curls of all corner functions sum to zero.
                        let curls = &mut curls[part];
                        for i in 0..E - 1 {
                            for j in 0..F - 1 {
                                let value = curls[i][j];
                                curls[i][F - 1] = simd.sub_f32s(curls[i][F - 1], value);
                                curls[E - 1][j] = simd.sub_f32s(curls[E - 1][j], value);
                                curls[E - 1][F - 1] = simd.add_f32s(curls[E - 1][F - 1], value);
                            }
                        }
                    }
                    let to = &mut self.to[p];
                    for part in 0..2 {
                        // alpha W = -j beta W.
                        let (other, factor) = (1 - part, if part == 0 { beta } else { minus_beta });
                        let [forward, backward, flow, flow_back] = [0, 1, 2, 3].map(|m| &kernels[p][m][part]);
                        let forward = first_to_corners::<S, E, F>(simd, &phi_e, forward);
                        let flow = first_to_corners::<S, E, F>(simd, &phi_e, flow);
                        for i in 0..E {
                            let row = self.e.local[e][i];
                            let forward = to_corners(simd, &phi_f, forward[i]);
                            for j in 0..F {
                                let value = simd.mul_add_e_f32s(factor, curls[other][i][j], forward[j]);
                                put(simd, &mut to.a, part, row, j * wf + at, value);
                                put(simd, &mut to.b, part, row, j * wf + at, flow[i][j]);
                            }
                        }
                        if self.diagonal {
                            continue;
                        }
                        let backward = first_to_corners::<S, E, F>(simd, &phi_e, backward);
                        for i in 0..E {
                            let row = self.e.local[e][i];
                            let backward = to_corners(simd, &phi_f, backward[i]);
                            for j in 0..F {
                                let value = simd.mul_add_e_f32s(factor, curls[other][i][j], backward[j]);
                                put(simd, &mut to.a_back, part, row, j * wf + at, value);
                            }
                        }
                        for a in 0..E {
                            let flow_back = to_corners(simd, &phi_f, flow_back[a]);
                            for j in 0..F {
                                put(simd, &mut to.b_back, part, a * we + e, j * wf + at, flow_back[j]);
                            }
                        }
                    }
                }
            }
        }
    }
}
