//! The folder of the entries: its place, its content, its limit.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, fs, io};

use super::entry::{Damage, is_file, is_name, is_own, renew};
use super::error::{Obstacle, StoreError};

/// Bytes the entries may take together by default: 4 GiB.
pub const LIMIT: u64 = 4 << 30;

/// How far clocks of machines that share a folder may differ.
const AHEAD: Duration = Duration::from_secs(3600);

/// Age beyond which a half-written file is abandoned.
const ABANDONED: Duration = Duration::from_secs(3600);

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

/// Whether a path is a folder, or none yet. Nothing is created.
///
/// # Errors
/// [`Obstacle`].
pub(super) fn examine(folder: &Path) -> Result<(), Obstacle> {
    let data = match fs::metadata(folder) {
        // A link to nothing is not an absent folder: none can be created under its name.
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

/// Makes sure that files can be written in a folder, which is created if it does not exist.
///
/// # Errors
/// [`Obstacle`].
pub(super) fn occupy(folder: &Path) -> Result<(), Obstacle> {
    examine(folder)?;
    fs::create_dir_all(folder).map_err(Obstacle::Unreachable)?;
    let trial = folder.join(format!(".trial-{}.tmp", std::process::id()));
    let written = fs::write(&trial, "").map_err(Obstacle::ReadOnly);
    // It is swept away later where it cannot be removed.
    let _ = fs::remove_file(&trial);
    written
}

/// The user's folder.
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

/// Files in a folder; none if it does not exist.
fn files(folder: &Path) -> io::Result<Vec<fs::DirEntry>> {
    match fs::read_dir(folder) {
        Ok(files) => files.collect(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}

/// Folders, links to nothing, pipes and the like that have the names of entries. Objects with other names belong to
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

/// All entries of a folder, last used first; none when it does not exist.
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

/// Removes the least recently used entries until the others are within the limit; returns the bytes of the others.
pub(super) fn bound(folder: &Path, limit: u64) -> io::Result<u64> {
    sweep(folder)?;
    let (mut sum, mut left) = (0_u64, 0);
    let mut entries = entries(folder)?;
    // A clock that was set back leaves times in the future, whose order is meaningless: they count as used now.
    let soon = SystemTime::now() + AHEAD;
    for entry in entries.iter().filter(|entry| entry.used > soon) {
        renew(&entry.path);
    }
    entries.sort_by_key(|entry| entry.used > soon);
    for entry in entries {
        sum += entry.bytes;
        // In a folder that several users share, each may remove their own entries only; those of the others stay.
        if sum <= limit || !is_own(&entry.path) || remove(&entry.path).is_err() {
            left += entry.bytes;
        }
    }
    Ok(left)
}

/// Removes half-written files of killed processes; a file of the last hour may still be under way.
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
            // Files of another user stay if only owners may remove their files.
            let _ = remove(&path);
        }
    }
    Ok(())
}

/// Removes an entry or the object under its name, unless another process has done so.
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
