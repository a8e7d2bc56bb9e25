//! Accelerometers of a design with their points on its bodies, and pressure transducers in its chambers.

use nailnoise_acoustics::radiation::flush_with_sand::MovingSand;
use nalgebra::Vector3;

use super::assembly::{has_housing, has_workpiece};
use crate::design::{BodyModel, Carrier, Design, Sensor, SensorProblem, Transducer};
use crate::error::Error;
use crate::model::supports;
use crate::stages::bodies::BodyError;
use crate::stages::bodies::SensorPoint;
use crate::stages::cycle::{AssembledCycle, BORE, RETURN_WALL};
use crate::stages::sensors::Accelerometer;
use crate::stages::transducers::{CYLINDER, Chamber, PressureTransducer, RETURN};

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

/// The pressure transducers in chambers that the tool has, by name.
///
/// # Errors
/// [`Problem::NoVolume`](crate::design::Problem::NoVolume) for a volume that the cycle does not have.
pub(crate) fn transducers(design: &Design) -> Result<Vec<PressureTransducer>, Error> {
    let tool = Chambers::of(design)?;
    let transducer = |(name, own): (&String, &Transducer)| {
        let chamber = tool.chamber(&own.chamber.0);
        if chamber.is_none() && !is_in_wall(own) {
            let mut known: Vec<&str> = tool.volumes.iter().map(String::as_str).collect();
            known.extend(tool.has_bore.then_some(CYLINDER));
            known.extend(tool.has_return.then_some(RETURN));
            return Some(Err(design.refuse_chamber(name, &own.chamber.0, &known).into()));
        }
        Some(Ok(PressureTransducer {
            name: name.clone(),
            chamber: chamber?,
            position: own.position,
            discharge_time: own.discharge_time,
        }))
    };
    design.transducers.iter().filter_map(transducer).collect()
}

/// Names of the transducers in a cylinder or return chamber that the tool does not have.
///
/// # Errors
/// The errors of the cycle's inputs.
pub(crate) fn without_chamber(design: &Design) -> Result<Vec<&str>, Error> {
    let tool = Chambers::of(design)?;
    let is_absent = |own: &Transducer| is_in_wall(own) && tool.chamber(&own.chamber.0).is_none();
    let absent = design.transducers.iter().filter(|(_, own)| is_absent(own));
    Ok(absent.map(|(name, _)| name.as_str()).collect())
}

/// Whether a transducer is in the wall of the cylinder or of the return chamber, which not every tool has.
fn is_in_wall(transducer: &Transducer) -> bool {
    matches!(transducer.chamber.0.as_str(), CYLINDER | RETURN)
}

/// Where a tool can have pressure transducers.
struct Chambers {
    /// Volumes of the cycle.
    volumes: Vec<String>,
    /// Whether the gas on both sides of the piston presses on the cylinder's wall.
    has_bore: bool,
    /// Whether gas presses on the wall of the return chamber.
    has_return: bool,
}

impl Chambers {
    /// The chamber of this name; `None` if the tool does not have it.
    fn chamber(&self, name: &str) -> Option<Chamber> {
        match name {
            CYLINDER if self.has_bore => Some(Chamber::Cylinder),
            RETURN if self.has_return => Some(Chamber::Return),
            volume => {
                let found = self.volumes.iter().find(|own| *own == volume)?;
                Some(Chamber::Volume(found.clone()))
            }
        }
    }

    fn of(design: &Design) -> Result<Self, Error> {
        /// Volumes of the tool of the keys.
        const OF_KEYS: [&str; 5] = ["above_piston", "below_piston", "return_volume", "above_valve", "supply"];
        let assembled = match design.transducers.is_empty() {
            true => None,
            false => super::assembly::cycle(design)?,
        };
        let Some(AssembledCycle { assembly, .. }) = assembled else {
            return Ok(Self {
                volumes: OF_KEYS.map(str::to_owned).to_vec(),
                has_bore: true,
                has_return: true,
            });
        };
        let has = |surface: &str| assembly.pressures.iter().any(|own| own.surface == surface);
        Ok(Self {
            has_bore: has(BORE),
            has_return: has(RETURN_WALL),
            volumes: assembly.volumes.into_iter().map(|own| own.name).collect(),
        })
    }
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
