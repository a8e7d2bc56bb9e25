//! Number types for model evaluation: `f64`, and `f64` with exact derivatives.
//!
//! The right-hand side is generic over [`Real`]. With [`Dual`], one evaluation also yields the Jacobian to round-off by
//! forward-mode automatic differentiation (Griewank and Walther, Evaluating Derivatives, 2008, ch. 3). The Newton
//! matrix therefore has exactly the linear invariants of the model, and Newton steps conserve mass and energy to
//! round-off.

use std::ops::{Add, Mul, Neg, Sub};

/// Arithmetic required by the model.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Whether the type carries derivatives.
    const DIFFERENTIATED: bool;

    /// A number that does not depend on the state.
    fn constant(value: f64) -> Self;

    /// The number without its derivatives.
    fn value(self) -> f64;

    /// f(self), given f and f' at its value.
    fn chain(self, f: f64, derivative: f64) -> Self;

    /// 1/self.
    #[inline]
    fn recip(self) -> Self {
        let r = 1.0 / self.value();
        self.chain(r, -r * r)
    }

    /// 1/sqrt(self).
    #[inline]
    fn recip_sqrt(self) -> Self {
        let x = self.value();
        let r = 1.0 / x.sqrt();
        self.chain(r, -0.5 * r / x)
    }

    /// Evaluates the polynomial sum c_i self^i.
    #[inline]
    fn polynomial(self, coefficients: &[f64]) -> Self {
        let x = self.value();
        let (mut p, mut dp) = (0.0, 0.0);
        for c in coefficients.iter().rev() {
            dp = dp * x + p;
            p = p * x + c;
        }
        self.chain(p, dp)
    }
}

impl Real for f64 {
    const DIFFERENTIATED: bool = false;

    #[inline]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn chain(self, f: f64, _derivative: f64) -> Self {
        f
    }
}

/// A value with its derivatives along `N` directions.
#[derive(Debug, Clone, Copy)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub slope: [f64; N],
}

impl<const N: usize> Dual<N> {
    #[inline]
    fn map(self, value: f64, f: impl Fn(f64) -> f64) -> Self {
        let mut slope = self.slope;
        for s in &mut slope {
            *s = f(*s);
        }
        Self { value, slope }
    }

    #[inline]
    fn zip(self, other: &Self, value: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut slope = self.slope;
        for (s, o) in slope.iter_mut().zip(&other.slope) {
            *s = f(*s, *o);
        }
        Self { value, slope }
    }
}

impl<const N: usize> Real for Dual<N> {
    const DIFFERENTIATED: bool = true;

    #[inline]
    fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; N] }
    }

    #[inline]
    fn value(self) -> f64 {
        self.value
    }

    #[inline]
    fn chain(self, f: f64, derivative: f64) -> Self {
        self.map(f, |s| derivative * s)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(&other, self.value + other.value, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(&other, self.value - other.value, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "product rule")]
    fn mul(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        self.zip(&other, x * y, |a, b| a * y + b * x)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(-self.value, |s| -s)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(mut self, other: f64) -> Self {
        self.value -= other;
        self
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        self.map(self.value * other, |s| s * other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(f: impl Fn(f64) -> f64, g: impl Fn(Dual<1>) -> Dual<1>, x: f64) {
        let h = 1e-6 * x.abs();
        let slope = (f(x + h) - f(x - h)) / (2.0 * h);
        let dual = g(Dual { value: x, slope: [1.0] });
        assert!((dual.value - f(x)).abs() <= 1e-14 * f(x).abs());
        assert!(
            (dual.slope[0] - slope).abs() <= 1e-8 * slope.abs(),
            "{} {slope}",
            dual.slope[0]
        );
    }

    #[test]
    fn derivatives_equal_central_differences() {
        check(|x| 1.0 / x, |x| x.recip(), 3.0);
        check(|x| 1.0 / x.sqrt(), |x| x.recip_sqrt(), 3.0);
        check(
            |x| 1.0 - 2.0 * x + 5.0 * x * x,
            |x| x.polynomial(&[1.0, -2.0, 5.0]),
            0.7,
        );
        check(|x| (x * x - x) * 2.0, |x| (x * x - x) * 2.0, 1.3);
    }
}
