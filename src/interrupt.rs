//! Signals that request the process to end (Ctrl-C, `kill`, a closed terminal): half-written files are removed, and the
//! command ends with status 130. Signals of limits (`ulimit -t`, `ulimit -f`, no memory) end it with words and a
//! separate status.

use std::io::Write as _;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nailnoise_meshes::temporary;

/// Exit status of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Last words of an interrupted command.
const ON_REQUEST: &str = "interrupted: nothing is left half-written, what was computed for later runs is kept";

/// Exit status of a command that a limit of the system ended.
#[cfg(unix)]
const LIMITED: i32 = 2;

/// Exit status of a command that could not obtain memory.
#[cfg(unix)]
const FAILED: i32 = 3;

/// Whether the process has been interrupted.
static UNDER_WAY: AtomicBool = AtomicBool::new(false);

/// Held while files take their places together, and for good by an interruption.
static PLACING: Mutex<()> = Mutex::new(());

/// Ends this process cleanly on SIGINT, SIGTERM or SIGHUP. A signal that the caller has the process ignore stays
/// ignored: `nohup` does so with SIGHUP, and a shell with SIGINT for a command in the background.
#[cfg(unix)]
pub(crate) fn install() {
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM, SIGHUP, SIGXCPU]
        .into_iter()
        .filter(|signal| ignored & (1 << (signal - 1)) == 0);
    // Without a handler, or without a thread for it, the signals end the process at once; the next run removes the
    // files left by this one.
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
    // With a handler, a file that would exceed `ulimit -f` is an error of the write, which names the file.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    // Without memory the standard library reports it and aborts.
    let _ = signal_hook::flag::register_conditional_shutdown(SIGABRT, FAILED, Arc::new(AtomicBool::new(true)));
}

/// Ends this process cleanly when it is interrupted.
#[cfg(not(unix))]
pub(crate) fn install() {
    // A second command in the same process finds the first one's handler in place.
    let _ = ctrlc::set_handler(|| end(ON_REQUEST, INTERRUPTED));
}

/// The signals that this process ignores, one bit each, the lowest for signal 1. Only Linux lets safe code query them.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

fn end(text: &str, status: i32) {
    // Files that are taking their places come first; none begins to afterwards.
    let _placing = undisturbed();
    UNDER_WAY.store(true, Ordering::SeqCst);
    // A terminal that was closed takes no message.
    let _ = writeln!(std::io::stderr(), "{text}");
    let _own = temporary::remove_all();
    std::process::exit(status);
}

/// As long as the guard lives no interruption ends this process: for short work that must be done completely or not at
/// all.
pub(crate) fn undisturbed() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Leaves the end of the process to an interruption that is under way: a command whose folder is taken from it fails,
/// and that failure is not reported.
pub(crate) fn give_way() {
    while UNDER_WAY.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
