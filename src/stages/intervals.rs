//! The intervals between neighbouring events, for which levels of every source are given.

use nailnoise_acoustics::levels::IntervalLevels;
use nailnoise_dynamics::Events;

use crate::result::IntervalLevel;

/// The events of a shot in the order of their times: the edges of its intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct EventEdges {
    /// `t0` ..., then `end`.
    names: Vec<String>,
    /// \[s\], not falling.
    times: Vec<f64>,
}

impl EventEdges {
    /// The edges of a shot whose records last until `end` \[s\]. Events that do not occur are left out.
    pub fn new(events: &Events, end: f64) -> Self {
        let times = events.to_array();
        let mut marks: Vec<(f64, String)> = times
            .iter()
            .enumerate()
            .filter_map(|(i, time)| Some(((*time)?, format!("t{i}"))))
            .collect();
        // Stable: simultaneous events keep the order of their numbers.
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

    /// Levels between these edges, with the names of the events on either side.
    pub(super) fn named(&self, levels: &[IntervalLevels]) -> Vec<IntervalLevel> {
        let interval = |(names, level): (&[String], &IntervalLevels)| IntervalLevel {
            from: names[0].clone(),
            to: names[1].clone(),
            from_s: level.from,
            to_s: level.to,
            lwa_db: level.lwa,
            lwa_cut_db: level.lwa_cut,
        };
        self.names.windows(2).zip(levels).map(interval).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_in_the_order_of_their_times() {
        let events = Events {
            t0: Some(0.0),
            t9: Some(0.02),
            t10: Some(0.01),
            ..Events::default()
        };
        let edges = EventEdges::new(&events, 0.1);
        assert_eq!(edges.names, ["t0", "t10", "t9", "end"]);
        assert_eq!(edges.times, [0.0, 0.01, 0.02, 0.1]);
        let none = EventEdges::new(&Events::default(), 0.1);
        assert_eq!(none.names, ["start", "end"]);
    }
}
