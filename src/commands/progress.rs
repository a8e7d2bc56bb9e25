//! Progress on standard error: a spinner and bars on a terminal, one line per stage elsewhere, nothing with `--quiet`.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use super::stage_words::in_words;
use super::{Shown, message};
use crate::stages::{Observer, Progress, Task};
use crate::units::Units;

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses progress from now on.
pub(super) fn silence() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Prints a remark of a command without progress.
pub(super) fn note(text: &str) {
    if !QUIET.load(Ordering::Relaxed) {
        message(&format!("note: {text}"));
    }
}

/// Remarks below a table, one per line; none with `--quiet`.
pub(super) fn noted(notes: &[String]) -> String {
    match QUIET.load(Ordering::Relaxed) {
        true => String::new(),
        false => notes.iter().map(|note| format!("  - {note}\n")).collect(),
    }
}

/// Progress on this process's standard error.
pub(crate) fn progress() -> Progress {
    progress_in(Units::Si)
}

impl Shown {
    /// Progress on standard error with remarks in these units.
    pub(super) fn progress(self) -> Progress {
        progress_in(self.units)
    }
}

/// The same with remarks in these units.
fn progress_in(units: Units) -> Progress {
    let quiet = QUIET.load(Ordering::Relaxed);
    let lines = MultiProgress::new();
    let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
        let bar = lines.add(ProgressBar::new_spinner());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        bar
    });
    Progress::to(Arc::new(Terminal {
        bar,
        lines,
        tasks: Mutex::default(),
        quiet,
        units,
        since: Instant::now(),
    }))
}

/// Shows the stages of a run as they proceed.
struct Terminal {
    bar: Option<ProgressBar>,
    /// One line for the stage, and a bar for each long task in progress.
    lines: MultiProgress,
    tasks: Mutex<Vec<(&'static str, ProgressBar)>>,
    quiet: bool,
    units: Units,
    since: Instant,
}

impl Observer for Terminal {
    fn stage(&self, name: &str) {
        let name = in_words(name);
        match &self.bar {
            Some(bar) => bar.set_message(name.to_owned()),
            None if self.quiet => {}
            None => message(&format!("[{:6.1} s] {name}", self.since.elapsed().as_secs_f64())),
        }
    }

    fn note(&self, text: &str) {
        let text = self.units.text(text);
        match &self.bar {
            Some(_) => self.lines.suspend(|| message(&format!("note: {text}"))),
            None if self.quiet => {}
            None => message(&format!("note: {text}")),
        }
    }

    fn done(&self, items: u64, of: u64) {
        let Some(bar) = &self.bar else { return };
        if bar.length() != Some(of) {
            if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {per_sec}, {eta} left") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_length(of);
        }
        bar.set_position(items);
    }

    fn task(&self, task: &Task) {
        if self.bar.is_none() {
            return;
        }
        let mut tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        let known = tasks.iter().position(|(name, _)| *name == task.name);
        if task.ended {
            if let Some(known) = known {
                let (_, bar) = tasks.remove(known);
                bar.finish_and_clear();
                self.lines.remove(&bar);
            }
            return;
        }
        let known = known.unwrap_or_else(|| {
            let bar = self
                .lines
                .add(ProgressBar::no_length().with_message(in_words(task.name)));
            tasks.push((task.name, bar));
            tasks.len() - 1
        });
        let bar = &tasks[known].1;
        let of = (task.of > 0).then_some(task.of);
        if bar.length() != of || bar.position() == 0 {
            let template = match of {
                Some(_) => format!(
                    "  {{msg:44}} {{bar:24}} {{pos}}/{{len}} {}, {{per_sec}}, {{eta}} left",
                    task.items
                ),
                None => format!("  {{msg:44}} {{pos}} {}, {{per_sec}}, {{elapsed}}", task.items),
            };
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style.progress_chars("=> "));
            }
            of.into_iter().for_each(|of| bar.set_length(of));
        }
        bar.set_position(task.done);
    }

    fn end(&self) {
        let tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        tasks
            .iter()
            .map(|(_, bar)| bar)
            .chain(&self.bar)
            .for_each(ProgressBar::finish_and_clear);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.end();
    }
}
