//! Work on a separate thread: the interpreter continues, progress is passed to a callback, and Ctrl-C ends the work.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use nailnoise::calibration::{CalibrationError, Workers};
use nailnoise::stages::{Observer, Task};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::Refused;

/// Interval at which signals to the interpreter are checked.
const POLL: Duration = Duration::from_millis(20);

/// Tasks, or their results.
type Messages = Vec<Vec<u8>>;

/// A message to the thread of the interpreter.
enum Event {
    /// Progress for a callback: a kind (`stage`, `note` or `done`), a text, and items done of how many.
    Progress(&'static str, String, u64, u64),
    /// Tasks for the workers, and where their results go.
    Tasks(Messages, Sender<Messages>),
}

/// Callbacks in Python.
pub(crate) struct Callbacks {
    /// `report(kind, text, done, of)`.
    pub(crate) report: Option<Py<PyAny>>,
    /// `tasks(list of bytes)`, which returns their results as a list of bytes.
    pub(crate) tasks: Option<Py<PyAny>>,
}

/// Sends tasks to a callback in Python, by the thread of the interpreter.
pub(crate) struct CallbackWorkers {
    events: Mutex<Sender<Event>>,
    count: usize,
}

impl Workers for CallbackWorkers {
    fn count(&self) -> usize {
        self.count
    }

    fn results(&self, tasks: Messages) -> Result<Messages, CalibrationError> {
        let (sender, results) = channel();
        let sent = self
            .events
            .lock()
            .map(|events| events.send(Event::Tasks(tasks, sender)));
        // The callback has failed, or the interpreter was interrupted, if there are no results.
        let received = matches!(sent, Ok(Ok(()))).then(|| results.recv().ok()).flatten();
        received.ok_or(CalibrationError::NoResults)
    }
}

/// Sends progress to the thread of the interpreter, and ends the work that reports to it once it is cancelled.
struct Reporter {
    events: Mutex<Sender<Event>>,
    cancelled: Arc<AtomicBool>,
}

/// The payload of the unwinding that ends cancelled work. No panic hook sees it.
struct Cancelled;

impl Reporter {
    fn send(&self, kind: &'static str, text: String, done: u64, of: u64) {
        self.step();
        if let Ok(events) = self.events.lock() {
            // Nobody listens any more once the interpreter has been interrupted.
            let _ = events.send(Event::Progress(kind, text, done, of));
        }
    }
}

impl Observer for Reporter {
    fn stage(&self, name: &str) {
        self.send("stage", name.to_owned(), 0, 0);
    }

    fn note(&self, text: &str) {
        self.send("note", text.to_owned(), 0, 0);
    }

    fn done(&self, items: u64, of: u64) {
        self.send("done", String::new(), items, of);
    }

    fn step(&self) {
        if self.cancelled.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Cancelled));
        }
    }

    fn task(&self, task: &Task) {
        self.send("done", task.name.to_owned(), task.done, task.of);
    }
}

/// Does work on a thread without the interpreter's lock, and passes its progress on to `report(kind, text, done, of)`.
///
/// # Errors
/// Those of the work and of the callback. `KeyboardInterrupt` on Ctrl-C, after which the work ends at its next report.
pub(crate) fn off_the_lock<T: Send + 'static>(
    py: Python<'_>,
    report: Option<Py<PyAny>>,
    work: impl FnOnce(Arc<dyn Observer>) -> Result<T, Refused> + Send + 'static,
) -> PyResult<T> {
    let callbacks = Callbacks { report, tasks: None };
    with_workers(py, callbacks, 0, |observer, _| work(observer))
}

/// [`off_the_lock`] for work whose tasks go to `workers` workers by a callback. Without this callback, there are none.
///
/// # Errors
/// As [`off_the_lock`].
pub(crate) fn with_workers<T: Send + 'static>(
    py: Python<'_>,
    callbacks: Callbacks,
    workers: usize,
    work: impl FnOnce(Arc<dyn Observer>, Option<CallbackWorkers>) -> Result<T, Refused> + Send + 'static,
) -> PyResult<T> {
    let (sender, events) = channel();
    let cancelled = Arc::new(AtomicBool::new(false));
    let workers = callbacks.tasks.is_some().then(|| CallbackWorkers {
        events: Mutex::new(sender.clone()),
        count: workers,
    });
    let observer: Arc<dyn Observer> = Arc::new(Reporter {
        events: Mutex::new(sender),
        cancelled: Arc::clone(&cancelled),
    });
    let worker = thread::spawn(move || catch_unwind(AssertUnwindSafe(|| work(observer, workers))));
    let listened = listen(py, events, &callbacks);
    if listened.is_err() {
        cancelled.store(true, Ordering::Relaxed);
    }
    listened?;
    let ended = py.detach(|| worker.join());
    match ended.unwrap_or_else(Err) {
        Ok(done) => Ok(done?),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            Err(PyRuntimeError::new_err(format!(
                "nailnoise failed within: {}; this is a fault of the program",
                text.unwrap_or_else(|| "no message".to_owned())
            )))
        }
    }
}

/// Passes events on until the work drops its end.
fn listen(py: Python<'_>, events: Receiver<Event>, callbacks: &Callbacks) -> PyResult<()> {
    let events = Mutex::new(events);
    loop {
        let next = py.detach(|| {
            let events = events.lock().map_err(|_| RecvTimeoutError::Disconnected)?;
            events.recv_timeout(POLL)
        });
        match next {
            Ok(Event::Progress(kind, text, done, of)) => {
                if let Some(report) = &callbacks.report {
                    report.call1(py, (kind, text, done, of))?;
                }
            }
            Ok(Event::Tasks(tasks, results)) => {
                if let Some(compute) = &callbacks.tasks {
                    let tasks: Vec<_> = tasks.iter().map(|own| PyBytes::new(py, own)).collect();
                    // The work has ended if nobody waits for the results.
                    let _ = results.send(compute.call1(py, (tasks,))?.extract(py)?);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        py.check_signals()?;
    }
}
