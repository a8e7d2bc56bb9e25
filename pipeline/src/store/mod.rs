//! Caches the results of expensive stages between runs, under the digest of everything they depend on.
//!
//! An entry is one file, named by its stage and by the SHA-256 of its inputs and of the program's sources; it contains
//! a checksum of its contents. Truncated, altered or foreign entries are detected, reported and recomputed. Values have
//! the same bytes on every machine. Files are written atomically, so that several processes may share a folder and a
//! killed process leaves no partial entry. When the folder exceeds its limit, the least recently used entries are
//! removed.

mod checksum;
mod claim;
mod entry;
mod error;
mod folder;
mod key;
mod replace;

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

pub use checksum::{Checksum, checksum};
pub use claim::Claim;
use claim::{Patience, Unclaimed};
pub use entry::Damage;
pub use error::{Obstacle, StoreError};
pub use folder::{LIMIT, Listed};
pub use key::{Digest, Key, hexadecimal};

use crate::codec::Codec;

/// The store for results of expensive stages; it may be absent.
#[derive(Debug, Clone, Default)]
pub struct Store {
    place: Option<Place>,
    /// Notes for the user: damaged entries, a folder that cannot be written.
    notes: Arc<Mutex<Vec<String>>>,
    /// Which once-per-run notes have already been made.
    noted: Arc<Noted>,
    /// Names of the entries that were read or written.
    used: Arc<Mutex<BTreeSet<String>>>,
}

/// Flags for notes made once per run, however often their cause occurs.
#[derive(Debug, Default)]
struct Noted {
    /// Results cannot be stored.
    unkept: AtomicBool,
    /// Another process computes the same entry.
    waiting: AtomicBool,
    /// An entry is computed without a claim.
    unclaimed: AtomicBool,
}

/// Time and size of an entry, by which a new entry is distinguished from an old one; none if it does not exist.
pub type Stamp = Option<(SystemTime, u64)>;

#[derive(Debug, Clone)]
struct Place {
    folder: PathBuf,
    /// Limit on the total size of all entries \[bytes\].
    limit: u64,
    /// Number of bytes that may be written before the next scan of the folder; none before the first scan.
    allowance: Arc<Mutex<Option<u64>>>,
}

impl Place {
    /// Enforces the size limit. A scan takes time for every entry, and a study writes thousands. The folder is
    /// therefore scanned only once the bytes written reach the free space or a sixteenth of the limit; other processes
    /// may write as much meanwhile.
    fn bound(&self, written: u64) -> std::io::Result<()> {
        let mut allowance = self.allowance.lock().unwrap_or_else(PoisonError::into_inner);
        *allowance = match allowance.and_then(|free| free.checked_sub(written)) {
            Some(free) => Some(free),
            None => {
                let used = folder::bound(&self.folder, self.limit)?;
                Some(self.limit.saturating_sub(used).min(self.limit / 16))
            }
        };
        Ok(())
    }
}

/// The key of an entry: the digest of the stage's key and of the code that determines the byte layout. Programs with
/// different layouts can thus share a folder without reading each other's entries.
fn in_this_layout(key: &Digest) -> Digest {
    Key::empty().with(env!("NAILNOISE_LAYOUT")).with(key).digest()
}

impl Store {
    /// A store that stores nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// The user's cache: `$NAILNOISE_CACHE`, else `$XDG_CACHE_HOME/nailnoise`, else `~/.cache/nailnoise` (on Windows
    /// `%LOCALAPPDATA%\nailnoise\cache`). Its limit is `$NAILNOISE_CACHE_LIMIT` GiB, else [`LIMIT`].
    ///
    /// # Errors
    /// [`StoreError`] if the environment names no folder, something other than a folder, or an invalid size.
    pub fn of_user() -> Result<Self, StoreError> {
        let (limit, path) = (folder::limit()?, folder::of_user()?);
        match folder::examine(&path) {
            Ok(()) => Ok(Self::at(path, limit)),
            Err(obstacle) => Err(StoreError::Unusable { path, obstacle }),
        }
    }

    /// A store without a size limit in a results folder named by the user, which is created if necessary.
    ///
    /// # Errors
    /// [`StoreError::NoStore`] if files cannot be written there.
    pub fn shared(path: &Path) -> Result<Self, StoreError> {
        Self::examined(path, u64::MAX, folder::occupy(path))
    }

