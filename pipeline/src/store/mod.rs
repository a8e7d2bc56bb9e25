//! Results of expensive stages, stored from run to run under the digest of everything they depend on.
//!
//! An entry is one file, named by its stage and by the SHA-256 of its inputs and of the sources of this program; it
//! contains the checksum of its content. Truncated, altered or foreign entries are noticed, reported and computed anew.
//! Values have the same bytes on every machine. Files are written completely, so that several processes may share a
//! folder and a killed one leaves nothing half-written. The least recently used entries go first when the folder
//! outgrows its limit.

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

/// The store for results of expensive stages, if any.
#[derive(Debug, Clone, Default)]
pub struct Store {
    place: Option<Place>,
    /// Notes for the user: damaged entries, a folder that cannot be written.
    notes: Arc<Mutex<Vec<String>>>,
    /// Which notes there have been that are worth one a run.
    noted: Arc<Noted>,
    /// Names of the entries that were read or written.
    used: Arc<Mutex<BTreeSet<String>>>,
}

/// Notes that are taken once however often their cause occurs.
#[derive(Debug, Default)]
struct Noted {
    /// Nothing can be stored.
    unkept: AtomicBool,
    /// Another process computes the same.
    waiting: AtomicBool,
    /// An entry is computed without a claim.
    unclaimed: AtomicBool,
}

/// An entry's time and size, which distinguish a new one from an old one; none if the entry does not exist.
pub type Stamp = Option<(SystemTime, u64)>;

#[derive(Debug, Clone)]
struct Place {
    folder: PathBuf,
    /// Bytes that all entries may take together.
    limit: u64,
    /// Bytes that may be written before the folder is scanned again; none before the first scan.
    allowance: Arc<Mutex<Option<u64>>>,
}

impl Place {
    /// Bounds the folder by its limit. A scan costs time for every entry, and a study writes thousands. Thus the folder
    /// is scanned once the bytes written reach the free space or a sixteenth of the limit, which other processes may
    /// write meanwhile.
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

/// The key of an entry: that of the stage's output, and the code that lays values out in bytes. Programs that lay them
/// out differently share a folder without reading each other's entries.
fn in_this_layout(key: &Digest) -> Digest {
    Key::empty().with(env!("NAILNOISE_LAYOUT")).with(key).digest()
}

impl Store {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// The user's own: `$NAILNOISE_CACHE`, else `$XDG_CACHE_HOME/nailnoise`, else `~/.cache/nailnoise` (on Windows
    /// `%LOCALAPPDATA%\nailnoise\cache`); at most
    /// `$NAILNOISE_CACHE_LIMIT` GiB, else [`LIMIT`].
    ///
    /// # Errors
    /// [`StoreError`] where the environment names no folder, something else than a folder, or no size.
    pub fn of_user() -> Result<Self, StoreError> {
        let (limit, path) = (folder::limit()?, folder::of_user()?);
        match folder::examine(&path) {
            Ok(()) => Ok(Self::at(path, limit)),
            Err(obstacle) => Err(StoreError::Unusable { path, obstacle }),
        }
    }

    /// In a folder that the user named for results, and that has no limit; it is created if it does not exist.
    ///
    /// # Errors
    /// [`StoreError::NoStore`] where no files can be written in it.
    pub fn shared(path: &Path) -> Result<Self, StoreError> {
        Self::examined(path, u64::MAX, folder::occupy(path))
    }

    /// In a folder that the user named, with this many bytes at most; files may be read-only there.
    ///
    /// # Errors
    /// [`StoreError::NoStore`] if it is not a folder.
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

    /// In this folder, with this many bytes at most.
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

    /// Bytes that all entries may take together; 0 if nothing is stored.
    pub fn limit(&self) -> u64 {
        self.place.as_ref().map_or(0, |store| store.limit)
    }

