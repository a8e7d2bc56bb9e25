//! The blow of the rod on the nail as waves in elastic bars.
//!
//! The cycle has a single moving mass. In addition, rod and nail are modelled as elastic bars from the impact until
//! shortly after the nail stops. The piston is a mass at the upper end of the rod, on which the cycle's forces of gas,
//! friction and bumper act. Rod and nail touch without tension, and the wood grips the nail's elements, its tip and its
//! head. The limits of the grips sum to the resistance of the cycle's law at the nail's local speed.
//!
//! ```text
//! along the shank:  limit f_shank dx,   Z = 2 pi r rho c_s dx               (M. Novak, Can. Geotech. J. 11, 574, 1974)
//! tip and head:     limit f_tip, f_head,  Z = 3.4 a^2 rho c_s/(1 - nu), nu = 0.4, a the radius       (J. Lysmer, 1965)
//! ```
//!
//! After the first contact the nail runs ahead of the rod, the wood slows it, and the rod strikes it again, some tens
//! of times in a shot. The times of the last strikes depend on details: bands of the force above 6 kHz differ by some 3
//! dB between numbers of elements, those below 5 kHz by 1 dB.
//!
//! The grips share the unloading stiffness k_u of the cycle in proportion to their limits, so that a rigid nail unloads
//! as in the cycle.

mod bar;
mod grip;

pub use bar::{Bar, EndContact, Rod, advance};

use std::f64::consts::PI;

use grip::{Grip, GripLaw};
use nailnoise_penetration::Envelope;
use nailnoise_quantities::Check;

use crate::{CycleRecord, Geometry, Parameters};

/// Elements along the nail; with steel, a step of 0.18 us for a 12d nail.
const NAIL_ELEMENTS: usize = 64;

/// Linear bulk viscosity, which damps the oscillations of single elements after contacts (J. von Neumann and R. D.
/// Richtmyer, J. Appl. Phys. 21, 232, 1950).
const VISCOSITY: f64 = 0.2;

/// c dt/h of the nail's elements; the viscosity lowers the limit of stability to 0.82.
const COURANT: f64 = 0.7;

/// Time after the nail's stop for which the bars are followed, and the last part of it over which the force goes back
/// to that of the cycle \[s\].
const AFTER_STOP: [f64; 2] = [1e-3, 0.3e-3];

/// 3.4/(1 - nu) of a disc on an elastic half-space, for a Poisson's ratio of 0.4.
const LYSMER: f64 = 3.4 / 0.6;

/// Largest relative error of momentum and energy.
const BALANCE: f64 = 1e-6;

/// Maximum mass of the rod relative to the piston's mass.
const LARGEST_ROD: f64 = 0.9;

/// The bars of a blow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bars {
    /// The driver rod.
    pub rod: Rod,
    /// The nail's shank; its head is a mass at its upper end.
    pub nail: Rod,
    /// Speed of shear waves in the wood \[m/s\].
    pub shear_speed: f64,
    /// Number of elements along the nail.
    pub elements: usize,
    /// Linear bulk viscosity b: the stress b rho c h dv/dx of an element of the length h.
    pub viscosity: f64,
}

impl Bars {
    /// The bars of a shot.
    pub fn new(p: &Parameters) -> Self {
        let steel = |length, diameter| Rod {
            length,
            diameter,
            modulus: p.piston.rod_modulus,
            density: p.nail.density,
        };
        let rod = steel(p.piston.rod_length, p.piston.rod_diameter);
        // A rod heavier than the cycle's piston allows is shortened to the permitted mass.
        let longest = rod.length * LARGEST_ROD * p.piston.mass / rod.mass();
        let diameter = p.nail.diameter * f64::from(p.nail.legs).sqrt();
        Self {
            rod: Rod {
                length: rod.length.min(longest),
                ..rod
            },
            nail: steel(p.nail.length, diameter),
            shear_speed: p.wood.shear_speed,
            elements: NAIL_ELEMENTS,
            viscosity: VISCOSITY,
        }
    }
}

/// Forces of an elastic blow, at the samples of the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Blow {
    /// Force of the nail on the wood \[N\], averaged over the interval around each sample; outside the time of the
    /// blow, that of the cycle.
    pub on_wood: Vec<f64>,
    /// Force between rod and nail \[N\].
    pub rod_on_nail: Vec<f64>,
    /// First and last sample of the blow.
    pub samples: [usize; 2],
    /// Impulse on the wood until the deepest point of the nail, elastic and in the cycle \[N s\].
    pub impulses: [f64; 2],
    /// Number of contacts of rod and nail.
    pub contacts: usize,
    /// Balances of momentum and energy.
    pub checks: Vec<Check>,
}

/// Computes the blow of a shot from its cycle; `None` if the rod never strikes the nail or the nail does not stop.
pub fn elastic_blow(p: &Parameters, record: &CycleRecord) -> Option<Blow> {
    with_bars(&Bars::new(p), p, record)
}

