//! Faults of the program itself: a panic in any thread ends the command with a message and a distinct status. If the
//! system refuses a thread, that is not a fault of the program; the command ends as for wrong usage.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook};
use std::sync::atomic::{AtomicBool, Ordering};

use super::message;

/// Exit status after a panic, the same for any Rust program.
const FAULT: u8 = 101;

/// Exit status if the system refuses threads.
const REFUSED: u8 = 2;

/// Start of panic messages in the standard library and elsewhere when the system refuses a thread or its stack.
const NO_THREAD: [&str; 3] = [
    "failed to spawn thread",
    "failed to allocate an alternative stack",
    "failed to set up alternative stack",
];

/// Whether the system has refused a thread.
static WITHOUT_THREAD: AtomicBool = AtomicBool::new(false);

/// Replaces panic output with messages from now on.
pub(super) fn install() {
    set_hook(Box::new(|fault| {
        if NO_THREAD.iter().any(|beginning| what(fault).starts_with(beginning)) {
            // Several threads may meet the limit at once.
            if !WITHOUT_THREAD.swap(true, Ordering::SeqCst) {
                message(&refused(what(fault)));
            }
        } else {
            message(&text(fault));
        }
    }));
}

/// Warns about a limit of the address space: if it is exceeded, the program ends without a message.
pub(super) fn announce_limits() {
    if let Some(gigabytes) = crate::cost::address_space() {
        message(&format!(
            "warning: the address space is limited to {gigabytes:.1} GB (ulimit -v); a command that exceeds it ends \
             with status 3"
        ));
    }
}

fn refused(reason: &str) -> String {
    format!(
        "error: {reason}\n  \
         The system permits no more threads or no more address space. Nothing is left half-written.\n  \
         help: choose a smaller --threads N, or raise the limit (ulimit -u, ulimit -v)"
    )
}

/// Returns the result of the work, or the exit status if it panicked. Files that the work had started to write are
/// removed.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, u8> {
    // Nothing produced by the work is used after a panic.
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| match WITHOUT_THREAD.load(Ordering::SeqCst) {
        true => REFUSED,
        false => FAULT,
    })
}

fn what<'a>(fault: &'a PanicHookInfo<'_>) -> &'a str {
    let payload = fault.payload();
    let what = payload.downcast_ref::<&str>().copied();
    let what = what.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    what.unwrap_or("no reason is known")
}

fn text(fault: &PanicHookInfo<'_>) -> String {
    let what = what(fault);
    let place = fault.location().map_or_else(String::new, |place| format!(" ({place})"));
    let mut text = format!(
        "error: nailnoise {} has a fault: {what}{place}\n  \
         The design may be right. Nothing is left half-written.\n  \
         help: report the command and the design; RUST_BACKTRACE=1 shows where the fault is",
        env!("CARGO_PKG_VERSION")
    );
    let trace = Backtrace::capture();
    if trace.status() == BacktraceStatus::Captured {
        text.push_str(&format!("\n{trace}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn work_that_ends_gives_its_result() {
        assert_eq!(caught(|| 3), Ok(3));
    }

    /// Thread pools and separate threads propagate their panic to the thread that waits for them.
    #[test]
    fn a_panic_in_any_thread_gives_the_status_of_a_fault() {
        let in_pool = || (0..8).into_par_iter().for_each(|n| assert!(n != 5, "of a pool"));
        let in_thread = || std::thread::scope(|scope| drop(scope.spawn(|| panic!("of its own"))));
        assert_eq!(caught(|| panic!("of the caller")), Err::<(), _>(FAULT));
        assert_eq!(caught(in_pool), Err(FAULT));
        assert_eq!(caught(in_thread), Err(FAULT));
    }
}
