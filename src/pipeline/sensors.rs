//! What accelerometers of a design would record of the shot.

use std::f64::consts::FRAC_PI_8;

use nailnoise_acoustics::fourier::filtered;
use nailnoise_acoustics::radiation::MovingSand;
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::LoadVector;
use nailnoise_fem::transient::{Loads, ModalResponse, Settings};
use nailnoise_meshes::MeshError;
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use rayon::prelude::*;

use super::bodies::GraphBody;
use crate::design::inputs::radiation::moving_sand;
use crate::design::{BodyModel, Carrier, Design, Sensor, SensorProblem, SupportKind};
use crate::error::Error;
use crate::result::SensorLevel;

/// Standard acceleration of gravity, in which accelerometers are read (ISO 80000-3) \[m/s2\].
const STANDARD_GRAVITY: f64 = 9.80665;

/// Length of the transforms over that of the record; the slowest filter has died out in the rest.
const PADDING: f64 = 4.0;

/// What one sensor records.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorRecord {
    /// Its name in the design.
    pub name: String,
    /// What it is fixed to.
    pub body: Carrier,
    /// Interval of the samples, the first at t = 0 \[s\].
    pub interval: f64,
    /// Acceleration along its axis within its band \[m/s2\].
    pub acceleration: Vec<f64>,
}

/// An elastic body of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moving {
    Block,
    Table,
    Tool,
}

/// The sensors that read a body.
pub(super) struct Sensing {
    names: Vec<String>,
    /// Displacement of each mode along the axis of each sensor: modes x sensors \[kg^-1/2\].
    pub(super) shapes: DMatrix<f64>,
}

/// What sensors read of a body.
pub(super) struct Sensed {
    names: Vec<String>,
    /// Acceleration along their axes on the grid of the body's response: samples x sensors \[m/s2\].
    motion: DMatrix<f64>,
}

impl Sensing {
    /// Those of a design on one of its bodies.
    ///
    /// # Errors
    /// [`DesignError::Sensor`](crate::design::DesignError::Sensor) for a sensor that is not on its body, and those of
    /// [`GraphBody::modes`].
    pub(super) fn of(design: &Design, carrier: Moving, body: &GraphBody) -> Result<Self, Error> {
        let (mut names, mut vectors) = (Vec::new(), Vec::new());
        for (name, sensor) in present(design) {
            let place = match (sensor.body, carrier) {
                (Carrier::Workpiece, Moving::Block)
                | (Carrier::Worktable, Moving::Table)
                | (Carrier::Tool, Moving::Tool) => (Point3::new(sensor.x, sensor.y, sensor.z), axis(sensor)),
                (Carrier::Sand, Moving::Block) => {
                    let law = moving_sand(design)?;
                    let distance = off_the_sand(&law, [sensor.x, sensor.y]);
                    if distance > 0.0 {
                        return Err(outside(design, name, sensor, "sand's surface", distance));
                    }
                    let [x, y] = law.edge([sensor.x, sensor.y]);
                    let edge = Point3::new(x, y, design.workpiece.thickness);
                    (edge, Vector3::z() * axis(sensor).z)
                }
                _ => continue,
            };
            let vector = LoadVector::point(&body.mesh, place.0, place.1, OFF).map_err(|error| match error {
                MeshError::Outside { distance, .. } => outside(design, name, sensor, body.name, distance),
                other => other.into(),
            })?;
            names.push(name.clone());
            vectors.push(vector);
        }
        let shapes = body.participation(vectors)?;
        Ok(Self { names, shapes })
    }

    /// With what they read, samples x sensors \[m/s2\].
    pub(super) fn sensed(self, motion: DMatrix<f64>) -> Sensed {
        Sensed {
            names: self.names,
            motion,
        }
    }
}

impl Sensed {
    fn of(&self, name: &str) -> Option<Vec<f64>> {
        let number = self.names.iter().position(|own| own == name)?;
        Some(self.motion.column(number).iter().copied().collect())
    }
}

