use super::jet::Jet;
use crate::air::Air;
use std::ops::RangeInclusive;

/// Range of lg(U_j/c0) for which the correlation is valid.
pub const MIXING_RANGE: RangeInclusive<f64> = -0.4..=0.4;

/// First lg V* of both tables, and their step.
const START: f64 = -0.45;
const STEP: f64 = 0.05;

/// Density exponent omega at lg V* = -0.45 (0.05) 0.60.
const OMEGA: [f64; 22] = [
    -1.0, -0.9, -0.76, -0.58, -0.41, -0.22, 0.0, 0.22, 0.5, 0.77, 1.07, 1.39, 1.74, 1.95, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0,
    2.0, 2.0,
];

/// lg of the power deviation factor P at lg V* = -0.45 (0.05) 0.40.
const LG_P: [f64; 18] = [
    -0.13, -0.13, -0.13, -0.13, -0.13, -0.13, -0.12, -0.1, -0.05, 0.0, 0.1, 0.21, 0.32, 0.41, 0.43, 0.41, 0.31, 0.14,
];

/// Turbulent mixing noise of subsonic or fully expanded jets \[W\].
///
/// ```text
/// W = 6.67e-5 rho*^omega V*^8 P(V*) rho0 c0^3 A_j        V* = U_j/c0,  rho* = rho_j/rho0
/// ```
///
/// SAE ARP876 in the form of NASA TM-83199, sec. 8.4. `jet_area` is A_j of all jets \[m²\]. Outside [`MIXING_RANGE`],
/// omega and P are constant, so that W ~ U^8 at low speeds.
pub fn mixing_power(jet: &Jet, jet_area: f64, air: &Air) -> f64 {
    let v = jet.velocity / air.sound_speed;
    let lg_v = v.log10();
    let omega = interpolate(&OMEGA, (lg_v - START) / STEP);
    let lg_p = interpolate(&LG_P, (lg_v - START) / STEP);
    let lg_density = (jet.density / air.density).log10();
    let deviation = 10f64.powf(omega * lg_density + lg_p);
    6.67e-5 * deviation * v.powi(8) * air.density * air.sound_speed.powi(3) * jet_area
}

/// Linear interpolation at the fractional index `x`, constant beyond the ends.
pub(super) fn interpolate(table: &[f64], x: f64) -> f64 {
    let x = x.clamp(0.0, (table.len() - 1) as f64);
    let i = (x as usize).min(table.len() - 2);
    table[i] + (x - i as f64) * (table[i + 1] - table[i])
}
