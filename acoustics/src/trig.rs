#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use pulp::Simd;
use std::f64::consts::FRAC_2_PI;

/// pi/2 in three parts of 33 bits (Cody & Waite 1980, as in fdlibm): n times the first two is exact for n < 2^20.
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];
/// Adding and subtracting 1.5 x 2^52 rounds to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// sin x = x + x³ S(x²) and cos x = 1 - x²/2 + x⁴ C(x²) on |x| <= pi/4, highest power first (fdlibm).
const SINE: [f64; 6] = [
    1.589_690_995_211_55e-10,
    -2.505_076_025_340_686_3e-8,
    2.755_731_370_707_006_8e-6,
    -1.984_126_982_985_795e-4,
    8.333_333_333_322_49e-3,
    -0.166_666_666_666_666_32,
];
const COSINE: [f64; 6] = [
    -1.135_964_755_778_819_5e-11,
    2.087_572_321_298_175e-9,
    -2.755_731_435_139_066_3e-7,
    2.480_158_728_947_673e-5,
    -1.388_888_888_887_411e-3,
    4.166_666_666_666_66e-2,
];

// Functions are used instead of closures, because only functions that are always inlined inherit the vector features of
// their caller.

#[inline(always)]
fn rounded<S: Simd>(simd: S, y: S::f64s) -> S::f64s {
    let shift = simd.splat_f64s(ROUND);
    simd.sub_f64s(simd.add_f64s(y, shift), shift)
}

#[inline(always)]
fn horner<S: Simd>(simd: S, c: &[f64; 6], x: S::f64s) -> S::f64s {
    let mut sum = simd.splat_f64s(c[0]);
    for k in 1..6 {
        sum = simd.mul_add_e_f64s(sum, x, simd.splat_f64s(c[k]));
    }
    sum
}

/// v, or -v where `keep` is negative.
#[inline(always)]
fn signed<S: Simd>(simd: S, keep: S::f64s, v: S::f64s) -> S::f64s {
    simd.select_f64s(simd.less_than_f64s(keep, simd.splat_f64s(0.0)), simd.neg_f64s(v), v)
}

/// (sin x, cos x) for |x| < 10^6 with an error below 3e-16.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd>(simd: S, x: S::f64s) -> (S::f64s, S::f64s) {
    let n = rounded(simd, simd.mul_f64s(x, simd.splat_f64s(FRAC_2_PI)));
    let mut r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(HALF_PI[0]), x);
    r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(HALF_PI[1]), r);
    r = simd.negate_mul_add_e_f64s(n, simd.splat_f64s(HALF_PI[2]), r);
    let r2 = simd.mul_f64s(r, r);
    let sine = simd.mul_add_e_f64s(simd.mul_f64s(r, r2), horner(simd, &SINE, r2), r);
    let (one, half) = (simd.splat_f64s(1.0), simd.splat_f64s(0.5));
    let start = simd.negate_mul_add_e_f64s(r2, half, one);
    let cosine = simd.mul_add_e_f64s(simd.mul_f64s(r2, r2), horner(simd, &COSINE, r2), start);
    // Quadrant n mod 4 as -2 .. 2; odd quadrants swap sine and cosine.
    let quarter = rounded(simd, simd.mul_f64s(n, simd.splat_f64s(0.25)));
    let m = simd.negate_mul_add_e_f64s(quarter, simd.splat_f64s(4.0), n);
    let size = simd.abs_f64s(m);
    let odd = simd.less_than_f64s(simd.abs_f64s(simd.sub_f64s(size, one)), half);
    let (s, c) = (simd.select_f64s(odd, cosine, sine), simd.select_f64s(odd, sine, cosine));
    // sin changes sign for m = -2, -1, 2 and cos for m = -2, 1, 2.
    let two = simd.less_than_f64s(simd.splat_f64s(1.5), size);
    let minus = simd.splat_f64s(-1.0);
    let keep_s = simd.select_f64s(two, minus, simd.add_f64s(m, half));
    let keep_c = simd.select_f64s(two, minus, simd.sub_f64s(half, m));
    (signed(simd, keep_s, s), signed(simd, keep_c, c))
}

