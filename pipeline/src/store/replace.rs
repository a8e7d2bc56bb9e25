//! Entries that are complete or absent.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Files written by this process so far.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// Replaces a file with the output of `fill`: a temporary file next to it, rename. A killed process leaves the old file
/// or none. Without a sync in `fill` a power failure may leave a partial file; such files must be verified when they
/// are read.
///
/// # Errors
/// Those of the file system and of `fill`; the temporary file is removed.
pub(super) fn replace<T>(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<T>) -> io::Result<T> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    // Processes and threads may write the same file at once; each has its own temporary.
    let count = WRITTEN.fetch_add(1, Ordering::Relaxed);
    temporary.push(format!(".{}-{count}.tmp", std::process::id()));
    let temporary = path.with_file_name(temporary);
    let written = File::create(&temporary)
        .and_then(|mut file| fill(&mut file))
        .and_then(|value| std::fs::rename(&temporary, path).map(|()| value));
    if written.is_err() {
        // The first error is the one to report.
        let _ = std::fs::remove_file(&temporary);
    }
    written
}
