//! Ctrl-C: what is half-written goes, and the command ends with status 130.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Exit status of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Folders to be removed when the process is interrupted.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Ends this process cleanly when it is interrupted; only the first call has an effect.
pub(crate) fn install() {
    // A second command in the same process finds the first one's handler in place.
    let _ = ctrlc::set_handler(|| {
        let folders = std::mem::take(&mut *FOLDERS.lock().unwrap_or_else(PoisonError::into_inner));
        for folder in folders {
            // The run may write into it until the process ends: once more takes what came meanwhile.
            for _ in 0..3 {
                if std::fs::remove_dir_all(&folder).is_ok() {
                    break;
                }
            }
        }
        eprintln!("interrupted: nothing is left half-written, what was computed for later runs is kept");
        std::process::exit(INTERRUPTED);
    });
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
