use super::jet::Jet;
use super::opening::FlowHistory;
use crate::air::Air;
use serde::{Deserialize, Serialize};
use std::f64::consts::SQRT_2;

/// Coefficients of the valve-noise cross-check.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ValveNoise {
    /// Liquid pressure recovery factor F_L; 1 for holes that discharge without recovery.
    pub recovery: f64,
    /// Acoustic power ratio r_w; 1 for a free discharge, below it inside a pipe.
    pub power_ratio: f64,
}

impl Default for ValveNoise {
    fn default() -> Self {
        Self {
            recovery: 1.0,
            power_ratio: 1.0,
        }
    }
}

/// Sound energy \[J\] of a flow by the acoustic efficiencies of IEC 60534-8-3: another estimate of the jet noise.
///
/// ```text
/// W = r_w F_L^2 eta W_m       W_m = m' U^2/2, U at the vena contracta, at most sonic
/// eta = 1e-4 M^3.6                           M <= 1
///       1e-4 M_j^(6.6 F_L^2)                 M_j <= sqrt 2
///       1e-4 (M_j^2/2) sqrt2^(6.6 F_L^2)     above
/// ```
pub fn valve_noise_energy(history: &FlowHistory, air: &Air, valve: &ValveNoise) -> f64 {
    let fl2 = valve.recovery * valve.recovery;
    let power = |(sample, ((&flow, &pressure), &temperature)): (usize, ((&f64, &f64), &f64))| {
        let Some(jet) = Jet::expand(pressure, temperature, &history.surroundings(sample, air)).filter(|_| flow > 0.0)
        else {
            return 0.0;
        };
        let g = air.heat_ratio;
        let sonic2 = 2.0 * g / (g + 1.0) * air.gas_constant * temperature;
        let (speed2, eta) = match jet.mach {
            m if m <= 1.0 => (jet.velocity * jet.velocity, 1e-4 * m.powf(3.6)),
            m if m <= SQRT_2 => (sonic2, 1e-4 * m.powf(6.6 * fl2)),
            m => (sonic2, 1e-4 * 0.5 * m * m * SQRT_2.powf(6.6 * fl2)),
        };
        valve.power_ratio * fl2 * eta * 0.5 * flow * speed2
    };
    let samples = history
        .mass_flow
        .iter()
        .zip(&history.pressure)
        .zip(&history.temperature)
        .enumerate();
    samples.map(power).sum::<f64>() * history.sample_interval
}
