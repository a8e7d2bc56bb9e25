//! Figures of the shot that a calibration states before and after, of the tool of the keys or of an own assembly.

use nailnoise_dynamics::CycleRecord;
use nailnoise_dynamics::network::Assembly;

use super::assembly_quantities;
use super::shot::Shot;
use crate::sensitivity::AssemblyOutput;

/// A figure of a shot.
#[derive(Debug, Clone)]
pub(super) struct Figure {
    /// Its name.
    pub(super) name: String,
    /// SI unit.
    pub(super) unit: &'static str,
    read: Read,
}

/// Where a figure is in a record.
#[derive(Debug, Clone)]
enum Read {
    OfKeys(fn(&CycleRecord) -> Option<f64>),
    OfAssembly(AssemblyOutput),
}

impl Figure {
    /// The figures of an assembly; without one, those of the tool of the keys.
    pub(super) fn all(assembly: Option<&Assembly>) -> Vec<Self> {
        match assembly {
            Some(assembly) => {
                let figures = assembly_quantities::figures(assembly).into_iter();
                figures.map(Self::of_assembly).collect()
            }
            None => OF_KEYS.iter().map(Self::of_keys).collect(),
        }
    }

    fn of_assembly(own: AssemblyOutput) -> Self {
        Self {
            name: own.name.replace('_', " "),
            unit: own.unit,
            read: Read::OfAssembly(own),
        }
    }

    fn of_keys(own: &KeysFigure) -> Self {
        Self {
            name: own.name.to_owned(),
            unit: own.unit,
            read: Read::OfKeys(own.of),
        }
    }

    /// Its value; NaN if the shot does not have it.
    pub(super) fn of(&self, shot: &Shot) -> f64 {
        let value = match (&self.read, shot) {
            (Read::OfKeys(of), Shot::Keys(record)) => of(record),
            (Read::OfAssembly(own), Shot::Assembly(record)) => own.of(record),
            _ => None,
        };
        value.unwrap_or(f64::NAN)
    }
}

/// A figure of a shot of the tool of the keys.
struct KeysFigure {
    name: &'static str,
    unit: &'static str,
    of: fn(&CycleRecord) -> Option<f64>,
}

/// Figures of the shot that determine the sources: speed, energy and force for the workpiece, flow for the exhaust.
const OF_KEYS: [KeysFigure; 8] = [
    KeysFigure {
        name: "speed before impact",
        unit: "m/s",
        of: |own| own.figures.summary.speed_before_impact,
    },
    KeysFigure {
        name: "mean drive speed",
        unit: "m/s",
        of: |own| own.figures.summary.mean_drive_speed,
    },
    KeysFigure {
        name: "head depth",
        unit: "m",
        of: |own| Some(own.figures.summary.head_depth),
    },
    KeysFigure {
        name: "energy left at full depth",
        unit: "J",
        of: energy_left,
    },
    KeysFigure {
        name: "peak penetration force",
        unit: "N",
        of: |own| Some(own.figures.summary.peak_penetration_force),
    },
    KeysFigure {
        name: "air through the exhaust",
        unit: "kg",
        of: |own| Some(own.figures.summary.exhaust_mass),
    },
    KeysFigure {
        name: "peak exhaust flow",
        unit: "kg/s",
        of: |own| largest(own.history("exhaust.mass_flow")),
    },
    KeysFigure {
        name: "peak return pressure",
        unit: "Pa",
        of: |own| largest(own.history("return_volume.pressure")),
    },
];

fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::max)
}

/// Kinetic energy of piston and nail when the nail reaches its full depth \[J\].
fn energy_left(record: &CycleRecord) -> Option<f64> {
    let index = (record.figures.summary.full_penetration? / record.sample_interval()).round() as usize;
    let mass = record.history("piston.moving_mass").get(index)?;
    let speed = record.history("piston.velocity").get(index)?;
    Some(0.5 * mass * speed * speed)
}
