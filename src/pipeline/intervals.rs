//! Which event makes which noise: levels of every source between neighbouring events, and its power over time.

use nailnoise_acoustics::levels::{PowerHistory, level_energy};
use nailnoise_dynamics::Events;

use super::sound::Source;
use crate::result::{Check, IntervalLevel, RankedSource};

/// Cells of the power histories \[s\].
const CELL: f64 = 1e-4;

/// Time shown before and after the records \[s\]: the ends of the range spread a sudden sound a little to both sides.
const MARGIN: f64 = 0.01;

/// Largest mismatch of a signal's bins with the spectrum's before they are matched, beside what a resistance may be off
/// between its samples, which its root is off as well: 0.04 dB.
const MISMATCH: f64 = 1e-2;

/// A source's A-weighted power over time, in the common range.
#[derive(Debug, Clone)]
pub struct SoundPower {
    /// Name of the source.
    pub source: String,
    /// Its power; the time of the cycle.
    pub history: PowerHistory,
}

/// The events of a shot in the order of their times.
pub(super) struct Clock {
    /// `t0` ..., then `end`.
    names: Vec<String>,
    /// \[s\], not falling.
    pub(super) times: Vec<f64>,
}

impl Clock {
    /// The clock of a shot whose records last until `end` \[s\]. Events that do not occur are left out.
    pub(super) fn new(events: &Events, end: f64) -> Self {
        let times = events.to_array();
        let mut marks: Vec<(f64, String)> = times
            .iter()
            .enumerate()
            .filter_map(|(i, time)| Some(((*time)?, format!("t{i}"))))
            .collect();
        // Stable, so that events at one time keep their numbers' order.
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        if marks.first().is_none_or(|first| first.0 > 0.0) {
            marks.insert(0, (0.0, "start".to_owned()));
        }
        let last = marks.last().map_or(0.0, |last| last.0);
        marks.push((end.max(last), "end".to_owned()));
        let (times, names) = marks.into_iter().unzip();
        Self { names, times }
    }
}

/// Gives every ranked source its intervals, and returns the powers over time with the checks of both; `tolerance` is that of
/// interpolated resistances.
pub(super) fn intervals(
    sources: &[&Source],
    ranking: &mut [RankedSource],
    clock: &Clock,
    end: f64,
    tolerance: f64,
) -> (Vec<SoundPower>, Vec<Check>) {
    let (mut powers, mut checks) = (Vec::new(), Vec::new());
    for ranked in ranking {
        let Some(source) = sources.iter().find(|own| own.spectrum.source == ranked.source) else {
            continue;
        };
        let levels = &source.intervals;
        let total = level_energy(ranked.lwa_db);
        let sum: f64 = levels.iter().map(|level| level.energy).sum();
        let gap = if total > 0.0 { sum / total - 1.0 } else { sum };
        checks.push(Check::at_most(
            format!("{}: intervals sum to the total", ranked.source),
            gap,
            1e-9,
        ));
        for (part, mismatch) in &source.mismatches {
            let name = format!("{part}: energy of interval signals beside the spectrum's");
            checks.push(Check::at_most(name, *mismatch, MISMATCH + tolerance));
        }
        let names = clock.names.windows(2);
        let interval = |(names, level): (&[String], &nailnoise_acoustics::levels::IntervalLevels)| IntervalLevel {
            from: names[0].clone(),
            to: names[1].clone(),
            from_s: level.from,
            to_s: level.to,
            lwa_db: level.lwa,
            lwa_cut_db: level.lwa_cut,
        };
        ranked.intervals = names.zip(levels).map(interval).collect();
        let cells = ((end + 2.0 * MARGIN) / CELL).ceil() as usize;
        powers.push(SoundPower {
            source: ranked.source.clone(),
            history: PowerHistory::sum(&source.histories, 0.5 * CELL - MARGIN, CELL, cells),
        });
    }
    (powers, checks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_stand_in_the_order_of_their_times() {
        let events = Events {
            t0: Some(0.0),
            t9: Some(0.02),
            t10: Some(0.01),
            ..Events::default()
        };
        let clock = Clock::new(&events, 0.1);
        assert_eq!(clock.names, ["t0", "t10", "t9", "end"]);
        assert_eq!(clock.times, [0.0, 0.01, 0.02, 0.1]);
        let none = Clock::new(&Events::default(), 0.1);
        assert_eq!(none.names, ["start", "end"]);
    }
}
