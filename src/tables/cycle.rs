//! Tables of a nailing cycle, the same for the terminal and the page.

use nailnoise_dynamics::Summary;
use nailnoise_dynamics::network::EventTime;

use super::{Column, Table, dash, fixed};
use crate::stages::cycle::event_in_words;
use crate::wording::figure;

/// Times of the events.
pub(crate) fn events(events: &[EventTime]) -> Table {
    let rows = events.iter().map(|event| {
        let words = event_in_words(&event.name, &event.description);
        // The descriptions of t0 to t18 are aligned.
        let words = match words.strip_prefix(&format!("{} ", event.name)) {
            Some(rest) => format!("{:<3} {rest}", event.name),
            None => words,
        };
        vec![words.into(), fixed(event.time.map(|time| 1e3 * time), 3).into()]
    });
    Table::new(
        [Column::words("event"), Column::number("time ms")],
        rows.collect::<Vec<_>>(),
    )
}

/// Figures of the shot in plain words, in the order of their times.
pub(crate) fn figures(own: &Summary) -> Table {
    let head = match own.head_depth {
        ..0.0 => "head stands proud by",
        _ => "head below the surface",
    };
    let some = |name, words, value| (name, words, Some(value));
    let figures = [
        (
            "speed_before_impact",
            "piston before it meets the nail",
            own.speed_before_impact,
        ),
        (
            "speed_after_impact",
            "piston after it has met the nail",
            own.speed_after_impact,
        ),
        ("mean_drive_speed", "mean speed of the drive", own.mean_drive_speed),
        ("full_penetration", "nail at full depth after", own.full_penetration),
        some("penetration", "deepest point of the tip", own.penetration),
        some("head_depth", head, own.head_depth.abs()),
        some(
            "peak_penetration_force",
            "largest resistance of the wood",
            own.peak_penetration_force,
        ),
        some("peak_cap_force", "largest force on the cap", own.peak_cap_force),
        some(
            "peak_seat_force",
            "largest force on the head valve\u{2019}s seat",
            own.peak_seat_force,
        ),
        some(
            "peak_bumper_force",
            "largest force on the bumper",
            own.peak_bumper_force,
        ),
        some(
            "peak_stopper_force",
            "largest force on the stopper",
            own.peak_stopper_force,
        ),
        some(
            "peak_support_force",
            "largest force on the support",
            own.peak_support_force,
        ),
        some("peak_nose_force", "largest force on the nose", own.peak_nose_force),
        some("supply_mass", "air in from the hose", own.supply_mass),
        some("exhaust_mass", "air out of the exhaust", own.exhaust_mass),
        some("vent_mass", "air out of the trigger vent", own.vent_mass),
        some("leak_mass", "air out of the rod guide", own.leak_mass),
        (
            "intake_choked_fraction",
            "intake choked, of its open time",
            own.intake_choked_fraction,
        ),
        (
            "exhaust_chamber_choked_fraction",
            "exhaust choked at the chamber, of its time",
            own.exhaust_chamber_choked_fraction,
        ),
        (
            "exhaust_choked_fraction",
            "exhaust choked at the holes, of its time",
            own.exhaust_choked_fraction,
        ),
        some(
            "cap_contacts",
            "contacts of the head valve with the cap",
            own.cap_contacts as f64,
        ),
        some(
            "seat_contacts",
            "contacts of the head valve with its seat",
            own.seat_contacts as f64,
        ),
    ];
    let row = |(name, words, value): (&str, &str, Option<f64>)| {
        vec![words.into(), dash(value, |value| figure(name, value)).into()]
    };
    Table::new(
        [Column::words("figure of the shot"), Column::number("value")],
        figures.map(row),
    )
}