    /// The value that was read; damage becomes a note.
    fn undamaged<T>(&self, place: &Place, path: &Path, found: Result<Option<T>, Damage>) -> Option<T> {
        found.unwrap_or_else(|damage| {
            // No entry is damaged where the folder has become something else.
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

    /// A folder that cannot be written is worth one note, not one for each stage.
    fn unkept(&self, place: &Place, source: &std::io::Error) {
        if !self.noted.unkept.swap(true, Ordering::Relaxed) {
            self.note(format!(
                "results cannot be kept in {}: {source}; choose another folder with NAILNOISE_CACHE",
                place.folder.display()
            ));
        }
    }

    /// The stored output of a stage; damage becomes a note.
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

    /// When the entry of a stage was written or last read, and its size.
    pub fn stamp(&self, stage: &str, key: &Digest) -> Stamp {
        let path = self
            .place
            .as_ref()?
            .folder
            .join(entry::name(stage, &in_this_layout(key)));
        let data = std::fs::metadata(path).ok()?;
        Some((data.modified().ok()?, data.len()))
    }

    /// The claim to compute the output of a stage, which other processes heed until it is dropped. Waits while another
    /// one has it, up to an hour; none if nothing is stored, if the entry is no longer that of `before`, or if no claim
    /// can be made. `step` is called now and then meanwhile; the first long wait and the first failure become notes.
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
            // If no file can be created, the output cannot be stored, either: that is the note.
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

    /// Stores the output of a stage; trouble becomes a note.
    pub fn save<T, C: Codec<T>>(&self, stage: &str, key: &Digest, value: &T) {
        let Some(place) = &self.place else { return };
        let key = &in_this_layout(key);
        let path = place.folder.join(entry::name(stage, key));
        let written = entry::write_by(&path, key, |to| C::write(value, to)).and_then(|bytes| place.bound(bytes));
        match written {
            // The note on an object under the name of the entry was taken when the entry was to be read.
            Err(source) if source.kind() == ErrorKind::IsADirectory && path.is_dir() => {}
            Err(source) => self.unkept(place, &source),
            Ok(()) => self.count_as_used(&path),
        }
    }

    /// An entry that is useful without being read counts as used.
    pub fn renew(&self, stage: &str, key: &Digest) {
        if let Some(place) = &self.place {
            entry::renew(&place.folder.join(entry::name(stage, &in_this_layout(key))));
        }
    }

    /// Takes the notes for the user.
    pub fn take_notes(&self) -> Vec<String> {
        self.notes
            .lock()
            .map(|mut notes| std::mem::take(&mut *notes))
            .unwrap_or_default()
    }

    /// All entries, last used first.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn entries(&self) -> std::io::Result<Vec<Listed>> {
        self.folder().map_or_else(|| Ok(Vec::new()), folder::entries)
    }

    /// Folders, links to nothing, pipes and the like that have the names of entries.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn obstacles(&self) -> std::io::Result<Vec<(PathBuf, Damage)>> {
        self.folder().map_or_else(|| Ok(Vec::new()), folder::obstacles)
    }

    /// Reads every entry completely; returns the damaged files and the [`obstacles`](Self::obstacles), with their
    /// faults.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn verify(&self) -> std::io::Result<Vec<(PathBuf, Damage)>> {
        let damaged = |listed: Listed| entry::verify(&listed.path).err().map(|damage| (listed.path, damage));
        let mut found: Vec<_> = self.entries()?.into_iter().filter_map(damaged).collect();
        found.extend(self.obstacles()?);
        Ok(found)
    }

    /// Removes an entry, or the object under its name.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn remove(&self, path: &Path) -> std::io::Result<()> {
        folder::remove(path)
    }

    /// Whether a file was written by this or another version of the program, or is an obstacle: whether it may be
    /// removed.
    pub fn is_own(&self, path: &Path) -> bool {
        entry::is_own(path)
    }

    /// Removes all entries and obstacles; returns how many entries there were, and the files that have the name of an
    /// entry, but not its content. These are left: this program did not write them.
    ///
    /// # Errors
    /// Those of the file system.
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
