//! Histories of a cycle that a blow uses.

use super::input::BlowInput;
use crate::network::Record;

/// Entry in the log where a fastener stops and its resistance begins to unload along another curve.
const UNLOADS: &str = "unloads";

/// Motion of the body that a fastener enters, at the samples of a cycle.
#[derive(Debug, Clone, Copy)]
pub struct WorkMotion<'a> {
    /// Position \[m\].
    pub position: &'a [f64],
    /// Velocity \[m/s\].
    pub velocity: &'a [f64],
}

/// Motion of the driver, at the samples of a cycle.
#[derive(Debug, Clone, Copy)]
pub struct DriverMotion<'a> {
    /// Position \[m\].
    pub position: &'a [f64],
    /// Velocity \[m/s\].
    pub velocity: &'a [f64],
    /// Acceleration \[m/s2\].
    pub acceleration: &'a [f64],
    /// Mass of the driver, with that of the fastener while both move together \[kg\].
    pub moving_mass: &'a [f64],
}

/// The cycle around a blow: when the driver strikes the fastener, and the histories of the bodies.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a> {
    /// Interval of the samples \[s\].
    pub interval: f64,
    /// Time of the first impact \[s\].
    pub strike: f64,
    /// Velocity of the driver before it \[m/s\].
    pub speed: f64,
    /// Time after it at which the work first unloads \[s\]; `None` for a resistance that is the same in both
    /// directions.
    pub unloads: Option<f64>,
    /// The driver.
    pub driver: DriverMotion<'a>,
    /// The body that the fastener enters; `None` for the ground.
    pub work: Option<WorkMotion<'a>>,
    /// Velocity of the body that guides the fastener; `None` for the ground \[m/s\].
    pub guide: Option<&'a [f64]>,
    /// Resistance of the work to the fastener \[N\].
    pub resistance: &'a [f64],
}

impl<'a> Course<'a> {
    /// The cycle of a record; `None` if the driver does not strike the fastener, or if histories are missing.
    pub fn of_record(input: &BlowInput, record: &'a Record) -> Option<Self> {
        let strike = record.strikes.iter().find(|own| own.fastener == input.fastener.name)?;
        let of = |block: &str, quantity: &str| record.get(&format!("{block}.{quantity}"));
        let driver = input.driver.as_str();
        Some(Self {
            interval: record.interval?,
            strike: strike.time,
            speed: strike.before,
            unloads: {
                let mut log = record.log.iter().filter(|entry| entry.time >= strike.time);
                let unloads = log.find(|entry| entry.block == input.fastener.name && entry.word == UNLOADS);
                unloads.map(|entry| entry.time)
            },
            driver: DriverMotion {
                position: of(driver, "position")?,
                velocity: of(driver, "velocity")?,
                acceleration: of(driver, "acceleration")?,
                moving_mass: of(driver, "moving_mass")?,
            },
            work: match &input.work {
                None => None,
                Some(work) => Some(WorkMotion {
                    position: of(work, "position")?,
                    velocity: of(work, "velocity")?,
                }),
            },
            guide: match &input.guide {
                None => None,
                Some(guide) => Some(of(guide, "velocity")?),
            },
            resistance: of(&input.fastener.name, "force")?,
        })
    }

    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        self.resistance.len()
    }

    /// Forces on the driver other than gravity and the resistance of the work, from its equation of motion \[N\].
    pub fn push(&self, gravity: f64) -> Vec<f64> {
        let motion = self.driver.moving_mass.iter().zip(self.driver.acceleration);
        let pairs = motion.zip(self.resistance);
        pairs
            .map(|((mass, acceleration), resistance)| mass * (acceleration - gravity) + resistance)
            .collect()
    }

    /// Time at which the fastener first stops in the work \[s\]: that of its unloading or, without one, by linear
    /// interpolation between samples; `None` if it does not stop. Its tip enters the work where the driver's position
    /// relative to the work is `tip_at` \[m\].
    pub fn stop(&self, tip_at: f64) -> Option<f64> {
        if self.unloads.is_some() {
            return self.unloads;
        }
        let of = |values: Option<&[f64]>, n: usize| values.map_or(0.0, |values| values[n]);
        let advance = |n: usize| self.driver.velocity[n] - of(self.work.map(|work| work.velocity), n);
        let depth = |n: usize| self.driver.position[n] - of(self.work.map(|work| work.position), n) - tip_at;
        let first = (self.strike / self.interval).ceil() as usize + 1;
        let stopped = (first..self.len()).find(|n| depth(*n) > 0.0 && advance(*n) <= 0.0)?;
        let [before, after] = [advance(stopped - 1), advance(stopped)];
        let part = if before > after { before / (before - after) } else { 1.0 };
        Some(((stopped - 1) as f64 + part.clamp(0.0, 1.0)) * self.interval)
    }
}

/// Values of a cycle at a time, by linear interpolation.
#[derive(Clone, Copy)]
pub(super) struct Sampled {
    sample: usize,
    part: f64,
}

impl Sampled {
    pub(super) fn new(course: &Course<'_>, time: f64) -> Self {
        let position = (time / course.interval).max(0.0);
        let sample = (position as usize).min(course.len().saturating_sub(2));
        Self {
            sample,
            part: (position - sample as f64).min(1.0),
        }
    }

    pub(super) fn of(self, values: &[f64]) -> f64 {
        values[self.sample] + self.part * (values[self.sample + 1] - values[self.sample])
    }

    /// The value of a body; zero for the ground.
    pub(super) fn of_base(self, values: Option<&[f64]>) -> f64 {
        values.map_or(0.0, |values| self.of(values))
    }
}
