//! Wall time of each stage, excluding the time spent waiting for other stages.

use std::cell::Cell;
use std::time::{Duration, Instant};

thread_local! {
    /// Time that this thread has spent waiting for other stages during the current one.
    static WAITED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

/// Measures the time of a stage itself.
pub(super) struct Stopwatch;

impl Stopwatch {
    /// Runs work; returns its value and its duration, less the time spent waiting for other stages.
    pub(super) fn run<T>(work: impl FnOnce() -> T) -> (T, Duration) {
        let before = WAITED.replace(Duration::ZERO);
        let start = Instant::now();
        let value = work();
        let whole = start.elapsed();
        let waited = WAITED.replace(before + whole);
        (value, whole.saturating_sub(waited))
    }

    /// Runs work whose time is charged to another stage.
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
