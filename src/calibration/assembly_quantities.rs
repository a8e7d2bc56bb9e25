//! Quantities of the shot of a design's own assembly that a user can measure, named after its blocks and events.

use std::collections::BTreeSet;

use nailnoise_calibration::likelihood::Prediction;
use nailnoise_dynamics::Ambient;
use nailnoise_dynamics::network::assembly::Space;
use nailnoise_dynamics::network::{Assembly, Record};
use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{ENERGY, LENGTH, MASS, PRESSURE, TIME, VELOCITY, VOLUME};

use super::history::interpolated_clamped;
use super::spread::{self, Spread};
use crate::result::free_air;
use crate::sensitivity::AssemblyOutput;
use crate::stages::cycle::outflows;

/// Groups of figures that can be measured; forces inside the tool cannot, and times are measured as intervals.
const FIGURES: [&str; 3] = ["speed", "penetration", "masses"];

/// Name of the trigger pull as an event, at t = 0.
pub(super) const START: &str = "start";

/// When a value is read: at an event, or some time before or after it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AssemblyMoment {
    /// The event, or [`START`].
    pub(super) event: String,
    /// Time from the event \[s\].
    pub(super) after: f64,
}

impl AssemblyMoment {
    /// At an event.
    pub(super) fn event(event: &str) -> Self {
        Self {
            event: event.to_owned(),
            after: 0.0,
        }
    }

    /// At a time from the trigger pull \[s\].
    pub(super) fn time(after: f64) -> Self {
        Self {
            event: START.to_owned(),
            after,
        }
    }
}

/// A quantity that was measured.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AssemblyQuantity {
    /// A figure of the shot, such as `nail_depth` or `speed_before_nail`.
    Figure(AssemblyOutput),
    /// Free air that leaves the tool during one shot \[m3\].
    AirPerShot {
        /// Balances of the mass that leaves, and their signs.
        outflows: Vec<(String, f64)>,
        /// The volumes that discharge through openings.
        volumes: Vec<String>,
    },
    /// Time between two events \[s\].
    Interval { from: String, to: String },
    /// Travel of a body \[m\].
    Travel { body: String, at: AssemblyMoment },
    /// Absolute pressure of a volume \[Pa\].
    Pressure { volume: String, at: AssemblyMoment },
    /// Largest absolute pressure of a volume \[Pa\].
    PeakPressure { volume: String },
}

/// Figures of an assembly's shot that can be measured.
pub(super) fn figures(assembly: &Assembly) -> Vec<AssemblyOutput> {
    let mut all = AssemblyOutput::all(assembly);
    all.retain(|own| FIGURES.contains(&own.group));
    all
}

/// The air that leaves the tool; none without a passage to the surroundings.
pub(super) fn air_per_shot(assembly: &Assembly) -> Option<AssemblyQuantity> {
    let outflows = outflows(assembly);
    let passages = assembly
        .openings
        .iter()
        .filter_map(|own| assembly.passages.get(own.passage));
    let spaces = passages.flat_map(|passage| [passage.from, passage.to]);
    let volumes: BTreeSet<usize> = spaces
        .filter_map(|space| match space {
            Space::Volume(volume) => Some(volume),
            Space::Reservoir(_) => None,
        })
        .collect();
    let volumes = volumes
        .into_iter()
        .map(|own| assembly.volumes[own].name.clone())
        .collect();
    (!outflows.is_empty()).then_some(AssemblyQuantity::AirPerShot { outflows, volumes })
}

