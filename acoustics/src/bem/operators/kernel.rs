//! Green's function in single precision, for pairs of points of the far rule.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use pulp::Simd;
use std::f32::consts::TAU;

/// 2 pi minus its single-precision value.
const TAU_REST: f32 = -1.748_455_5e-7;
/// Adding and subtracting 1.5 x 2^23 rounds to the nearest integer.
const ROUND: f32 = 12_582_912.0;
/// sin t = t + t³ S(t²) and cos t = 1 + t² C(t²) for |t| <= pi, minimax with largest errors of 1e-9 and 1e-8; highest
/// power first.
const SINE: [f32; 6] = [
    1.353_119_1e-10,
    -2.470_400_2e-8,
    2.753_303_3e-6,
    -1.984_038_8e-4,
    8.333_318e-3,
    -0.166_666_66,
];
const COSINE: [f32; 6] = [
    1.729_556_3e-9,
    -2.709_501e-7,
    2.477_182_2e-5,
    -1.388_791_6e-3,
    4.166_652e-2,
    -0.499_999_94,
];
/// Added to squared distances \[m²\], because masked pairs may coincide.
pub(crate) const APART: f32 = 1e-24;

#[inline(always)]
fn horner<S: Simd>(simd: S, c: &[f32; 6], x: S::f32s) -> S::f32s {
    let mut sum = simd.splat_f32s(c[0]);
    for k in 1..6 {
        sum = simd.mul_add_e_f32s(sum, x, simd.splat_f32s(c[k]));
    }
    sum
}

/// The vector of values that starts at `start`.
#[inline(always)]
pub(crate) fn load<S: Simd>(values: &[f32], start: usize) -> S::f32s {
    S::as_simd_f32s(&values[start..start + S::F32_LANES]).0[0]
}

/// Three vectors of values, with stride `step`.
#[inline(always)]
pub(crate) fn load3<S: Simd>(values: &[f32], start: usize, step: usize) -> [S::f32s; 3] {
    [
        load::<S>(values, start),
        load::<S>(values, start + step),
        load::<S>(values, start + 2 * step),
    ]
}

/// `scale` times G = e^{-jkr} / r and h = (1 + jkr) G / r², real and imaginary parts, computed from r².
///
/// The imaginary part of h, x cos x - sin x with x = kr, is -x³/3 for small x. The cancelling terms are removed
/// analytically,
///
/// ```text
/// x = t + 2 pi n      x cos x - sin x = (x - t) + t² (x C(t²) - t S(t²))
/// ```
///
/// so the resistance stays accurate at low frequencies.
#[inline(always)]
pub(crate) fn green<S: Simd>(simd: S, r2: S::f32s, k: S::f32s, scale: S::f32s) -> [S::f32s; 4] {
    let one = simd.splat_f32s(1.0);
    let inverse = simd.div_f32s(one, simd.sqrt_f32s(r2));
    let x = simd.mul_f32s(k, simd.mul_f32s(r2, inverse));
    let shift = simd.splat_f32s(ROUND);
    let turns = simd.mul_add_e_f32s(x, simd.splat_f32s(1.0 / TAU), shift);
    let turns = simd.sub_f32s(turns, shift);
    let t = simd.negate_mul_add_e_f32s(turns, simd.splat_f32s(TAU), x);
    let t = simd.negate_mul_add_e_f32s(turns, simd.splat_f32s(TAU_REST), t);
    let t2 = simd.mul_f32s(t, t);
    let (c, s) = (horner(simd, &COSINE, t2), horner(simd, &SINE, t2));
    let ts = simd.mul_f32s(t, s);
    let cosine = simd.mul_add_e_f32s(t2, c, one);
    let sine = simd.mul_add_e_f32s(t2, ts, t);
    let real = simd.mul_add_e_f32s(x, sine, cosine);
    let rest = simd.sub_f32s(simd.mul_f32s(x, c), ts);
    let imaginary = simd.mul_add_e_f32s(t2, rest, simd.sub_f32s(x, t));
    let magnitude = simd.mul_f32s(inverse, scale);
    let cubed = simd.mul_f32s(magnitude, simd.mul_f32s(inverse, inverse));
    [
        simd.mul_f32s(cosine, magnitude),
        simd.neg_f32s(simd.mul_f32s(sine, magnitude)),
        simd.mul_f32s(real, cubed),
        simd.mul_f32s(imaginary, cubed),
    ]
}

#[cfg(test)]
mod tests {
    use super::green;
    use pulp::{Arch, Simd, WithSimd};

    struct All<'a>(&'a [f32], f32, [&'a mut [f32]; 4]);

    impl WithSimd for All<'_> {
        type Output = ();
        fn with_simd<S: Simd>(self, simd: S) {
            let Self(r2, k, mut to) = self;
            for (i, r2) in S::as_simd_f32s(r2).0.iter().enumerate() {
                let found = green(simd, *r2, simd.splat_f32s(k), simd.splat_f32s(1.0));
                for (to, found) in to.iter_mut().zip(found) {
                    S::as_mut_simd_f32s(to).0[i] = found;
                }
            }
        }
    }

    /// Each part is accurate relative to itself for small kr, and relative to the magnitude and rounded phase
    /// otherwise.
    #[test]
    fn keeps_its_digits_at_any_distance() {
        for k in [1e-3f32, 0.1, 1.0, 20.0, 60.0] {
            let r2: Vec<f32> = (1..4097).map(|i| (i as f32 * 5e-4).powi(2)).collect();
            let mut found = [(); 4].map(|()| vec![0f32; r2.len()]);
            Arch::new().dispatch(All(&r2, k, found.each_mut().map(Vec::as_mut_slice)));
            for (i, r2) in r2.iter().enumerate() {
                let r = f64::from(*r2).sqrt();
                let x = f64::from(k) * r;
                let (sine, cosine) = x.sin_cos();
                // Taylor series of x cos x - sin x where the expression would suffer from cancellation.
                let small = -x.powi(3) / 3.0 * (1.0 - x * x / 10.0 * (1.0 - x * x / 28.0));
                let imaginary = if x < 0.1 { small } else { x * cosine - sine };
                let exact = [cosine, -sine, cosine + x * sine, imaginary];
                let size = [1.0, x.min(1.0), 1.0 + x, x.powi(3).min(1.0 + x)];
                for (part, scale) in [r, r, r.powi(3), r.powi(3)].into_iter().enumerate() {
                    let error = (f64::from(found[part][i]) * scale - exact[part]).abs() / size[part];
                    assert!(error < 1e-6 + 1.5e-7 * x, "k {k}, r {r}, part {part}: {error:e}");
                }
            }
        }
    }
}
