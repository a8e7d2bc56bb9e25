//! Current content of the page, shared by the command that computes and the connections that wait for changes.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::shot::{Differences, FinishedRun};
use super::slider::{Slider, save};
use crate::design::Assignment;

/// The state of the page.
#[derive(Debug)]
pub struct Board {
    /// Name of the design.
    pub name: String,
    /// The design file.
    design: PathBuf,
    /// Values over those of the file, from the command line.
    set: Vec<Assignment>,
    state: Mutex<State>,
    news: Condvar,
}

/// Content of the page.
#[derive(Debug, Clone, Default)]
pub(super) struct State {
    /// Increases with every change.
    pub(super) version: u64,
    /// The work in progress; `None` when idle.
    pub(super) doing: Option<String>,
    /// The last successful run.
    pub(super) last: Option<Arc<FinishedRun>>,
    /// The run before it.
    pub(super) before: Option<Arc<FinishedRun>>,
    /// The run with which others are compared.
    pub(super) pinned: Option<Arc<FinishedRun>>,
    /// Reason why there is no result for the last saved version.
    pub(super) failure: Option<String>,
    /// Warnings for the user about the design of the last run.
    pub(super) warnings: Vec<String>,
    /// The report of the last run, and the number of reports so far.
    pub(super) report: Option<(u32, Arc<str>)>,
    /// The keys that the page can move.
    pub(super) sliders: Vec<Slider>,
    /// Basis on which these keys were chosen.
    pub(super) basis: String,
    /// Values that the page gave, the last one for each key.
    pub(super) moved: Vec<(String, Assignment)>,
    /// Counts the values that the page gave.
    pub(super) moves: u64,
    /// The design that was saved last, or why it could not be.
    pub(super) saved: Option<String>,
}

