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

use nailnoise_dynamics::Parameters;
use nailnoise_dynamics::network::FastenerResistance;
use nailnoise_dynamics::network::assembly::Fastener;
use nailnoise_penetration::Envelope;
use nalgebra::DMatrix;
use serde::Serialize;

use crate::stages::bodies::STATIONS;
use crate::stages::cycle::OnWorkpiece;

/// A fastener in the work, and the share of its resistance at full depth that is friction along the shank.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrivenFastener {
    /// What gives the resistance.
    pub law: FastenerLaw,
    /// Share of the resistance at full depth that is friction along the shank.
    pub friction_share: f64,
}

/// What gives the resistance of the work to a fastener.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum FastenerLaw {
    /// The nail of a design's keys.
    Nail(Box<Parameters>),
    /// A fastener of an assembly.
    Fastener(Fastener),
}

/// Evaluates the resistance to a fastener.
pub(super) struct Resistance {
    curve: Curve,
    length: f64,
    full_friction: f64,
}

enum Curve {
    Nail(Envelope),
    Fastener(FastenerResistance),
}

impl Resistance {
    pub(super) fn of(driven: &DrivenFastener) -> Self {
        let (curve, length) = match &driven.law {
            FastenerLaw::Nail(parameters) => (Curve::Nail(parameters.penetration_envelope()), parameters.nail.length),
            FastenerLaw::Fastener(fastener) => (Curve::Fastener(FastenerResistance::of(fastener)), fastener.length),
        };
        let mut resistance = Self {
            curve,
            length,
            full_friction: 0.0,
        };
        resistance.full_friction = driven.friction_share * resistance.shank(length);
        resistance
    }

    fn shank(&self, depth: f64) -> f64 {
        match &self.curve {
            Curve::Nail(envelope) => envelope.shank(depth),
            Curve::Fastener(resistance) => resistance.shank(depth),
        }
    }

    fn head(&self, depth: f64) -> f64 {
        match &self.curve {
            Curve::Nail(envelope) => envelope.head(depth),
            Curve::Fastener(resistance) => resistance.head(depth),
        }
    }
}

/// Downward force on the wood at each station: stations x samples \[N\]. Each column sums to F_pen.
pub(super) fn forces(driven: &DrivenFastener, on: &OnWorkpiece) -> DMatrix<f64> {
    let resistance = Resistance::of(driven);
    let mut forces = DMatrix::zeros(STATIONS, on.fastener.len());
    for (sample, mut column) in forces.column_iter_mut().enumerate() {
        let (force, depth) = (on.fastener[sample], on.deepest[sample]);
        if force > 0.0 && depth > 0.0 {
            resistance.spread(force, depth, column.as_mut_slice());
        }
    }
    forces
}

impl Resistance {
    /// Shares of the stations in F_pen with the tip at a depth; all of it acts at the surface before it is in.
    pub(super) fn shares(&self, depth: f64) -> [f64; STATIONS] {
        let mut shares = [0.0; STATIONS];
        if depth > 0.0 && self.shank(depth) + self.head(depth) > 0.0 {
            self.spread(1.0, depth, &mut shares);
        } else {
            shares[0] = 1.0;
        }
        shares
    }

    /// Adds a force with the tip at a depth to the stations.
    fn spread(&self, force: f64, depth: f64, stations: &mut [f64]) {
        let embedded = depth.min(self.length);
        let (law, head) = (self.shank(depth), self.head(depth));
        let shank = (self.full_friction * embedded / self.length).min(law);
        let scale = force / (law + head);
        stations[0] += scale * head;
        let position = embedded / self.length * (STATIONS - 1) as f64;
        for (k, weight) in uniform(position) {
            stations[k] += scale * shank * weight;
        }
        let below = (position.floor() as usize).min(STATIONS - 2);
        let upper = position - below as f64;
        stations[below] += scale * (law - shank) * (1.0 - upper);
        stations[below + 1] += scale * (law - shank) * upper;
    }
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