/// Single-precision versions.
pub(crate) mod single {
    use pulp::Simd;
    use std::f32::consts::{FRAC_1_PI, PI};

    /// pi minus its single-precision value.
    const PI_REST: f32 = -8.742_278e-8;
    /// Adding and subtracting 1.5 x 2^23 rounds to the nearest integer.
    const ROUND: f32 = 12_582_912.0;
    /// sin t = t + t³ S(t²) and cos t = 1 + t² C(t²) on |t| <= pi/2: minimax polynomials with errors of 5e-9 and
    /// 2e-10; highest power first.
    const SINE: [f32; 4] = [2.600_024_6e-6, -1.980_660_2e-4, 8.333_017e-3, -0.166_666_57];
    const COSINE: [f32; 5] = [-2.607_682e-7, 2.476_187_1e-5, -1.388_840_3e-3, 4.166_664e-2, -0.5];

    #[inline(always)]
    fn horner<S: Simd, const N: usize>(simd: S, c: &[f32; N], x: S::f32s) -> S::f32s {
        let mut sum = simd.splat_f32s(c[0]);
        for k in 1..N {
            sum = simd.mul_add_e_f32s(sum, x, simd.splat_f32s(c[k]));
        }
        sum
    }

    #[inline(always)]
    fn rounded<S: Simd>(simd: S, x: S::f32s, factor: f32) -> S::f32s {
        let shift = simd.splat_f32s(ROUND);
        simd.sub_f32s(simd.mul_add_e_f32s(x, simd.splat_f32s(factor), shift), shift)
    }

    /// (sin x, cos x) of the rounded x, with an error below 2e-7 for |x| < 60, using fused multiply-add.
    #[inline(always)]
    pub(crate) fn sin_cos<S: Simd>(simd: S, x: S::f32s) -> (S::f32s, S::f32s) {
        let (one, two) = (simd.splat_f32s(1.0), simd.splat_f32s(2.0));
        let n = rounded(simd, x, FRAC_1_PI);
        let t = simd.negate_mul_add_e_f32s(n, simd.splat_f32s(PI), x);
        let t = simd.negate_mul_add_e_f32s(n, simd.splat_f32s(PI_REST), t);
        // Both change sign for odd n.
        let odd = simd.negate_mul_add_e_f32s(rounded(simd, n, 0.5), two, n);
        let sign = simd.negate_mul_add_e_f32s(simd.mul_f32s(two, odd), odd, one);
        let t2 = simd.mul_f32s(t, t);
        let (c, s) = (horner(simd, &COSINE, t2), horner(simd, &SINE, t2));
        let sine = simd.mul_add_e_f32s(simd.mul_f32s(t, t2), s, t);
        let cosine = simd.mul_add_e_f32s(t2, c, one);
        (simd.mul_f32s(sign, sine), simd.mul_f32s(sign, cosine))
    }
}

/// a . b of vectors.
#[inline(always)]
pub(super) fn dot<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> S::f64s {
    simd.mul_add_e_f64s(a[2], b[2], simd.mul_add_e_f64s(a[1], b[1], simd.mul_f64s(a[0], b[0])))
}

/// a - b of vectors.
#[inline(always)]
pub(super) fn minus<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> [S::f64s; 3] {
    [
        simd.sub_f64s(a[0], b[0]),
        simd.sub_f64s(a[1], b[1]),
        simd.sub_f64s(a[2], b[2]),
    ]
}

/// s (a u - b v) of vectors.
#[inline(always)]
pub(super) fn combine<S: Simd>(
    simd: S,
    s: S::f64s,
    [a, b]: [S::f64s; 2],
    u: [S::f64s; 3],
    v: [S::f64s; 3],
) -> [S::f64s; 3] {
    let mut w = u;
    for c in 0..3 {
        w[c] = simd.mul_f64s(s, simd.negate_mul_add_e_f64s(b, v[c], simd.mul_f64s(a, u[c])));
    }
    w
}

/// s a x b of vectors.
#[inline(always)]
pub(super) fn cross<S: Simd>(simd: S, s: S::f64s, a: [S::f64s; 3], b: [S::f64s; 3]) -> [S::f64s; 3] {
    let mut w = a;
    for c in 0..3 {
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        w[c] = simd.mul_f64s(s, simd.negate_mul_add_e_f64s(a[j], b[i], simd.mul_f64s(a[i], b[j])));
    }
    w
}

