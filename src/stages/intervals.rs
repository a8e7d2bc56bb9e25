//! The intervals between adjacent events, for which levels of every source are given.

use nailnoise_acoustics::signals::IntervalLevels;
use nailnoise_dynamics::network::EventTime;
use serde::{Deserialize, Serialize};

use crate::result::IntervalLevel;

/// Sound of a source between two events.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Event at its start.
    pub from: String,
    /// Event at its end.
    pub to: String,
    /// Its ends, energies and levels.
    pub levels: IntervalLevels,
}

impl Interval {
    /// Its levels, in the form of a result.
    pub(super) fn in_result(&self) -> IntervalLevel {
        let own = &self.levels;
        let absorbed = own.energy < 0.0 || own.cut_energy < 0.0;
        IntervalLevel {
            from: self.from.clone(),
            to: self.to.clone(),
            from_s: own.from,
            to_s: own.to,
            lwa_db: own.lwa,
            lwa_cut_db: own.lwa_cut,
            energies_j: absorbed.then_some([own.energy, own.cut_energy]),
        }
    }
}

/// The events of a shot in chronological order: the edges of its intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct EventEdges {
    /// Names of events, then `end`.
    names: Vec<String>,
    /// \[s\], in ascending order.
    times: Vec<f64>,
}

impl EventEdges {
    /// The edges for a shot whose records last until `end` \[s\]. Events that do not occur are omitted.
    pub fn new(events: &[EventTime], end: f64) -> Self {
        let happened = events
            .iter()
            .filter_map(|event| Some((event.time?, event.name.clone())));
        let mut marks: Vec<(f64, String)> = happened.collect();
        // Stable: simultaneous events stay in the order of the tool.
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        if marks.first().is_none_or(|first| first.0 > 0.0) {
            marks.insert(0, (0.0, "start".to_owned()));
        }
        let last = marks.last().map_or(0.0, |last| last.0);
        marks.push((end.max(last), "end".to_owned()));
        let (times, names) = marks.into_iter().unzip();
        Self { names, times }
    }

    /// Times of the edges \[s\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Levels between these edges, with the names of the adjacent events.
    pub(super) fn named(&self, levels: &[IntervalLevels]) -> Vec<Interval> {
        let interval = |(names, levels): (&[String], &IntervalLevels)| Interval {
            from: names[0].clone(),
            to: names[1].clone(),
            levels: *levels,
        };
        self.names.windows(2).zip(levels).map(interval).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_in_the_order_of_their_times() {
        let event = |name: &str, time| EventTime {
            name: name.to_owned(),
            description: String::new(),
            time,
        };
        let events = [
            event("t0", Some(0.0)),
            event("t3", None),
            event("t9", Some(0.02)),
            event("t10", Some(0.01)),
        ];
        let edges = EventEdges::new(&events, 0.1);
        assert_eq!(edges.names, ["t0", "t10", "t9", "end"]);
        assert_eq!(edges.times, [0.0, 0.01, 0.02, 0.1]);
        let none = EventEdges::new(&[], 0.1);
        assert_eq!(none.names, ["start", "end"]);
    }
}