    /// A store in a folder named by the user, with a size limit in bytes; the folder may be read-only.
    ///
    /// # Errors
    /// [`StoreError::NoStore`] if the path is not a folder.
    pub fn in_folder(path: &Path, limit: u64) -> Result<Self, StoreError> {
        Self::examined(path, limit, folder::examine(path))
    }

    fn examined(path: &Path, limit: u64, found: Result<(), Obstacle>) -> Result<Self, StoreError> {
        let path = path.to_owned();
        match found {
            Ok(()) => Ok(Self::at(path, limit)),
            Err(obstacle) => Err(StoreError::NoStore { path, obstacle }),
        }
    }

    /// A store in this folder with a size limit in bytes.
    pub fn at(folder: PathBuf, limit: u64) -> Self {
        Self {
            place: Some(Place {
                folder,
                limit,
                allowance: Arc::default(),
            }),
            notes: Arc::default(),
            noted: Arc::default(),
            used: Arc::default(),
        }
    }

    /// The folder; none if nothing is stored.
    pub fn folder(&self) -> Option<&Path> {
        self.place.as_ref().map(|store| store.folder.as_path())
    }

    /// Limit on the total size of all entries \[bytes\]; 0 if nothing is stored.
    pub fn limit(&self) -> u64 {
        self.place.as_ref().map_or(0, |store| store.limit)
    }

    /// Unwraps the value that was read, and turns damage into a note.
    fn undamaged<T>(&self, place: &Place, path: &Path, found: Result<Option<T>, Damage>) -> Option<T> {
        found.unwrap_or_else(|damage| {
            // If the folder itself has been replaced by something else, the entry is not damaged.
            if let Damage::Unreadable(source) = &damage
                && !place.folder.is_dir()
            {
                self.unkept(place, source);
                return None;
            }
            let remedy = match damage {
                Damage::NoFile(_) => "; `nailnoise cache verify` removes it",
                _ => "",
            };
            self.note(format!(
                "the cache entry {} {damage}; it is computed anew{remedy}",
                path.display()
            ));
            None
        })
    }

    /// A folder that cannot be written is reported once, not for every stage.
    fn unkept(&self, place: &Place, source: &std::io::Error) {
        if !self.noted.unkept.swap(true, Ordering::Relaxed) {
            self.note(format!(
                "results cannot be kept in {}: {source}; choose another folder with NAILNOISE_CACHE",
                place.folder.display()
            ));
        }
    }

    /// Loads the stored output of a stage; damage becomes a note.
    pub fn load<T, C: Codec<T>>(&self, stage: &str, key: &Digest) -> Option<T> {
        let key = &in_this_layout(key);
        let place = self.place.as_ref()?;
        let path = place.folder.join(entry::name(stage, key));
        let read = |from: &mut dyn Read, length| C::read(from, length);
        let found = self.undamaged(place, &path, entry::read_by(&path, key, read))?;
        let value = found.map_err(|error| {
            self.note(format!(
                "the cache entry {} {error}; it is computed anew",
                path.display()
            ))
        });
        value.ok().inspect(|_| self.count_as_used(&path))
    }

    /// Time of last use and size of a stage's entry.
    pub fn stamp(&self, stage: &str, key: &Digest) -> Stamp {
        let path = self
            .place
            .as_ref()?
            .folder
            .join(entry::name(stage, &in_this_layout(key)));
        let data = std::fs::metadata(path).ok()?;
        Some((data.modified().ok()?, data.len()))
    }

