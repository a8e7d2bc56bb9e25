//! Accelerometers on the bodies of a shot.

use std::f64::consts::{FRAC_PI_8, TAU};

use nailnoise_acoustics::radiation::flush_with_sand::MovingSand;
use nailnoise_acoustics::signals::fourier::filtered;
use nailnoise_fem::vibration::{Loads, Settings};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::response::Vibration;
use super::spectra::{BodyMotion, SensorMotion};
use super::{Code, Postcard, Progress, Stage, Stored, all, code};
use crate::design::Carrier;
use crate::error::Error;
use crate::result::SensorLevel;
use crate::stages::cycle::ShotRecord;

/// Standard acceleration due to gravity, the unit of accelerometer readings (ISO 80000-3) \[m/s2\].
const STANDARD_GRAVITY: f64 = 9.80665;

/// Number of time constants of a high-pass by which a transform is longer than the motion, so that only exp(-12) of its
/// decay wraps around.
const DECAY: f64 = 12.0;

/// Longest decay of a high-pass that fits into a transform \[s\]; only a high-pass below 0.5 Hz decays longer.
const LONGEST_DECAY: f64 = 4.0;

/// Fraction of a signal's energy that may be cut off at the end of its record; it changes the level by 4e-5 dB.
const REST: f64 = 1e-5;

/// Minimum number of samples in a record, for a spectrum.
const SHORTEST: usize = 8;

/// An accelerometer with its measuring chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Accelerometer {
    /// Name in the design.
    pub name: String,
    /// Body that carries the sensor.
    pub body: Carrier,
    /// Upward component of its axis along z; on a rigid tool, the other components have no effect.
    pub axis_z: f64,
    /// Limits of its band at -3 dB \[Hz\]; the upper one is not above the modes of its body.
    pub band_hz: [f64; 2],
    /// Law and position, if the sensor is on sand next to the workpiece.
    pub sand: Option<(MovingSand, [f64; 2])>,
}

impl Accelerometer {
    /// Response of the measuring chain, which is a first-order high-pass and a fourth-order Butterworth low-pass,
    ///
    /// ```text
    /// H = s_l/(1 + s_l) / prod_k (1 + 2 s_h sin((2k - 1) pi/8) + s_h^2),  k = 1, 2;  s = j f/f_limit
    /// ```
    ///
    /// including the sand between workpiece and sensor.
    fn transfer(&self, hz: f64) -> Complex<f64> {
        let low = Complex::new(0.0, hz / self.band_hz[0]);
        let high = Complex::new(0.0, hz / self.band_hz[1]);
        let section = |k: f64| 1.0 + high * (2.0 * (k * FRAC_PI_8).sin()) + high * high;
        let sand = self.sand.map_or(Complex::from(1.0), |(law, at)| law.ratio(at, hz));
        low / (1.0 + low) / (section(1.0) * section(3.0)) * sand
    }
}

/// Signal of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensorRecord {
    /// Name in the design.
    pub name: String,
    /// Body that carries the sensor.
    pub body: Carrier,
    /// Sampling interval, the first sample at t = 0 \[s\].
    pub interval: f64,
    /// Acceleration along its axis within its band \[m/s2\].
    pub acceleration: Vec<f64>,
}

/// Signals of all sensors of a shot.
#[derive(Clone, Serialize)]
pub struct Sensors {
    /// The sensors.
    pub accelerometers: Vec<Accelerometer>,
    /// The cycle.
    pub cycle: Stored<ShotRecord>,
    /// Response of workpiece and support, whose step the signals share; none for a tool without a workpiece, whose
    /// signals have the step of the cycle.
    pub vibration: Option<Stored<Vibration>>,
    /// Motions of the elastic bodies.
    pub motions: Vec<Stored<BodyMotion>>,
}

impl Stage for Sensors {
    type Output = Vec<SensorRecord>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "sensors";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_response,
        stages_sensors,
        stages_spectra,
        stages_cycle
    );

    fn compute(&self, _: &Progress) -> Result<Vec<SensorRecord>, Error> {
        self.records()
    }
}

impl Sensors {
    /// The signals, in the order of the sensors.
    ///
    /// # Errors
    /// The errors of previous stages and of the filter.
    pub(super) fn records(&self) -> Result<Vec<SensorRecord>, Error> {
        let record = self.cycle.get()?;
        let vibration = self.vibration.as_ref().map(Stored::get).transpose()?;
        let motions = all(&self.motions)?;
        let motions: Vec<&SensorMotion> = motions.iter().map(|motion| &motion.sensors).collect();
        let of_response = vibration.map(|own| (own.response.step, own.response.samples()));
        let (step, of_response) = of_response.unwrap_or((record.sample_interval, 0));
        let others = motions.iter().filter(|motion| !motion.names.is_empty());
        let others = others.map(|motion| motion.acceleration.nrows());
        // The tool may still move when the workpiece has come to rest.
        let cycle = (record.len() as f64 * record.sample_interval / step).ceil() as usize;
        let samples = others.fold(of_response.max(cycle), usize::max);
        signals(&self.accelerometers, (step, samples), &record, &motions)
    }
}

