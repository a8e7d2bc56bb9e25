//! Atomic writing of several files: either all are replaced or none.
//!
//! All files are first written to a hidden folder on the same file system. After that, only renames are needed. If one
//! of them fails, the preceding ones are undone, by copying if the system refuses renames, so that the folder is
//! restored. Files that cannot be restored either way are left in the hidden folder, which the error names. A full disk
//! is detected before the first rename.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use nailnoise_meshes::temporary::{self, TemporaryFolder};

use crate::error::Error;
use crate::interrupt;

/// Prefix of the hidden folder's name.
const UNFINISHED: &str = ".unfinished-";

/// Name of the folder for files that are replaced or removed.
const OLD: &str = "old";

/// Moves a file or folder to another path on its file system.
type Rename<'a> = &'a dyn Fn(&Path, &Path) -> io::Result<()>;

/// Files being written for a folder; if dropped without [`place`](Self::place), they are deleted.
#[derive(Debug)]
pub struct AtomicWrite {
    folder: PathBuf,
    temporary: TemporaryFolder,
    /// Files written so far, relative to the folder.
    written: Mutex<Vec<PathBuf>>,
}

impl AtomicWrite {
    /// Starts writing files for `folder`, which is created if it does not exist. Partial files of killed processes
    /// there are removed.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn within(folder: &Path) -> Result<Self, Error> {
        create(folder)?;
        sweep(folder);
        let temporary = TemporaryFolder::new(folder, UNFINISHED).map_err(|source| failed(folder, source))?;
        let staging = Self {
            folder: folder.to_owned(),
            temporary,
            written: Mutex::default(),
        };
        for own in [staging.outgoing(), staging.incoming()] {
            fs::create_dir(own).map_err(|source| failed(folder, source))?;
        }
        Ok(staging)
    }

    fn incoming(&self) -> PathBuf {
        self.temporary.path().join("new")
    }

    fn outgoing(&self) -> PathBuf {
        self.temporary.path().join(OLD)
    }

    /// Writes a file that belongs at `path`, relative to the folder, and waits until it is on disk.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.fill(path, |file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
    }

    /// Like [`write`](Self::write), but the system decides when the file reaches the disk: for files that a later run
    /// compares with their expected contents and rewrites after a power failure.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write_unsynced(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.fill(path, |file| file.write_all(bytes))
    }

    /// Opens a file for incremental writing, for tables that do not fit in memory.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn file(&self, path: &Path) -> Result<GrowingFile, Error> {
        self.fill(path, |_| Ok(()))?;
        let place = self.folder.join(path);
        let file = File::options().append(true).open(self.incoming().join(path));
        let file = file.map_err(|source| failed(&place, source))?;
        Ok(GrowingFile {
            file: BufWriter::new(file),
            place,
        })
    }

    fn fill(&self, path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Error> {
        let incoming = self.incoming();
        let written = create_between(&incoming, path)
            .and_then(|()| File::create(incoming.join(path)))
            .and_then(|mut file| fill(&mut file));
        written.map_err(|source| failed(&self.folder.join(path), source))?;
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.push(path.to_owned());
        Ok(())
    }

    /// Puts the files in place and removes `outdated` files and folders. The file `last` represents all of them: it is
    /// removed first and put back last, so that a process killed in between leaves a folder without it.
    ///
    /// # Errors
    /// [`Error::Write`]; the folder is then unchanged. [`Error::NotRestored`] with the location of the old files if
    /// they could not be restored.
    pub fn place(self, outdated: &[PathBuf], last: &Path) -> Result<(), Error> {
        self.place_by(&|from, to| fs::rename(from, to), outdated, last)
    }

    /// Like [`place`](Self::place), with the given rename function.
    fn place_by(self, rename: Rename<'_>, outdated: &[PathBuf], last: &Path) -> Result<(), Error> {
        let mut paths = std::mem::take(&mut *self.written.lock().unwrap_or_else(PoisonError::into_inner));
        paths.sort_by_key(|path| path == last);
        let mut swap = Swap {
            folder: &self.folder,
            new: self.incoming(),
            old: self.outgoing(),
            rename,
            done: Vec::new(),
        };
        let _whole = interrupt::undisturbed();
        let Err(error) = swap.all(&paths, outdated, last) else {
            return Ok(());
        };
        let lost = swap.undo();
        match error {
            Error::Write { path, source } if !lost.is_empty() => Err(Error::NotRestored {
                path,
                source,
                folder: self.temporary.leave().join(OLD),
                files: lost.iter().map(|path| path.display().to_string()).collect(),
            }),
            error => Err(error),
        }
    }
}

