//! Time of each stage of a run.

use std::time::Duration;

use serde::{Serialize, Serializer};

/// Wall time of each stage \[s\], excluding waits for other stages, in the order of completion; stages may overlap.
#[derive(Debug, Clone, Default)]
pub struct Timing(Vec<(&'static str, f64)>);

/// Name of the entry for the complete run.
const WHOLE: &str = "whole run";

impl Timing {
    /// Adds time to a stage.
    pub fn add(&mut self, stage: &'static str, time: Duration) {
        let seconds = time.as_secs_f64();
        match self.0.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, sum)) => *sum += seconds,
            None => self.0.push((stage, seconds)),
        }
    }

    /// Records the duration of the complete run.
    pub fn end(&mut self, whole: Duration) {
        self.add(WHOLE, whole);
    }

    /// Stages and their times \[s\].
    pub fn stages(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(stage, seconds)| (*stage, *seconds))
    }

    /// Duration of the complete run \[s\].
    pub fn whole(&self) -> f64 {
        self.stages()
            .filter(|(stage, _)| *stage == WHOLE)
            .map(|(_, seconds)| seconds)
            .sum()
    }
}

impl Serialize for Timing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(stage, seconds)| (stage, seconds)))
    }
}
