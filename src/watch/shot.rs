//! Result of one run of a design, with the values needed for comparison.

use std::sync::Arc;

use crate::design::Design;
use crate::result::RunResult;
use crate::stages::headline::{Headline, unlike};

/// A finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct FinishedRun {
    /// Its number, starting at 1.
    pub number: u32,
    /// Its duration \[s\].
    pub seconds: f64,
    /// Every key with its value in a readable unit.
    pub values: Vec<(String, String)>,
    /// A-weighted levels of the total and of the sources in ranking order \[dB re 1 pW s\]; `None` if silent.
    pub levels: Vec<(String, Option<f64>)>,
    /// Failed checks.
    pub failed: Vec<String>,
    /// The headline of a shot that does not drive its nail.
    pub headline: Option<Headline>,
    /// Sound of all sources in front of the device, if any.
    pub sound: Option<Arc<Sound>>,
}

/// A recording of a run.
#[derive(Debug, PartialEq)]
pub struct Sound {
    /// A complete WAV file.
    pub wav: Vec<u8>,
    /// Pressure at its full scale \[Pa\].
    pub full_scale_pa: f64,
}

impl FinishedRun {
    /// The run of a design.
    pub fn new(number: u32, seconds: f64, design: &Design, result: &RunResult) -> Self {
        let sources = result.ranking.iter().map(|own| (own.source.clone(), own.lwa_db));
        let failed = result.checks.iter().filter(|check| !check.ok);
        Self {
            number,
            seconds,
            values: design.in_words(),
            levels: std::iter::once(("total".to_owned(), result.total.lwa_db))
                .chain(sources)
                .collect(),
            failed: failed.map(|check| check.name.clone().into_owned()).collect(),
            headline: result.headline.clone(),
            sound: None,
        }
    }

    /// Level of a source or of the total \[dB\].
    pub fn level(&self, name: &str) -> Option<f64> {
        self.levels.iter().find(|(own, _)| own == name)?.1
    }

    /// Differences between an earlier run and this one.
    pub fn differences(&self, before: &Self) -> Differences {
        let value = |shot: &Self, key: &str| {
            let own = shot.values.iter().find(|(own, _)| own == key);
            own.map(|(_, value)| value.clone())
        };
        let new = self.values.iter().map(|(key, _)| key);
        // Members of lists may be removed.
        let gone = before
            .values
            .iter()
            .map(|(key, _)| key)
            .filter(|key| value(self, key).is_none());
        let changed = new.chain(gone).filter_map(|key| {
            let [old, new] = [before, self].map(|shot| value(shot, key));
            let shown = |value: Option<String>| value.unwrap_or_else(|| "none".to_owned());
            (old != new).then(|| (key.clone(), shown(old), shown(new)))
        });
        let change = |(name, now): &(String, Option<f64>)| {
            let change = now.zip(before.level(name)).map(|(now, before)| now - before);
            (name.clone(), change)
        };
        let named = [before, self].map(|shot| (format!("run {}", shot.number), shot.headline.as_ref()));
        Differences {
            from: before.number,
            unlike: unlike(named.iter().map(|(name, headline)| (name.as_str(), *headline))),
            values: changed.collect(),
            levels: self.levels.iter().map(change).collect(),
        }
    }
}

/// Differences between two runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Differences {
    /// Number of the earlier run.
    pub from: u32,
    /// Reason why the levels must not be compared, if the shots have different outcomes.
    pub unlike: Option<String>,
    /// Keys with their previous and current values.
    pub values: Vec<(String, String, String)>,
    /// Changes of the levels of the total and of the sources \[dB\]; `None` if either is silent.
    pub levels: Vec<(String, Option<f64>)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot(number: u32, values: &[(&str, &str)], total: Option<f64>) -> FinishedRun {
        let values = values
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        FinishedRun {
            number,
            seconds: 1.0,
            values: values.collect(),
            levels: vec![("total".to_owned(), total)],
            failed: Vec::new(),
            headline: None,
            sound: None,
        }
    }

    #[test]
    fn values_that_change_come_and_go_are_named() {
        let before = shot(1, &[("a", "1 m"), ("b", "2"), ("gone", "3")], Some(100.0));
        let now = shot(2, &[("a", "4 m"), ("b", "2"), ("new", "5")], Some(98.5));
        let found = now.differences(&before);
        let named: Vec<_> = found
            .values
            .iter()
            .map(|(a, b, c)| (a.as_str(), b.as_str(), c.as_str()))
            .collect();
        assert_eq!(
            named,
            [("a", "1 m", "4 m"), ("new", "none", "5"), ("gone", "3", "none")]
        );
        assert_eq!(found.levels, [("total".to_owned(), Some(-1.5))]);
    }

    #[test]
    fn a_silent_level_has_no_change() {
        let found = shot(2, &[], None).differences(&shot(1, &[], Some(90.0)));
        assert_eq!(found.levels, [("total".to_owned(), None)]);
    }
}
