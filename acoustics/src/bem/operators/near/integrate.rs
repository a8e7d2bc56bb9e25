//! Applies a quadrature rule to a pair of panels, summing vectors of points.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::matrices::PairMatrices;
use super::tables::Sampled;
use crate::bem::mesh::panel::MOST_NODES;
use crate::trig::{combine, cross, dot, green, load, minus};
use pulp::{Simd, WithSimd};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

pub(super) struct Integrate<'a> {
    pub(super) k: f64,
    pub(super) x: &'a Sampled,
    pub(super) y: &'a Sampled,
    pub(super) weights: &'a [f64],
    pub(super) x_nodes: &'a [[f64; 3]; MOST_NODES],
    pub(super) y_nodes: &'a [[f64; 3]; MOST_NODES],
    /// -1 if the second panel is reflected once or three times, because mirrored tangents reverse its normal.
    pub(super) sign: f64,
    pub(super) out: &'a mut PairMatrices,
}

/// One side of a pair, evaluated at a vector of points.
struct Side<V, const E: usize> {
    x: [V; 3],
    normal: [V; 3],
    area: V,
    phi: [V; E],
    curl: [[V; 3]; E],
}

#[inline(always)]
fn side<S: Simd, const E: usize>(
    simd: S,
    table: &Sampled,
    at: usize,
    nodes: &[[f64; 3]; MOST_NODES],
    sign: f64,
) -> Side<S::f64s, E> {
    let zero = simd.splat_f64s(0.0);
    let offset = at * S::F64_LANES;
    let (nodes_count, step) = (table.nodes, table.padded);
    let mut sums = [[zero; 3]; 3];
    for a in 0..nodes_count {
        let node = nodes[a];
        let p = [
            simd.splat_f64s(node[0]),
            simd.splat_f64s(node[1]),
            simd.splat_f64s(node[2]),
        ];
        for m in 0..3 {
            let n = load::<S>(&table.values, (m * nodes_count + a) * step + offset);
            for c in 0..3 {
                sums[m][c] = simd.mul_add_e_f64s(n, p[c], sums[m][c]);
            }
        }
    }
    let [x, t1, t2] = sums;
    let sign = simd.splat_f64s(sign);
    let normal = cross(simd, sign, t1, t2);
    let mut side = Side {
        x,
        normal,
        area: simd.sqrt_f64s(dot(simd, normal, normal)),
        phi: [zero; E],
        curl: [[zero; 3]; E],
    };
    for i in 0..E {
        let start = (3 * nodes_count + i) * step + offset;
        side.phi[i] = load::<S>(&table.values, start);
        let d1 = load::<S>(&table.values, start + E * step);
        let d2 = load::<S>(&table.values, start + 2 * E * step);
        side.curl[i] = combine(simd, sign, [d1, d2], t2, t1);
    }
    side
}

impl WithSimd for Integrate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match (self.x.corners, self.y.corners) {
            (3, 3) if self.x.nodes == 3 && self.y.nodes == 3 => self.flat(simd),
            (3, 3) => self.run::<S, 3, 3>(simd),
            (3, _) => self.run::<S, 3, 4>(simd),
            (_, 3) => self.run::<S, 4, 3>(simd),
            _ => self.run::<S, 4, 4>(simd),
        }
    }
}

impl Integrate<'_> {
    #[inline(always)]
    fn run<S: Simd, const E: usize, const F: usize>(self, simd: S) {
        let zero = simd.splat_f64s(0.0);
        let k = simd.splat_f64s(self.k);
        let k2 = simd.splat_f64s(self.k * self.k);
        // s, k, kp, w; real and imaginary.
        let mut sums = [[[[zero; F]; E]; 2]; 4];
        for at in 0..self.weights.len() / S::F64_LANES {
            let w = load::<S>(self.weights, at * S::F64_LANES);
            let x = side::<S, E>(simd, self.x, at, self.x_nodes, 1.0);
            let y = side::<S, F>(simd, self.y, at, self.y_nodes, self.sign);
            let d = minus(simd, x.x, y.x);
            let scale = simd.mul_f64s(w, simd.splat_f64s(0.25 / PI));
            let [g_re, g_im, h_re, h_im] = green(simd, dot(simd, d, d), k, scale);
            let areas = simd.mul_f64s(x.area, y.area);
            let dn_y = simd.mul_f64s(dot(simd, d, y.normal), x.area);
            let dn_x = simd.neg_f64s(simd.mul_f64s(dot(simd, d, x.normal), y.area));
            let nn = simd.mul_f64s(k2, dot(simd, x.normal, y.normal));
            let (g, h) = ([g_re, g_im], [h_re, h_im]);
            for i in 0..E {
                let mut rows = [[zero; 3]; 2];
                for part in 0..2 {
                    let (g, h) = (simd.mul_f64s(g[part], x.phi[i]), simd.mul_f64s(h[part], x.phi[i]));
                    rows[part] = [simd.mul_f64s(g, areas), simd.mul_f64s(h, dn_y), simd.mul_f64s(h, dn_x)];
                }
                for j in 0..F {
                    let mass = simd.mul_f64s(x.phi[i], y.phi[j]);
                    let curls = simd.negate_mul_add_e_f64s(nn, mass, dot(simd, x.curl[i], y.curl[j]));
                    for part in 0..2 {
                        for m in 0..3 {
                            sums[m][part][i][j] = simd.mul_add_e_f64s(rows[part][m], y.phi[j], sums[m][part][i][j]);
                        }
                        sums[3][part][i][j] = simd.mul_add_e_f64s(g[part], curls, sums[3][part][i][j]);
                    }
                }
            }
        }
        let out = self.out;
        for (m, matrix) in [&mut out.s, &mut out.k, &mut out.kp, &mut out.w]
            .into_iter()
            .enumerate()
        {
            for i in 0..E {
                for j in 0..F {
                    let re = simd.reduce_sum_f64s(sums[m][0][i][j]);
                    let im = simd.reduce_sum_f64s(sums[m][1][i][j]);
                    matrix[i][j] += Complex::new(re, im);
                }
            }
        }
    }
}
