//! Performance and consumption of a shot, which show the costs of quieting a tool.

use nailnoise_dynamics::network::assembly::Fastener;
use nailnoise_dynamics::network::{Assembly, Record};
use nailnoise_dynamics::{Ambient, Crossing, NailerFigures, Parameters};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::stages::cycle::outflows;

/// Energy reserve, air consumption and rate of a shot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Performance {
    /// Depth of the nail's head below the surface \[m\]; negative if it protrudes, null for a tool without a fastener.
    pub head_depth_m: Option<f64>,
    /// Kinetic energy of the piston when the nail has penetrated its own length, which is the energy left at flush
    /// \[J\]; null if the nail is not driven that far.
    pub energy_left_j: Option<f64>,
    /// Air that leaves the tool, as a volume at ambient pressure and temperature \[m3\]; null for a tool from which no
    /// passage leads to the surroundings.
    pub air_m3: Option<f64>,
    /// Maximum number of shots per second: the reciprocal of the time from the trigger until the piston rests on the
    /// stop again, for an assembly until the event `finish` \[Hz\]; null if that does not occur.
    pub shots_per_second: Option<f64>,
}

impl Performance {
    /// The performance of a shot with these parameters.
    pub fn of(nailer: &NailerFigures, parameters: &Parameters) -> Self {
        let summary = &nailer.summary;
        let deep = |entry: &&nailnoise_dynamics::LogEntry| entry.crossing == Crossing::FullDepth && entry.is_rising();
        let flush = nailer.log.iter().find(deep).map(|entry| &entry.state);
        let kinetic = |velocity: f64| 0.5 * parameters.piston.mass * velocity.powi(2);
        let air = summary.exhaust_mass + summary.vent_mass + summary.leak_mass;
        let ambient = &parameters.ambient;
        Self {
            head_depth_m: Some(summary.head_depth),
            energy_left_j: flush.map(|state| kinetic(state.piston_velocity + state.tool_velocity)),
            air_m3: Some(free_volume(air, ambient)),
            shots_per_second: nailer.events.t18.map(f64::recip),
        }
    }

    /// The performance of an assembly's shot: that of its first fastener, of all flows to the surroundings, and of the
    /// event after which its record ends.
    pub fn of_assembly(record: &Record, assembly: &Assembly, ambient: &Ambient) -> Self {
        let finish = assembly.finish.as_ref().and_then(|own| assembly.events.get(own.event));
        let fastener = assembly.fasteners.first();
        Self {
            head_depth_m: fastener.and_then(|own| {
                let deepest = record.get(&format!("{}.deepest", own.name))?.last()?;
                Some(deepest - own.length)
            }),
            energy_left_j: fastener.and_then(|own| energy_at_flush(record, assembly, own)),
            air_m3: free_air(record, &outflows(assembly), ambient),
            shots_per_second: finish.and_then(|event| record.event(&event.name)).map(f64::recip),
        }
    }

    /// Name, value and unit of each figure in readable form; a missing value is `None`.
    pub(crate) fn figures(&self) -> [PerformanceFigure; 4] {
        let figure = |name, value: Option<f64>, unit, decimals| PerformanceFigure {
            name,
            value: value.map(|value| format!("{value:.decimals$}")),
            unit,
        };
        [
            figure(HEAD_DEPTH, self.head_depth_m.map(|depth| 1e3 * depth), "mm", 1),
            figure("energy left at flush", self.energy_left_j, "J", 1),
            figure("air a shot", self.air_m3.map(|air| 1e3 * air), "L", 2),
            figure("shots a second at most", self.shots_per_second, "", 1),
        ]
    }

    /// The figures in one line: `head 4.0 mm deep, 12.3 J left at flush, 1.92 L of air a shot, at most 12.4 shots a
    /// second`.
    pub(crate) fn in_words(&self) -> String {
        let left = self.energy_left_j.map(|left| format!("{left:.1} J left at flush"));
        let rate = self
            .shots_per_second
            .map(|rate| format!("at most {rate:.1} shots a second"));
        let air = self.air_m3.map(|air| format!("{:.2} L of air a shot", 1e3 * air));
        let all = [self.head_depth_m.map(head), left, air, rate];
        all.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// Free air that leaves a tool by these balances and signs \[m3\]; `None` without a balance.
pub(crate) fn free_air(record: &Record, outflows: &[(String, f64)], ambient: &Ambient) -> Option<f64> {
    let masses = outflows.iter().map(|(name, sign)| Some(sign * record.integral(name)?));
    let mass: Option<f64> = masses.sum();
    mass.filter(|_| !outflows.is_empty())
        .map(|mass| free_volume(mass, ambient))
}

/// Volume of a mass of air at ambient pressure and temperature \[m3\].
pub(crate) fn free_volume(mass: f64, ambient: &Ambient) -> f64 {
    mass * ambient.gas_constant * ambient.temperature / ambient.pressure
}

/// Kinetic energy of the body that drives a fastener when the tip has penetrated the fastener's length \[J\].
fn energy_at_flush(record: &Record, assembly: &Assembly, fastener: &Fastener) -> Option<f64> {
    let driver = assembly.bodies.get(fastener.driver)?;
    let depth = record.get(&format!("{}.deepest", fastener.name))?;
    let velocity = record.get(&format!("{}.velocity", driver.name))?;
    let after = depth.iter().position(|depth| *depth > fastener.length)?;
    let before = after.checked_sub(1)?;
    let share = (fastener.length - depth[before]) / (depth[after] - depth[before]);
    let speed = velocity[before] + share * (velocity[after] - velocity[before]);
    Some(0.5 * driver.mass * speed * speed)
}

const HEAD_DEPTH: &str = "head below the surface";

/// Text for the position of a nail's head: `head 4.0 mm deep`, or `head 0.3 mm proud` if it protrudes.
pub(crate) fn head(depth_m: f64) -> String {
    let side = if depth_m < 0.0 { "proud" } else { "deep" };
    format!("head {:.1} mm {side}", 1e3 * depth_m.abs())
}

/// Text for a pressure, from the absolute one and that of the air around \[Pa\]: `763 kPa absolute, 662 kPa gauge`.
pub(crate) fn pressures(absolute: f64, ambient: f64) -> String {
    format!(
        "{:.0} kPa absolute, {:.0} kPa gauge",
        1e-3 * absolute,
        1e-3 * (absolute - ambient)
    )
}

/// A figure of [`Performance`] for a table.
pub(crate) struct PerformanceFigure {
    /// Its name.
    pub(crate) name: &'static str,
    /// Its value in the unit; `None` if missing.
    pub(crate) value: Option<String>,
    /// The unit; empty for a rate.
    pub(crate) unit: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_protruding_head_stands_proud() {
        assert_eq!(head(0.004), "head 4.0 mm deep");
        assert_eq!(head(-0.0003), "head 0.3 mm proud");
    }

    #[test]
    fn figures_that_do_not_exist_are_left_out() {
        let none = Performance {
            head_depth_m: Some(-0.012),
            air_m3: Some(1.9e-3),
            ..Performance::default()
        };
        assert_eq!(none.in_words(), "head 12.0 mm proud, 1.90 L of air a shot");
        assert!(none.figures()[1].value.is_none());
    }
}
