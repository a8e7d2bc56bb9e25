use nalgebra::Complex;
use std::ops::Mul;

/// Relates sound pressure and volume flow at the inlet of an element to those at its outlet.
///
/// ```text
/// [p1]   [A B] [p2]
/// [U1] = [C D] [U2]
/// ```
///
/// Reciprocal elements have A D - B C = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourPole {
    /// p1/p2 with the outlet closed.
    pub a: Complex<f64>,
    /// p1/U2 with zero pressure at the outlet \[Pa s/m³\].
    pub b: Complex<f64>,
    /// U1/p2 with the outlet closed \[m³/(Pa s)\].
    pub c: Complex<f64>,
    /// U1/U2 with zero pressure at the outlet.
    pub d: Complex<f64>,
}

impl FourPole {
    /// No element between inlet and outlet; also a sudden change of area, across which pressure and flow are
    /// continuous.
    pub const IDENTITY: Self = Self {
        a: Complex::ONE,
        b: Complex::ZERO,
        c: Complex::ZERO,
        d: Complex::ONE,
    };

    /// A pipe of length `length` \[m\], with wavenumber k \[1/m\] and characteristic impedance Z \[Pa s/m³\].
    ///
    /// ```text
    /// A = D = cos k l      B = j Z sin k l      C = j sin(k l) / Z
    /// ```
    pub fn pipe(k: Complex<f64>, impedance: Complex<f64>, length: f64) -> Self {
        let (sine, cosine) = ((k * length).sin(), (k * length).cos());
        Self {
            a: cosine,
            b: Complex::<f64>::i() * impedance * sine,
            c: Complex::<f64>::i() * sine / impedance,
            d: cosine,
        }
    }

    /// A D - B C.
    pub fn determinant(&self) -> Complex<f64> {
        self.a * self.d - self.b * self.c
    }

    /// Transmission loss between anechoic pipes of impedances Z1 and Z2 \[Pa s/m³\], in decibels.
    ///
    /// ```text
    /// TL = 10 lg( Z2/Z1 |(A + B/Z2 + C Z1 + D Z1/Z2) / 2|^2 )
    /// ```
    pub fn transmission_loss(&self, inlet: f64, outlet: f64) -> f64 {
        let sum = self.a + self.b / outlet + self.c * inlet + self.d * inlet / outlet;
        10.0 * (0.25 * sum.norm_sqr() * outlet / inlet).log10()
    }

    /// Level difference between the volume flows at inlet and outlet for a load Z \[Pa s/m³\]: 20 lg |C Z + D|.
    pub fn flow_loss(&self, load: Complex<f64>) -> f64 {
        10.0 * (self.c * load + self.d).norm_sqr().log10()
    }
}

impl Mul for FourPole {
    type Output = Self;

    fn mul(self, next: Self) -> Self {
        Self {
            a: self.a * next.a + self.b * next.c,
            b: self.a * next.b + self.b * next.d,
            c: self.c * next.a + self.d * next.c,
            d: self.c * next.b + self.d * next.d,
        }
    }
}
