//! The log of the shot: changes of the events' conditions and of blocks, in terms of the nailer.

use crate::network::{ConditionChange, LogEntry as Entry, Record};
use crate::{Crossing, Direction, LogEntry, LogState, Parameters};

/// Crossings that are conditions of events, and whether they rise when the condition becomes satisfied.
const CONDITIONS: [(&str, Crossing, bool); 18] = [
    ("t1", Crossing::FirstLift, true),
    ("t2", Crossing::ControlPressure, false),
    ("t3", Crossing::Intake, true),
    ("t4", Crossing::FirstTravel, true),
    ("t5", Crossing::RodAtNail, true),
    ("t6", Crossing::TipInWood, true),
    ("t7", Crossing::PositionMark, true),
    ("t8", Crossing::CheckHoles, true),
    ("t9", Crossing::Advance, false),
    ("t10", Crossing::PistonAtBumper, true),
    ("t11", Crossing::RestSpeed, false),
    ("t13", Crossing::ExhaustShut, false),
    ("t14", Crossing::StillSpeed, true),
    ("t16", Crossing::PistonOffStopper, false),
    ("t17", Crossing::ChamberPressure, false),
    ("full_depth", Crossing::FullDepth, true),
    ("landing", Crossing::Landing, true),
    ("chamber_choked", Crossing::ChamberChoked, true),
];

/// Crossings that are words of blocks: the block, the words that begin and end it.
const WORDS: [(&str, Crossing, &[&str], &[&str]); 14] = [
    ("bumper", Crossing::BumperContact, &["closes"], &["opens"]),
    ("stopper", Crossing::StopperContact, &["closes"], &["opens"]),
    ("cap", Crossing::CapContact, &["closes"], &["opens"]),
    ("seat", Crossing::SeatContact, &["closes"], &["opens"]),
    ("nose", Crossing::NoseContact, &["closes"], &["opens"]),
    ("support", Crossing::SupportContact, &["closes"], &["opens"]),
    ("guard", Crossing::Guard, &["closes"], &["opens"]),
    ("released", Crossing::Trigger, &["switches off"], &["switches on"]),
    ("nail", Crossing::NailDriven, &["struck"], &["left"]),
    ("nail", Crossing::Penetration, &["enters", "reloads"], &["unloads"]),
    ("vent", Crossing::Vent, &["gate opens"], &["gate shuts"]),
    ("fill", Crossing::Fill, &["gate opens"], &["gate shuts"]),
    ("intake", Crossing::IntakeUnchoked, &["unchoked"], &["choked"]),
    ("exhaust", Crossing::HolesChoked, &["choked"], &["unchoked"]),
];

/// Bodies whose reversals are in the log, and the channels of their velocities.
const REVERSALS: [(&str, Crossing, &str); 3] = [
    ("piston", Crossing::PistonReversal, "piston.speed"),
    ("head_valve", Crossing::ValveReversal, "head_valve.speed"),
    ("tool", Crossing::ToolReversal, "tool.velocity"),
];

/// All entries in chronological order.
pub(super) fn log(p: &Parameters, record: &Record) -> Vec<LogEntry> {
    let reader = StateReader::new(p, record);
    let entry = |time, crossing, rising, state: &[f64]| LogEntry {
        time,
        crossing,
        direction: Direction::new(rising),
        state: reader.read(state),
    };
    let of_condition = |change: &ConditionChange| {
        let (_, crossing, rises) = CONDITIONS.iter().find(|(event, ..)| *event == change.event)?;
        Some(entry(change.time, *crossing, change.satisfied == *rises, &change.state))
    };
    let of_word = |word: &Entry| {
        let found = WORDS.iter().find_map(|(block, crossing, begin, end)| {
            let named = |words: &[&str]| *block == word.block && words.contains(&word.word);
            let rising = named(begin);
            (rising || named(end)).then_some((*crossing, rising))
        });
        let reversal = || {
            let turned = word.word == "reverses";
            let (_, crossing, speed) = REVERSALS.iter().find(|(body, ..)| turned && *body == word.block)?;
            Some((*crossing, is_rising_after(record, speed, word.time)?))
        };
        let (crossing, rising) = found.or_else(reversal)?;
        Some(entry(word.time, crossing, rising, &word.state))
    };
    let mut entries: Vec<LogEntry> = record.condition_changes.iter().filter_map(of_condition).collect();
    entries.extend(record.log.iter().filter_map(of_word));
    let pulled = LogEntry {
        time: 0.0,
        crossing: Crossing::Trigger,
        direction: Direction::Rising,
        state: reader.start(record),
    };
    entries.push(pulled);
    entries.sort_by(|a, b| a.time.total_cmp(&b.time));
    entries
}

/// Whether a quantity is positive at the first sample after a time.
fn is_rising_after(record: &Record, channel: &str, time: f64) -> Option<bool> {
    let after = (time / record.interval?).floor() as usize + 1;
    Some(*record.get(channel)?.get(after)? > 0.0)
}

/// Places of quantities in a logged state.
struct StateReader<'p> {
    p: &'p Parameters,
    /// Position and velocity of piston, head valve, tool and workpiece.
    motions: [[Option<usize>; 2]; 4],
    pressures: [Option<usize>; 5],
    tip: Option<usize>,
}

impl<'p> StateReader<'p> {
    fn new(p: &'p Parameters, record: &Record) -> Self {
        let place = |block: &str, quantity: &str| {
            let name = format!("{block}.{quantity}");
            record.state_columns.iter().position(|column| column.name == name)
        };
        Self {
            p,
            motions: ["piston", "head_valve", "tool", "workpiece"]
                .map(|body| [place(body, "position"), place(body, "velocity")]),
            pressures: ["above_piston", "below_piston", "return_volume", "above_valve", "supply"]
                .map(|volume| place(volume, "pressure")),
            tip: place("nail", "tip"),
        }
    }

    fn read(&self, state: &[f64]) -> LogState {
        let at = |place: Option<usize>| place.and_then(|place| state.get(place)).copied().unwrap_or(0.0);
        let [piston, valve, tool, workpiece] = self.motions.map(|motion| motion.map(at));
        LogState {
            piston_travel: piston[0] - tool[0],
            piston_velocity: piston[1] - tool[1],
            valve_lift: self.p.head_valve.lift - (valve[0] - tool[0]),
            valve_velocity: tool[1] - valve[1],
            tool_rise: workpiece[0] - tool[0],
            tool_velocity: tool[1],
            tip_depth: at(self.tip),
            pressures: self.pressures.map(at),
        }
    }

    /// The state of the first sample.
    fn start(&self, record: &Record) -> LogState {
        let first = |name: &str| record.get(name).and_then(|history| history.first()).copied();
        let columns = record.state_columns.iter();
        let state: Vec<f64> = columns.map(|column| first(&column.name).unwrap_or(0.0)).collect();
        self.read(&state)
    }
}