/// A file that is written incrementally.
#[derive(Debug)]
pub struct GrowingFile {
    file: BufWriter<File>,
    place: PathBuf,
}

impl GrowingFile {
    /// Appends bytes.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file.write_all(bytes).map_err(|source| failed(&self.place, source))
    }

    /// Waits until everything is on disk.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish(mut self) -> Result<(), Error> {
        let flushed = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        flushed.map_err(|source| failed(&self.place, source))
    }
}

/// Removes partial files of killed processes from a folder.
pub(crate) fn sweep(folder: &Path) {
    temporary::sweep(folder, UNFINISHED);
}

/// Writes one file atomically: if the process is killed or the disk is full, the old file or none remains.
///
/// # Errors
/// [`Error::Write`].
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let name = path
        .file_name()
        .map(Path::new)
        .ok_or_else(|| failed(path, ErrorKind::InvalidFilename.into()))?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let staging = AtomicWrite::within(parent.unwrap_or_else(|| Path::new(".")))?;
    staging.write(name, bytes)?;
    staging.place(&[], name)
}

/// Whether a name is that of a file or folder in the current folder: not empty, not a path, and neither `.` nor `..`.
pub(crate) fn is_file_name(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(only)), None) if only == name)
}

/// Creates a folder and its parents.
///
/// # Errors
/// [`Error::Write`].
pub(crate) fn create(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|source| failed(folder, source))
}

/// Creates the folders between `folder` and a file in it, but not `folder`: if an interruption has removed it, threads
/// that still write must not bring it back.
fn create_between(folder: &Path, file: &Path) -> io::Result<()> {
    let mut folder = folder.to_owned();
    for name in file.parent().into_iter().flat_map(Path::components) {
        folder.push(name);
        match fs::create_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            created => created?,
        }
    }
    Ok(())
}

fn failed(path: &Path, source: io::Error) -> Error {
    Error::Write {
        path: path.to_owned(),
        source,
    }
}

/// The renames in progress, each of which can be undone.
struct Swap<'a> {
    folder: &'a Path,
    /// Folder of the new files.
    new: PathBuf,
    /// Folder of the replaced files.
    old: PathBuf,
    rename: Rename<'a>,
    done: Vec<Step>,
}

/// A change of the folder.
enum Step {
    /// The object at this path was moved to the folder of replaced files.
    SetAside(PathBuf),
    /// The new file is at this path.
    Placed(PathBuf),
    /// This folder was created.
    Created(PathBuf),
}

