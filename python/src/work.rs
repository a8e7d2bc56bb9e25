//! Work on a separate thread: the interpreter continues, progress is passed to a callback, and Ctrl-C ends the work.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use nailnoise::stages::{Observer, Task};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::Refused;

/// Interval at which signals to the interpreter are checked.
const POLL: Duration = Duration::from_millis(20);

/// The message to a callback: a kind (`stage`, `note` or `done`), a text, and items done of how many.
type Event = (&'static str, String, u64, u64);

/// Sends progress to the thread of the interpreter, and ends the work that reports to it once it is cancelled.
struct Reporter {
    events: Mutex<Sender<Event>>,
    cancelled: Arc<AtomicBool>,
}

/// The payload of the unwinding that ends cancelled work. No panic hook sees it.
struct Cancelled;

impl Reporter {
    fn send(&self, event: Event) {
        self.step();
        if let Ok(events) = self.events.lock() {
            // Nobody listens any more once the interpreter has been interrupted.
            let _ = events.send(event);
        }
    }
}

impl Observer for Reporter {
    fn stage(&self, name: &str) {
        self.send(("stage", name.to_owned(), 0, 0));
    }

    fn note(&self, text: &str) {
        self.send(("note", text.to_owned(), 0, 0));
    }

    fn done(&self, items: u64, of: u64) {
        self.send(("done", String::new(), items, of));
    }

    fn step(&self) {
        if self.cancelled.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Cancelled));
        }
    }

    fn task(&self, task: &Task) {
        self.send(("done", task.name.to_owned(), task.done, task.of));
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
    let (sender, events) = channel();
    let cancelled = Arc::new(AtomicBool::new(false));
    let observer: Arc<dyn Observer> = Arc::new(Reporter {
        events: Mutex::new(sender),
        cancelled: Arc::clone(&cancelled),
    });
    let worker = thread::spawn(move || catch_unwind(AssertUnwindSafe(|| work(observer))));
    let listened = listen(py, events, report.as_ref());
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
fn listen(py: Python<'_>, events: Receiver<Event>, report: Option<&Py<PyAny>>) -> PyResult<()> {
    let events = Mutex::new(events);
    loop {
        let next = py.detach(|| {
            let events = events.lock().map_err(|_| RecvTimeoutError::Disconnected)?;
            events.recv_timeout(POLL)
        });
        match next {
            Ok(event) => {
                if let Some(report) = report {
                    report.call1(py, event)?;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        py.check_signals()?;
    }
}
