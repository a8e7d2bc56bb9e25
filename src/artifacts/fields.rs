//! Files of the fields of a run, rendered from inputs that are stored once for all runs with the same motion of the
//! bodies.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::graph::program_key;
use crate::output::{BodyFields, Fields};
use crate::stages::{Digest, Postcard, Stage, Stored};
use crate::store::{Checksum, Store, checksum};

/// Name of the entries in the store with the checksums of the files.
const CHECKSUMS: &str = "checksums of fields";

/// Paths and checksums of the files of [`Fields`]. They make up most of a run's bytes and are the same for all runs
/// with the same motion of the bodies, so their inputs are stored once, and files already in place are not touched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FieldFiles {
    /// Key of the fields in the store.
    key: Digest,
    files: Vec<(PathBuf, Checksum)>,
}

impl FieldFiles {
    /// Writes all files.
    fn write(staging: &AtomicWrite, key: Digest, fields: &Fields) -> Result<Self, Error> {
        let write = |bytes: &mut Vec<u8>, file: usize| {
            let path = fields.path(file);
            fields.render(file, bytes)?;
            staging.write_unsynced(path, bytes)?;
            Ok((path.to_owned(), checksum(bytes)))
        };
        let files = (0..fields.len()).into_par_iter().map_init(Vec::new, write);
        Ok(Self {
            key,
            files: files.collect::<Result<_, Error>>()?,
        })
    }

    /// Those that are not in place in a folder.
    fn missing(&self, folder: &Path) -> Vec<usize> {
        let there = |bytes: &mut Vec<u8>, (path, expected): &(PathBuf, Checksum)| {
            bytes.clear();
            let read = fs::File::open(folder.join(path)).and_then(|mut file| io::copy(&mut file, bytes));
            read.is_ok() && checksum(bytes) == *expected
        };
        let there: Vec<bool> = self.files.par_iter().map_init(Vec::new, there).collect();
        (0..there.len()).filter(|&file| !there[file]).collect()
    }

    /// Those that are not in place, with their inputs from the store; nothing if the store no longer has them.
    pub(super) fn pending(&self, folder: &Path, store: &Store) -> Option<PendingFields> {
        let missing = self.missing(folder);
        if missing.is_empty() {
            store.renew(BodyFields::NAME, &self.key);
            return Some(PendingFields::default());
        }
        let fields = store.load::<Fields, Postcard>(BodyFields::NAME, &self.key)?;
        Some(PendingFields {
            missing,
            fields: Arc::new(fields),
        })
    }
}

/// Files of fields that must be put in place.
#[derive(Default)]
pub(super) struct PendingFields {
    missing: Vec<usize>,
    fields: Arc<Fields>,
}

impl PendingFields {
    /// Whether all files are in place.
    pub(super) fn is_empty(&self) -> bool {
        self.missing.is_empty()
    }

    /// Renders the files.
    pub(super) fn write(&self, staging: &AtomicWrite) -> Result<(), Error> {
        let write = |bytes: &mut Vec<u8>, &file: &usize| {
            self.fields.render(file, bytes)?;
            staging.write_unsynced(self.fields.path(file), bytes)
        };
        let written = self.missing.par_iter().map_init(Vec::new, write);
        written.collect()
    }
}

/// Paths and checksums of the files of fields, and those that must be rendered. Files that are not in the store are
/// rendered at once.
pub(super) fn field_files(
    fields: &Stored<Fields>,
    folder: &Path,
    staging: &AtomicWrite,
    store: &Store,
) -> Result<(FieldFiles, PendingFields), Error> {
    let key = fields.key();
    // The layout is defined by this file, which is not part of the fields' key.
    let of_checksums = program_key().with(key).digest();
    if let Some(files) = store.load::<FieldFiles, Postcard>(CHECKSUMS, &of_checksums) {
        let missing = files.missing(folder);
        let fields = if missing.is_empty() {
            store.renew(BodyFields::NAME, key);
            Arc::default()
        } else {
            fields.get()?
        };
        return Ok((files, PendingFields { missing, fields }));
    }
    let files = FieldFiles::write(staging, *key, &*fields.get()?)?;
    store.save::<_, Postcard>(CHECKSUMS, &of_checksums, &files);
    Ok((files, PendingFields::default()))
}