impl Swap<'_> {
    fn all(&mut self, paths: &[PathBuf], outdated: &[PathBuf], last: &Path) -> Result<(), Error> {
        self.set_aside(last, false)?;
        outdated.iter().try_for_each(|path| self.set_aside(path, true))?;
        for path in paths {
            self.set_aside(path, false)?;
            self.put(path)?;
        }
        Ok(())
    }

    /// Moves the object at a path away, if there is one. A new file never replaces a folder.
    fn set_aside(&mut self, path: &Path, may_be_folder: bool) -> Result<(), Error> {
        let from = self.folder.join(path);
        let moved = match fs::symlink_metadata(&from) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            Ok(data) if data.is_dir() && !may_be_folder => Err(ErrorKind::IsADirectory.into()),
            found => found.and_then(|_| {
                let to = self.old.join(path);
                to.parent().map_or(Ok(()), fs::create_dir_all)?;
                (self.rename)(&from, &to)
            }),
        };
        moved.map_err(|source| failed(&from, source))?;
        self.done.push(Step::SetAside(path.to_owned()));
        Ok(())
    }

    fn put(&mut self, path: &Path) -> Result<(), Error> {
        let to = self.folder.join(path);
        let folders: Vec<&Path> = path
            .ancestors()
            .skip(1)
            .filter(|above| !above.as_os_str().is_empty())
            .collect();
        for above in folders.into_iter().rev() {
            let above = self.folder.join(above);
            if !above.is_dir() {
                fs::create_dir(&above).map_err(|source| failed(&above, source))?;
                self.done.push(Step::Created(above));
            }
        }
        // The path is free by now: some file systems (ext4) flush a file before it replaces another.
        (self.rename)(&self.new.join(path), &to).map_err(|source| failed(&to, source))?;
        self.done.push(Step::Placed(path.to_owned()));
        Ok(())
    }

    /// Restores the folder; returns the files that could not be restored. The file that represents all others was moved
    /// first, so it is restored last, and only if all others were.
    fn undo(&mut self) -> Vec<PathBuf> {
        let mut lost = Vec::new();
        while let Some(step) = self.done.pop() {
            match step {
                Step::SetAside(path) => {
                    let stands_for_all = self.done.is_empty();
                    let (from, to) = (self.old.join(&path), self.folder.join(&path));
                    if stands_for_all && !lost.is_empty() || self.put_back(&from, &to).is_err() {
                        lost.push(path);
                    }
                }
                // If the new file cannot be removed, it is replaced by the old one, or remains as an additional file.
                Step::Placed(path) => drop(fs::remove_file(self.folder.join(path))),
                // Another process may use it by now.
                Step::Created(folder) => drop(fs::remove_dir(folder)),
            }
        }
        lost
    }

    /// Moves a file or folder back, or copies it if the system refuses to move it. A partial copy is removed.
    fn put_back(&self, from: &Path, to: &Path) -> io::Result<()> {
        if (self.rename)(from, to).is_ok() {
            return Ok(());
        }
        let is_free = fs::symlink_metadata(to).is_err();
        let copied = copy(from, to);
        if copied.is_err() && is_free {
            let _ = fs::remove_file(to).or_else(|_| fs::remove_dir_all(to));
        }
        copied
    }
}