/// Signals of sensors on a time grid (`step` \[s\], number of `samples`), cut when all have come to rest. Sensors
/// without a motion of their body are on a rigid tool, which moves as in the cycle.
///
/// # Errors
/// The errors of the filter.
fn signals(
    sensors: &[Accelerometer],
    (step, samples): (f64, usize),
    record: &ShotRecord,
    motions: &[&SensorMotion],
) -> Result<Vec<SensorRecord>, Error> {
    let signal = |sensor: &Accelerometer| {
        let elastic = motions.iter().find_map(|motion| motion.of(&sensor.name));
        // The cycle counts downwards, the sensor upwards.
        let mut raw = elastic.unwrap_or_else(|| rigid(record, (step, samples), -sensor.axis_z));
        let decay = (DECAY / (TAU * sensor.band_hz[0])).min(LONGEST_DECAY);
        raw.resize(samples + (decay / step).ceil() as usize, 0.0);
        let acceleration = filtered(&raw, step, 1.0, |hz| sensor.transfer(hz))?;
        Ok(SensorRecord {
            name: sensor.name.clone(),
            body: sensor.body,
            interval: step,
            acceleration,
        })
    };
    let mut records: Vec<SensorRecord> = sensors.par_iter().map(signal).collect::<Result<_, Error>>()?;
    let length = records
        .iter()
        .map(|record| decayed_length(&record.acceleration))
        .max()
        .unwrap_or(0);
    records
        .iter_mut()
        .for_each(|record| record.acceleration.truncate(length));
    Ok(records)
}

/// Number of samples after which less than [`REST`] of a signal's energy remains.
fn decayed_length(signal: &[f64]) -> usize {
    let left = REST * signal.iter().map(|a| a * a).sum::<f64>();
    let mut after = 0.0;
    let last = signal.iter().rposition(|a| {
        after += a * a;
        after > left
    });
    last.map_or(0, |last| last + 1).max(SHORTEST.min(signal.len()))
}

/// Acceleration of a rigid tool, multiplied by a factor.
fn rigid(record: &ShotRecord, (step, samples): (f64, usize), factor: f64) -> Vec<f64> {
    if record.tool_acceleration().is_empty() {
        return vec![0.0; samples];
    }
    // After the record the forces on the tool balance each other.
    let acceleration = Loads {
        interval: record.sample_interval,
        history: DMatrix::from_row_slice(1, record.tool_acceleration().len(), record.tool_acceleration()),
        final_values: vec![0.0],
    };
    let acceleration = acceleration.sampled(step, samples, Settings::default().taper);
    (acceleration * factor).as_slice().to_vec()
}

impl SensorRecord {
    /// RMS over 1 s, and peak.
    pub fn level(&self) -> SensorLevel {
        let energy: f64 = self.acceleration.iter().map(|a| a * a).sum::<f64>() * self.interval;
        let peak = self.acceleration.iter().fold(0.0, |peak: f64, a| peak.max(a.abs()));
        SensorLevel {
            name: self.name.clone(),
            body: self.body.as_str(),
            rms_g: energy.sqrt() / STANDARD_GRAVITY,
            peak_g: peak / STANDARD_GRAVITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_band_ends_three_decibels_down_and_falls_with_its_order() {
        let sensor = |top_hz: f64| Accelerometer {
            name: "a".to_owned(),
            body: Carrier::Workpiece,
            axis_z: -0.8,
            band_hz: [2.0, top_hz],
            sand: None,
        };
        let level = |hz: f64| 20.0 * sensor(5e3).transfer(hz).norm().log10();
        assert!(level(100.0).abs() < 0.01);
        assert!((level(2.0) + 3.0103).abs() < 1e-3 && (level(5e3) + 3.0103).abs() < 1e-3);
        assert!((level(0.02) - level(0.2) + 20.0).abs() < 0.1);
        assert!((level(5e5) - level(5e4) + 80.0).abs() < 0.1);
        assert!((20.0 * sensor(4e3).transfer(4e3).norm().log10() + 3.0103).abs() < 1e-3);
    }

    #[test]
    fn a_record_ends_where_its_energy_has_decayed() {
        let decay = |n: i32| (-0.01 * f64::from(n)).exp();
        let signal: Vec<f64> = (0..5000).map(decay).collect();
        // The energy left after n samples is exp(-0.02 n).
        assert_eq!(decayed_length(&signal), (REST.ln() / -0.02).ceil() as usize);
        assert_eq!(decayed_length(&[0.0; 20]), SHORTEST);
    }

    #[test]
    fn a_burst_of_one_second_has_the_rms_of_its_sine() {
        let interval = 1e-4;
        let record = SensorRecord {
            name: "a".to_owned(),
            body: Carrier::Tool,
            interval,
            acceleration: (0..10_000)
                .map(|n| (TAU * 50.0 * n as f64 * interval).sin() * STANDARD_GRAVITY)
                .collect(),
        };
        let level = record.level();
        assert!((level.rms_g - 0.5_f64.sqrt()).abs() < 1e-9 && (level.peak_g - 1.0).abs() < 1e-4);
    }
}
