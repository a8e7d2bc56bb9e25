//! Charts of a network cycle: pressures, motion, forces and flows of its blocks.

use nailnoise_dynamics::network::Record;

use super::chart::{Axis, Chart, Panel, Series, events};

/// A group of channels that share an axis.
struct Kind {
    quantity: &'static str,
    label: &'static str,
    unit: &'static str,
    factor: f64,
}

const PRESSURES: [Kind; 1] = [Kind {
    quantity: "pressure",
    label: "absolute pressure",
    unit: "kPa",
    factor: 1e-3,
}];
const MOTION: [Kind; 2] = [
    Kind {
        quantity: "travel",
        label: "travel from the parent, down",
        unit: "mm",
        factor: 1e3,
    },
    Kind {
        quantity: "speed",
        label: "speed from the parent, down",
        unit: "m/s",
        factor: 1.0,
    },
];
const FORCES: [Kind; 1] = [Kind {
    quantity: "force",
    label: "force",
    unit: "kN",
    factor: 1e-3,
}];
const FLOWS: [Kind; 1] = [Kind {
    quantity: "mass_flow",
    label: "mass flow",
    unit: "g/s",
    factor: 1e3,
}];

/// The charts of a cycle. `subject` names its tool and outcome.
pub fn network(subject: &str, record: &Record) -> Vec<Chart> {
    let Some(interval) = record.interval else {
        return Vec::new();
    };
    let samples = record.channels.first().map_or(0, |channel| channel.values.len());
    let time: Vec<f64> = (0..samples).map(|index| 1e3 * interval * index as f64).collect();
    let of = |name: &str, title: &'static str, caption: &str, kinds: &[Kind]| {
        let panels: Vec<Panel> = kinds.iter().filter_map(|kind| panel(record, &time, kind)).collect();
        (!panels.is_empty()).then(|| Chart {
            name: name.to_owned(),
            title,
            subject: subject.to_owned(),
            caption: caption.to_owned(),
            panels,
            events: events(&record.events),
        })
    };
    let charts = [
        of("pressures", "Pressures", "Pressure in each volume.", &PRESSURES),
        of(
            "motion",
            "Motion",
            "Travel and speed of each body from its parent.",
            &MOTION,
        ),
        of(
            "forces",
            "Forces",
            "Contacts, friction and fasteners: on the body against which they act; others: on their own body.",
            &FORCES,
        ),
        of(
            "flows",
            "Flows",
            "Mass flow of each passage, from its first to its second end.",
            &FLOWS,
        ),
    ];
    charts.into_iter().flatten().collect()
}

/// The channels of a kind that vary; `None` if none do.
fn panel(record: &Record, time: &[f64], kind: &Kind) -> Option<Panel> {
    let mut series = Vec::new();
    for channel in &record.channels {
        let Some((block, quantity)) = channel.name.split_once('.') else {
            continue;
        };
        let moves = channel.values.windows(2).any(|pair| pair[0] != pair[1]);
        if quantity == kind.quantity && moves {
            let values: Vec<f64> = channel.values.iter().map(|value| kind.factor * value).collect();
            series.push(Series::line(block.replace('_', " "), series.len(), time, &values));
        }
    }
    (!series.is_empty()).then(|| Panel {
        x: Axis::new("time", "ms", [0.0, time.last().copied().unwrap_or(1.0).max(1e-6)]),
        y: Axis::around(kind.label, kind.unit, &series),
        height: 60,
        series,
    })
}
