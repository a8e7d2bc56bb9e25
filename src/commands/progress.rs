//! Progress on standard error: a spinner or a bar where somebody looks, a line a stage where nobody does, nothing if asked.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::pipeline::{Observer, Task};

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Shows nothing from now on.
pub(super) fn silence() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Shows the stages of a run while it works.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    /// One below the other: the stage, and a bar for each long task under way.
    lines: MultiProgress,
    tasks: Vec<(&'static str, ProgressBar)>,
    quiet: bool,
    since: Instant,
}

impl Progress {
    /// Progress for this process's standard error.
    pub(super) fn new() -> Self {
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
        Self {
            bar,
            lines,
            tasks: Vec::new(),
            quiet,
            since: Instant::now(),
        }
    }
}

impl Observer for Progress {
    fn stage(&mut self, name: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(name.to_owned()),
            None if self.quiet => {}
            None => eprintln!("[{:6.1} s] {name}", self.since.elapsed().as_secs_f64()),
        }
    }

    fn note(&mut self, text: &str) {
        match &self.bar {
            Some(_) => self.lines.suspend(|| eprintln!("note: {text}")),
            None if self.quiet => {}
            None => eprintln!("note: {text}"),
        }
    }

    fn done(&mut self, items: u64, of: u64) {
        let Some(bar) = &self.bar else { return };
        if bar.length() != Some(of) {
            if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {per_sec}, {eta} left") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_length(of);
        }
        bar.set_position(items);
    }

    fn task(&mut self, task: &Task) {
        if self.bar.is_none() {
            return;
        }
        let known = self.tasks.iter().position(|(name, _)| *name == task.name);
        if task.ended {
            if let Some(known) = known {
                let (_, bar) = self.tasks.remove(known);
                bar.finish_and_clear();
                self.lines.remove(&bar);
            }
            return;
        }
        let known = known.unwrap_or_else(|| {
            let bar = self.lines.add(ProgressBar::no_length().with_message(task.name));
            self.tasks.push((task.name, bar));
            self.tasks.len() - 1
        });
        let bar = &self.tasks[known].1;
        let of = (task.of > 0).then_some(task.of);
        if bar.length() != of || bar.position() == 0 {
            let template = match of {
                Some(_) => format!(
                    "  {{msg:24}} {{bar:30}} {{pos}}/{{len}} {}, {{per_sec}}, {{eta}} left",
                    task.items
                ),
                None => format!("  {{msg:24}} {{pos}} {}, {{per_sec}}, {{elapsed}}", task.items),
            };
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style.progress_chars("=> "));
            }
            of.into_iter().for_each(|of| bar.set_length(of));
        }
        bar.set_position(task.done);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        let tasks = self.tasks.iter().map(|(_, bar)| bar);
        tasks.chain(&self.bar).for_each(ProgressBar::finish_and_clear);
    }
}
