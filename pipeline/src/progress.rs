//! Progress of a computation, for its observers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Receives the progress of stages that may run side by side.
pub trait Observer: Send + Sync {
    /// A stage begins.
    fn stage(&self, name: &str);
    /// A remark for the user to read with the result.
    fn note(&self, text: &str);
    /// So many items of the command's own work are done, of so many.
    fn done(&self, _items: u64, _of: u64) {}
    /// A long task of a stage has advanced.
    fn task(&self, _task: &Task) {}
    /// Work has advanced that reports no stages; called now and then, so that it can be ended.
    fn step(&self) {}
    /// Nothing more is to come.
    fn end(&self) {}
}

/// Passes on all but the beginnings of stages: for work that runs the same stages many times.
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
    /// The counted items.
    pub items: &'static str,
    /// How many items are done.
    pub done: u64,
    /// How many there are, as far as is known; 0 if unknown.
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
    /// Passes progress on to an observer.
    pub fn to(observer: Arc<dyn Observer>) -> Self {
        Self(observer)
    }

    /// Passes nothing on.
    pub fn silent() -> Self {
        Self(Arc::new(Silent))
    }

    /// Target of the progress.
    pub fn observer(&self) -> Arc<dyn Observer> {
        Arc::clone(&self.0)
    }

    /// A stage, or a step of one, begins.
    pub fn stage(&self, name: &str) {
        self.0.stage(name);
    }

    /// A remark for the user to read with the result.
    pub fn note(&self, text: &str) {
        self.0.note(text);
    }

    /// Nothing more is to come.
    pub fn end(&self) {
        self.0.end();
    }

    /// So many items of the command's own work are done, of so many.
    pub fn done(&self, items: u64, of: u64) {
        self.0.done(items, of);
    }

    /// Runs a task that reports how many `items` are done, and of how many (0 if unknown).
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

    /// Runs a task that reports the end of each item; `expected` is their number, as far as is known, else 0.
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