/// The records of all sensors whose body the design has, by name, as long as the response of the workpiece; a rigid tool is
/// that of the cycle.
///
/// # Errors
/// Those of the filter.
pub(super) fn sensors(
    design: &Design,
    (response, record): (&ModalResponse, &CycleRecord),
    sensed: &[&Sensed],
) -> Result<Vec<SensorRecord>, Error> {
    let interval = response.step;
    let of_sensor = |(name, sensor): (&String, &Sensor)| {
        let read = sensed.iter().find_map(|sensed| sensed.of(name));
        let rigid = read.is_none();
        // The cycle counts downwards, the sensor upwards.
        let raw = read.unwrap_or_else(|| falling(response, record, -axis(sensor).z));
        let top_hz = if rigid {
            f64::INFINITY
        } else {
            top_of(design, sensor.body)
        };
        let sand = match sensor.body {
            Carrier::Sand => Some(moving_sand(design)?),
            _ => None,
        };
        let at = [sensor.x, sensor.y];
        let mut acceleration = filtered(&raw, interval, PADDING, |hz| {
            band(sensor, top_hz, hz) * sand.map_or(Complex::from(1.0), |sand| sand.ratio(at, hz))
        })?;
        acceleration.truncate(response.samples());
        Ok(SensorRecord {
            name: name.clone(),
            body: sensor.body,
            interval,
            acceleration,
        })
    };
    let present: Vec<_> = present(design).collect();
    present.into_par_iter().map(of_sensor).collect()
}

/// Acceleration of a rigid tool on the grid of the response, times a factor.
fn falling(response: &ModalResponse, record: &CycleRecord, factor: f64) -> Vec<f64> {
    // After the record the forces on the tool balance each other.
    let fall = Loads {
        interval: record.sample_interval,
        history: DMatrix::from_row_slice(1, record.len(), &record.tool.acceleration),
        final_values: vec![0.0],
    };
    let fall = fall.sampled(response.step, response.samples(), Settings::default().taper);
    (fall * factor).as_slice().to_vec()
}

/// The sensors whose body the design has, by name.
fn present(design: &Design) -> impl Iterator<Item = (&String, &Sensor)> {
    design.sensors.iter().filter(|(_, sensor)| carries(design, sensor.body))
}

/// Names of the sensors whose body the design lacks.
pub(super) fn idle(design: &Design) -> Vec<&str> {
    let absent = design
        .sensors
        .iter()
        .filter(|(_, sensor)| !carries(design, sensor.body));
    absent.map(|(name, _)| name.as_str()).collect()
}

fn carries(design: &Design, body: Carrier) -> bool {
    match body {
        Carrier::Workpiece | Carrier::Tool => true,
        Carrier::Worktable => design.support.kind == SupportKind::Worktable,
        Carrier::Sand => design.support.kind == SupportKind::Sandbox,
    }
}

/// How far off its body a sensor may be \[m\]: less than half its base, more than the chords of a mesh are off the
/// cylinders that they stand for.
const OFF: f64 = 1e-3;

/// Frequency up to which the modes of a body take part \[Hz\]; above it what they and their static corrections do is no
/// motion of the body.
fn top_of(design: &Design, carrier: Carrier) -> f64 {
    let analysis = &design.analysis;
    match carrier {
        Carrier::Workpiece | Carrier::Sand => analysis.workpiece_top,
        Carrier::Worktable => analysis.worktable_top,
        Carrier::Tool => analysis.body_top,
    }
}

/// Names of the sensors whose band ends with the modes of their body, and where \[Hz\].
pub(super) fn limited(design: &Design) -> Vec<(&str, f64)> {
    let elastic = |sensor: &Sensor| sensor.body != Carrier::Tool || design.body.model == BodyModel::Elastic;
    let present = design.sensors.iter().filter(|(_, sensor)| carries(design, sensor.body));
    present
        .filter(|(_, sensor)| elastic(sensor) && sensor.band_high > top_of(design, sensor.body))
        .map(|(name, sensor)| (name.as_str(), top_of(design, sensor.body)))
        .collect()
}

