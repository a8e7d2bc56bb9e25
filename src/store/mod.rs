//! Results of expensive stages, kept from run to run under the digest of everything they depend on.
//!
//! An entry is one file, named by its stage and by the SHA-256 of its inputs and of the sources of this program; it
//! carries the checksum of its own content. What is truncated, altered or foreign is noticed, reported and computed anew.
//! Files are written whole, so that several processes may share a folder and a killed one leaves nothing half-written.
//! The least recently used entries go first when the folder outgrows its limit.

mod bytes;
mod checksum;
mod entry;
mod folder;
mod key;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

pub use bytes::Bytes;
pub(crate) use checksum::{Checksum, checksum};
pub use entry::Damage;
pub use folder::{LIMIT, StoreError};
pub use key::Key;

use crate::stages::{Codec, Digest};

/// Where results of expensive stages are kept, if anywhere.
#[derive(Debug, Clone, Default)]
pub struct Store {
    place: Option<Place>,
    /// What the user should know: damaged entries, a folder that cannot be written.
    notes: Arc<Mutex<Vec<String>>>,
}

#[derive(Debug, Clone)]
struct Place {
    folder: PathBuf,
    /// Bytes that all entries may take together.
    limit: u64,
}

/// An entry as it lies in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// The file.
    pub path: PathBuf,
    /// The stage that computed it.
    pub stage: String,
    /// Its size \[bytes\].
    pub bytes: u64,
    /// When it was last written or read.
    pub used: SystemTime,
}

impl Store {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// The user's own: `$NAILNOISE_CACHE`, else `$XDG_CACHE_HOME/nailnoise`, else `~/.cache/nailnoise`; at most
    /// `$NAILNOISE_CACHE_LIMIT` GiB, else [`LIMIT`].
    ///
    /// # Errors
    /// [`StoreError`] where the environment names no folder or no size.
    pub fn of_user() -> Result<Self, StoreError> {
        Ok(Self::at(folder::of_user()?, folder::limit()?))
    }

    /// In this folder, with this many bytes at most.
    pub fn at(folder: PathBuf, limit: u64) -> Self {
        Self {
            place: Some(Place { folder, limit }),
            notes: Arc::default(),
        }
    }

    /// The folder; none when nothing is kept.
    pub fn folder(&self) -> Option<&Path> {
        self.place.as_ref().map(|store| store.folder.as_path())
    }

    /// Bytes that all entries may take together; 0 when nothing is kept.
    pub fn limit(&self) -> u64 {
        self.place.as_ref().map_or(0, |store| store.limit)
    }

    /// What was read; damage becomes a note.
    fn undamaged<T>(&self, path: &Path, found: Result<Option<T>, Damage>) -> Option<T> {
        found.unwrap_or_else(|damage| {
            self.note(format!(
                "the cache entry {} {damage}; it is computed anew",
                path.display()
            ));
            None
        })
    }

    fn unkept(&self, stage: &str, place: &Place, source: &std::io::Error) {
        self.note(format!(
            "{stage} cannot be kept in {}: {source}; choose another folder with NAILNOISE_CACHE",
            place.folder.display()
        ));
    }

    /// The kept output of a stage; damage becomes a note.
    pub fn load<T, C: Codec<T>>(&self, stage: &str, key: &Digest) -> Option<T> {
        let path = self.place.as_ref()?.folder.join(entry::name(stage, key));
        let read = |from: &mut dyn Read, length| C::read(from, length);
        let found = self.undamaged(&path, entry::read_by(&path, key, read))?;
        found
            .map_err(|error| {
                self.note(format!(
                    "the cache entry {} {error}; it is computed anew",
                    path.display()
                ))
            })
            .ok()
    }

    /// Keeps the output of a stage; trouble becomes a note.
    pub fn save<T, C: Codec<T>>(&self, stage: &str, key: &Digest, value: &T) {
        let Some(place) = &self.place else { return };
        let path = place.folder.join(entry::name(stage, key));
        let written = entry::write_by(&path, key, |to| C::write(value, to))
            .and_then(|()| folder::bound(&place.folder, place.limit));
        if let Err(source) = written {
            self.unkept(stage, place, &source);
        }
    }

    /// An entry that is of use though nobody reads it counts as used.
    pub fn renew(&self, stage: &str, key: &Digest) {
        if let Some(place) = &self.place {
            entry::renew(&place.folder.join(entry::name(stage, key)));
        }
    }

    /// Takes what there is to tell the user.
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

    /// Reads every entry whole; those that are damaged, with what is wrong.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn verify(&self) -> std::io::Result<Vec<(Listed, Damage)>> {
        let damaged = |listed: Listed| entry::verify(&listed.path).err().map(|damage| (listed, damage));
        Ok(self.entries()?.into_iter().filter_map(damaged).collect())
    }

    /// Removes all entries; returns how many there were.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn clear(&self) -> std::io::Result<usize> {
        let entries = self.entries()?;
        for entry in &entries {
            folder::remove(&entry.path)?;
        }
        Ok(entries.len())
    }

    fn note(&self, text: String) {
        if let Ok(mut notes) = self.notes.lock() {
            notes.push(text);
        }
    }
}
