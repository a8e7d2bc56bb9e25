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

use serde::Serialize;
use serde::de::DeserializeOwned;

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

    /// What `stage` computes from the inputs in `key`, from the cache or else by `compute`, and kept then.
    ///
    /// # Errors
    /// Those of `compute`; trouble with the cache itself becomes a note.
    pub fn get_or<T: Serialize + DeserializeOwned + Send, E>(
        &self,
        stage: &str,
        key: Key,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if let Some(value) = self.get(stage, &key) {
            return Ok(value);
        }
        let value = compute()?;
        self.put(stage, &key, &value);
        Ok(value)
    }

    /// What is kept of `stage` for the inputs in `key`; damage becomes a note.
    pub fn get<T: DeserializeOwned + Send>(&self, stage: &str, key: &Key) -> Option<T> {
        let (_, digest, path) = self.place(stage, key)?;
        self.undamaged(&path, entry::read(&path, &digest))
    }

    /// What `decode` makes of the bytes, and their number, that `stage` computes from the inputs in `key`, from the cache or
    /// else by `compute`, and kept then: what is large is never in memory as bytes when it comes from the cache.
    ///
    /// # Errors
    /// Those of `compute` and `decode`; trouble with the cache itself becomes a note.
    pub fn decoded_or<T, E>(
        &self,
        stage: &str,
        key: &Key,
        decode: impl Fn(&mut dyn Read, usize) -> Result<T, E>,
        compute: impl FnOnce() -> Result<Vec<u8>, E>,
    ) -> Result<T, E> {
        if let Some(value) = self.decoded(stage, key, &decode) {
            return value;
        }
        let bytes = compute()?;
        self.put_bytes(stage, key, &bytes);
        decode(&mut &bytes[..], bytes.len())
    }

    /// What `decode` makes of the bytes, and their number, that are kept of `stage` for the inputs in `key`; damage becomes a
    /// note.
    pub fn decoded<T>(&self, stage: &str, key: &Key, decode: impl FnOnce(&mut dyn Read, usize) -> T) -> Option<T> {
        let (_, digest, path) = self.place(stage, key)?;
        self.undamaged(&path, entry::read_by(&path, &digest, decode))
    }

    /// Keeps bytes as what `stage` gives for the inputs in `key`; trouble becomes a note.
    pub fn put_bytes(&self, stage: &str, key: &Key, bytes: &[u8]) {
        self.keep(stage, key, |path, digest| {
            entry::write_by(path, digest, |to| to.write_all(bytes))
        });
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

    /// Keeps what `stage` gives for the inputs in `key`; trouble becomes a note.
    pub fn put<T: Serialize>(&self, stage: &str, key: &Key, value: &T) {
        self.keep(stage, key, |path, digest| entry::write(path, digest, value));
    }

    fn keep(&self, stage: &str, key: &Key, write: impl FnOnce(&Path, &[u8; 32]) -> std::io::Result<()>) {
        let Some((store, digest, path)) = self.place(stage, key) else {
            return;
        };
        let written = write(&path, &digest).and_then(|()| folder::bound(&store.folder, store.limit));
        if let Err(source) = written {
            self.unkept(stage, store, &source);
        }
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
    pub fn renew(&self, stage: &str, key: &Key) {
        if let Some((_, _, path)) = self.place(stage, key) {
            entry::renew(&path);
        }
    }

    fn place(&self, stage: &str, key: &Key) -> Option<(&Place, [u8; 32], PathBuf)> {
        let store = self.place.as_ref()?;
        let digest = key.clone().digest();
        let path = store.folder.join(entry::name(stage, &digest));
        Some((store, digest, path))
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
