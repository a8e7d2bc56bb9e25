//! When the files of a design change: by their content, read again and again.
//!
//! Contents do not depend on how an editor saves: in place, by a new file of the same name, or by removing the old one
//! first. They are read instead of the system's events (crate `notify`), which are per folder, do not come from network
//! file systems and from outside of a container, and after which the contents would still have to be read. A design is
//! a handful of small files, which are read in less than a millisecond.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use nailnoise_documents::read_regular;

use crate::design::{Assignment, dependencies};
use crate::store::{Checksum, checksum};

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(40);

/// How long files must stay unchanged before they count as saved.
const QUIET: Duration = Duration::from_millis(60);

/// How long a file may be missing between its removal and its successor before it counts as removed.
const MISSING: Duration = Duration::from_millis(500);

/// How long an unending change is waited for.
const LONGEST: Duration = Duration::from_secs(2);

/// Files up to this size are read, larger ones (meshes) are known by time and size \[byte\].
const READ: u64 = 1 << 20;

/// State of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Stamp {
    Missing,
    Content(Checksum),
    Written(SystemTime, u64),
}

impl Stamp {
    fn of(path: &Path) -> Self {
        if let Ok(bytes) = read_regular(path, READ) {
            return Self::Content(checksum(&bytes));
        }
        fs::metadata(path).map_or(Self::Missing, |data| {
            Self::Written(data.modified().unwrap_or(SystemTime::UNIX_EPOCH), data.len())
        })
    }
}

/// The files of a design at one moment.
#[derive(Debug, Clone)]
pub struct Watched {
    files: Vec<PathBuf>,
    stamps: Vec<Stamp>,
}

impl Watched {
    /// The current files of a design. Content that is read later is this or newer: a change is never missed.
    pub fn new(design: &Path, assignments: &[Assignment]) -> Self {
        let mut files = dependencies(design, assignments);
        loop {
            let stamps = stamps(&files);
            // The content of the files determines which files there are.
            let again = dependencies(design, assignments);
            if again == files {
                return Self { files, stamps };
            }
            files = again;
        }
    }

    /// Whether a file has changed.
    pub fn changed(&self) -> bool {
        stamps(&self.files) != self.stamps
    }

    /// Waits for a change of the files, or until `other` happens.
    pub fn wait(&self, other: impl Fn() -> bool) {
        while !self.changed() && !other() {
            sleep(PAUSE);
        }
    }

    /// Waits until the files stay unchanged: a file that is being written is not read in part.
    pub fn settle(&self) {
        let since = Instant::now();
        let mut found = stamps(&self.files);
        loop {
            sleep(QUIET);
            let again = stamps(&self.files);
            let lost = again.iter().zip(&self.stamps);
            let lost = lost.filter(|(now, before)| **now == Stamp::Missing && **before != Stamp::Missing);
            let whole = lost.count() == 0 || since.elapsed() > MISSING;
            if again == found && whole || since.elapsed() > LONGEST {
                return;
            }
            found = again;
        }
    }
}

fn stamps(files: &[PathBuf]) -> Vec<Stamp> {
    files.iter().map(|path| Stamp::of(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    /// A folder with a design over a base.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("nailnoise-watched-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a folder for the test");
        put(&folder.join("base.toml"), "supply.pressure = \"90 psig\"\n");
        put(
            &folder.join("own.toml"),
            "base = \"base.toml\"\nbody.mesh = \"housing.step\"\n",
        );
        folder
    }

    fn put(path: &Path, text: &str) {
        fs::write(path, text).expect("a file for the test");
    }

    /// Whether the action of a test on a folder is a change.
    #[track_caller]
    fn is_seen(name: &str, change: impl FnOnce(&Path)) {
        let folder = folder(name);
        let watched = Watched::new(&folder.join("own.toml"), &[]);
        assert!(!watched.changed());
        change(&folder);
        assert!(watched.changed(), "{name}");
        watched.wait(|| false);
        watched.settle();
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn a_file_written_in_place_is_seen() {
        is_seen("place", |folder| {
            put(&folder.join("own.toml"), "base = \"base.toml\"\n")
        });
    }

    #[test]
    fn a_file_that_replaces_another_is_seen() {
        is_seen("rename", |folder| {
            put(&folder.join("own.toml~"), "base = \"base.toml\"\n");
            fs::rename(folder.join("own.toml~"), folder.join("own.toml")).expect("a rename");
        });
    }

    /// Same length, same time of modification.
    #[test]
    fn a_change_that_keeps_time_and_length_is_seen() {
        is_seen("time", |folder| {
            let path = folder.join("base.toml");
            let time = fs::metadata(&path).and_then(|data| data.modified()).expect("a time");
            let mut file = fs::File::create(&path).expect("a file");
            file.write_all(b"supply.pressure = \"80 psig\"\n").expect("a file");
            file.set_modified(time).expect("a time");
        });
    }

    #[test]
    fn files_that_appear_or_go_are_seen() {
        is_seen("appears", |folder| put(&folder.join("housing.step"), "ISO-10303-21;"));
        is_seen("goes", |folder| {
            fs::remove_file(folder.join("base.toml")).expect("a removal")
        });
    }

    /// The files of a broken design are unknown, except the design itself.
    #[test]
    fn a_broken_file_is_watched_until_it_is_whole() {
        let folder = folder("broken");
        let path = folder.join("own.toml");
        put(&path, "base = \"ba");
        let watched = Watched::new(&path, &[]);
        assert_eq!(watched.files, std::slice::from_ref(&path));
        put(&path, "base = \"base.toml\"\n");
        assert!(watched.changed());
        assert_eq!(Watched::new(&path, &[]).files.len(), 2);
        let _ = fs::remove_dir_all(folder);
    }
}
