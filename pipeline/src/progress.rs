//! Reports the progress of a computation to observers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Receives the progress of stages, which may run in parallel.
pub trait Observer: Send + Sync {
    /// A stage starts.
    fn stage(&self, name: &str);
    /// A remark that the user should read with the result.
    fn note(&self, text: &str);
    /// The command itself has completed `items` of `of` items.
    fn done(&self, _items: u64, _of: u64) {}
    /// A long task of a stage has progressed.
    fn task(&self, _task: &Task) {}
    /// Called now and then during work without stages, so that it can be interrupted.
    fn step(&self) {}
    /// No further calls follow.
    fn end(&self) {}
}

/// Forwards everything but the start of stages, for work that runs the same stages many times.
pub struct WithoutStages(pub Arc<dyn Observer>);

impl Observer for WithoutStages {
    fn stage(&self, _: &str) {
        self.0.step();
    }

    fn note(&self, text: &str) {
        self.0.note(text);
    }

    fn done(&self, items: u64, of: u64) {
        self.0.done(items, of);
    }

    fn task(&self, task: &Task) {
        self.0.task(task);
    }

    fn step(&self) {
        self.0.step();
    }

    fn end(&self) {
        self.0.end();
    }
}

/// State of a long task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// Its name.
    pub name: &'static str,
    /// Name of the items counted.
    pub items: &'static str,
    /// Number of items done.
    pub done: u64,
    /// Total number of items, if known, else 0.
    pub of: u64,
    /// Whether the task has ended.
    pub ended: bool,
}

/// Ignores all progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn stage(&self, _: &str) {}
    fn note(&self, _: &str) {}
}

/// Progress of one stage, passed on to an [`Observer`].
#[derive(Clone)]
pub struct Progress(Arc<dyn Observer>);

impl Progress {
    /// Creates a progress that reports to an observer.
    pub fn to(observer: Arc<dyn Observer>) -> Self {
        Self(observer)
    }

    /// Creates a progress that reports nothing.
    pub fn silent() -> Self {
        Self(Arc::new(Silent))
    }

    /// The observer.
    pub fn observer(&self) -> Arc<dyn Observer> {
        Arc::clone(&self.0)
    }

    /// Reports the start of a stage or of a step within it.
    pub fn stage(&self, name: &str) {
        self.0.stage(name);
    }

    /// Reports a remark that the user should read with the result.
    pub fn note(&self, text: &str) {
        self.0.note(text);
    }

    /// Reports that nothing more follows.
    pub fn end(&self) {
        self.0.end();
    }

    /// Reports that the command itself has completed `items` of `of` items.
    pub fn done(&self, items: u64, of: u64) {
        self.0.done(items, of);
    }

    /// Runs a task that reports how many `items` are done and how many there are (0 if unknown).
    pub fn count<T>(
        &self,
        (name, items): (&'static str, &'static str),
        work: impl FnOnce(&(dyn Fn(u64, u64) + Sync)) -> T,
    ) -> T {
        let report = |done: u64, of: u64, ended: bool| {
            self.0.task(&Task {
                name,
                items,
                done,
                of,
                ended,
            });
        };
        let value = work(&|done, of| report(done, of, false));
        report(0, 0, true);
        value
    }

    /// Runs a task that reports each completed item; `expected` is their number, or 0 if unknown.
    pub fn count_each<T>(
        &self,
        task: (&'static str, &'static str),
        expected: u64,
        work: impl FnOnce(&(dyn Fn() + Sync)) -> T,
    ) -> T {
        let done = AtomicU64::new(0);
        self.count(task, |report| {
            work(&|| {
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                report(done, if expected > 0 { done.max(expected) } else { 0 });
            })
        })
    }
}
