//! The folder of the entries: where it is, what is in it, how large it may grow.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{env, fs, io};

use miette::Diagnostic;
use thiserror::Error;

use super::Listed;
use super::entry::EXTENSION;

/// Bytes the entries may take together when nothing else is said: 4 GiB.
pub const LIMIT: u64 = 4 << 30;

/// Age at which a half-written file is nobody's.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Why there is no cache.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum StoreError {
    /// No environment variable names a folder.
    #[error("there is no folder for the cache: neither NAILNOISE_CACHE nor XDG_CACHE_HOME nor HOME is set")]
    #[diagnostic(help("set NAILNOISE_CACHE to a folder, or go without: --no-cache"))]
    NoFolder,
    /// The limit is no size.
    #[error("NAILNOISE_CACHE_LIMIT is \"{found}\", which is no size in GiB")]
    #[diagnostic(help("give a number above zero, for instance 4 or 0.5"))]
    Limit {
        /// What it holds.
        found: String,
    },
}

/// The user's folder.
pub(super) fn of_user() -> Result<PathBuf, StoreError> {
    let set = |name: &str| env::var_os(name).filter(|value: &OsString| !value.is_empty());
    let under = |name: &str, path: &str| set(name).map(|folder| Path::new(&folder).join(path));
    set("NAILNOISE_CACHE")
        .map(PathBuf::from)
        .or_else(|| under("XDG_CACHE_HOME", "nailnoise"))
        .or_else(|| under("HOME", ".cache/nailnoise"))
        .ok_or(StoreError::NoFolder)
}

/// The user's limit \[bytes\].
pub(super) fn limit() -> Result<u64, StoreError> {
    let Some(found) = env::var_os("NAILNOISE_CACHE_LIMIT") else {
        return Ok(LIMIT);
    };
    let found = found.to_string_lossy().into_owned();
    match found.trim().parse::<f64>() {
        Ok(size) if size.is_finite() && size > 0.0 => Ok((size * f64::from(1u32 << 30)) as u64),
        _ => Err(StoreError::Limit { found }),
    }
}

/// All entries of a folder, last used first; none when it does not exist.
pub(super) fn entries(folder: &Path) -> io::Result<Vec<Listed>> {
    let files = match fs::read_dir(folder) {
        Ok(files) => files,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut entries = Vec::new();
    for file in files {
        let file = file?;
        let path = file.path();
        if path.extension().is_none_or(|extension| extension != EXTENSION) {
            continue;
        }
        // Another process may have removed it meanwhile.
        let Ok(data) = file.metadata() else { continue };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        entries.push(Listed {
            stage: name
                .rsplit_once('-')
                .map_or(&*name, |(stage, _)| stage)
                .replace('-', " "),
            bytes: data.len(),
            used: data.modified()?,
            path,
        });
    }
    entries.sort_by(|a, b| b.used.cmp(&a.used).then_with(|| a.path.cmp(&b.path)));
    Ok(entries)
}

/// Removes the least recently used entries until the others keep the limit.
pub(super) fn bound(folder: &Path, limit: u64) -> io::Result<()> {
    sweep(folder)?;
    let mut sum = 0;
    for entry in entries(folder)? {
        sum += entry.bytes;
        if sum > limit {
            remove(&entry.path)?;
        }
    }
    Ok(())
}

/// Removes what killed processes left half-written; a file of the last hour may still be under way.
fn sweep(folder: &Path) -> io::Result<()> {
    for file in fs::read_dir(folder)? {
        let file = file?;
        let path = file.path();
        let modified = file.metadata().and_then(|data| data.modified());
        let old = modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > ABANDONED));
        if old && path.extension().is_some_and(|extension| extension == "tmp") {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Removes a file, unless another process has done so.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
