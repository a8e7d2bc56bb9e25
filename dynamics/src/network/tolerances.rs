//! Absolute tolerance of each state.

use super::plan::Plan;

/// Size of the integrals, which have no error weight.
const UNWEIGHTED: f64 = 1e30;

/// Absolute tolerances: every state has a characteristic size, and its error is limited to the relative tolerance times
/// that size.
///
/// Relative weights would not work. A contact of 5e8 N/m needs the position of the body to 1e-10 m at every travel. A
/// gas energy of 1 kJ must not relax the tolerance of one of 1 J. The characteristic size of a gas is that of its dead
/// volume at the highest pressure of the assembly.
pub(crate) fn tolerances(plan: &Plan, relative: f64) -> Vec<f64> {
    let a = &plan.assembly;
    let mut size = vec![UNWEIGHTED; plan.size()];
    for (body, described) in a.bodies.iter().enumerate() {
        size[2 * body] = described.weights.position;
        size[2 * body + 1] = described.weights.velocity;
    }
    let pressures = a
        .volumes
        .iter()
        .map(|v| v.pressure)
        .chain(a.reservoirs.iter().map(|r| r.pressure));
    let pressure = pressures.fold(0.0, f64::max);
    let ambient = a
        .reservoirs
        .iter()
        .find(|r| r.name == "atmosphere")
        .map(|r| r.temperature);
    for (i, volume) in a.volumes.iter().enumerate() {
        let energy = pressure * volume.dead;
        size[plan.energy() + i] = energy / (plan.gamma - 1.0);
        size[plan.mass() + i] = energy / (plan.gas_constant * ambient.unwrap_or(volume.temperature));
    }
    let mut weighted = plan.states();
    if let Some(driven) = &plan.driven {
        // The motion of a driven body is prescribed.
        size[2 * driven.body..2 * driven.body + 2].fill(UNWEIGHTED);
        weighted -= 2;
    }
    // The solver's norm is a mean over all entries, so those without an error weight must be excluded from it.
    // Without bodies and volumes no entry has a weight.
    let share = (weighted.max(1) as f64 / plan.size().max(1) as f64).sqrt();
    size.iter().map(|size| relative * size * share).collect()
}