impl Board {
    /// Of a design file and values over it, without a result yet.
    pub fn new(design: &Path, set: &[Assignment]) -> Self {
        Self {
            name: design.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            design: design.to_owned(),
            set: set.to_vec(),
            state: Mutex::default(),
            news: Condvar::new(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the content of the page, and notifies all waiting connections.
    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        change(&mut state);
        state.version += 1;
        self.news.notify_all();
    }

    /// Sets the work in progress.
    pub fn begin(&self, what: &str) {
        self.change(|state| state.doing = Some(what.to_owned()));
    }

    /// Ends the work in progress.
    pub fn rest(&self) {
        self.change(|state| state.doing = None);
    }

    /// Shows a successful run; returns the changes since the one before it and since the pinned one.
    pub fn show(&self, shot: FinishedRun, warnings: Vec<String>, report: String) -> [Option<Differences>; 2] {
        let shot = Arc::new(shot);
        self.change(|state| {
            let number = state.report.as_ref().map_or(0, |(number, _)| *number);
            state.before = state.last.replace(shot);
            state.report = Some((number + 1, report.into()));
            (state.doing, state.failure, state.warnings) = (None, None, warnings);
        });
        self.state().differences()
    }

    /// Sets the complete report of the last run, with the intervals of its levels.
    pub fn complete(&self, report: String) {
        self.change(|state| {
            let number = state.report.as_ref().map_or(0, |(number, _)| *number);
            state.report = Some((number + 1, report.into()));
        });
    }

    /// Reports an error in the saved version; the last result remains.
    pub fn fail(&self, message: String) {
        self.change(|state| (state.doing, state.failure) = (None, Some(message)));
    }

    /// Starts or stops comparing later runs with the last one.
    pub fn pin(&self, pin: bool) {
        self.change(|state| state.pinned = state.last.clone().filter(|_| pin));
    }

    /// Offers sliders in place of earlier ones; `basis` states how these keys were chosen.
    pub fn offer(&self, sliders: Vec<Slider>, basis: &str) {
        self.change(|state| (state.sliders, state.basis) = (sliders, basis.to_owned()));
    }

    /// Moves a slider; returns whether the key has one and the value is in its range.
    pub(super) fn move_to(&self, key: &str, value: f64) -> bool {
        let mut moved = false;
        self.change(|state| {
            let slider = state.sliders.iter_mut().find(|own| own.key == key);
            let Some((slider, assignment)) = slider.and_then(|own| own.assign(value).map(|to| (own, to))) else {
                return;
            };
            slider.value = value;
            state.moved.retain(|(own, _)| own != key);
            state.moved.push((key.to_owned(), assignment));
            (state.moves, state.saved, moved) = (state.moves + 1, None, true);
        });
        moved
    }

    /// Discards the values set on the page.
    pub fn reset(&self) {
        self.change(|state| {
            // The next run offers sliders with the values of the file.
            state.sliders.clear();
            state.moved.clear();
            (state.moves, state.saved) = (state.moves + 1, None);
        });
    }

    /// Number of changes made on the page so far, and all values that override those of the file.
    pub fn moved(&self) -> (u64, Vec<Assignment>) {
        let state = self.state();
        let moved = state.moved.iter().map(|(_, assignment)| assignment.clone());
        (state.moves, self.set.iter().cloned().chain(moved).collect())
    }

    /// Number of changes made on the page so far.
    pub fn moves(&self) -> u64 {
        self.state().moves
    }

    /// Whether there are sliders.
    pub fn has_sliders(&self) -> bool {
        !self.state().sliders.is_empty()
    }

    /// Saves the design with the values set on the page, next to the design file.
    pub(super) fn save(&self) {
        let (_, values) = self.moved();
        let told = match save(&self.design, &values) {
            Ok(path) => format!("saved as {}", path.file_name().unwrap_or_default().to_string_lossy()),
            Err(error) => format!("not saved: {error}"),
        };
        self.change(|state| state.saved = Some(told));
    }

    /// The state as soon as its version differs from this one, or after a maximum time.
    pub(super) fn wait(&self, version: u64, most: Duration) -> State {
        let same = |state: &mut State| state.version == version;
        let waited = self.news.wait_timeout_while(self.state(), most, same);
        waited.unwrap_or_else(PoisonError::into_inner).0.clone()
    }

    /// The current state.
    pub(super) fn now(&self) -> State {
        self.state().clone()
    }

    /// Wakes all waiting connections.
    pub(super) fn wake(&self) {
        self.change(|_| {});
    }
}

impl State {
    /// Changes from the previous run to the last one, and from the pinned one.
    pub(super) fn differences(&self) -> [Option<Differences>; 2] {
        let pinned = self.pinned.as_ref();
        [self.before.as_ref(), pinned].map(|other| Some(self.last.as_ref()?.differences(other?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot(number: u32) -> FinishedRun {
        FinishedRun {
            number,
            seconds: 1.0,
            values: Vec::new(),
            levels: Vec::new(),
            failed: Vec::new(),
            headline: None,
            sound: None,
        }
    }

    #[test]
    fn a_failure_keeps_the_last_result_until_the_next() {
        let board = Board::new("own.toml".as_ref(), &[]);
        board.show(shot(1), Vec::new(), "one".to_owned());
        board.fail("wrong unit".to_owned());
        let state = board.now();
        assert_eq!(state.report, Some((1, "one".into())));
        assert_eq!(state.failure.as_deref(), Some("wrong unit"));
        board.show(shot(2), Vec::new(), "two".to_owned());
        assert_eq!(
            (board.now().failure, board.now().report),
            (None, Some((2, "two".into())))
        );
    }

    #[test]
    fn runs_are_compared_with_the_one_before_and_the_pinned_one() {
        let board = Board::new("own.toml".as_ref(), &[]);
        let from = |found: [Option<Differences>; 2]| found.map(|found| found.map(|found| found.from));
        assert_eq!(from(board.show(shot(1), Vec::new(), String::new())), [None, None]);
        board.pin(true);
        assert_eq!(from(board.show(shot(2), Vec::new(), String::new())), [Some(1), Some(1)]);
        assert_eq!(from(board.show(shot(3), Vec::new(), String::new())), [Some(2), Some(1)]);
        board.pin(false);
        assert_eq!(from(board.now().differences()), [Some(2), None]);
    }

    #[test]
    fn who_waits_is_woken_by_news_alone() {
        let board = Board::new("own.toml".as_ref(), &[]);
        let none = board.wait(0, Duration::from_millis(10));
        assert_eq!(none.version, 0);
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| board.wait(0, Duration::from_secs(60)).version);
            board.begin("modes");
            assert_eq!(waiting.join().ok(), Some(1));
        });
    }
}