/// Computes the blow with other bars.
pub fn with_bars(bars: &Bars, p: &Parameters, record: &CycleRecord) -> Option<Blow> {
    let start = record.events.t5?;
    let stop = record.events.t9?;
    let speed = record.summary.speed_before_impact?;
    let dt_record = record.sample_interval;
    let first = (start / dt_record).ceil() as usize;
    let [after, fade] = AFTER_STOP;
    let last = (((stop + after) / dt_record) as usize).min(record.len().checked_sub(2)?);
    let mut run = BlowIntegration::new(bars, p, record, start, speed);
    let mut on_wood = record.forces.penetration.clone();
    let mut rod_on_nail = vec![0.0; record.len()];
    let (mut impulse, mut from) = (0.0, start);
    for sample in first..=last {
        let end = (sample as f64 + 0.5) * dt_record;
        let mean = run.until(end);
        let remaining = ((stop + after - end) / fade).clamp(0.0, 1.0);
        let weight = (0.5 * PI * remaining).sin().powi(2);
        on_wood[sample] += weight * (mean.on_wood - on_wood[sample]);
        rod_on_nail[sample] = mean.rod_on_nail;
        // The bars step past the end of an interval, so its duration is not that between the ends of the intervals.
        impulse += record.forces.penetration[sample] * (end.min(stop) - from.min(stop));
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
    p: &'a Parameters,
    record: &'a CycleRecord,
    bars: &'a Bars,
    envelope: Envelope,
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
    fn new(bars: &'a Bars, p: &'a Parameters, record: &'a CycleRecord, start: f64, speed: f64) -> Self {
        let element = bars.nail.length / bars.elements as f64;
        let elements = bars.rod.length / element * bars.nail.wave_speed() / bars.rod.wave_speed();
        let mut piston = Bar::new(&bars.rod, (elements as usize).max(1), speed);
        piston.mass[0] += p.piston.mass - bars.rod.mass();
        let at = Sampled::new(record, start);
        let mut nail = Bar::new(&bars.nail, bars.elements, at.of(&record.tool.velocity));
        let geometry = Geometry::new(p);
        nail.mass[0] += (geometry.nail_mass - bars.nail.mass()).max(0.0);
        let dt = COURANT * element / bars.nail.wave_speed();
        let wood = at.of(&record.workpiece.position);
        Self {
            envelope: p.penetration_envelope(),
            impact: speed - at.of(&record.workpiece.velocity),
            depth: at.of(&record.piston.position) - wood - geometry.tip_gap,
            wood,
            initial_momentum: piston.momentum() + nail.momentum(),
            initial_energy: piston.energy(dt) + nail.energy(dt),
            grips: vec![Grip::default(); bars.elements + 3],
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
            bars,
            p,
            record,
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
        let at = Sampled::new(self.record, self.time);
        let forces = &self.record.forces;
        let push = at.of(&forces.piston_gas)
            - at.of(&forces.bumper)
            - at.of(&forces.stopper)
            - at.of(&forces.piston_friction)
            - at.of(&forces.magazine);
        let gravity = self.p.ambient.gravity;
        for bar in [&mut self.piston, &mut self.nail] {
            for (load, mass) in bar.load.iter_mut().zip(&bar.mass) {
                *load = mass * gravity;
            }
        }
        self.piston.load[0] += push;
        let wood = at.of(&self.record.workpiece.position) - self.wood;
        let on_wood = self.grip(wood, at.of(&self.record.workpiece.velocity));
        for (bar, rod) in [(&mut self.piston, &self.bars.rod), (&mut self.nail, &self.bars.nail)] {
            bar.add_damping(self.bars.viscosity * rod.density * rod.wave_speed() * rod.area());
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
        let (bars, wood, nail) = (self.bars, &self.p.wood, &self.p.nail);
        let element = bars.nail.length / tip as f64;
        let impedance = wood.density * bars.shear_speed;
        let [friction, point, head] = self.envelope.parts(self.deepest, 0.0, self.impact);
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
            (lower.min(bars.nail.length) - upper.max(0.0)).max(0.0)
        };
        let lengths: Vec<f64> = (0..=tip).map(embedded).collect();
        let whole: f64 = lengths.iter().sum();
        let perimeter = PI * nail.diameter * f64::from(nail.legs);
        let disc = |diameter: f64| LYSMER * 0.25 * diameter * diameter * impedance;
        let speeds: Vec<f64> = self.nail.velocity.iter().map(|v| v - speed).collect();
        let moving = |node: usize| self.envelope.parts(self.deepest, speeds[node].abs(), self.impact);
        let mut held = Vec::with_capacity(tip + 3);
        for (node, length) in lengths.iter().enumerate() {
            let part = if whole > 0.0 { length / whole } else { 0.0 };
            let limit = if part > 0.0 { part * moving(node)[0] } else { 0.0 };
            held.push((node, limit, part * friction, perimeter * impedance * length));
        }
        held.push((tip, moving(tip)[1], point, disc(bars.nail.diameter)));
        held.push((0, head, head, disc(nail.head_diameter)));
        let share = self.p.wood.unloading_stiffness / total;
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

/// Values of a record at a time, by linear interpolation.
#[derive(Clone, Copy)]
struct Sampled {
    sample: usize,
    part: f64,
}

impl Sampled {
    fn new(record: &CycleRecord, time: f64) -> Self {
        let position = (time / record.sample_interval).max(0.0);
        let sample = (position as usize).min(record.len().saturating_sub(2));
        Self {
            sample,
            part: (position - sample as f64).min(1.0),
        }
    }

    fn of(&self, values: &[f64]) -> f64 {
        values[self.sample] + self.part * (values[self.sample + 1] - values[self.sample])
    }
}
