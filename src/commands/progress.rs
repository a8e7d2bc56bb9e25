//! Progress on standard error: a spinner or a bar where somebody looks, a line a stage where nobody does, nothing if asked.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::pipeline::Observer;

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Shows nothing from now on.
pub(super) fn silence() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Shows the stages of a run while it works.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    since: Instant,
}

impl Progress {
    /// Progress for this process's standard error.
    pub(super) fn new() -> Self {
        let quiet = QUIET.load(Ordering::Relaxed);
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        Self {
            bar,
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
            Some(bar) => bar.suspend(|| eprintln!("note: {text}")),
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
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
