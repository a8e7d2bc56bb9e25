//! Pairs of flat triangles: normals, areas and curls are constant on the panels, and W follows from S and the sum of G.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::integrate::Integrate;
use crate::trig::{dot, green, load};
use nalgebra::Vector3;
use pulp::Simd;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Twice the vector area, and the curls n x grad phi of the corner functions times twice the area.
fn triangle(nodes: &[[f64; 3]], sign: f64) -> (Vector3<f64>, [Vector3<f64>; 3]) {
    let [a, b, c] = [0, 1, 2].map(|i| Vector3::from(nodes[i]));
    (
        (b - a).cross(&(c - a)) * sign,
        [b - c, c - a, a - b].map(|edge| edge * sign),
    )
}

#[inline(always)]
fn splat3<S: Simd>(simd: S, v: Vector3<f64>) -> [S::f64s; 3] {
    [simd.splat_f64s(v.x), simd.splat_f64s(v.y), simd.splat_f64s(v.z)]
}

impl Integrate<'_> {
    /// Both panels are three-node triangles.
    #[inline(always)]
    pub(super) fn flat<S: Simd>(self, simd: S) {
        let zero = simd.splat_f64s(0.0);
        let (normal_x, curls_x) = triangle(self.x_nodes, 1.0);
        let (normal_y, curls_y) = triangle(self.y_nodes, self.sign);
        let (area_x, area_y) = (normal_x.norm(), normal_y.norm());
        let (n_x, n_y) = (splat3(simd, normal_x), splat3(simd, normal_y));
        let mut x_nodes = [[zero; 3]; 3];
        let mut y_nodes = [[zero; 3]; 3];
        for a in 0..3 {
            x_nodes[a] = splat3(simd, Vector3::from(self.x_nodes[a]));
            y_nodes[a] = splat3(simd, Vector3::from(self.y_nodes[a]));
        }
        let k = simd.splat_f64s(self.k);
        let unit = simd.splat_f64s(0.25 / PI);
        // G, (x - y) . n_y h and (x - y) . n_x h times corner functions, and the sum of G.
        let mut sums = [[[[zero; 3]; 3]; 2]; 3];
        let mut whole = [zero; 2];
        for at in 0..self.weights.len() / S::F64_LANES {
            let offset = at * S::F64_LANES;
            let scale = simd.mul_f64s(load::<S>(self.weights, offset), unit);
            let (mut phi, mut psi) = ([zero; 3], [zero; 3]);
            let mut d = [zero; 3];
            for a in 0..3 {
                phi[a] = load::<S>(&self.x.values, a * self.x.padded + offset);
                psi[a] = load::<S>(&self.y.values, a * self.y.padded + offset);
            }
            for a in 0..3 {
                for c in 0..3 {
                    d[c] = simd.mul_add_e_f64s(phi[a], x_nodes[a][c], d[c]);
                }
            }
            for a in 0..3 {
                for c in 0..3 {
                    d[c] = simd.negate_mul_add_e_f64s(psi[a], y_nodes[a][c], d[c]);
                }
            }
            let [g_re, g_im, h_re, h_im] = green(simd, dot(simd, d, d), k, scale);
            let (on_y, on_x) = (dot(simd, d, n_y), dot(simd, d, n_x));
            let (g, h) = ([g_re, g_im], [h_re, h_im]);
            for part in 0..2 {
                whole[part] = simd.add_f64s(whole[part], g[part]);
                let kernels = [g[part], simd.mul_f64s(h[part], on_y), simd.mul_f64s(h[part], on_x)];
                for m in 0..3 {
                    for i in 0..3 {
                        let row = simd.mul_f64s(kernels[m], phi[i]);
                        for j in 0..3 {
                            sums[m][part][i][j] = simd.mul_add_e_f64s(row, psi[j], sums[m][part][i][j]);
                        }
                    }
                }
            }
        }
        let whole = Complex::new(simd.reduce_sum_f64s(whole[0]), simd.reduce_sum_f64s(whole[1]));
        let nn = self.k * self.k * normal_x.dot(&normal_y);
        let out = self.out;
        for i in 0..3 {
            for j in 0..3 {
                let mut value = [Complex::default(); 3];
                for m in 0..3 {
                    let re = simd.reduce_sum_f64s(sums[m][0][i][j]);
                    let im = simd.reduce_sum_f64s(sums[m][1][i][j]);
                    value[m] = Complex::new(re, im);
                }
                let [s, on_y, on_x] = value;
                out.s[i][j] += s * (area_x * area_y);
                out.k[i][j] += on_y * area_x;
                out.kp[i][j] -= on_x * area_y;
                out.w[i][j] += whole * curls_x[i].dot(&curls_y[j]) - s * nn;
            }
        }
    }
}