/// The vector of values that starts at `start`.
#[inline(always)]
pub(super) fn load<S: Simd>(values: &[f64], start: usize) -> S::f64s {
    S::as_simd_f64s(&values[start..start + S::F64_LANES]).0[0]
}

/// Green's function G = e^{-jkr} / (4 pi r), times `scale`, and h = (1 + jkr) G / r²; real and imaginary parts, from
/// r². Then dG/dn_y = h (x - y) . n_y and dG/dn_x = -h (x - y) . n_x.
#[inline(always)]
pub(super) fn green<S: Simd>(simd: S, r2: S::f64s, k: S::f64s, scale: S::f64s) -> [S::f64s; 4] {
    let r = simd.sqrt_f64s(r2);
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), r);
    let kr = simd.mul_f64s(k, r);
    let (sine, cosine) = sin_cos(simd, kr);
    let magnitude = simd.mul_f64s(inverse, scale);
    let g_re = simd.mul_f64s(cosine, magnitude);
    let g_im = simd.neg_f64s(simd.mul_f64s(sine, magnitude));
    let inverse2 = simd.mul_f64s(inverse, inverse);
    let h_re = simd.mul_f64s(simd.negate_mul_add_e_f64s(kr, g_im, g_re), inverse2);
    let h_im = simd.mul_f64s(simd.mul_add_e_f64s(kr, g_re, g_im), inverse2);
    [g_re, g_im, h_re, h_im]
}

#[cfg(test)]
mod tests {
    use super::{sin_cos, single};
    use pulp::{Arch, Simd, WithSimd};

    struct All<'a>(&'a [f64], &'a mut [f64], &'a mut [f64]);

    impl WithSimd for All<'_> {
        type Output = ();
        fn with_simd<S: Simd>(self, simd: S) {
            let x = S::as_simd_f64s(self.0).0;
            let (s, c) = (S::as_mut_simd_f64s(self.1).0, S::as_mut_simd_f64s(self.2).0);
            for ((x, s), c) in x.iter().zip(s).zip(c) {
                (*s, *c) = sin_cos(simd, *x);
            }
        }
    }

    struct Single<'a>(&'a [f32], &'a mut [f32], &'a mut [f32]);

    impl WithSimd for Single<'_> {
        type Output = ();
        fn with_simd<S: Simd>(self, simd: S) {
            let x = S::as_simd_f32s(self.0).0;
            let (s, c) = (S::as_mut_simd_f32s(self.1).0, S::as_mut_simd_f32s(self.2).0);
            for ((x, s), c) in x.iter().zip(s).zip(c) {
                (*s, *c) = single::sin_cos(simd, *x);
            }
        }
    }

    #[test]
    fn equals_the_library_in_single_precision() {
        let x: Vec<f32> = (-60_000..60_000).map(|i| i as f32 * 1e-3).collect();
        let (mut s, mut c) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        Arch::new().dispatch(Single(&x, &mut s, &mut c));
        let errors = x.iter().zip(&s).zip(&c).map(|((x, s), c)| {
            let (sine, cosine) = f64::from(*x).sin_cos();
            (sine - f64::from(*s)).abs().max((cosine - f64::from(*c)).abs())
        });
        let largest = errors.fold(0.0, f64::max);
        println!("{largest:e}");
        assert!(largest < 2e-7, "{largest:e}");
    }

    #[test]
    fn equals_the_library_to_rounding() {
        let x: Vec<f64> = (0..800_000)
            .map(|i| f64::from(i) * 1.000_37e-3 + 1e-9)
            .chain((0..8).map(f64::from))
            .collect();
        let (mut s, mut c) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        Arch::new().dispatch(All(&x, &mut s, &mut c));
        for ((x, s), c) in x.iter().zip(&s).zip(&c) {
            assert!(
                (x.sin() - s).abs() < 3e-16 && (x.cos() - c).abs() < 3e-16,
                "{x}: {s} {c}"
            );
        }
    }
}
