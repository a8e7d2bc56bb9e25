//! Ctrl-C: what is half-written goes, and the command ends with status 130.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Exit status of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Removals of a folder tried, the pause between them, and how often in a row it must be found gone.
const ATTEMPTS: usize = 400;
const PAUSE: Duration = Duration::from_millis(5);
const QUIET: usize = 3;

/// Folders to be removed when the process is interrupted.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the process has been interrupted.
static UNDER_WAY: AtomicBool = AtomicBool::new(false);

/// Held while files take their places together, and for good by an interruption.
static PLACING: Mutex<()> = Mutex::new(());

/// Ends this process cleanly when it is interrupted; only the first call has an effect.
pub(crate) fn install() {
    // A second command in the same process finds the first one's handler in place.
    let _ = ctrlc::set_handler(|| {
        // Files that are taking their places come first; none begins to afterwards.
        let _placing = undisturbed();
        UNDER_WAY.store(true, Ordering::SeqCst);
        eprintln!("interrupted: nothing is left half-written, what was computed for later runs is kept");
        // Locked for good: no run begins another folder.
        let folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        for folder in folders.iter() {
            // The run may write into it until the process ends: again until nothing comes any more.
            let mut gone = 0;
            for _ in 0..ATTEMPTS {
                let _ = std::fs::remove_dir_all(folder);
                gone = if folder.exists() { 0 } else { gone + 1 };
                if gone == QUIET {
                    break;
                }
                std::thread::sleep(PAUSE);
            }
        }
        std::process::exit(INTERRUPTED);
    });
}

/// As long as the guard lives no interruption ends this process: for what must be done whole or not at all, and is short.
pub(crate) fn undisturbed() -> MutexGuard<'static, ()> {
    PLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Leaves the end of the process to an interruption that is under way: a command whose folder is taken from it fails, and
/// that failure is none to be told.
pub(crate) fn give_way() {
    while UNDER_WAY.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// As long as this lives, an interruption removes the folder.
pub(crate) struct Cleaning(PathBuf);

impl Cleaning {
    pub(crate) fn of(folder: &Path) -> Self {
        let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        folders.push(folder.to_owned());
        Self(folder.to_owned())
    }
}

impl Drop for Cleaning {
    fn drop(&mut self) {
        let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        folders.retain(|folder| *folder != self.0);
    }
}
