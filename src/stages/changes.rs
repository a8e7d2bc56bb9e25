//! Changes of events, figures and levels from the one-way to the two-way coupled run.

use nailnoise_acoustics::signals::{SourceSpectrum, Weighting, energy_level};
use nailnoise_dynamics::{CouplingWork, CycleRecord, Summary};

use crate::result::{Coupling, EventChange, FigureChange, LevelChange, RankedSource, Total};

/// Compares record and sources of the one-way run with record and levels of the two-way run.
pub fn changes(
    work: CouplingWork,
    (one_record, one): (&CycleRecord, &[SourceSpectrum]),
    (two_record, ranking, total): (&CycleRecord, &[RankedSource], &Total),
    range_hz: [f64; 2],
) -> Coupling {
    let (before, after) = (one_record.events.to_array(), two_record.events.to_array());
    let events = before.into_iter().zip(after).enumerate().skip(1);
    let level = |name: &str, one_way_lwa_db, two_way_lwa_db| LevelChange {
        source: name.to_owned(),
        one_way_lwa_db,
        two_way_lwa_db,
    };
    let mut levels: Vec<LevelChange> = ranking
        .iter()
        .map(|source| {
            let other = one.iter().find(|other| other.source == source.source);
            let other = other.and_then(|other| other.level(range_hz, Weighting::A));
            level(&source.source, other, source.lwa_db)
        })
        .collect();
    let energy = one.iter().map(|source| source.energy(range_hz, Weighting::A)).sum();
    levels.push(level("total", energy_level(energy), total.lwa_db));
    Coupling {
        events: events
            .map(|(k, (one_way_s, two_way_s))| EventChange {
                event: format!("t{k}"),
                one_way_s,
                two_way_s,
            })
            .collect(),
        figures: FIGURES
            .iter()
            .map(|(figure, unit, of)| FigureChange {
                figure,
                unit,
                one_way: of(&one_record.summary),
                two_way: of(&two_record.summary),
            })
            .collect(),
        levels,
        work,
    }
}

type Figure = (&'static str, &'static str, fn(&Summary) -> Option<f64>);

/// Figures that a support may change.
const FIGURES: [Figure; 8] = [
    ("mean_drive_speed", "m/s", |s| s.mean_drive_speed),
    ("penetration", "m", |s| Some(s.penetration)),
    ("peak_penetration_force", "N", |s| Some(s.peak_penetration_force)),
    ("peak_nose_force", "N", |s| Some(s.peak_nose_force)),
    ("peak_support_force", "N", |s| Some(s.peak_support_force)),
    ("peak_bumper_force", "N", |s| Some(s.peak_bumper_force)),
    ("peak_stopper_force", "N", |s| Some(s.peak_stopper_force)),
    ("exhaust_mass", "kg", |s| Some(s.exhaust_mass)),
];
