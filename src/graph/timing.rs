//! Wall time of each stage, without that of the stages that it waits for.

use std::cell::Cell;
use std::time::{Duration, Instant};

use serde::{Serialize, Serializer, ser::SerializeMap};

/// Wall time of each stage \[s\], in the order in which they ended; some run side by side.
#[derive(Debug, Clone, Default)]
pub struct Timing(Vec<(String, f64)>);

impl Timing {
    /// Adds time to a stage.
    pub fn add(&mut self, stage: &str, time: Duration) {
        let seconds = time.as_secs_f64();
        match self.0.iter_mut().find(|(known, _)| known == stage) {
            Some((_, sum)) => *sum += seconds,
            None => self.0.push((stage.to_owned(), seconds)),
        }
    }

    /// Stages and their times \[s\].
    pub fn stages(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(stage, seconds)| (stage.as_str(), *seconds))
    }
}

impl Serialize for Timing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (stage, seconds) in &self.0 {
            map.serialize_entry(stage, seconds)?;
        }
        map.end()
    }
}

thread_local! {
    /// Time that this thread has spent waiting for other stages within the present one.
    static WAITED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// Measures the time that a stage takes for itself.
pub(super) struct Stopwatch;

impl Stopwatch {
    /// Runs work; returns its value and the time it took less the time it waited for other stages.
    pub(super) fn run<T>(work: impl FnOnce() -> T) -> (T, Duration) {
        let before = WAITED.replace(Duration::ZERO);
        let start = Instant::now();
        let value = work();
        let whole = start.elapsed();
        let waited = WAITED.replace(before + whole);
        (value, whole.saturating_sub(waited))
    }

    /// Runs work that another stage is charged for.
    pub(super) fn wait<T>(work: impl FnOnce() -> T) -> T {
        let before = WAITED.get();
        let start = Instant::now();
        let value = work();
        WAITED.set(before + start.elapsed());
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;

    #[test]
    fn a_stage_is_not_charged_for_the_stages_it_waits_for() {
        let pause = Duration::from_millis(20);
        let ((_, inner), outer) = Stopwatch::run(|| {
            sleep(pause);
            Stopwatch::run(|| sleep(5 * pause))
        });
        assert!(inner >= 5 * pause, "{inner:?}");
        assert!(outer >= pause && outer < 5 * pause, "{outer:?}");
    }
}