/// Copies a file or a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if !fs::symlink_metadata(from)?.is_dir() {
        fs::copy(from, to)?;
        return File::open(to)?.sync_all();
    }
    fs::create_dir(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("nailnoise-staging-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("part")).expect("a folder for the test");
        for file in ["a", "part/b", "whole"] {
            fs::write(folder.join(file), "old").expect("a file for the test");
        }
        folder
    }

    /// Every file in a folder, with its contents.
    fn content(folder: &Path) -> Vec<(PathBuf, String)> {
        let mut found = Vec::new();
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                found.push((path.clone(), "folder".to_owned()));
                found.extend(content(&path));
            } else {
                found.push((path.clone(), fs::read_to_string(&path).expect("a file")));
            }
        }
        found.sort();
        found
    }

    fn staged(folder: &Path, files: &[&str]) -> Result<AtomicWrite, Error> {
        let staging = AtomicWrite::within(folder)?;
        files
            .iter()
            .try_for_each(|file| staging.write(Path::new(file), b"new"))?;
        Ok(staging)
    }

    #[test]
    fn a_folder_that_an_interruption_removed_does_not_come_back() -> Result<(), Error> {
        let folder = folder("removed");
        let staging = staged(&folder, &["a", "other/b"])?;
        let hidden = staging.temporary.path().to_owned();
        fs::remove_dir_all(&hidden).map_err(|source| failed(&hidden, source))?;
        for file in ["c", "other/d"] {
            assert!(
                staging.write(Path::new(file), b"new").is_err() && !hidden.exists(),
                "{file}"
            );
        }
        fs::remove_dir_all(&folder).map_err(|source| failed(&folder, source))
    }

    #[test]
    fn files_replace_others_together() -> Result<(), Error> {
        let folder = folder("together");
        let staging = staged(&folder, &["a", "part/b", "other/c", "whole"])?;
        assert_eq!(
            content(&folder.join("part"))[0].1,
            "old",
            "nothing changes before it is placed"
        );
        staging.place(&[], Path::new("whole"))?;
        let files = content(&folder);
        assert_eq!(files.iter().filter(|(_, text)| text == "new").count(), 4);
        assert_eq!(
            files.len(),
            4 + 2,
            "four files in two folders and nothing else: {files:?}"
        );
        let _ = fs::remove_dir_all(folder);
        Ok(())
    }

    #[test]
    fn outdated_files_and_folders_go() -> Result<(), Error> {
        let folder = folder("outdated");
        let outdated = ["part", "a", "not there"].map(PathBuf::from);
        staged(&folder, &["whole"])?.place(&outdated, Path::new("whole"))?;
        assert_eq!(content(&folder), [(folder.join("whole"), "new".to_owned())]);
        let _ = fs::remove_dir_all(folder);
        Ok(())
    }

    /// The second-to-last file meets an obstacle when all others are in place.
    #[test]
    fn a_folder_is_as_it_was_when_one_file_cannot_be_placed() -> Result<(), Error> {
        let folder = folder("undone");
        fs::create_dir(folder.join("taken")).expect("a folder");
        let before = content(&folder);
        let staging = staged(&folder, &["a", "new/c", "whole", "taken"])?;
        assert!(staging.place(&[PathBuf::from("part")], Path::new("whole")).is_err());
        assert_eq!(content(&folder), before);
        let _ = fs::remove_dir_all(folder);
        Ok(())
    }

    /// A rename function that fails from the given call onwards.
    fn failing_from(number: usize) -> impl Fn(&Path, &Path) -> io::Result<()> {
        let count = std::cell::Cell::new(0);
        move |from, to| {
            count.set(count.get() + 1);
            if count.get() > number {
                return Err(io::Error::other("no rename"));
            }
            fs::rename(from, to)
        }
    }

    /// Wherever the renames start to fail, even if none succeeds afterwards.
    #[test]
    fn a_folder_is_as_it_was_when_renames_fail_for_good() -> Result<(), Error> {
        let folder = folder("no-renames");
        fs::create_dir(folder.join("film")).expect("a folder");
        fs::write(folder.join("film/frame"), "old").expect("a file");
        let before = content(&folder);
        let outdated = ["film", "part"].map(PathBuf::from);
        // One rename for the representative file, one for each outdated folder, two for each of the others.
        for number in 0..8 {
            let staging = staged(&folder, &["a", "new/c", "other", "whole"])?;
            let placed = staging.place_by(&failing_from(number), &outdated, Path::new("whole"));
            let Err(Error::Write { .. }) = placed else {
                panic!("{number}: {placed:?}");
            };
            assert_eq!(content(&folder), before, "{number}");
        }
        staged(&folder, &["a", "whole"])?.place_by(&failing_from(99), &outdated, Path::new("whole"))?;
        let _ = fs::remove_dir_all(folder);
        Ok(())
    }

    /// A folder occupies the path of an old file when it is to be restored.
    #[test]
    fn what_cannot_be_put_back_is_left_where_the_error_says() -> Result<(), Error> {
        let folder = folder("lost");
        let (failing, taken) = (failing_from(3), folder.join("a"));
        let rename = |from: &Path, to: &Path| {
            let moved = failing(from, to);
            if moved.is_err() {
                let _ = fs::remove_file(&taken);
                let _ = fs::create_dir_all(taken.join("taken"));
            }
            moved
        };
        let placed = staged(&folder, &["a", "c", "whole"])?.place_by(&rename, &[], Path::new("whole"));
        let Err(Error::NotRestored { folder: old, files, .. }) = placed else {
            panic!("{placed:?}");
        };
        assert_eq!(
            files,
            ["a", "whole"],
            "the file that stands for all is not there without the others"
        );
        for file in &files {
            assert_eq!(fs::read_to_string(old.join(file)).expect("the old file"), "old");
        }
        assert!(!folder.join("whole").exists() && !folder.join("c").exists());
        // Later operations in the folder leave them in place.
        drop(staged(&folder, &["b"])?);
        assert!(old.join("a").exists());
        let _ = fs::remove_dir_all(folder);
        Ok(())
    }

    #[test]
    fn a_file_name_is_no_path() {
        for name in ["", ".", "..", "a/b", "a/", "/", "/a", "../a", "./a"] {
            assert!(!is_file_name(name), "{name}");
        }
        for name in ["a", "a.b", "...", ".a", "a b", "\u{e9}"] {
            assert!(is_file_name(name), "{name}");
        }
    }

    #[test]
    fn a_folder_cannot_be_replaced_by_a_file() {
        let folder = folder("folder");
        assert!(write(&folder.join("part"), b"").is_err());
        assert!(write(Path::new("/"), b"").is_err());
        assert_eq!(fs::read(folder.join("part/b")).expect("a file"), b"old");
        let _ = fs::remove_dir_all(folder);
    }
}
