//! The blow of a driver on a fastener as waves in elastic bars.
//!
//! The cycle has a single moving mass. In addition, the driver's rod and the fastener, a nail or staple, are modelled
//! as elastic bars from the impact until shortly after the nail stops. The rest of the driver's mass, as a piston, is
//! at the upper end of the rod. The forces of the cycle on the driver, without gravity and the resistance F of the
//! wood, act on this mass. They are m (a - g) + F, with the moving mass m and the acceleration a of the cycle. Rod and
//! nail touch without tension, and the wood grips the nail's elements, its tip and its head. The limits of the grips
//! sum to the resistance of the cycle's law at the nail's local speed.
//!
//! ```text
//! along the shank:  limit f_shank dx,   Z = 2 pi r rho c_s dx               (M. Novak, Can. Geotech. J. 11, 574, 1974)
//! tip and head:     limit f_tip, f_head,  Z = 3.4 a^2 rho c_s/(1 - nu), nu = 0.4, a the radius       (J. Lysmer, 1965)
//! ```
//!
//! After the first contact the nail runs ahead of the rod, the wood slows it, and the rod strikes it again. This occurs
//! some tens of times in a shot. The times of the last strikes depend on details. If the number of elements changes,
//! third octaves of the force change by less than 1 dB up to 3.15 kHz, by up to 3 dB at 4 kHz and by up to 10 dB from
//! 6.3 kHz upwards.
//!
//! The grips share the unloading stiffness k_u of the cycle in proportion to their limits, so that a rigid nail unloads
//! as in the cycle.

mod bar;
mod course;
mod grip;
mod input;

pub use bar::{Bar, EndContact, advance};
pub use course::{Course, DriverMotion, WorkMotion};
pub use input::BlowInput;

use std::f64::consts::PI;

use grip::{Grip, GripLaw};
use nailnoise_quantities::Check;

use crate::network::FastenerResistance;
use crate::network::assembly::ElasticBlow;
use course::Sampled;

/// c dt/h of the nail's elements; the viscosity lowers the limit of stability to 0.82.
const COURANT: f64 = 0.7;

/// Time from the nail's stop to the end of the integration of the bars, and the final part of this time, when the force
/// returns to that of the cycle \[s\].
const AFTER_STOP: [f64; 2] = [1e-3, 0.3e-3];

/// 3.4/(1 - nu) of a disc on an elastic half-space, for a Poisson's ratio of 0.4.
const LYSMER: f64 = 3.4 / 0.6;

/// Largest relative error of momentum and energy.
const BALANCE: f64 = 1e-6;

/// Forces of an elastic blow, at the samples of the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Blow {
    /// Force of the fastener on the wood \[N\], averaged over the interval around each sample; outside the time of the
    /// blow, that of the cycle.
    pub on_wood: Vec<f64>,
    /// Force between rod and fastener \[N\].
    pub rod_on_nail: Vec<f64>,
    /// First and last sample of the blow.
    pub samples: [usize; 2],
    /// Impulse on the wood until the deepest point of the nail: with elastic bars, and in the cycle \[N s\].
    pub impulses: [f64; 2],
    /// Number of contacts of rod and nail.
    pub contacts: usize,
    /// Balances of momentum and energy.
    pub checks: Vec<Check>,
}

/// Computes the blow of a shot from its cycle; `None` if the driver never strikes the fastener or the fastener does not
/// stop in the wood.
pub fn elastic_blow(input: &BlowInput, course: &Course<'_>) -> Option<Blow> {
    let stop = course.stop(input.fastener.tip_at)?;
    let (start, interval) = (course.strike, course.interval);
    let first = (start / interval).ceil() as usize;
    let [after, fade] = AFTER_STOP;
    let last = (((stop + after) / interval) as usize).min(course.len().checked_sub(2)?);
    let mut run = BlowIntegration::new(input, course);
    let mut on_wood = course.resistance.to_vec();
    let mut rod_on_nail = vec![0.0; course.len()];
    let (mut impulse, mut from) = (0.0, start);
    for sample in first..=last {
        let end = (sample as f64 + 0.5) * interval;
        let mean = run.until(end);
        let remaining = ((stop + after - end) / fade).clamp(0.0, 1.0);
        let weight = (0.5 * PI * remaining).sin().powi(2);
        on_wood[sample] += weight * (mean.on_wood - on_wood[sample]);
        rod_on_nail[sample] = mean.rod_on_nail;
        // The last step of the bars passes the end of an interval, so the averaged duration differs from the interval.
        impulse += course.resistance[sample] * (end.min(stop) - from.min(stop));
        from = end;
    }
    Some(Blow {
        on_wood,
        rod_on_nail,
        samples: [first, last],
        impulses: [run.impulse_at_deepest, impulse],
        contacts: run.contacts,
        checks: run.checks(),
    })
}

