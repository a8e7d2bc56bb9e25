//! Pressure transducers in the chambers of the tool.

use rayon::prelude::*;
use serde::Serialize;

use super::{Code, Progress, Stage, Stored, Uncached, code};
use crate::error::Error;
use crate::result::TransducerRange;
use crate::stages::cycle::{BORE, RETURN_WALL, ShotRecord};

/// The chambers that are not named after a volume of the cycle.
pub(crate) const CYLINDER: &str = "cylinder";
pub(crate) const RETURN: &str = "return";

/// Where a pressure transducer is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Chamber {
    /// In the wall of the cylinder.
    Cylinder,
    /// In the wall of the return chamber.
    Return,
    /// In a volume of the cycle.
    Volume(String),
}

impl Chamber {
    /// Its name in designs and files.
    pub fn as_str(&self) -> &str {
        match self {
            Self::Cylinder => CYLINDER,
            Self::Return => RETURN,
            Self::Volume(name) => name,
        }
    }
}

/// A piezoelectric pressure transducer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressureTransducer {
    /// Name in the design.
    pub name: String,
    /// Its chamber.
    pub chamber: Chamber,
    /// Travel of the piston at which it passes a transducer in the cylinder's wall \[m\].
    pub position: f64,
    /// Discharge time of its amplifier, tau \[s\].
    pub discharge_time: f64,
}

/// Signal of one transducer.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureRecord {
    /// Name in the design.
    pub name: String,
    /// Its chamber.
    pub chamber: Chamber,
    /// Sampling interval, the first sample at t = 0 \[s\].
    pub interval: f64,
    /// Reading relative to the pressure at t = 0 \[Pa\].
    pub values: Vec<f64>,
}

impl PressureRecord {
    /// Lowest and highest reading.
    pub fn range(&self) -> TransducerRange {
        let of = |value: fn(f64, f64) -> f64| self.values.iter().copied().fold(0.0, value);
        TransducerRange {
            name: self.name.clone(),
            chamber: self.chamber.as_str().to_owned(),
            lowest_pa: of(f64::min),
            highest_pa: of(f64::max),
        }
    }
}

/// Signals of all pressure transducers of a shot.
///
/// Its output is not stored: computing it takes less time than reading it would.
#[derive(Serialize)]
pub struct Transducers {
    /// The transducers.
    pub transducers: Vec<PressureTransducer>,
    /// The cycle.
    pub cycle: Stored<ShotRecord>,
}

impl Stage for Transducers {
    type Output = Vec<PressureRecord>;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "pressure transducers";
    const CODE: Code = code!(dynamics, stages_transducers, stages_cycle);

    fn compute(&self, _: &Progress) -> Result<Vec<PressureRecord>, Error> {
        let record = self.cycle.get()?;
        let signal = |transducer: &PressureTransducer| PressureRecord {
            name: transducer.name.clone(),
            chamber: transducer.chamber.clone(),
            interval: record.sample_interval,
            values: discharged(
                &transducer.pressure(&record),
                record.sample_interval,
                transducer.discharge_time,
            ),
        };
        Ok(self.transducers.par_iter().map(signal).collect())
    }
}

impl PressureTransducer {
    /// Absolute pressure at the transducer \[Pa\]. In the cylinder's wall, it is that of the volume below the piston
    /// until the piston has passed, and that above the piston while the piston is below it.
    fn pressure(&self, record: &ShotRecord) -> Vec<f64> {
        let wall = |surface: &str| record.pressures().find(|wall| wall.surface == surface);
        let read = match &self.chamber {
            Chamber::Volume(name) => record.volume_pressure(name).map(<[f64]>::to_vec),
            Chamber::Return => wall(RETURN_WALL).map(|wall| wall.pressure.clone()),
            Chamber::Cylinder => wall(BORE).map(|wall| {
                let volumes = wall.pressure.iter().zip(&wall.below);
                let before =
                    |(y, (above, below)): (&f64, (&f64, &f64))| if *y > self.position { *above } else { *below };
                wall.divide.iter().zip(volumes).map(before).collect()
            }),
        };
        // The inputs contain no transducer in a chamber that the tool does not have.
        read.unwrap_or_default()
    }
}

/// A signal after the first-order high-pass of a leaking charge, initially at rest at its first value.
///
/// ```text
/// y' + y/tau = p'      H = s tau/(1 + s tau)
/// ```
///
/// The solution is exact for a pressure that is linear between its samples at `interval` \[s\].
fn discharged(pressure: &[f64], interval: f64, tau: f64) -> Vec<f64> {
    let ratio = interval / tau;
    let (kept, gained) = ((-ratio).exp(), -(-ratio).exp_m1() / ratio);
    let mut reading = 0.0;
    let steps = pressure.windows(2).map(|pair| {
        reading = kept * reading + gained * (pair[1] - pair[0]);
        reading
    });
    let first = pressure.first().map(|_| 0.0);
    first.into_iter().chain(steps).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_read_up_to_its_slope_times_the_discharge_time() {
        let (interval, tau, slope) = (1e-3, 0.02, 5e6);
        let ramp: Vec<f64> = (0..100).map(|n| 1e5 + slope * interval * f64::from(n)).collect();
        let read = discharged(&ramp, interval, tau);
        for (n, value) in read.iter().enumerate() {
            let exact = slope * tau * -(-(n as f64) * interval / tau).exp_m1();
            assert!((value - exact).abs() <= 1e-9 * slope * tau, "{n}: {value} {exact}");
        }
    }

    #[test]
    fn a_static_pressure_is_not_read_and_a_long_discharge_keeps_every_change() {
        assert!(discharged(&[7e5; 50], 1e-5, 0.1).iter().all(|value| *value == 0.0));
        assert_eq!(discharged(&[], 1e-5, 0.1), [0.0; 0]);
        let pressure: Vec<f64> = (0..200).map(|n| 1e5 * (0.1 * f64::from(n)).sin()).collect();
        let read = discharged(&pressure, 1e-5, 1e6);
        for (value, p) in read.iter().zip(&pressure) {
            assert!((value - (p - pressure[0])).abs() < 1e-3);
        }
    }
}
