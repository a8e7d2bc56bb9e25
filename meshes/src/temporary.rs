//! Temporary folders that are removed when their process ends.
//!
//! The owner of a folder locks a file in it. The system releases the lock when the process ends, for whatever reason.
//! Any process that obtains the lock may therefore remove the folder. The next process thus removes the folders of
//! killed ones at once, even on a file system shared by several machines.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The locked file in a folder.
const LOCK: &str = "in-use";

/// On a file system without locks, a folder of this age or older counts as abandoned.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Number of attempts to remove a folder, the pause between them, and the number of consecutive checks that must find
/// it gone.
const ATTEMPTS: usize = 400;
const PAUSE: Duration = Duration::from_millis(5);
const QUIET: usize = 3;

/// The folders of this process.
static OWN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A folder that is removed when it is dropped.
#[derive(Debug)]
pub struct TemporaryFolder {
    path: PathBuf,
    /// Locked as long as the folder is in use.
    lock: Option<File>,
}

impl TemporaryFolder {
    /// Creates a folder under `parent` whose name begins with `prefix`, and removes similar folders left by ended
    /// processes.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn new(parent: &Path, prefix: &str) -> io::Result<Self> {
        sweep(parent, prefix);
        let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
        for number in 0..u32::MAX {
            let path = parent.join(format!("{prefix}{}-{number}", std::process::id()));
            match fs::create_dir(&path) {
                // The name is taken by another thread, a process on another machine, or another program.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                created => created?,
            }
            match occupy(&path) {
                Ok(Some(lock)) => {
                    own.push(path.clone());
                    let lock = Some(lock);
                    return Ok(Self { path, lock });
                }
                Ok(None) => {}
                Err(error) => {
                    let _ = fs::remove_dir_all(&path); // the first error is the one reported
                    return Err(error);
                }
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Leaves the folder and its contents to the user; returns its path. Without the lock file, no process considers it
    /// abandoned.
    pub fn leave(mut self) -> PathBuf {
        self.lock = None;
        let path = std::mem::take(&mut self.path);
        let _ = fs::remove_file(path.join(LOCK));
        let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
        own.retain(|folder| *folder != path);
        path
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // Some systems cannot remove an open file. Remains of the folder are harmless; a later process removes them.
        self.lock = None;
        if self.path.as_os_str().is_empty() {
            return; // left to the user
        }
        let _ = fs::remove_dir_all(&self.path);
        let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
        own.retain(|folder| *folder != self.path);
    }
}

/// Locks a new folder; none if another process removed it first.
fn occupy(folder: &Path) -> io::Result<Option<File>> {
    let path = folder.join(LOCK);
    let file = match File::create(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        created => created?,
    };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Ok(None),
        // On a file system without locks, the age of the folder decides.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(path.exists().then_some(file)),
    }
}

/// Removes folders of ended processes under `parent` whose names begin with `prefix`.
pub fn sweep(parent: &Path, prefix: &str) {
    for entry in fs::read_dir(parent).into_iter().flatten().flatten() {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_folder && entry.file_name().to_string_lossy().starts_with(prefix) {
            remove_abandoned(&entry.path());
        }
    }
}

/// Removes a folder that nobody uses. Whatever cannot be removed is left to a later process.
fn remove_abandoned(folder: &Path) {
    let lock = match File::options().read(true).write(true).open(folder.join(LOCK)) {
        Ok(lock) => lock,
        Err(error) => {
            // A process that ended before it created the lock file left an empty folder; any other folder is not ours.
            if error.kind() == ErrorKind::NotFound {
                let _ = fs::remove_dir(folder);
            }
            return;
        }
    };
    let abandoned = match lock.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => {
            let modified = fs::metadata(folder).and_then(|data| data.modified());
            modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > ABANDONED))
        }
    };
    if abandoned {
        let _ = fs::remove_dir_all(folder);
    }
}

/// Removes all folders of this process before it ends. No folder can be created while the guard exists.
pub fn remove_all() -> MutexGuard<'static, Vec<PathBuf>> {
    let own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
    for folder in own.iter() {
        // Other threads may still write to the folder, so removal is repeated until it stays gone.
        let mut gone = 0;
        for _ in 0..ATTEMPTS {
            let _ = fs::remove_dir_all(folder);
            gone = if folder.exists() { 0 } else { gone + 1 };
            if gone == QUIET {
                break;
            }
            std::thread::sleep(PAUSE);
        }
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parent(name: &str) -> PathBuf {
        let parent = std::env::temp_dir().join(format!("nailnoise-temporary-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&parent);
        fs::create_dir_all(&parent).expect("a folder for the test");
        parent
    }

    fn count(parent: &Path) -> usize {
        fs::read_dir(parent).map_or(0, Iterator::count)
    }

    #[test]
    fn a_folder_lives_as_long_as_its_value() -> io::Result<()> {
        let parent = parent("lives");
        let first = TemporaryFolder::new(&parent, "work-")?;
        let second = TemporaryFolder::new(&parent, "work-")?;
        assert!(first.path() != second.path() && first.path().is_dir() && second.path().is_dir());
        drop((first, second));
        assert_eq!(count(&parent), 0);
        fs::remove_dir(parent)
    }

    #[test]
    fn a_folder_without_its_owner_is_removed_at_once() -> io::Result<()> {
        let parent = parent("abandoned");
        let owned = TemporaryFolder::new(&parent, "work-")?;
        // Remains of a killed process: the lock file without a lock.
        let left = parent.join("work-1-0");
        fs::create_dir(&left)?;
        fs::write(left.join(LOCK), "")?;
        fs::write(left.join("half"), "half of a file")?;
        fs::create_dir(parent.join("work-1-1"))?;
        sweep(&parent, "work-");
        assert!(owned.path().is_dir());
        assert_eq!(count(&parent), 1);
        fs::remove_dir_all(parent)
    }

    #[test]
    fn a_folder_that_is_left_to_the_user_is_not_swept() -> io::Result<()> {
        let parent = parent("left");
        let folder = TemporaryFolder::new(&parent, "work-")?;
        fs::write(folder.path().join("old"), "old")?;
        let place = folder.leave();
        sweep(&parent, "work-");
        assert_eq!(fs::read_to_string(place.join("old"))?, "old");
        fs::remove_dir_all(parent)
    }

    #[test]
    fn a_folder_of_somebody_else_is_left_alone() -> io::Result<()> {
        let parent = parent("foreign");
        fs::create_dir(parent.join("work-of-mine"))?;
        fs::write(parent.join("work-of-mine/notes"), "mine")?;
        fs::write(parent.join("work-file"), "mine")?;
        sweep(&parent, "work-");
        assert_eq!(count(&parent), 2);
        fs::remove_dir_all(parent)
    }
}
