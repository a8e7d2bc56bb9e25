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
//!
//! Where the resistance depends on speed, the parts are those at the nail's speed. An elastic blow replaces the
//! frequencies of F_pen above 2 kHz.

use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_dynamics::Parameters;
use nailnoise_dynamics::blow::{Blow, BlowInput, Course, elastic_blow};
use nailnoise_dynamics::network::FastenerResistance;
use nailnoise_dynamics::network::assembly::Fastener;
use nailnoise_penetration::Envelope;
use nalgebra::DMatrix;
use serde::Serialize;

use crate::result::Check;
use crate::stages::bodies::STATIONS;
use crate::stages::cycle::{OnWorkpiece, ShotRecord};

/// Frequencies between which the force of an elastic blow replaces that of the cycle \[Hz\].
const CROSSOVER: [f64; 2] = [1000.0, 2000.0];

/// A fastener in the work, with the fraction of its resistance at full depth that is friction along the shank.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrivenFastener {
    /// Law of the resistance.
    pub law: FastenerLaw,
    /// Fraction of the resistance at full depth that is friction along the shank.
    pub friction_share: f64,
    /// Elastic blows on the fasteners in the work; those without one are rigid.
    pub blows: Vec<BlowInput>,
}

/// Law of the work's resistance to a fastener.
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
}

enum Curve {
    Nail(Envelope),
    /// With the fraction that is friction along the shank.
    Fastener(FastenerResistance, f64),
}

/// Forces of the fastener on the wood.
#[derive(Debug)]
pub(super) struct FastenerForces {
    /// Downward force at each station: stations x samples \[N\]. Each column sums to F_pen.
    pub(super) stations: DMatrix<f64>,
    /// Checks of elastic blows.
    pub(super) checks: Vec<Check>,
}

/// Forces of a shot's fastener on the wood; `None` if the tool has no workpiece.
pub(super) fn forces(driven: &DrivenFastener, shot: &ShotRecord) -> Option<FastenerForces> {
    let on = shot.workpiece.as_ref()?;
    let resistance = Resistance::of(driven);
    let (force, checks) = penetration(driven, shot, on);
    let mut stations = DMatrix::zeros(STATIONS, force.len());
    for (sample, mut column) in stations.column_iter_mut().enumerate() {
        let depth = on.deepest[sample];
        if force[sample] != 0.0 && depth > 0.0 {
            let parts = resistance.parts(depth, on.fastener_speed.as_ref().map_or(0.0, |speed| speed[sample]));
            resistance.spread(parts, (force[sample], depth), column.as_mut_slice());
        }
    }
    Some(FastenerForces { stations, checks })
}

/// F_pen at the samples of a shot, and the checks of elastic blows.
fn penetration(driven: &DrivenFastener, shot: &ShotRecord, on: &OnWorkpiece) -> (Vec<f64>, Vec<Check>) {
    let (mut force, mut checks) = (on.fastener.clone(), Vec::new());
    for input in &driven.blows {
        let course = Course::of_record(input, &shot.record);
        let blow = course.and_then(|course| Some((elastic_blow(input, &course)?, course)));
        if let Some((blow, course)) = blow {
            let more = above_crossover(&blow, &course);
            force.iter_mut().zip(more).for_each(|(force, more)| *force += more);
            checks.extend(blow.checks);
        }
    }
    (force, checks)
}

/// Difference between the force of an elastic blow and that of its cycle above [`CROSSOVER`].
fn above_crossover(blow: &Blow, course: &Course<'_>) -> Vec<f64> {
    let pairs = blow.on_wood.iter().zip(course.resistance);
    let mut difference: Vec<f64> = pairs.map(|(elastic, rigid)| elastic - rigid).collect();
    high_pass(&mut difference, course.interval);
    difference
}

/// Removes frequencies below [`CROSSOVER`] without a time shift; the pass band begins as a raised cosine over the
/// logarithm of frequency.
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

impl Resistance {
    pub(super) fn of(driven: &DrivenFastener) -> Self {
        match &driven.law {
            FastenerLaw::Nail(parameters) => Self {
                curve: Curve::Nail(parameters.penetration_envelope()),
                length: parameters.nail.length,
            },
            FastenerLaw::Fastener(fastener) => Self {
                curve: Curve::Fastener(FastenerResistance::of(fastener), driven.friction_share),
                length: fastener.length,
            },
        }
    }

    /// Friction along the shank, force of the tip and force under the head \[N\], of a fastener that moves into the
    /// wood at `speed` \[m/s\].
    fn parts(&self, depth: f64, speed: f64) -> [f64; 3] {
        match &self.curve {
            Curve::Nail(envelope) => envelope.parts(depth, speed, envelope.usual_impact()),
            Curve::Fastener(resistance, friction_share) => resistance.parts(depth, speed, *friction_share),
        }
    }

    /// Fractions of F_pen at the stations for a tip depth of a resting fastener; before the tip enters the wood, all of
    /// it acts at the surface.
    pub(super) fn shares(&self, depth: f64) -> [f64; STATIONS] {
        let mut shares = [0.0; STATIONS];
        if depth <= 0.0 {
            shares[0] = 1.0;
            return shares;
        }
        let parts = self.parts(depth, 0.0);
        if parts.iter().sum::<f64>() > 0.0 {
            self.spread(parts, (1.0, depth), &mut shares);
        } else {
            shares[0] = 1.0;
        }
        shares
    }

    /// Adds a force at a tip depth to the stations. The forces of shank, tip and head have the ratios of
    /// `parts`.
    fn spread(&self, parts: [f64; 3], (force, depth): (f64, f64), stations: &mut [f64]) {
        let [shank, tip, head] = parts;
        let scale = force / (shank + tip + head);
        stations[0] += scale * head;
        let position = depth.min(self.length) / self.length * (STATIONS - 1) as f64;
        for (k, weight) in uniform(position) {
            stations[k] += scale * shank * weight;
        }
        let below = (position.floor() as usize).min(STATIONS - 2);
        let upper = position - below as f64;
        stations[below] += scale * tip * (1.0 - upper);
        stations[below + 1] += scale * tip * upper;
    }
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
