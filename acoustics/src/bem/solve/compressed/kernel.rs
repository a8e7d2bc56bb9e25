//! Kernels between one point and the points of a cluster.
//!
//! With d = x - y, r = |d|, G = e^{-jkr} / (4 pi r), h = (1 + jkr) G / r² and alpha = -j beta, the kernels between
//! points x and y are
//!
//! ```text
//! a(x, y) = -(1 + alpha d/dn_x) dG/dn_y     dG/dn_y = h d.n_y
//!                                            d²G/dn_x dn_y = (d.n_x)(d.n_y)/r² (k² G - 3 h) + h n_x.n_y
//! b(x, y) =  (1 + alpha d/dn_x) G            dG/dn_x = -h d.n_x
//! ```
//!
//! For distant panels, the derivative of the double layer needs no integration by parts. Integrated over all panels
//! that carry an unknown, both forms yield the same operator. Without integration by parts, a row of the block is a
//! sound field plus its normal derivative, so its rank is that of G.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::points::{ClusterPoints, FIELDS};
use crate::bem::mesh::symmetry::{Image, Parity};
use crate::bem::operators::kernel::{APART, green, load};
use crate::bem::operators::wave::Wave;
use nalgebra::Vector3;
use pulp::{Simd, WithSimd};
use std::f64::consts::PI;

/// Mirror planes relative to the origin of the points, and the images with their signs for one parity.
#[derive(Debug)]
pub(super) struct Images {
    images: Vec<(Image, f32)>,
    planes: [f32; 3],
}

impl Images {
    pub(super) fn new(images: &[Image], parity: Parity, planes: &[Option<f64>; 3], middle: &Vector3<f64>) -> Self {
        Self {
            images: images.iter().map(|&i| (i, parity.sign(i) as f32)).collect(),
            planes: std::array::from_fn(|c| planes[c].map_or(0.0, |plane| (plane - middle[c]) as f32)),
        }
    }

    /// The images of a point and its normal, with their signs.
    ///
    /// The distance from x to the image of y equals that from the image of x to y; likewise for the products with
    /// normals.
    fn of(&self, point: [f32; 6]) -> impl Iterator<Item = ([f32; 6], f32)> {
        self.images.iter().map(move |&(image, sign)| {
            let mut seen = point;
            for axis in (0..3).filter(|&axis| image.sign_along(axis) < 0.0) {
                seen[axis] = 2.0 * self.planes[axis] - point[axis];
                seen[3 + axis] = -point[3 + axis];
            }
            (seen, sign)
        })
    }
}

/// Which point of a pair is the single one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Single {
    /// x: a row of the block.
    Receiver,
    /// y: a column of the block.
    Source,
}

/// Kernels between one point and the points of a cluster, all weighted with areas.
#[derive(Debug)]
pub(super) struct Kernels<'a> {
    pub(super) wave: Wave,
    pub(super) images: &'a Images,
}

impl Kernels<'_> {
    /// a and `scale` times b between x = `point` and y = the points of the cluster. The real and imaginary parts of a
    /// come first, each with the padded number of points. Those of b follow, each with the number of owned values.
    pub(super) fn row(
        &self,
        (point, weight): ([f32; 6], f32),
        cluster: &ClusterPoints,
        (scale, own): (f32, usize),
        to: &mut [f32],
    ) {
        let (a, b) = to.split_at_mut(2 * cluster.padded);
        self.add(point, weight, Single::Receiver, cluster, Some(a), Some((scale, own, b)));
    }

    /// a between y = `point` and x = the points of the cluster, real and imaginary part.
    pub(super) fn column_a(&self, (point, weight): ([f32; 6], f32), cluster: &ClusterPoints, to: &mut [f32]) {
        self.add(point, weight, Single::Source, cluster, Some(to), None);
    }

    /// `scale` times b between y = `point` and x = the points of the cluster, real and imaginary part.
    pub(super) fn column_b(
        &self,
        (point, weight): ([f32; 6], f32),
        cluster: &ClusterPoints,
        scale: f32,
        to: &mut [f32],
    ) {
        let b = Some((scale, cluster.padded, to));
        self.add(point, weight, Single::Source, cluster, None, b);
    }

    fn add(
        &self,
        point: [f32; 6],
        weight: f32,
        single: Single,
        cluster: &ClusterPoints,
        mut a: Option<&mut [f32]>,
        mut b: Option<(f32, usize, &mut [f32])>,
    ) {
        if let Some(a) = &mut a {
            a.fill(0.0);
        }
        if let Some((_, _, b)) = &mut b {
            b.fill(0.0);
        }
        for (seen, sign) in self.images.of(point) {
            pulp::Arch::new().dispatch(Between {
                wave: self.wave,
                point: seen,
                weight: sign * weight,
                single,
                cluster,
                a: a.as_deref_mut(),
                b: b.as_mut().map(|(scale, own, b)| (*scale, *own, &mut **b)),
            });
        }
    }
}

