//! Absolute tolerance of each state.

use super::mode::Mode;
use super::state::*;
use super::system::System;

/// Size of quantities without an error weight: the integrals, the hand if massless, the wood if its motion is
/// prescribed.
const UNWEIGHTED: f64 = 1e30;

/// Absolute tolerances: every state has a characteristic size, and its error is limited to the relative tolerance times
/// that size.
///
/// Relative weights would not work: a nose contact of 5e8 N/m needs the position of the body to 1e-10 m wherever it is,
/// and a gas energy of 1 kJ must not loosen that of 1 J.
pub(crate) fn tolerances(system: &System, mode: &Mode, relative: f64) -> Vec<f64> {
    let p = &system.p;
    let mut size = [UNWEIGHTED; SIZE];
    size[Y_P] = 1e-2;
    size[V_P] = 10.0;
    size[Y_H] = 1e-3;
    size[V_H] = 5.0;
    size[Y_G] = 1e-4;
    size[V_G] = 0.5;
    if mode.wood.is_none() {
        size[Y_W] = 1e-4;
        size[V_W] = 0.5;
    }
    if system.sprung_hand {
        size[Y_M] = 1e-3;
        size[V_M] = 0.5;
    }
    let c = &p.chambers;
    let volumes = [
        c.above_piston,
        c.below_piston,
        c.return_volume,
        c.above_valve,
        c.supply_volume,
    ];
    for (i, volume) in volumes.into_iter().enumerate() {
        size[ENERGY + i] = p.supply.pressure * volume / (system.air.gamma - 1.0);
        size[MASS + i] = p.supply.pressure * volume / (system.air.gas_constant * p.ambient.temperature);
    }
    // The solver's norm is a mean over all entries, so those without an error weight must be excluded from it.
    let weighted = size.iter().filter(|size| **size < UNWEIGHTED).count();
    let share = (weighted as f64 / SIZE as f64).sqrt();
    size.iter().map(|size| relative * size * share).collect()
}
