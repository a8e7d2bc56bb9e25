//! The nail's forces on the wood, spread over stations along its axis.
//!
//! The cycle gives one force F_pen. In the wood there are three: friction along the embedded shank, a force of the tip
//! that wedges the fibres apart, and, once the head meets the surface, a force under the head. With z the deepest tip
//! depth, l_n the nail's length, F_r the penetration law and k_w the stiffness under the head, the envelope is
//!
//! ```text
//! E(z) = F_r(z) + k_w max(0, z - l_n),     shank S(z) = phi F_r(l_n) z/l_n  (at most F_r(z)),     tip = F_r(z) - S(z)
//! ```
//!
//! S is linear in depth and reaches the share phi of F_r at full depth: the published second drive into the same hole
//! (Nili Ahmadabadi 2016, sec. 2.4.3: 81 % for a smooth 6d nail in poplar plywood). While the nail is unloaded
//! (F_pen < E) all parts shrink in proportion.
//!
//! Where the resistance depends on speed, the parts are those at the nail's speed. An elastic blow replaces the
//! frequencies of F_pen above 2 kHz.

use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_dynamics::blow::elastic_blow;
use nailnoise_dynamics::{BlowModel, CycleRecord, Parameters};
use nailnoise_penetration::{Envelope, RateLaw};
use nalgebra::DMatrix;

use crate::result::Check;
use crate::stages::bodies::STATIONS;

/// Frequencies between which the force of an elastic blow replaces that of the cycle \[Hz\].
const CROSSOVER: [f64; 2] = [1000.0, 2000.0];

/// Forces of the nail on the wood.
#[derive(Debug)]
pub(super) struct NailForces {
    /// Downward force at each station: stations x samples \[N\]. Each column sums to F_pen.
    pub(super) stations: DMatrix<f64>,
    /// Checks of an elastic blow.
    pub(super) checks: Vec<Check>,
}

/// Forces of the nail of a cycle on the wood.
pub(super) fn forces(parameters: &Parameters, record: &CycleRecord) -> NailForces {
    let length = parameters.nail.length;
    let envelope = parameters.penetration_envelope();
    let (force, checks) = penetration(parameters, record);
    let mut stations = DMatrix::zeros(STATIONS, record.len());
    for (sample, mut column) in stations.column_iter_mut().enumerate() {
        let depth = record.motion.nail_depth[sample];
        if force[sample] != 0.0 && depth > 0.0 {
            let speed = match parameters.wood.rate {
                RateLaw::None => 0.0,
                RateLaw::Speed => (record.piston.velocity[sample] - record.workpiece.velocity[sample]).max(0.0),
            };
            let parts = envelope.parts(depth, speed, envelope.usual_impact());
            spread(parts, length, (force[sample], depth), column.as_mut_slice());
        }
    }
    NailForces { stations, checks }
}

/// F_pen at the samples of a cycle.
fn penetration(parameters: &Parameters, record: &CycleRecord) -> (Vec<f64>, Vec<Check>) {
    let rigid = &record.forces.penetration;
    let blow = match parameters.model.blow {
        BlowModel::Rigid => None,
        BlowModel::Elastic => elastic_blow(parameters, record),
    };
    let Some(blow) = blow else {
        return (rigid.clone(), Vec::new());
    };
    let mut difference: Vec<f64> = blow
        .on_wood
        .iter()
        .zip(rigid)
        .map(|(elastic, rigid)| elastic - rigid)
        .collect();
    high_pass(&mut difference, record.sample_interval);
    let force = rigid
        .iter()
        .zip(&difference)
        .map(|(rigid, more)| rigid + more)
        .collect();
    (force, blow.checks)
}

/// Removes what lies below [`CROSSOVER`] without a shift in time; the pass band begins as a raised cosine over the
/// logarithm of the frequency.
fn high_pass(signal: &mut [f64], interval: f64) {
    let transform = RealTransform::new(2 * signal.len().next_power_of_two());
    let df = 1.0 / (interval * transform.length() as f64);
    let mut lines = transform.lines(signal);
    for (k, line) in lines.iter_mut().enumerate() {
        let octave = (k as f64 * df / CROSSOVER[0]).log2() / (CROSSOVER[1] / CROSSOVER[0]).log2();
        *line *= (0.5 * std::f64::consts::PI * octave.clamp(0.0, 1.0)).sin().powi(2);
    }
    let filtered = transform.signal(lines);
    signal.copy_from_slice(&filtered[..signal.len()]);
}

/// Shares of the stations in F_pen with the tip of a resting nail at a depth; all of it acts at the surface before it
/// is in.
pub(super) fn shares(envelope: &Envelope, length: f64, depth: f64) -> [f64; STATIONS] {
    let mut shares = [0.0; STATIONS];
    let parts = envelope.parts(depth, 0.0, envelope.usual_impact());
    if parts.iter().sum::<f64>() > 0.0 {
        spread(parts, length, (1.0, depth), &mut shares);
    } else {
        shares[0] = 1.0;
    }
    shares
}

/// Adds a force with the tip at a depth to the stations. The forces of shank, tip and head have the ratios of `parts`.
fn spread(parts: [f64; 3], length: f64, (force, depth): (f64, f64), stations: &mut [f64]) {
    let [shank, tip, head] = parts;
    let scale = force / (shank + tip + head);
    stations[0] += scale * head;
    let position = depth.min(length) / length * (STATIONS - 1) as f64;
    for (k, weight) in uniform(position) {
        stations[k] += scale * shank * weight;
    }
    let below = (position.floor() as usize).min(STATIONS - 2);
    let upper = position - below as f64;
    stations[below] += scale * tip * (1.0 - upper);
    stations[below + 1] += scale * tip * upper;
}

/// A uniform load from station 0 to `position` (in stations) of total 1, lumped by linear interpolation.
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
    fn the_crossover_passes_5_khz_and_removes_500_hz() {
        let interval = 4e-6;
        let tone = |hz: f64| -> Vec<f64> {
            (0..8192)
                .map(|n| {
                    let t = f64::from(n) * interval;
                    let window = (std::f64::consts::PI * t / (8192.0 * interval)).sin().powi(2);
                    window * (2.0 * std::f64::consts::PI * hz * t).sin()
                })
                .collect()
        };
        let energy = |signal: &[f64]| signal.iter().map(|x| x * x).sum::<f64>();
        for (hz, expected) in [(500.0, 0.0), (5000.0, 1.0)] {
            let mut signal = tone(hz);
            let before = energy(&signal);
            high_pass(&mut signal, interval);
            assert!((energy(&signal) / before - expected).abs() < 1e-4, "{hz} Hz");
        }
    }

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
