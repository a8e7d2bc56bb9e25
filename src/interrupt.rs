//! Signals that ask the process to end (Ctrl-C, `kill`, a closed terminal): what is half-written is removed, and the command
//! ends with status 130.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nailnoise_meshes::temporary;

/// Exit status of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Whether the process has been interrupted.
static UNDER_WAY: AtomicBool = AtomicBool::new(false);

/// Held while files take their places together, and for good by an interruption.
static PLACING: Mutex<()> = Mutex::new(());

/// Ends this process cleanly when SIGINT, SIGTERM or SIGHUP asks for it. A signal that the caller has the process ignore
/// stays ignored: `nohup` does so with SIGHUP, and a shell with SIGINT for a command in the background.
#[cfg(unix)]
pub(crate) fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| ignored & (1 << (signal - 1)) == 0);
    // Without a handler the signals end the process at once; the next run removes what this one leaves.
    if let Ok(mut signals) = Signals::new(wanted) {
        std::thread::spawn(move || {
            if signals.forever().next().is_some() {
                end();
            }
        });
    }
}

/// Ends this process cleanly when it is interrupted.
#[cfg(not(unix))]
pub(crate) fn install() {
    // A second command in the same process finds the first one's handler in place.
    let _ = ctrlc::set_handler(end);
}

/// The signals that this process ignores, one bit each, the lowest for signal 1. Only Linux lets safe code ask for them.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

fn end() {
    // Files that are taking their places come first; none begins to afterwards.
    let _placing = undisturbed();
    UNDER_WAY.store(true, Ordering::SeqCst);
    // A terminal that was closed takes no message.
    let text = "interrupted: nothing is left half-written, what was computed for later runs is kept";
    let _ = writeln!(std::io::stderr(), "{text}");
    let _own = temporary::remove_all();
    std::process::exit(INTERRUPTED);
}

/// As long as the guard lives no interruption ends this process: for what must be done whole or not at all, and is short.
pub(crate) fn undisturbed() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Leaves the end of the process to an interruption that is under way: a command whose folder is taken from it fails, and
/// that failure is not reported.
pub(crate) fn give_way() {
    while UNDER_WAY.load(Ordering::SeqCst) {
        std::thread::park();
    }
}