impl AssemblyQuantity {
    /// Its name in the file.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Figure(own) => &own.name,
            Self::AirPerShot { .. } => "air_per_shot",
            Self::Interval { .. } => "interval",
            Self::Travel { .. } => "travel",
            Self::Pressure { .. } => "pressure",
            Self::PeakPressure { .. } => "peak_pressure",
        }
    }

    /// Its dimension.
    pub(super) fn dimension(&self) -> Dimension {
        match self {
            Self::Figure(own) => match own.unit {
                "m/s" => VELOCITY,
                "kg" => MASS,
                "J" => ENERGY,
                "s" => TIME,
                _ => LENGTH,
            },
            Self::AirPerShot { .. } => VOLUME,
            Self::Interval { .. } => TIME,
            Self::Travel { .. } => LENGTH,
            Self::Pressure { .. } | Self::PeakPressure { .. } => PRESSURE,
        }
    }

    /// Whether it is never below 0.
    pub(super) fn is_positive(&self) -> bool {
        !matches!(self, Self::Figure(_) | Self::Travel { .. })
    }

    /// The time from the trigger pull at which it is read, if it is not read at an event \[s\].
    pub(super) fn time(&self) -> Option<f64> {
        let at = self.moment()?;
        (at.event == START).then_some(at.after)
    }

    /// The time from its event at which it is read \[s\].
    pub(super) fn offset(&self) -> f64 {
        self.moment().map_or(0.0, |at| at.after)
    }

    fn moment(&self) -> Option<&AssemblyMoment> {
        match self {
            Self::Travel { at, .. } | Self::Pressure { at, .. } => Some(at),
            _ => None,
        }
    }

    /// The same quantity, read some time after its moment \[s\].
    pub(super) fn after(mut self, time: f64) -> Self {
        if let Self::Travel { at, .. } | Self::Pressure { at, .. } = &mut self {
            at.after += time;
        }
        self
    }

    /// Model error: that of the same kind of quantity of the tool of the keys, for which measurements exist. Intervals
    /// and pressures have the largest error of their kind, because this tool has not been compared with measurements.
    pub(super) fn discrepancy(&self) -> Spread {
        match self {
            Self::Figure(own) if own.unit == "m" => spread::LENGTH_ERROR,
            Self::Figure(_) => spread::SPEED_ERROR,
            Self::AirPerShot { .. } => spread::GAS_ERROR,
            Self::Interval { .. } => Spread::new(0.05, 1e-4),
            Self::Travel { .. } => spread::LENGTH_ERROR,
            Self::Pressure { .. } | Self::PeakPressure { .. } => spread::PRESSURE_ABOVE_ERROR,
        }
    }

    /// Scatter of repeated shots, if the file does not state it.
    pub(super) fn scatter(&self) -> Spread {
        match self {
            Self::Figure(own) if own.unit == "m" => spread::DEPTH_SCATTER,
            Self::AirPerShot { .. } | Self::Pressure { .. } | Self::PeakPressure { .. } => spread::GAS_SCATTER,
            _ => spread::OTHER_SCATTER,
        }
    }

    /// The group of predictions with which it shares part of its model error.
    pub(super) fn family(&self) -> Option<String> {
        match self {
            Self::Figure(own) if own.unit == "m" => Some(own.name.clone()),
            _ => self.volume().map(|volume| format!("pressure.{volume}")),
        }
    }

    /// The volume whose pressure it is.
    pub(super) fn volume(&self) -> Option<&str> {
        match self {
            Self::Pressure { volume, .. } | Self::PeakPressure { volume } => Some(volume),
            _ => None,
        }
    }

    /// Its value in a shot. An event that has not occurred at the end of the record may still follow. The end is then a
    /// lower bound of the interval.
    pub(super) fn predict(&self, record: &Record, ambient: &Ambient) -> Prediction {
        let known = |value: Option<f64>| value.map_or(Prediction::Missing, Prediction::Value);
        let event = |name: &str| if name == START { Some(0.0) } else { record.event(name) };
        let sampled = |channel: String, at: &AssemblyMoment| {
            // A time from the trigger pull is within the longest record.
            let end = if at.event == START { f64::INFINITY } else { record.end };
            let value =
                |event: f64| interpolated_clamped(record.get(&channel)?, record.interval?, event + at.after, end);
            known(event(&at.event).and_then(value))
        };
        match self {
            Self::Figure(own) => known(own.of(record)),
            Self::AirPerShot { outflows, volumes } => match free_air(record, outflows, ambient) {
                Some(free) if !volumes.iter().all(|own| has_settled(record, own, ambient.pressure)) => {
                    Prediction::AtLeast(free)
                }
                other => known(other),
            },
            Self::Interval { from, to } => match (event(from), event(to)) {
                (Some(from), Some(to)) => Prediction::Value(to - from),
                (Some(from), None) => Prediction::AtLeast(record.end - from),
                _ => Prediction::Missing,
            },
            Self::Travel { body, at } => sampled(format!("{body}.travel"), at),
            Self::Pressure { volume, at } => sampled(format!("{volume}.pressure"), at),
            Self::PeakPressure { volume } => {
                let history = record.get(&format!("{volume}.pressure"));
                known(history.and_then(|own| own.iter().copied().reduce(f64::max)))
            }
        }
    }
}

/// Whether the pressure of a volume at the end of the record equals its initial pressure (as in a tool that is ready
/// again) or the ambient pressure (as in an empty vessel), within a fraction of its largest change.
fn has_settled(record: &Record, volume: &str, ambient: f64) -> bool {
    const SETTLED: f64 = 0.02;
    let Some(pressure) = record.get(&format!("{volume}.pressure")) else {
        return false;
    };
    let (Some(first), Some(last)) = (pressure.first(), pressure.last()) else {
        return false;
    };
    let change = pressure.iter().fold(0.0_f64, |most, own| most.max((own - first).abs()));
    [*first, ambient]
        .iter()
        .any(|rest| (last - rest).abs() <= SETTLED * change)
}

#[cfg(test)]
mod tests;