fn axis(sensor: &Sensor) -> Vector3<f64> {
    Vector3::new(sensor.along_x, sensor.along_y, sensor.along_z).normalize()
}

fn outside(design: &Design, name: &str, sensor: &Sensor, body: &'static str, distance: f64) -> Error {
    let point = [sensor.x, sensor.y, sensor.z];
    let problem = SensorProblem::Outside { body, point, distance };
    design.refuse_sensor(name, problem).into()
}

/// How far a point lies from the sand around the block, 0 on it \[m\].
fn off_the_sand(law: &MovingSand, point: [f64; 2]) -> f64 {
    let beyond = |i: usize| (law.sand[i][0] - point[i]).max(point[i] - law.sand[i][1]).max(0.0);
    let box_gap = beyond(0).hypot(beyond(1));
    let depth = |i: usize| (point[i] - law.footprint[i][0]).min(law.footprint[i][1] - point[i]);
    box_gap.max(depth(0).min(depth(1)))
}

/// Response of the measuring chain: a high-pass of first order and a Butterworth low-pass of fourth order, the latter at
/// most at the top frequency of its body,
///
/// ```text
/// H = s_l/(1 + s_l) / prod_k (1 + 2 s_h sin((2k - 1) pi/8) + s_h^2),  k = 1, 2;  s = j f/f_limit
/// ```
fn band(sensor: &Sensor, top_hz: f64, hz: f64) -> Complex<f64> {
    let low = Complex::new(0.0, hz / sensor.band_low);
    let high = Complex::new(0.0, hz / sensor.band_high.min(top_hz));
    let section = |k: f64| 1.0 + high * (2.0 * (k * FRAC_PI_8).sin()) + high * high;
    low / (1.0 + low) / (section(1.0) * section(3.0))
}

impl SensorRecord {
    /// RMS over 1 s and peak, as they are reported.
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

    fn sensor() -> Sensor {
        Sensor {
            body: Carrier::Workpiece,
            x: 0.0,
            y: 0.0,
            z: 0.0,
            along_x: 0.0,
            along_y: 0.6,
            along_z: -0.8,
            band_low: 2.0,
            band_high: 5e3,
        }
    }

    #[test]
    fn the_band_ends_three_decibels_down_and_falls_with_its_order() {
        let level = |hz: f64| 20.0 * band(&sensor(), 8e3, hz).norm().log10();
        assert!(level(100.0).abs() < 0.01);
        assert!((level(2.0) + 3.0103).abs() < 1e-3 && (level(5e3) + 3.0103).abs() < 1e-3);
        assert!((level(0.02) - level(0.2) + 20.0).abs() < 0.1);
        assert!((level(5e5) - level(5e4) + 80.0).abs() < 0.1);
        // No higher than the modes of its body.
        assert!((20.0 * band(&sensor(), 4e3, 4e3).norm().log10() + 3.0103).abs() < 1e-3);
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

    #[test]
    fn distance_off_the_sand_is_measured_from_box_and_block() {
        let law = MovingSand {
            footprint: [[-0.2, 0.2], [-0.1, 0.1]],
            sand: [[-0.3, 0.3], [-0.3, 0.3]],
            shear_speed: 112.0,
            loss_factor: 0.1,
            to_hz: 800.0,
        };
        assert_eq!(off_the_sand(&law, [0.25, 0.0]), 0.0);
        assert!((off_the_sand(&law, [0.15, 0.0]) - 0.05).abs() < 1e-12);
        assert!((off_the_sand(&law, [0.33, 0.34]) - 0.05).abs() < 1e-12);
    }
}