/// Averages over a period of time.
struct Means {
    on_wood: f64,
    rod_on_nail: f64,
}

/// The moving bars.
struct BlowIntegration<'a> {
    input: &'a BlowInput,
    course: &'a Course<'a>,
    resistance: FastenerResistance,
    /// Forces of the cycle on the driver without those of the wood and gravity, at its samples \[N\].
    push: Vec<f64>,
    /// Speed of the rod in the wood at the impact \[m/s\].
    impact: f64,
    piston: Bar,
    nail: Bar,
    contact: EndContact,
    /// The grips along the shank, then those of the tip and the head.
    grips: Vec<Grip>,
    /// Depth of the tip in the wood at the start \[m\].
    depth: f64,
    /// Position of the wood at the start \[m\].
    wood: f64,
    deepest: f64,
    time: f64,
    dt: f64,
    contacts: usize,
    /// Impulse of all external forces so far \[N s\].
    impulse: f64,
    /// Impulse on the wood so far, and at the deepest point \[N s\].
    impulse_on_wood: f64,
    impulse_at_deepest: f64,
    initial_momentum: f64,
    initial_energy: f64,
}

impl<'a> BlowIntegration<'a> {
    fn new(input: &'a BlowInput, course: &'a Course<'a>) -> Self {
        let ElasticBlow { rod, shank, .. } = &input.bars;
        let (start, speed) = (course.strike, course.speed);
        let element = shank.length / input.elements as f64;
        let elements = rod.length / element * shank.wave_speed() / rod.wave_speed();
        let mut piston = Bar::new(rod, (elements as usize).max(1), speed);
        piston.mass[0] += input.driver_mass - rod.mass();
        let at = Sampled::new(course, start);
        let mut nail = Bar::new(shank, input.elements, at.of_base(course.guide));
        nail.mass[0] += (input.fastener.mass - shank.mass()).max(0.0);
        let dt = COURANT * element / shank.wave_speed();
        let wood = at.of_base(course.work.map(|work| work.position));
        Self {
            resistance: FastenerResistance::of(&input.fastener),
            push: course.push(input.gravity),
            impact: speed - at.of_base(course.work.map(|work| work.velocity)),
            depth: at.of(course.driver.position) - wood - input.fastener.tip_at,
            wood,
            initial_momentum: piston.momentum() + nail.momentum(),
            initial_energy: piston.energy(dt) + nail.energy(dt),
            grips: vec![Grip::default(); input.elements + 3],
            dt,
            contact: EndContact::default(),
            deepest: 0.0,
            time: start,
            contacts: 0,
            impulse: 0.0,
            impulse_on_wood: 0.0,
            impulse_at_deepest: 0.0,
            piston,
            nail,
            input,
            course,
        }
    }

    /// Steps to a time and returns the averages over this period.
    fn until(&mut self, end: f64) -> Means {
        let (from, mut wood, mut rod) = (self.time, 0.0, 0.0);
        while self.time < end {
            wood += self.step() * self.dt;
            rod += self.contact.force * self.dt;
        }
        let duration = self.time - from;
        let mean = |impulse: f64| if duration > 0.0 { impulse / duration } else { 0.0 };
        Means {
            on_wood: mean(wood),
            rod_on_nail: mean(rod),
        }
    }

