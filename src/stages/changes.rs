//! Changes of events, figures and levels from the one-way to the two-way coupled run.

use std::borrow::Cow;

use nailnoise_acoustics::signals::{SourceSpectrum, Weighting, energy_level};
use nailnoise_dynamics::CouplingWork;

use super::cycle::{ShotRecord, SummaryFigures, figure_unit};
use crate::result::{Coupling, EventChange, FigureChange, LevelChange, RankedSource, Total};

/// Compares record and sources of the one-way run with record and levels of the two-way run.
pub fn changes(
    work: CouplingWork,
    (one_shot, one): (&ShotRecord, &[SourceSpectrum]),
    (two_shot, ranking, total): (&ShotRecord, &[RankedSource], &Total),
    range_hz: [f64; 2],
) -> Coupling {
    // The first event of the tool of the keys is the trigger, at the same time in both.
    let first = usize::from(one_shot.nailer.is_some());
    let events = one_shot.events.iter().skip(first);
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
            .map(|event| EventChange {
                event: event.name.clone(),
                one_way_s: event.time,
                two_way_s: two_shot.event(&event.name),
            })
            .collect(),
        figures: figures(&one_shot.figures)
            .into_iter()
            .map(|(figure, unit)| FigureChange {
                unit,
                one_way: one_shot.figures.get(&figure),
                two_way: two_shot.figures.get(&figure),
                figure,
            })
            .collect(),
        levels,
        work,
    }
}

/// Figures to compare, with their units: those of the tool of the keys that a support may change, or all of an
/// assembly.
fn figures(of: &SummaryFigures) -> Vec<(Cow<'static, str>, &'static str)> {
    match of {
        SummaryFigures::Keys(_) => FIGURES.map(|(figure, unit)| (Cow::Borrowed(figure), unit)).to_vec(),
        SummaryFigures::Assembly(all) => all
            .keys()
            .map(|figure| (Cow::Owned(figure.clone()), figure_unit(figure)))
            .collect(),
    }
}

/// Figures that a support may change, with their units.
const FIGURES: [(&str, &str); 8] = [
    ("mean_drive_speed", "m/s"),
    ("penetration", "m"),
    ("peak_penetration_force", "N"),
    ("peak_nose_force", "N"),
    ("peak_support_force", "N"),
    ("peak_bumper_force", "N"),
    ("peak_stopper_force", "N"),
    ("exhaust_mass", "kg"),
];
