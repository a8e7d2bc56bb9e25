//! Rayleigh's kernel and the spherical waves of its points, by pair.

use crate::trig::sin_cos;
use pulp::{Arch, Simd, WithSimd};

/// K_b = sin(k r_b)/(k r_b), where r_b is the distance between a point of a plane and others with the coordinates `x`
/// and `y`.
pub(crate) fn sinc(k: f64, from: [f64; 2], [x, y]: [&[f64]; 2], kernel: &mut [f64]) {
    Arch::new().dispatch(Sinc { k, from, x, y, kernel });
}

struct Sinc<'a> {
    k: f64,
    from: [f64; 2],
    x: &'a [f64],
    y: &'a [f64],
    kernel: &'a mut [f64],
}

/// Below this, sin(x)/x is 1.
const SMALL: f64 = 1e-8;

impl WithSimd for Sinc<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (x, rest_x) = S::as_simd_f64s(self.x);
        let (y, rest_y) = S::as_simd_f64s(self.y);
        let (kernel, rest) = S::as_mut_simd_f64s(self.kernel);
        let [x0, y0] = self.from.map(|c| simd.splat_f64s(c));
        for ((x, y), kernel) in x.iter().zip(y).zip(kernel) {
            let (dx, dy) = (simd.sub_f64s(*x, x0), simd.sub_f64s(*y, y0));
            let r = simd.sqrt_f64s(simd.mul_add_e_f64s(dx, dx, simd.mul_f64s(dy, dy)));
            let kr = simd.max_f64s(simd.mul_f64s(simd.splat_f64s(self.k), r), simd.splat_f64s(SMALL));
            *kernel = simd.div_f64s(sin_cos(simd, kr).0, kr);
        }
        for ((x, y), kernel) in rest_x.iter().zip(rest_y).zip(rest) {
            let kr = (self.k * (x - self.from[0]).hypot(y - self.from[1])).max(SMALL);
            *kernel = kr.sin() / kr;
        }
    }
}

/// e^{-j k r_b}/r_b, real and imaginary part, where r_b is the distance between a point at `height` above a plane and
/// points in it with the coordinates `x` and `y`.
pub(super) fn outgoing(k: f64, (from, height): ([f64; 2], f64), [x, y]: [&[f64]; 2], [re, im]: [&mut [f64]; 2]) {
    Arch::new().dispatch(Outgoing {
        k,
        from,
        height,
        x,
        y,
        re,
        im,
    });
}

struct Outgoing<'a> {
    k: f64,
    from: [f64; 2],
    height: f64,
    x: &'a [f64],
    y: &'a [f64],
    re: &'a mut [f64],
    im: &'a mut [f64],
}

impl WithSimd for Outgoing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (x, rest_x) = S::as_simd_f64s(self.x);
        let (y, rest_y) = S::as_simd_f64s(self.y);
        let (re, rest_re) = S::as_mut_simd_f64s(self.re);
        let (im, rest_im) = S::as_mut_simd_f64s(self.im);
        let [x0, y0] = self.from.map(|c| simd.splat_f64s(c));
        let above = simd.splat_f64s(self.height * self.height);
        for (((x, y), re), im) in x.iter().zip(y).zip(re).zip(im) {
            let (dx, dy) = (simd.sub_f64s(*x, x0), simd.sub_f64s(*y, y0));
            let r = simd.sqrt_f64s(simd.mul_add_e_f64s(dx, dx, simd.mul_add_e_f64s(dy, dy, above)));
            let (sine, cosine) = sin_cos(simd, simd.mul_f64s(simd.splat_f64s(self.k), r));
            *re = simd.div_f64s(cosine, r);
            *im = simd.neg_f64s(simd.div_f64s(sine, r));
        }
        for (((x, y), re), im) in rest_x.iter().zip(rest_y).zip(rest_re).zip(rest_im) {
            let r = (x - self.from[0]).hypot(y - self.from[1]).hypot(self.height);
            let (sine, cosine) = (self.k * r).sin_cos();
            (*re, *im) = (cosine / r, -sine / r);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_that_leave_equal_their_definition() {
        let x: Vec<f64> = (0..13).map(|i| 0.05 * f64::from(i)).collect();
        let y: Vec<f64> = (0..13).map(|i| 0.3 - 0.02 * f64::from(i * i)).collect();
        for k in [0.5, 20.0, 300.0] {
            let (mut re, mut im) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            outgoing(k, ([0.2, -0.1], 0.7), [&x, &y], [&mut re, &mut im]);
            for i in 0..x.len() {
                let r = (x[i] - 0.2).hypot(y[i] + 0.1).hypot(0.7);
                let (sine, cosine) = (k * r).sin_cos();
                assert!(
                    (re[i] * r - cosine).abs() < 1e-12 && (im[i] * r + sine).abs() < 1e-12,
                    "{k} {i}"
                );
            }
        }
    }

    #[test]
    fn equals_the_definition() {
        let x: Vec<f64> = (0..11).map(|i| 0.05 * f64::from(i)).collect();
        let y: Vec<f64> = (0..11).map(|i| 0.3 - 0.02 * f64::from(i * i)).collect();
        for k in [0.5, 20.0, 300.0] {
            let mut kernel = vec![0.0; x.len()];
            sinc(k, [x[3], y[3]], [&x, &y], &mut kernel);
            for (i, found) in kernel.iter().enumerate() {
                let kr = k * (x[i] - x[3]).hypot(y[i] - y[3]);
                let exact = if i == 3 { 1.0 } else { kr.sin() / kr };
                assert!((found - exact).abs() < 1e-14, "{k} {i}: {found} {exact}");
            }
        }
    }
}