    /// Claims the computation of a stage's output; other processes respect the claim until it is dropped. Waits up to
    /// an hour while another process has it. None if nothing is stored, if the entry has changed since `before`, or if
    /// no claim can be made. `step` is called now and then while waiting; the first long wait and the first failure
    /// become notes.
    pub fn claim(&self, stage: &str, key: &Digest, before: Stamp, step: impl Fn()) -> Option<Claim> {
        let path = self
            .place
            .as_ref()?
            .folder
            .join(entry::name(stage, &in_this_layout(key)));
        let appeared = || self.stamp(stage, key) != before;
        let report = |cause| {
            if !self.noted.waiting.swap(true, Ordering::Relaxed) {
                self.note(cause);
            }
        };
        claim::wait(&path, Patience::USUAL, appeared, step, report).unwrap_or_else(|cause| {
            // If no file can be created, the output cannot be stored either, which is reported in another note.
            let is_noted = matches!(cause, Unclaimed::NotCreated { .. });
            if !is_noted && !self.noted.unclaimed.swap(true, Ordering::Relaxed) {
                self.note(format!("{cause}; the result is computed without waiting"));
            }
            None
        })
    }

    /// Names of the entries that were read or written since the last call, by this value and its clones.
    pub fn take_used(&self) -> Vec<String> {
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *used).into_iter().collect()
    }

    fn count_as_used(&self, path: &Path) {
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        used.extend(path.file_name().map(|name| name.to_string_lossy().into_owned()));
    }

    /// Stores the output of a stage; failures become notes.
    pub fn save<T, C: Codec<T>>(&self, stage: &str, key: &Digest, value: &T) {
        let Some(place) = &self.place else { return };
        let key = &in_this_layout(key);
        let path = place.folder.join(entry::name(stage, key));
        let written = entry::write_by(&path, key, |to| C::write(value, to)).and_then(|bytes| place.bound(bytes));
        match written {
            // The object with the entry's name was already reported when reading was attempted.
            Err(source) if source.kind() == ErrorKind::IsADirectory && path.is_dir() => {}
            Err(source) => self.unkept(place, &source),
            Ok(()) => self.count_as_used(&path),
        }
    }

    /// Marks an entry as used when it has served without being read.
    pub fn renew(&self, stage: &str, key: &Digest) {
        if let Some(place) = &self.place {
            entry::renew(&place.folder.join(entry::name(stage, &in_this_layout(key))));
        }
    }

    /// Returns and clears the notes for the user.
    pub fn take_notes(&self) -> Vec<String> {
        self.notes
            .lock()
            .map(|mut notes| std::mem::take(&mut *notes))
            .unwrap_or_default()
    }

    /// All entries, most recently used first.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn entries(&self) -> std::io::Result<Vec<Listed>> {
        self.folder().map_or_else(|| Ok(Vec::new()), folder::entries)
    }

    /// Folders, dangling links, pipes and the like that have the names of entries.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn obstacles(&self) -> std::io::Result<Vec<(PathBuf, Damage)>> {
        self.folder().map_or_else(|| Ok(Vec::new()), folder::obstacles)
    }

    /// Reads every entry completely; returns the damaged files and the [`obstacles`](Self::obstacles), with the fault
    /// of each.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn verify(&self) -> std::io::Result<Vec<(PathBuf, Damage)>> {
        let damaged = |listed: Listed| entry::verify(&listed.path).err().map(|damage| (listed.path, damage));
        let mut found: Vec<_> = self.entries()?.into_iter().filter_map(damaged).collect();
        found.extend(self.obstacles()?);
        Ok(found)
    }

    /// Removes an entry or the object with its name.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn remove(&self, path: &Path) -> std::io::Result<()> {
        folder::remove(path)
    }

    /// Whether an object may be removed: it was written by some version of this program, or it is an obstacle.
    pub fn is_own(&self, path: &Path) -> bool {
        entry::is_own(path)
    }

    /// Removes all entries and obstacles; returns the number of entries removed, and the files that have the name of an
    /// entry but not its contents. The latter are left in place because this program did not write them.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn clear(&self) -> std::io::Result<(usize, Vec<PathBuf>)> {
        let entries = self.entries()?.into_iter().map(|entry| entry.path);
        let (own, others): (Vec<PathBuf>, Vec<PathBuf>) = entries.partition(|path| entry::is_own(path));
        let obstacles = self.obstacles()?.into_iter().map(|(path, _)| path);
        let own: Vec<PathBuf> = own.into_iter().chain(obstacles).collect();
        own.iter().try_for_each(|path| folder::remove(path))?;
        Ok((own.len(), others))
    }

    fn note(&self, text: String) {
        if let Ok(mut notes) = self.notes.lock() {
            notes.push(text);
        }
    }
}
