use std::sync::LazyLock;

/// Similarity spectrum of fine-scale jet turbulence, per hertz, in decibels below its peak.
///
/// C. K. W. Tam, M. Golebiowski & J. M. Seiner, AIAA 96-1716 (1996), with x = f/f_peak, l = lg x, m = lg(20 x/3) and
/// n = lg(x/10):
///
/// ```text
/// 10 lg G = 9.9 + 14.91126 l                                          x <= 0.05
///           -3.5 + (11.874876 + 2.1202444 m + 7.5211814 m^2) m        0.05 .. 0.15
///           (-1.0550362 + 4.9774046 l) l^2                            0.15 .. 1
///           -(8.1476823 + 3.6523177 l) l^2                            1 .. 10
///           -11.8 - (27.2523 + 0.8091863 n + 14.851964 n^2) n         10 .. 30
///           29.77786 - 38.16739 l                                     x >= 30
/// ```
pub fn fine_scale_shape(x: f64) -> f64 {
    let l = x.log10();
    if x <= 0.05 {
        9.9 + 14.91126 * l
    } else if x <= 0.15 {
        let m = (20.0 * x / 3.0).log10();
        -3.5 + (11.874876 + (2.1202444 + 7.5211814 * m) * m) * m
    } else if x <= 1.0 {
        (-1.0550362 + 4.9774046 * l) * l * l
    } else if x <= 10.0 {
        -(8.1476823 + 3.6523177 * l) * l * l
    } else if x <= 30.0 {
        let n = l - 1.0;
        -11.8 - (27.2523 + (0.8091863 + 14.851964 * n) * n) * n
    } else {
        29.77786 - 38.16739 * l
    }
}

/// x G(x), the shape per natural logarithm of frequency.
pub(super) fn shape(x: f64) -> f64 {
    x * 10f64.powf(0.1 * fine_scale_shape(x))
}

/// Integral of [`shape`] over ln x: closed forms for the power-law tails, the trapezoidal rule in lg x between them.
pub(super) fn total() -> f64 {
    static TOTAL: LazyLock<f64> = LazyLock::new(integral);
    *TOTAL
}

fn integral() -> f64 {
    const LN10: f64 = std::f64::consts::LN_10;
    let tails = shape(0.05) / (1.0 + 1.491126) + shape(30.0) / (3.816739 - 1.0);
    // Joints of the pieces, between which the function is smooth.
    let joints: [f64; 5] = [0.05, 0.15, 1.0, 10.0, 30.0];
    let piece = |pair: &[f64]| {
        let (a, b, n) = (pair[0].log10(), pair[1].log10(), 256);
        let h = (b - a) / f64::from(n);
        // Each joint belongs to the piece on its left; the function jumps there by less than 1e-3 dB.
        let inner: f64 = (1..n).map(|i| shape(10f64.powf(a + h * f64::from(i)))).sum();
        h * LN10 * (inner + 0.5 * (shape(pair[0]) + shape(pair[1])))
    };
    tails + joints.windows(2).map(piece).sum::<f64>()
}
