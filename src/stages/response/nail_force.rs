//! The forces of the nail on the wood, distributed over stations along its axis.
//!
//! The cycle gives one force F_pen. In the wood, there are three: friction along the embedded shank, a force at the tip
//! that wedges the fibres apart and, once the head meets the surface, a force below the head. With the deepest tip
//! depth z, the nail's length l_n, the penetration law F_r and the stiffness k_w below the head, the envelope is
//!
//! ```text
//! E(z) = F_r(z) + k_w max(0, z - l_n),     shank S(z) = phi F_r(l_n) z/l_n  (at most F_r(z)),     tip = F_r(z) - S(z)
//! ```
//!
//! S is linear in depth and reaches the fraction phi of F_r at full depth, from the published second drive into the
//! same hole (Nili Ahmadabadi 2016, sec. 2.4.3: 81 % for a smooth 6d nail in poplar plywood). While the nail is
//! unloaded (F_pen < E) all parts shrink in proportion.

use nailnoise_dynamics::{CycleRecord, Parameters};
use nailnoise_penetration::Envelope;
use nalgebra::DMatrix;

use crate::stages::bodies::STATIONS;

/// Downward force on the wood at each station: stations x samples \[N\]. Each column sums to F_pen.
pub(super) fn forces(parameters: &Parameters, friction_share: f64, record: &CycleRecord) -> DMatrix<f64> {
    let length = parameters.nail.length;
    let envelope = parameters.penetration_envelope();
    let full_friction = friction_share * envelope.shank(length);
    let mut forces = DMatrix::zeros(STATIONS, record.len());
    for (sample, mut column) in forces.column_iter_mut().enumerate() {
        let force = record.forces.penetration[sample];
        let depth = record.motion.nail_depth[sample];
        if force > 0.0 && depth > 0.0 {
            spread(&envelope, length, full_friction, (force, depth), column.as_mut_slice());
        }
    }
    forces
}

/// Fractions of F_pen at the stations for a tip depth; before the tip enters the wood, all of it acts at the surface.
pub(super) fn shares(envelope: &Envelope, length: f64, friction_share: f64, depth: f64) -> [f64; STATIONS] {
    let mut shares = [0.0; STATIONS];
    if depth > 0.0 && envelope.shank(depth) + envelope.head(depth) > 0.0 {
        let full_friction = friction_share * envelope.shank(length);
        spread(envelope, length, full_friction, (1.0, depth), &mut shares);
    } else {
        shares[0] = 1.0;
    }
    shares
}

/// Adds a force at a tip depth to the stations.
fn spread(envelope: &Envelope, length: f64, full_friction: f64, (force, depth): (f64, f64), stations: &mut [f64]) {
    let embedded = depth.min(length);
    let (law, head) = (envelope.shank(depth), envelope.head(depth));
    let shank = (full_friction * embedded / length).min(law);
    let scale = force / (law + head);
    stations[0] += scale * head;
    let position = embedded / length * (STATIONS - 1) as f64;
    for (k, weight) in uniform(position) {
        stations[k] += scale * shank * weight;
    }
    let below = (position.floor() as usize).min(STATIONS - 2);
    let upper = position - below as f64;
    stations[below] += scale * (law - shank) * (1.0 - upper);
    stations[below + 1] += scale * (law - shank) * upper;
}

/// A uniform load with total 1 from station 0 to `position` (in stations), lumped by linear interpolation.
fn uniform(position: f64) -> impl Iterator<Item = (usize, f64)> {
    let share = move |k: usize| {
        // Integral of the hat function of station k from its foot to x, both in stations.
        let rising = |x: f64| 0.5 * x.clamp(0.0, 1.0).powi(2);
        let x = position - k as f64;
        let left = if k == 0 { 0.0 } else { rising(x + 1.0) };
        let right = x.clamp(0.0, 1.0) - rising(x);
        (left + right) / position
    };
    (0..STATIONS)
        .map(move |k| (k, share(k)))
        .filter(|&(_, weight)| weight > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_load_keeps_its_total_and_its_centre() {
        for position in [1e-6, 0.3, 1.0, 2.5, 7.75, (STATIONS - 1) as f64] {
            let load: Vec<_> = uniform(position).collect();
            let total: f64 = load.iter().map(|l| l.1).sum();
            let moment: f64 = load.iter().map(|l| l.0 as f64 * l.1).sum();
            assert!((total - 1.0).abs() < 1e-12, "{position}: {total}");
            assert!((moment - 0.5 * position).abs() < 1e-12, "{position}: {moment}");
        }
    }
}
