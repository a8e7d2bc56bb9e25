//! Accelerometers of a design with their points on its bodies, and pressure transducers in its chambers.

use nailnoise_acoustics::radiation::flush_with_sand::MovingSand;
use nalgebra::Vector3;

use super::assembly::{has_housing, has_workpiece};
use crate::design::{BodyModel, Carrier, Design, Sensor, SensorProblem, Transducer};
use crate::error::Error;
use crate::model::supports;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::SensorPoint;
use crate::stages::sensors::Accelerometer;
use crate::stages::transducers::PressureTransducer;

/// The sensors on bodies that the design has, by name.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn accelerometers(design: &Design) -> Result<Vec<Accelerometer>, Error> {
    let sand = supports::of(design).moving_sand()?;
    let accelerometer = |(name, sensor): (&String, &Sensor)| {
        let top_hz = top_hz(design, sensor.body).unwrap_or(f64::INFINITY);
        let sand = match sensor.body {
            Carrier::Sand => sand.map(|law| (law, [sensor.x, sensor.y])),
            Carrier::Workpiece | Carrier::Worktable | Carrier::Tool => None,
        };
        Ok(Accelerometer {
            name: name.clone(),
            body: sensor.body,
            axis_z: axis(sensor).z,
            band_hz: [sensor.band_low, sensor.band_high.min(top_hz)],
            sand,
        })
    };
    present(design).map(accelerometer).collect()
}

/// The pressure transducers, by name.
pub(crate) fn transducers(design: &Design) -> Vec<PressureTransducer> {
    let transducer = |(name, own): (&String, &Transducer)| PressureTransducer {
        name: name.clone(),
        chamber: own.chamber,
        position: own.position,
        discharge_time: own.discharge_time,
    };
    design.transducers.iter().map(transducer).collect()
}

/// Points of the sensors that measure the motion of a body; sensors on the sand measure the edge of the workpiece.
///
/// # Errors
/// [`Problem::Sensor`](crate::design::Problem::Sensor) for a sensor on the sand whose point is not on it.
pub(crate) fn points(design: &Design, body: Carrier) -> Result<Vec<SensorPoint>, Error> {
    let sand = supports::of(design).moving_sand()?;
    let mut points = Vec::new();
    for (name, sensor) in present(design) {
        let (position, direction) = match (sensor.body, body, sand) {
            (Carrier::Sand, Carrier::Workpiece, Some(law)) => {
                let distance = off_the_sand(&law, [sensor.x, sensor.y]);
                if distance > 0.0 {
                    return Err(outside(design, name, sensor, "sand's surface", distance));
                }
                let [x, y] = law.edge([sensor.x, sensor.y]);
                ([x, y, design.workpiece.thickness], Vector3::z() * axis(sensor).z)
            }
            (own, body, _) if own == body => ([sensor.x, sensor.y, sensor.z], axis(sensor)),
            _ => continue,
        };
        points.push(SensorPoint {
            name: name.clone(),
            position,
            direction: direction.into(),
        });
    }
    Ok(points)
}

/// Adds to an error the place in the design file of the sensor that caused it.
pub(crate) fn located(design: &Design, error: Error) -> Error {
    match error {
        Error::Body(BodyError::SensorOffBody { sensor, body, distance }) => match design.sensors.get(&sensor) {
            Some(found) => outside(design, &sensor, found, body, distance),
            None => BodyError::SensorOffBody { sensor, body, distance }.into(),
        },
        other => other,
    }
}

/// Names of the sensors on bodies that the design does not have.
pub(crate) fn without_body(design: &Design) -> Vec<&str> {
    let carried = carriers(design);
    let absent = design
        .sensors
        .iter()
        .filter(|(_, sensor)| !carried.contains(&sensor.body));
    absent.map(|(name, _)| name.as_str()).collect()
}

/// Names of the sensors whose band is limited by the modes of their body, and that limit \[Hz\].
pub(crate) fn limited(design: &Design) -> Vec<(&str, f64)> {
    let limited = present(design).filter_map(|(name, sensor)| {
        let top_hz = top_hz(design, sensor.body)?;
        (sensor.band_high > top_hz).then_some((name.as_str(), top_hz))
    });
    limited.collect()
}

/// The sensors on bodies that the design has, by name.
fn present(design: &Design) -> impl Iterator<Item = (&String, &Sensor)> {
    let carried = carriers(design);
    let sensors = design.sensors.iter();
    sensors.filter(move |(_, sensor)| carried.contains(&sensor.body))
}

/// Bodies that the design has.
fn carriers(design: &Design) -> Vec<Carrier> {
    let mut carriers = Vec::new();
    if has_housing(design) {
        carriers.push(Carrier::Tool);
    }
    if has_workpiece(design) {
        carriers.push(Carrier::Workpiece);
        carriers.extend(supports::of(design).carriers());
    }
    carriers
}

/// Top frequency of the modes of a body \[Hz\], above which modes and static corrections no longer describe its motion;
/// `None` for a rigid tool.
fn top_hz(design: &Design, body: Carrier) -> Option<f64> {
    let analysis = &design.analysis;
    match body {
        Carrier::Workpiece | Carrier::Sand => Some(analysis.workpiece_max_frequency),
        Carrier::Worktable => Some(analysis.worktable_max_frequency),
        Carrier::Tool => (design.body.model == BodyModel::Elastic).then_some(analysis.body_max_frequency),
    }
}

fn axis(sensor: &Sensor) -> Vector3<f64> {
    Vector3::new(sensor.along_x, sensor.along_y, sensor.along_z).normalize()
}

fn outside(design: &Design, name: &str, sensor: &Sensor, body: &'static str, distance: f64) -> Error {
    let point = [sensor.x, sensor.y, sensor.z];
    let problem = SensorProblem::Outside { body, point, distance };
    design.refuse_sensor(name, problem).into()
}

/// Distance of a point from the sand around the workpiece \[m\]; 0 if it is on the sand.
fn off_the_sand(law: &MovingSand, point: [f64; 2]) -> f64 {
    let beyond = |i: usize| (law.sand[i][0] - point[i]).max(point[i] - law.sand[i][1]).max(0.0);
    let box_gap = beyond(0).hypot(beyond(1));
    let depth = |i: usize| (point[i] - law.footprint[i][0]).min(law.footprint[i][1] - point[i]);
    box_gap.max(depth(0).min(depth(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_off_the_sand_is_measured_from_box_and_block() {
        let law = MovingSand {
            footprint: [[-0.2, 0.2], [-0.1, 0.1]],
            sand: [[-0.3, 0.3], [-0.3, 0.3]],
            shear_speed: 112.0,
            poisson_ratio: 0.3,
            loss_factor: 0.1,
            to_hz: 800.0,
        };
        assert_eq!(off_the_sand(&law, [0.25, 0.0]), 0.0);
        assert!((off_the_sand(&law, [0.15, 0.0]) - 0.05).abs() < 1e-12);
        assert!((off_the_sand(&law, [0.33, 0.34]) - 0.05).abs() < 1e-12);
    }
}
