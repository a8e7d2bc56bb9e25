//! Signals that request the process to end (Ctrl-C, `kill`, a closed terminal): half-written files are removed, and the
//! command ends with status 130. Signals of resource limits (`ulimit -t`, `ulimit -f`, out of memory) end the command
//! with a message and a separate status.

use std::io::Write as _;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nailnoise_meshes::temporary;

/// Exit status of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Last message of an interrupted command.
const ON_REQUEST: &str = "interrupted: nothing is left half-written, what was computed for later runs is kept";

/// Exit status of a command that a resource limit ended.
#[cfg(unix)]
const LIMITED: i32 = 2;

/// Exit status of a command that could not obtain memory.
#[cfg(unix)]
const FAILED: i32 = 3;

/// Whether the process has been interrupted.
static UNDER_WAY: AtomicBool = AtomicBool::new(false);

/// Held while files are moved to their final places together, and permanently by an interruption.
static PLACING: Mutex<()> = Mutex::new(());

/// Ends this process cleanly on SIGINT, SIGTERM or SIGHUP. Signals that the caller has set to be ignored stay ignored:
/// `nohup` does this with SIGHUP, and a shell with SIGINT for commands in the background.
#[cfg(unix)]
pub(crate) fn install() {
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM, SIGHUP, SIGXCPU]
        .into_iter()
        .filter(|signal| ignored & (1 << (signal - 1)) == 0);
    // Without a handler or a thread for it, the signals end the process at once; the next run removes the files left by
    // this one.
    if let Ok(mut signals) = Signals::new(wanted) {
        let handle = signals.handle();
        let serve = move || match signals.forever().next() {
            Some(SIGXCPU) => end(
                "error: the limit of processor time is reached (ulimit -t): nothing is left half-written, what was \
                 computed for \
                 later runs is kept",
                LIMITED,
            ),
            Some(_) => end(ON_REQUEST, INTERRUPTED),
            None => {}
        };
        if std::thread::Builder::new().spawn(serve).is_err() {
            handle.close();
        }
    }
    // With a handler, a file that would exceed `ulimit -f` causes a write error, which names the file.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    // If memory runs out, the standard library reports it and aborts.
    let _ = signal_hook::flag::register_conditional_shutdown(SIGABRT, FAILED, Arc::new(AtomicBool::new(true)));
}

/// Ends this process cleanly when it is interrupted.
#[cfg(not(unix))]
pub(crate) fn install() {
    // A second command in the same process finds the handler of the first one installed.
    let _ = ctrlc::set_handler(|| end(ON_REQUEST, INTERRUPTED));
}

/// The signals that this process ignores, one bit each; the lowest bit represents signal 1. Only Linux allows safe code
/// to query them.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

fn end(text: &str, status: i32) {
    // Files being moved to their places are completed; no others are started.
    let _placing = undisturbed();
    UNDER_WAY.store(true, Ordering::SeqCst);
    // A closed terminal accepts no message.
    let _ = writeln!(std::io::stderr(), "{text}");
    let _own = temporary::remove_all();
    std::process::exit(status);
}

/// While the guard exists, no interruption ends this process: for short work that must be done completely or not at
/// all.
pub(crate) fn undisturbed() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for an interruption in progress to end the process. A command whose folder is being removed fails, and that
/// failure is not reported.
pub(crate) fn give_way() {
    while UNDER_WAY.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
