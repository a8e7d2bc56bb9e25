use super::jet::Jet;
use crate::air::Air;

/// First lg sigma of the table, and its step of a third octave.
const START: f64 = -0.8;
const STEP: f64 = 0.1;

/// lg H at lg sigma = -0.8 (0.1) 2.5.
const LG_H: [f64; 34] = [
    -5.73, -5.35, -4.97, -4.59, -4.21, -3.83, -3.45, -3.07, -2.69, -2.31, -1.94, -1.59, -1.33, -1.1, -0.94, -0.88,
    -0.91, -0.99, -1.09, -1.17, -1.3, -1.42, -1.55, -1.67, -1.81, -1.92, -2.06, -2.18, -2.3, -2.42, -2.54, -2.66,
    -2.78, -2.9,
];

/// Slopes d lg H / d lg sigma beyond the ends of the table.
const SLOPES: (f64, f64) = (3.8, -1.2);

/// Offset of lg H for jets with T_t/T_a < 1.1, which includes the exhaust of any tool.
const COLD_JET: f64 = -0.2;

/// lg sigma where H peaks.
const PEAK: f64 = 0.7;

/// lg H of the one-third octave centred at sigma.
fn lg_h(lg_sigma: f64) -> f64 {
    let x = (lg_sigma - START) / STEP;
    let last = (LG_H.len() - 1) as f64;
    let beyond = if x < 0.0 {
        SLOPES.0 * STEP * x
    } else {
        SLOPES.1 * STEP * (x - last).max(0.0)
    };
    COLD_JET + beyond + super::mixing::interpolate(&LG_H, x)
}

/// H per natural logarithm of frequency at f/f_peak; H itself refers to a third octave, 0.1 in lg f.
pub(super) fn shape(ratio: f64) -> f64 {
    10f64.powf(lg_h(PEAK + ratio.log10())) / (STEP * std::f64::consts::LN_10)
}

/// The integral of [`shape`] over ln f; lg H is piecewise linear, so each piece integrates in closed form.
pub(super) fn total() -> f64 {
    let ln10 = std::f64::consts::LN_10;
    let density = |lg: f64| 10f64.powf(COLD_JET + lg) / (STEP * ln10);
    let piece = |pair: &[f64]| {
        let rise = (pair[1] - pair[0]) * ln10;
        let width = STEP * ln10;
        if rise.abs() < 1e-12 {
            width * density(pair[0])
        } else {
            width * density(pair[0]) * rise.exp_m1() / rise
        }
    };
    let tails = density(LG_H[0]) / SLOPES.0 - density(LG_H[LG_H.len() - 1]) / SLOPES.1;
    tails + LG_H.windows(2).map(piece).sum::<f64>()
}

/// Broadband shock noise of underexpanded jets, summed over frequency \[W\]; zero below Mach 1.
///
/// ```text
/// W = 1.92e-3 beta^eta sum(H) rho0 c0^3 A_j         eta = 4 for beta <= 1, 1 above
/// ```
///
/// NASA TM-83199, sec. 8.5, after Harper-Bourne and Fisher (1974), with the cell interference factor taken as 1.
/// `jet_area` is A_j of all jets \[m²\]. The tabulated H is interpreted as a density over frequency, with its integral
/// as the sum.
pub fn shock_power(jet: &Jet, jet_area: f64, air: &Air) -> f64 {
    factor(jet, jet_area, air) * total()
}

/// [`shock_power`] without the factor sum(H).
pub(super) fn factor(jet: &Jet, jet_area: f64, air: &Air) -> f64 {
    let beta2 = jet.beta_squared();
    if beta2 <= 0.0 {
        return 0.0;
    }
    let beta_eta = if beta2 <= 1.0 { beta2 * beta2 } else { beta2.sqrt() };
    1.92e-3 * beta_eta * air.density * air.sound_speed.powi(3) * jet_area
}

/// Frequency of the loudest third octave of the shock noise \[Hz\]; `None` below Mach 1.
///
/// ```text
/// sigma = 7.80 beta sqrt(A_j1) f / c0 = 10^0.7
/// ```
///
/// `one_jet_area` is the area A_j1 of a single jet \[m²\].
pub fn shock_peak_frequency(jet: &Jet, one_jet_area: f64, air: &Air) -> Option<f64> {
    let beta2 = jet.beta_squared();
    (beta2 > 0.0).then(|| 10f64.powf(PEAK) * air.sound_speed / (7.80 * (beta2 * one_jet_area).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_is_the_sum_over_third_octaves() {
        let h: f64 = LG_H.iter().map(|lg| 10f64.powf(lg + COLD_JET)).sum();
        assert!((total() / h - 1.0).abs() < 0.02, "{} {h}", total());
        let (mut sum, n) = (0.0, 20_000);
        for i in 0..n {
            let lg = -4.0 + 12.0 * (f64::from(i) + 0.5) / f64::from(n);
            sum += shape(10f64.powf(lg)) * 12.0 / f64::from(n) * std::f64::consts::LN_10;
        }
        assert!((sum / total() - 1.0).abs() < 1e-5, "{sum} {}", total());
    }
}
