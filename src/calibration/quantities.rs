//! Quantities of a shot that a user can measure: their names, predictions, and default errors of model and repeats.

use nailnoise_calibration::likelihood::Prediction;
use nailnoise_dynamics::{Ambient, CycleRecord};
use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{LENGTH, PRESSURE, TIME, VELOCITY, VOLUME};

use super::assembly_quantities::AssemblyQuantity;
use super::history::interpolated_clamped;
use super::shot::Shot;
use super::spread::{self, Spread};
use crate::result::free_volume;

/// Events whose times a user can state: t0 to t18.
const EVENTS: usize = 19;

/// First event of the return stroke; a missing one may lie beyond the record.
const RETURN: usize = 12;

/// Last event of the drive.
const DRIVEN: usize = 9;

/// End of a record of which only the drive is used \[s\].
pub(super) const END_OF_DRIVE: f64 = 45e-3;

/// Shortest record for quantities of the return stroke \[s\]: by 100 ms, the piston has not reached its stopper in half
/// of the draws that drive the nail.
const END_OF_RETURN: f64 = 115e-3;

/// A chamber of the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Chamber {
    AbovePiston,
    BelowPiston,
    Return,
    AboveValve,
    Supply,
}

impl Chamber {
    /// Names in the file.
    pub(super) const NAMES: [(&str, Self); 5] = [
        ("above_piston", Self::AbovePiston),
        ("below_piston", Self::BelowPiston),
        ("return_volume", Self::Return),
        ("above_valve", Self::AboveValve),
        ("supply", Self::Supply),
    ];

    /// Its name in the file, which is that of the volume.
    fn name(self) -> &'static str {
        let name = Self::NAMES.iter().find(|(_, own)| *own == self);
        name.map_or("", |(name, _)| name)
    }

    /// Its absolute pressure \[Pa\].
    fn pressure(self, record: &CycleRecord) -> &[f64] {
        record.history(&format!("{}.pressure", self.name()))
    }
}

/// When a value is read: at an event, or some time before or after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// The event; t0 is the trigger pull, at 0.
    pub(super) event: usize,
    /// Time from the event \[s\].
    pub(super) after: f64,
}

impl Moment {
    /// At an event.
    pub(super) const fn event(event: usize) -> Self {
        Self { event, after: 0.0 }
    }

    /// At a time from the trigger pull \[s\].
    pub(super) const fn time(after: f64) -> Self {
        Self { event: 0, after }
    }

    /// Its time from the trigger pull, if it does not depend on another event \[s\].
    fn fixed(self) -> Option<f64> {
        (self.event == 0).then_some(self.after)
    }

    /// The event that decides the length of the record: its own, or an event of the return stroke if it lies later.
    fn last_event(self) -> usize {
        if self.event > 0 && self.after <= 0.0 {
            self.event
        } else {
            self.event.max(RETURN)
        }
    }
}

/// The number of an event from its name, such as `t6`.
pub(super) fn event(name: &str) -> Option<usize> {
    name.strip_prefix('t')?.parse().ok().filter(|&number| number < EVENTS)
}

/// A quantity that was measured.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Quantity {
    /// Depth of the nail's head below the surface \[m\].
    HeadDepth,
    /// Free air that leaves the tool during one shot \[m3\].
    AirPerShot,
    /// Time between two events \[s\].
    Interval { from: usize, to: usize },
    /// Mean speed over the nail's length in the wood \[m/s\].
    MeanDriveSpeed,
    /// Speed of the piston before it meets the nail \[m/s\].
    SpeedBeforeImpact,
    /// Travel of the piston \[m\].
    PistonTravel(Moment),
    /// Absolute pressure of a chamber \[Pa\].
    Pressure(Chamber, Moment),
    /// Largest absolute pressure of a chamber \[Pa\].
    PeakPressure(Chamber),
    /// Drop of the supply pressure below its initial value \[Pa\].
    SupplyDrop,
    /// A quantity of a design's own assembly.
    OfAssembly(AssemblyQuantity),
}

/// Names of the quantities of the cycle of the tool of the keys.
pub(super) const NAMES: [&str; 9] = [
    "head_depth",
    "air_per_shot",
    "interval",
    "mean_drive_speed",
    "speed_before_impact",
    "piston_travel",
    "pressure",
    "peak_pressure",
    "supply_drop",
];