    /// Advances by one step and returns the force on the wood.
    fn step(&mut self) -> f64 {
        let at = Sampled::new(self.course, self.time);
        let push = at.of(&self.push);
        for bar in [&mut self.piston, &mut self.nail] {
            for (load, mass) in bar.load.iter_mut().zip(&bar.mass) {
                *load = mass * self.input.gravity;
            }
        }
        self.piston.load[0] += push;
        let work = self.course.work;
        let wood = at.of_base(work.map(|work| work.position)) - self.wood;
        let on_wood = self.grip(wood, at.of_base(work.map(|work| work.velocity)));
        let ElasticBlow { rod, shank, .. } = &self.input.bars;
        for (bar, rod) in [(&mut self.piston, rod), (&mut self.nail, shank)] {
            bar.add_damping(self.input.viscosity * rod.density * rod.wave_speed() * rod.area);
        }
        let loads = self.piston.load.iter().chain(&self.nail.load);
        self.impulse += self.dt * loads.sum::<f64>();
        let touching = self.contact.force > 0.0;
        advance(&mut self.piston, &mut self.nail, &mut self.contact, self.dt);
        self.contacts += usize::from(self.contact.force > 0.0 && !touching);
        self.impulse_on_wood += self.dt * on_wood;
        self.time += self.dt;
        on_wood
    }

    /// Loads the nail with the forces of the wood, which has moved by `moved` \[m\] since the start, and returns their
    /// sum.
    fn grip(&mut self, moved: f64, speed: f64) -> f64 {
        let tip = self.nail.last();
        let z = self.depth + self.nail.displacement[tip] - moved;
        if z > self.deepest {
            (self.deepest, self.impulse_at_deepest) = (z, self.impulse_on_wood);
        }
        if z <= 0.0 {
            return 0.0;
        }
        let (bars, shank) = (&self.input.bars, self.input.bars.shank);
        let element = shank.length / tip as f64;
        let impedance = bars.wood_density * bars.shear_speed;
        let parts = |speed: f64| {
            let resistance = &self.resistance;
            resistance.parts_after(self.impact, self.deepest, speed, self.input.friction_share)
        };
        let [friction, point, head] = parts(0.0);
        let total = friction + point + head;
        if total <= 0.0 {
            return 0.0;
        }
        // Embedded lengths of the nodes; the tip's node has half an element above it, and the head's node half an
        // element below.
        let embedded = |node: usize| {
            let above = if node == tip { 0.0 } else { 0.5 * element };
            let below = if node == 0 { 0.0 } else { 0.5 * element };
            let depth = self.depth + self.nail.displacement[node] - moved - (tip - node) as f64 * element;
            let (upper, lower) = (depth - below, depth + above);
            (lower.min(shank.length) - upper.max(0.0)).max(0.0)
        };
        let lengths: Vec<f64> = (0..=tip).map(embedded).collect();
        let whole: f64 = lengths.iter().sum();
        let disc = |area: f64| LYSMER * area / PI * impedance;
        let speeds: Vec<f64> = self.nail.velocity.iter().map(|v| v - speed).collect();
        let moving = |node: usize| parts(speeds[node].abs());
        let mut held = Vec::with_capacity(tip + 3);
        for (node, length) in lengths.iter().enumerate() {
            let part = if whole > 0.0 { length / whole } else { 0.0 };
            let limit = if part > 0.0 { part * moving(node)[0] } else { 0.0 };
            held.push((node, limit, part * friction, bars.perimeter * impedance * length));
        }
        held.push((tip, moving(tip)[1], point, disc(shank.area)));
        held.push((0, head, head, disc(bars.head_area)));
        let share = self.input.fastener.seated.unloading / total;
        let mut sum = 0.0;
        for (grip, (node, limit, resting, dashpot)) in self.grips.iter_mut().zip(held) {
            let law = GripLaw {
                limit,
                stiffness: share * resting,
                dashpot,
            };
            let force = grip.force(&law, speeds[node], self.dt);
            self.nail.load[node] -= force;
            sum += force;
        }
        sum
    }

    /// Balances of momentum and energy.
    fn checks(&self) -> Vec<Check> {
        let momentum = self.piston.momentum() + self.nail.momentum() - self.initial_momentum - self.impulse;
        let energy = self.piston.energy(self.dt) + self.nail.energy(self.dt) + self.contact.loss
            - self.initial_energy
            - self.piston.work
            - self.nail.work;
        vec![
            Check::at_most(
                "elastic blow: imbalance of momentum over the momentum at the impact",
                momentum.abs() / self.initial_momentum.abs(),
                BALANCE,
            ),
            Check::at_most(
                "elastic blow: imbalance of energy over the energy at the impact",
                energy.abs() / self.initial_energy,
                BALANCE,
            ),
        ]
    }
}
