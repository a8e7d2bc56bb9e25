//! Atomic replacement of files.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of files written by this process.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// Replaces a file with the output of `fill`, using a temporary file in the same folder and a rename. If the process is
/// killed, either the old file or none remains. Unless `fill` syncs, a power failure may leave a partial file; readers
/// must verify such files.
///
/// # Errors
/// Errors of the file system and of `fill`; the temporary file is then removed.
pub(super) fn replace<T>(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<T>) -> io::Result<T> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    // Several processes and threads may write the same file at once; each has its own temporary file.
    let count = WRITTEN.fetch_add(1, Ordering::Relaxed);
    temporary.push(format!(".{}-{count}.tmp", std::process::id()));
    let temporary = path.with_file_name(temporary);
    let written = File::create(&temporary)
        .and_then(|mut file| fill(&mut file))
        .and_then(|value| std::fs::rename(&temporary, path).map(|()| value));
    if written.is_err() {
        // The first error is the one reported.
        let _ = std::fs::remove_file(&temporary);
    }
    written
}