/// Adds the kernels of one image.
struct Between<'a> {
    wave: Wave,
    point: [f32; 6],
    weight: f32,
    single: Single,
    cluster: &'a ClusterPoints,
    a: Option<&'a mut [f32]>,
    b: Option<(f32, usize, &'a mut [f32])>,
}

impl WithSimd for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            wave,
            point,
            weight,
            single,
            cluster,
            a,
            b,
        } = self;
        let (padded, data) = (cluster.padded, &cluster.data[..]);
        let (scale, own, to_b) = b.unwrap_or((0.0, 0, &mut []));
        let (b_re, b_im) = to_b.split_at_mut(own);
        let (empty, to_a) = match a {
            Some(a) => (false, a),
            None => (true, &mut [][..]),
        };
        let (a_re, a_im) = to_a.split_at_mut(if empty { 0 } else { padded });
        let k = simd.splat_f32s(wave.k as f32);
        let k2 = simd.splat_f32s((wave.k * wave.k) as f32);
        let beta = simd.splat_f32s(wave.coupling as f32);
        let (scale, three) = (simd.splat_f32s(scale), simd.splat_f32s(3.0));
        let apart = simd.splat_f32s(APART);
        let weight = simd.splat_f32s(weight / (4.0 * PI as f32));
        let lanes = S::F32_LANES;
        let receiver = single == Single::Receiver;
        let count = if empty { own } else { padded };
        for at in (0..count).step_by(lanes) {
            // Projections of the distance on the single point's normal and on the others' normals, and the product of
            // the normals; d points from the others to the single point.
            let (mut on_own, mut on_other) = (simd.splat_f32s(0.0), simd.splat_f32s(0.0));
            let (mut normals, mut r2) = (simd.splat_f32s(0.0), apart);
            for c in 0..3 {
                let d = simd.sub_f32s(simd.splat_f32s(point[c]), load::<S>(data, c * padded + at));
                let n = load::<S>(data, (3 + c) * padded + at);
                let own_normal = simd.splat_f32s(point[3 + c]);
                r2 = simd.mul_add_e_f32s(d, d, r2);
                on_own = simd.mul_add_e_f32s(d, own_normal, on_own);
                on_other = simd.mul_add_e_f32s(d, n, on_other);
                normals = simd.mul_add_e_f32s(n, own_normal, normals);
            }
            let areas = simd.mul_f32s(weight, load::<S>(data, (FIELDS - 1) * padded + at));
            let [g_re, g_im, h_re, h_im] = green(simd, r2, k, areas);
            // d is x - y for a single receiver, y - x for a single source.
            let (on_x, on_y) = if receiver {
                (on_own, on_other)
            } else {
                (simd.neg_f32s(on_other), simd.neg_f32s(on_own))
            };
            if !empty {
                let ratio = simd.div_f32s(simd.mul_f32s(on_x, on_y), r2);
                let h_factor = simd.negate_mul_add_e_f32s(three, ratio, normals);
                let g_factor = simd.mul_f32s(ratio, k2);
                let slope_re = simd.mul_add_e_f32s(g_factor, g_re, simd.mul_f32s(h_factor, h_re));
                let slope_im = simd.mul_add_e_f32s(g_factor, g_im, simd.mul_f32s(h_factor, h_im));
                // a = -h d.n_y + j beta d²G/dn_x dn_y
                let re = simd.mul_add_e_f32s(h_re, on_y, simd.mul_f32s(beta, slope_im));
                let im = simd.negate_mul_add_e_f32s(h_im, on_y, simd.mul_f32s(beta, slope_re));
                let to = &mut S::as_mut_simd_f32s(&mut a_re[at..at + lanes]).0[0];
                *to = simd.sub_f32s(*to, re);
                let to = &mut S::as_mut_simd_f32s(&mut a_im[at..at + lanes]).0[0];
                *to = simd.add_f32s(*to, im);
            }
            if at < own {
                // b = G + j beta h d.n_x
                let share = simd.mul_f32s(beta, on_x);
                let re = simd.negate_mul_add_e_f32s(share, h_im, g_re);
                let im = simd.mul_add_e_f32s(share, h_re, g_im);
                let to = &mut S::as_mut_simd_f32s(&mut b_re[at..at + lanes]).0[0];
                *to = simd.mul_add_e_f32s(scale, re, *to);
                let to = &mut S::as_mut_simd_f32s(&mut b_im[at..at + lanes]).0[0];
                *to = simd.mul_add_e_f32s(scale, im, *to);
            }
        }
    }
}