/// Groups of predictions with a common model error.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    HeadDepths,
    Pressures(Chamber),
    /// A group of quantities of an assembly, by its name.
    OfAssembly(String),
}

impl Family {
    /// Name of the shared error.
    pub(super) fn name(&self) -> String {
        match self {
            Self::OfAssembly(name) => format!("discrepancy.{name}"),
            Self::HeadDepths => "discrepancy.head_depth".to_owned(),
            Self::Pressures(chamber) => format!("discrepancy.pressure.{}", chamber.name()),
        }
    }
}

impl Quantity {
    /// Its name in the file.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::OfAssembly(own) => own.name(),
            Self::HeadDepth => NAMES[0],
            Self::AirPerShot => NAMES[1],
            Self::Interval { .. } => NAMES[2],
            Self::MeanDriveSpeed => NAMES[3],
            Self::SpeedBeforeImpact => NAMES[4],
            Self::PistonTravel(_) => NAMES[5],
            Self::Pressure(..) => NAMES[6],
            Self::PeakPressure(_) => NAMES[7],
            Self::SupplyDrop => NAMES[8],
        }
    }

    /// Its dimension.
    pub(super) fn dimension(&self) -> Dimension {
        match self {
            Self::OfAssembly(own) => own.dimension(),
            Self::HeadDepth | Self::PistonTravel(_) => LENGTH,
            Self::AirPerShot => VOLUME,
            Self::Interval { .. } => TIME,
            Self::MeanDriveSpeed | Self::SpeedBeforeImpact => VELOCITY,
            Self::Pressure(..) | Self::PeakPressure(_) | Self::SupplyDrop => PRESSURE,
        }
    }

    /// Whether it is never below 0.
    pub(super) fn is_positive(&self) -> bool {
        match self {
            Self::OfAssembly(own) => own.is_positive(),
            _ => !matches!(self, Self::HeadDepth | Self::PistonTravel(_)),
        }
    }

    /// The time from the trigger pull at which it is read, if it is not read at an event \[s\].
    pub(super) fn time(&self) -> Option<f64> {
        match self {
            Self::OfAssembly(own) => own.time(),
            Self::PistonTravel(moment) | Self::Pressure(_, moment) => moment.fixed(),
            _ => None,
        }
    }

    /// The time from its event at which it is read \[s\].
    pub(super) fn offset(&self) -> f64 {
        match self {
            Self::OfAssembly(own) => own.offset(),
            Self::PistonTravel(moment) | Self::Pressure(_, moment) => moment.after,
            _ => 0.0,
        }
    }

    /// Whether a gauge pressure is converted to an absolute one.
    pub(super) fn is_absolute_pressure(&self) -> bool {
        match self {
            Self::OfAssembly(own) => own.volume().is_some(),
            _ => matches!(self, Self::Pressure(..) | Self::PeakPressure(_)),
        }
    }

    /// Whether it is the air that a shot consumes.
    pub(super) fn is_air_consumption(&self) -> bool {
        matches!(
            self,
            Self::AirPerShot | Self::OfAssembly(AssemblyQuantity::AirPerShot { .. })
        )
    }

    /// Standard deviation of the model's error at a measured value.
    ///
    /// In published comparisons of the model, times differ by 2.6 % rms except for the drive, and pressures above the
    /// piston by 7.5 % rms. In the comparison with the N80CB (`docs/validation.md`), some figures are outside the
    /// interval that the ranges of its inputs give. Their error is the distance to that interval: 8 % for the mean
    /// speed, 0.25 ms for the drive. The values for depth, speed before impact and travel are estimates.
    pub(super) fn discrepancy(&self, value: f64) -> f64 {
        let share = |share: f64| Spread::new(share, 0.0).at(value);
        match self {
            Self::OfAssembly(own) => own.discrepancy().at(value),
            Self::HeadDepth | Self::PistonTravel(_) => spread::LENGTH_ERROR.at(value),
            Self::AirPerShot => spread::GAS_ERROR.at(value),
            Self::MeanDriveSpeed => share(0.08),
            Self::SpeedBeforeImpact => spread::SPEED_ERROR.at(value),
            Self::Interval { from, to } if [from, to].iter().any(|event| (RETURN..=RETURN + 1).contains(*event)) => {
                share(0.1).max(2e-3)
            }
            Self::Interval { to: DRIVEN, .. } => share(0.05).max(2.5e-4),
            Self::Interval { .. } => share(0.03).max(1e-4),
            Self::Pressure(Chamber::AbovePiston, _) | Self::PeakPressure(Chamber::AbovePiston) => {
                spread::PRESSURE_ABOVE_ERROR.at(value)
            }
            Self::Pressure(..) | Self::PeakPressure(_) | Self::SupplyDrop => spread::GAS_ERROR.at(value),
        }
    }

    /// Standard deviation between repeated shots at a measured value, if the file does not state it.
    pub(super) fn scatter(&self, value: f64) -> f64 {
        match self {
            Self::OfAssembly(own) => own.scatter().at(value),
            Self::HeadDepth => spread::DEPTH_SCATTER.at(value),
            Self::AirPerShot | Self::Pressure(..) | Self::PeakPressure(_) => spread::GAS_SCATTER.at(value),
            _ => spread::OTHER_SCATTER.at(value),
        }
    }

    /// The same quantity, read some time after its moment \[s\].
    pub(super) fn after(self, time: f64) -> Self {
        let later = |moment: Moment| Moment {
            after: moment.after + time,
            ..moment
        };
        match self {
            Self::OfAssembly(own) => Self::OfAssembly(own.after(time)),
            Self::PistonTravel(moment) => Self::PistonTravel(later(moment)),
            Self::Pressure(chamber, moment) => Self::Pressure(chamber, later(moment)),
            own => own,
        }
    }

    /// The group of predictions with which it shares part of its model error.
    pub(super) fn family(&self) -> Option<Family> {
        match self {
            Self::OfAssembly(own) => own.family().map(Family::OfAssembly),
            Self::HeadDepth => Some(Family::HeadDepths),
            Self::Pressure(chamber, _) | Self::PeakPressure(chamber) => Some(Family::Pressures(*chamber)),
            _ => None,
        }
    }

    /// Length of the record needed to read it, given that of the design \[s\].
    pub(super) fn end(&self, of_design: f64) -> f64 {
        let last = match self {
            // The record of an assembly ends as its file states.
            Self::OfAssembly(_) => return of_design,
            Self::HeadDepth | Self::MeanDriveSpeed | Self::SpeedBeforeImpact => DRIVEN,
            Self::Interval { to: event, .. } => *event,
            Self::PistonTravel(moment) | Self::Pressure(_, moment) => moment.last_event(),
            Self::AirPerShot => EVENTS,
            Self::PeakPressure(_) | Self::SupplyDrop => RETURN,
        };
        match last {
            ..=DRIVEN => of_design.min(END_OF_DRIVE),
            16.. => of_design.max(END_OF_RETURN),
            _ => of_design,
        }
    }

    /// Whether its prediction depends on the operator's hand and trigger.
    pub(super) fn depends_on_the_hand(&self) -> bool {
        matches!(self, Self::Interval { from, to }
            if [from, to].iter().any(|event| (RETURN..=RETURN + 1).contains(*event)))
    }

    /// Its value in a shot, which for the tool of the keys is recorded until `end` \[s\].
    pub(super) fn predict(&self, shot: &Shot, ambient: &Ambient, end: f64) -> Prediction {
        match (self, shot) {
            (Self::OfAssembly(own), Shot::Assembly(record)) => own.predict(record, ambient),
            (own, Shot::Keys(record)) => own.predict_of_keys(record, ambient, end),
            _ => Prediction::Missing,
        }
    }

    fn predict_of_keys(&self, record: &CycleRecord, ambient: &Ambient, end: f64) -> Prediction {
        let known = |value: Option<f64>| value.map_or(Prediction::Missing, Prediction::Value);
        let events = record.figures.events.to_array();
        let at = |moment: Moment| {
            moment
                .fixed()
                .or(events[moment.event].map(|event| event + moment.after))
        };
        let sampled = |values: &[f64], moment: Moment| {
            let value = |time: f64| interpolated_clamped(values, record.sample_interval(), time, end);
            known(at(moment).and_then(value))
        };
        match *self {
            Self::OfAssembly(_) => Prediction::Missing,
            Self::HeadDepth => Prediction::Value(record.figures.summary.head_depth),
            Self::MeanDriveSpeed => known(record.figures.summary.mean_drive_speed),
            Self::SpeedBeforeImpact => known(record.figures.summary.speed_before_impact),
            Self::AirPerShot => {
                let mass = record.figures.summary.exhaust_mass
                    + record.figures.summary.vent_mass
                    + record.figures.summary.leak_mass;
                let free = free_volume(mass, ambient);
                match events[17] {
                    Some(_) => Prediction::Value(free),
                    None => Prediction::AtLeast(free),
                }
            }
            Self::Interval { from, to } => match (events[from], events[to]) {
                (Some(from), Some(to)) => Prediction::Value(to - from),
                (Some(from), None) if to >= RETURN => Prediction::AtLeast(end - from),
                _ => Prediction::Missing,
            },
            Self::PistonTravel(moment) => sampled(record.history("piston.travel"), moment),
            Self::Pressure(chamber, moment) => sampled(chamber.pressure(record), moment),
            Self::PeakPressure(chamber) => known(chamber.pressure(record).iter().copied().reduce(f64::max)),
            Self::SupplyDrop => {
                let pressure = record.history("supply.pressure");
                let least = pressure.iter().copied().reduce(f64::min);
                known(pressure.first().zip(least).map(|(first, least)| first - least))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::chain;
    use crate::design::Design;

    fn shot() -> (CycleRecord, Ambient, f64) {
        let design = Design::shipped("n80cb.toml").unwrap();
        let record = chain::cycle(&design).unwrap();
        (record, design.ambient.clone(), design.analysis.cycle_end)
    }

    #[test]
    fn quantities_are_those_of_the_record() {
        let (record, ambient, end) = shot();
        let of = |quantity: Quantity| quantity.predict_of_keys(&record, &ambient, end);
        assert_eq!(
            of(Quantity::HeadDepth),
            Prediction::Value(record.figures.summary.head_depth)
        );
        let (t6, t9) = (record.figures.events.t6.unwrap(), record.figures.events.t9.unwrap());
        assert_eq!(of(Quantity::Interval { from: 6, to: 9 }), Prediction::Value(t9 - t6));
        let at_impact = of(Quantity::Pressure(Chamber::AbovePiston, Moment::event(9))).value();
        let nearest = record.history("above_piston.pressure")[(t9 / record.sample_interval()).round() as usize];
        assert!((at_impact / nearest - 1.0).abs() < 1e-3);
        assert!(of(Quantity::PeakPressure(Chamber::AbovePiston)).value() > at_impact);
        let drop = of(Quantity::SupplyDrop).value();
        assert!(drop > 0.0 && drop < record.history("supply.pressure")[0]);
        // Mass that leaves the tool, at an ambient density of 1.2 kg/m3.
        let air = of(Quantity::AirPerShot).value() * 1.2;
        assert!((air / (record.figures.summary.exhaust_mass + record.figures.summary.vent_mass) - 1.0).abs() < 0.05);
    }

    #[test]
    fn an_event_beyond_the_record_is_a_bound_and_one_that_does_not_happen_is_missing() {
        let (mut record, ambient, end) = shot();
        record.figures.events.t13 = None;
        record.figures.events.t9 = None;
        let of = |quantity: Quantity| quantity.predict_of_keys(&record, &ambient, end);
        let t6 = record.figures.events.t6.unwrap();
        assert_eq!(
            of(Quantity::Interval { from: 6, to: 13 }),
            Prediction::AtLeast(end - t6)
        );
        assert_eq!(of(Quantity::Interval { from: 6, to: 9 }), Prediction::Missing);
    }

    #[test]
    fn records_end_after_what_is_read() {
        let end = |quantity: Quantity| quantity.end(0.1);
        assert_eq!(end(Quantity::HeadDepth), END_OF_DRIVE);
        assert_eq!(end(Quantity::Interval { from: 6, to: 16 }), END_OF_RETURN);
        assert_eq!(end(Quantity::SupplyDrop), 0.1);
        let around = |event: usize, after: f64| end(Quantity::PistonTravel(Moment { event, after }));
        assert_eq!(around(9, -1e-3), END_OF_DRIVE);
        assert_eq!(around(9, 1e-3), 0.1);
        assert_eq!(around(16, 1e-3), END_OF_RETURN);
    }
}
