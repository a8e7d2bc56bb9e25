//! Files that take their places together: all of them, or none.
//!
//! All files are first written beside their places, in a hidden folder of the same file system. Only renames follow. If one
//! of them fails, those before it are undone, so that the folder is as it was. A full disk is met before the first rename.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use nailnoise_meshes::temporary::{self, TemporaryFolder};

use crate::error::Error;
use crate::interrupt;

/// Beginning of the name of the folder in which files are written before they take their places.
const UNFINISHED: &str = ".unfinished-";

/// Files that are being written for a folder; dropped without [`place`](Self::place) they are gone.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
    temporary: TemporaryFolder,
    /// Files written so far, relative to the folder.
    written: Mutex<Vec<PathBuf>>,
}

impl Staging {
    /// For files that belong under `folder`, which is created if it does not exist. What killed processes left half-written there
    /// is removed.
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
        create(&staging.outgoing())?;
        create(&staging.incoming())?;
        Ok(staging)
    }

    fn incoming(&self) -> PathBuf {
        self.temporary.path().join("new")
    }

    fn outgoing(&self) -> PathBuf {
        self.temporary.path().join("old")
    }

    /// Writes a file beside its place `path`, relative to the folder, and waits until it is on the disk.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.fill(path, |file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
    }

    /// Writes a file like [`write`](Self::write), but leaves it to the system when it reaches the disk: for files that a later
    /// run compares with what they should be, and writes again after a power failure.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write_unsynced(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        self.fill(path, |file| file.write_all(bytes))
    }

    /// Opens a file beside its place that is written bit by bit: for tables that do not fit in memory.
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
        let staged = self.incoming().join(path);
        let written = staged
            .parent()
            .map_or(Ok(()), fs::create_dir_all)
            .and_then(|()| File::create(&staged))
            .and_then(|mut file| fill(&mut file));
        written.map_err(|source| failed(&self.folder.join(path), source))?;
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.push(path.to_owned());
        Ok(())
    }

    /// Puts the files in their places and removes `outdated` files and folders. The file `last` stands for all of them: it is
    /// removed first and put back last, so that a process that is killed meanwhile leaves a folder without it.
    ///
    /// # Errors
    /// [`Error::Write`]; the folder is then as it was before.
    pub fn place(self, outdated: &[PathBuf], last: &Path) -> Result<(), Error> {
        let mut paths = std::mem::take(&mut *self.written.lock().unwrap_or_else(PoisonError::into_inner));
        paths.sort_by_key(|path| path == last);
        let mut swap = Swap {
            folder: &self.folder,
            new: self.incoming(),
            old: self.outgoing(),
            done: Vec::new(),
        };
        let _whole = interrupt::undisturbed();
        let swapped = swap.all(&paths, outdated, last);
        if swapped.is_err() {
            swap.undo();
        }
        swapped
    }
}

/// A file that is written bit by bit.
#[derive(Debug)]
pub struct GrowingFile {
    file: BufWriter<File>,
    place: PathBuf,
}

impl GrowingFile {
    /// Adds bytes.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file.write_all(bytes).map_err(|source| failed(&self.place, source))
    }

    /// Waits until all is on the disk.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish(mut self) -> Result<(), Error> {
        let flushed = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        flushed.map_err(|source| failed(&self.place, source))
    }
}

/// Removes what killed processes left half-written in a folder.
pub(crate) fn sweep(folder: &Path) {
    temporary::sweep(folder, UNFINISHED);
}

/// Writes one file whole: a killed process or a full disk leaves the old file or none.
///
/// # Errors
/// [`Error::Write`].
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let name = path
        .file_name()
        .map(Path::new)
        .ok_or_else(|| failed(path, ErrorKind::InvalidFilename.into()))?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let staging = Staging::within(parent.unwrap_or_else(|| Path::new(".")))?;
    staging.write(name, bytes)?;
    staging.place(&[], name)
}

/// Whether a name is that of a file or folder in the same folder: not empty, no path, neither `.` nor `..`.
pub(crate) fn is_file_name(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(only)), None) if only == name)
}

/// Creates a folder with those above it.
///
/// # Errors
/// [`Error::Write`].
pub(crate) fn create(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|source| failed(folder, source))
}

fn failed(path: &Path, source: io::Error) -> Error {
    Error::Write {
        path: path.to_owned(),
        source,
    }
}

/// The renames under way, each of which can be undone.
struct Swap<'a> {
    folder: &'a Path,
    /// Folder of the files that come.
    new: PathBuf,
    /// Folder of the files that go.
    old: PathBuf,
    done: Vec<Step>,
}

/// A change of the folder.
enum Step {
    /// What was at this path is in the folder of old files.
    SetAside(PathBuf),
    /// The new file is at this path.
    Placed(PathBuf),
    /// This folder did not exist.
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

    /// Moves away what is at a path, if there is anything. A new file never takes the place of a folder.
    fn set_aside(&mut self, path: &Path, may_be_folder: bool) -> Result<(), Error> {
        let from = self.folder.join(path);
        let moved = match fs::symlink_metadata(&from) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            Ok(data) if data.is_dir() && !may_be_folder => Err(ErrorKind::IsADirectory.into()),
            found => found.and_then(|_| {
                let to = self.old.join(path);
                to.parent().map_or(Ok(()), fs::create_dir_all)?;
                fs::rename(&from, to)
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
        // Nothing is there any more: some file systems (ext4) write a file to the disk before it replaces another.
        fs::rename(self.new.join(path), &to).map_err(|source| failed(&to, source))?;
        self.done.push(Step::Placed(path.to_owned()));
        Ok(())
    }

    /// Restores the folder. A step that cannot be undone ends the restoration before the file that stands for all others is
    /// back: that one was set aside first.
    fn undo(&mut self) {
        while let Some(step) = self.done.pop() {
            let undone = match &step {
                Step::SetAside(path) => fs::rename(self.old.join(path), self.folder.join(path)),
                Step::Placed(path) => fs::rename(self.folder.join(path), self.new.join(path)),
                // Another process may use it by now.
                Step::Created(folder) => fs::remove_dir(folder).or(Ok(())),
            };
            if undone.is_err() {
                return;
            }
        }
    }
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

    /// Every file under a folder with its content.
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

    fn staged(folder: &Path, files: &[&str]) -> Result<Staging, Error> {
        let staging = Staging::within(folder)?;
        files
            .iter()
            .try_for_each(|file| staging.write(Path::new(file), b"new"))?;
        Ok(staging)
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

    /// The last but one of the files meets an obstacle when all others are in their places.
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
