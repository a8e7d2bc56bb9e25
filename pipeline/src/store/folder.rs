//! The folder of the entries: its location, contents and size limit.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, fs, io};

use super::entry::{Damage, is_file, is_name, is_own, renew};
use super::error::{Obstacle, StoreError};

/// Default limit on the total size of the entries: 2 GB.
pub const LIMIT: u64 = 2_000_000_000;

/// Largest expected clock difference between machines that share a folder.
const AHEAD: Duration = Duration::from_secs(3600);

/// Age beyond which a partial file counts as abandoned.
const ABANDONED: Duration = Duration::from_secs(3600);

/// An entry found in the folder.
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

/// Checks that a path is a folder or does not exist. Creates nothing.
///
/// # Errors
/// [`Obstacle`].
pub(super) fn examine(folder: &Path) -> Result<(), Obstacle> {
    let data = match fs::metadata(folder) {
        // A dangling link is not an absent folder: no folder can be created under its name.
        Err(error) if error.kind() == io::ErrorKind::NotFound => match fs::symlink_metadata(folder) {
            Ok(data) => data,
            Err(_) => return Ok(()),
        },
        found => found.map_err(Obstacle::Unreachable)?,
    };
    match data.file_type() {
        kind if kind.is_dir() => Ok(()),
        kind if kind.is_file() => Err(Obstacle::NoFolder("a file")),
        kind if kind.is_symlink() => Err(Obstacle::NoFolder("a link to nothing")),
        _ => Err(Obstacle::NoFolder("a pipe or a device")),
    }
}

/// Ensures that files can be written in a folder, which is created if necessary.
///
/// # Errors
/// [`Obstacle`].
pub(super) fn occupy(folder: &Path) -> Result<(), Obstacle> {
    examine(folder)?;
    fs::create_dir_all(folder).map_err(Obstacle::Unreachable)?;
    let trial = folder.join(format!(".trial-{}.tmp", std::process::id()));
    let written = fs::write(&trial, "").map_err(Obstacle::ReadOnly);
    // If it cannot be removed now, it is swept later.
    let _ = fs::remove_file(&trial);
    written
}

/// The user's cache folder.
pub(super) fn of_user() -> Result<PathBuf, StoreError> {
    let set = |name: &str| env::var_os(name).filter(|value: &OsString| !value.is_empty());
    let under = |name: &str, path: &str| set(name).map(|folder| Path::new(&folder).join(path));
    set("NAILNOISE_CACHE")
        .map(PathBuf::from)
        .or_else(|| under("XDG_CACHE_HOME", "nailnoise"))
        .or_else(|| {
            cfg!(windows)
                .then(|| under("LOCALAPPDATA", "nailnoise\\cache"))
                .flatten()
        })
        .or_else(|| under("HOME", ".cache/nailnoise"))
        .ok_or(StoreError::NoFolder)
}

/// The user's size limit \[bytes\].
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

/// Lists the files of a folder; none if it does not exist.
fn files(folder: &Path) -> io::Result<Vec<fs::DirEntry>> {
    match fs::read_dir(folder) {
        Ok(files) => files.collect(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}

/// Folders, dangling links, pipes and the like that have the names of entries. Objects with other names belong to
/// somebody else.
pub(super) fn obstacles(folder: &Path) -> io::Result<Vec<(PathBuf, Damage)>> {
    let mut found = Vec::new();
    for file in files(folder)? {
        let path = file.path();
        let data = fs::metadata(&path).or_else(|_| file.metadata());
        let Ok(Err(damage)) = data.map(|data| is_file(&data)) else {
            continue;
        };
        if is_name(&file.file_name().to_string_lossy()) {
            found.push((path, damage));
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(found)
}

/// All entries of a folder, most recently used first; none if the folder does not exist.
pub(super) fn entries(folder: &Path) -> io::Result<Vec<Listed>> {
    let mut entries = Vec::new();
    for file in files(folder)? {
        let path = file.path();
        // Objects with other names belong to somebody else.
        if !is_name(&file.file_name().to_string_lossy()) {
            continue;
        }
        // Another process may have removed it meanwhile.
        let Ok(data) = fs::metadata(&path) else { continue };
        if !data.is_file() {
            continue;
        }
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

/// Removes the least recently used entries until the rest is within the limit; returns the total size of the rest.
pub(super) fn bound(folder: &Path, limit: u64) -> io::Result<u64> {
    sweep(folder)?;
    let (mut sum, mut left) = (0_u64, 0);
    let mut entries = entries(folder)?;
    // If a clock was set back, file times may lie in the future. Their order is meaningless, so they count as used now.
    let soon = SystemTime::now() + AHEAD;
    for entry in entries.iter().filter(|entry| entry.used > soon) {
        renew(&entry.path);
    }
    entries.sort_by_key(|entry| entry.used > soon);
    for entry in entries {
        sum += entry.bytes;
        // In a shared folder, users may be able to remove only their own entries; those of others remain.
        if sum <= limit || !is_own(&entry.path) || remove(&entry.path).is_err() {
            left += entry.bytes;
        }
    }
    Ok(left)
}

/// Removes partial files of killed processes; files of the last hour are left because they may still be in use.
fn sweep(folder: &Path) -> io::Result<()> {
    for file in files(folder)? {
        let path = file.path();
        let modified = file.metadata().and_then(|data| data.modified());
        let old = modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > ABANDONED));
        let is_own = path.extension().is_some_and(|extension| extension == "tmp")
            && path
                .file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if old && is_own {
            // Files of other users remain if only owners may remove them.
            let _ = remove(&path);
        }
    }
    Ok(())
}

/// Removes an entry, or the object with its name, unless another process already has.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    let removed = match fs::symlink_metadata(path) {
        Ok(data) if data.is_dir() => fs::remove_dir_all(path),
        _ => fs::remove_file(path),
    };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
