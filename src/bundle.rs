//! Everything a run leaves behind as one value, kept from run to run: an unchanged design is not computed again.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use std::{fs, io};

use nailnoise_dynamics::CycleRecord;
use nailnoise_meshes::write_atomic;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::cache::{Bytes, Cache, Key};
use crate::design::Design;
use crate::error::Error;
use crate::pipeline::{self, Observer, Options, Run, Vibration};
use crate::report::{self, Pictures, Recording};
use crate::result::Check;
use crate::{figures, interrupt, output};

/// The file that is written last, so that a folder that holds it holds all the rest.
const LAST: &str = "result.json";

/// Beginning of the name of the folder in which a run writes before all of its files take their places at once.
const UNFINISHED: &str = ".unfinished-";

/// The microphone whose sound the report holds: in front of the device, half way up.
const IN_THE_REPORT: usize = 1;

/// Names of the stages in the cache.
const STAGE: &str = "run";
const OF_BODIES: &str = "sound and pictures of the bodies";
const FIELDS: &str = "fields of the bodies";

/// Age at which an unfinished folder is nobody's.
const ABANDONED: Duration = Duration::from_secs(3600);

/// What a run leaves behind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bundle {
    /// `result.json`.
    pub json: String,
    /// The result as a person reads it, and the parts of its sources.
    pub text: [String; 2],
    /// The checks.
    pub checks: Vec<Check>,
    files: Vec<File>,
    fields: Fields,
}

/// A file by its path in the run's folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct File {
    path: PathBuf,
    content: Bytes,
}

/// Paths and SHA-256 of what the bodies in motion leave. It is most of a run's bytes and the same in all runs whose
/// bodies move alike: kept once under these digests, and left alone where it is in place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Fields(Vec<(PathBuf, [u8; 32])>);

impl Fields {
    /// Of these files, with what is in them.
    fn of(files: Vec<File>) -> (Self, Vec<Bytes>) {
        let (paths, contents): (Vec<PathBuf>, Vec<Bytes>) =
            files.into_iter().map(|file| (file.path, file.content)).unzip();
        let digests: Vec<[u8; 32]> = contents.par_iter().map(|content| digest(&content.0)).collect();
        (Self(paths.into_iter().zip(digests).collect()), contents)
    }

    fn key(&self) -> Key {
        Key::new().with(&self.0)
    }

    /// Those that are not in their places under a folder.
    fn missing(&self, folder: &Path) -> Vec<usize> {
        let there = |(path, expected): &(PathBuf, [u8; 32])| {
            fs::read(folder.join(path)).is_ok_and(|content| digest(&content) == *expected)
        };
        (0..self.0.len())
            .into_par_iter()
            .filter(|&at| !there(&self.0[at]))
            .collect()
    }

    /// Those that are not in their places, from the cache; nothing where it does not hold them.
    fn wanted(&self, folder: &Path, cache: &Cache) -> Option<Vec<File>> {
        let missing = self.missing(folder);
        if missing.is_empty() {
            cache.renew(FIELDS, &self.key());
            return Some(Vec::new());
        }
        let mut contents: Vec<Bytes> = cache.get(FIELDS, &self.key())?;
        let wanted = missing.into_iter().map(|at| {
            let content = std::mem::replace(contents.get_mut(at)?, Bytes(Vec::new()));
            let path = self.0[at].0.clone();
            Some(File { path, content })
        });
        wanted.collect()
    }
}

fn digest(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// How a run is told in words: the table, and the parts of the sources.
pub type Words = fn(&Run) -> [String; 2];

/// Runs a design and leaves its files in `folder`: every file whole, `result.json` last. Nothing is computed when the
/// cache holds what this very design gives; the flag tells whether it did.
///
/// # Errors
/// Those of [`pipeline::run`], and [`Error::Write`] with the file that could not be written.
pub fn deliver(
    design: &Design,
    folder: &Path,
    draw: bool,
    words: Words,
    cache: &Cache,
    observer: &mut dyn Observer,
) -> Result<(Bundle, bool), Error> {
    let key = key(design, draw)?;
    let kept = cache.get(STAGE, &key).and_then(|bundle: Bundle| {
        let fields = bundle.fields.wanted(folder, cache)?;
        Some((bundle, fields))
    });
    if let Some((bundle, fields)) = kept {
        cache.take_notes().iter().for_each(|note| observer.note(note));
        observer.stage("the design has not changed: its files are those kept from the last run");
        let _whole = interrupt::undisturbed();
        bundle.place(folder, &fields, None)?;
        return Ok((bundle, true));
    }
    let unfinished = Unfinished::within(folder)?;
    let [of_bodies, others] = unfinished.parts();
    let fresh = Mutex::new(Vec::new());
    let tell = |vibration: &Vibration, record: &CycleRecord| {
        let write = || {
            output::write_fields(&of_bodies, vibration, &record.events)?;
            read_all(&of_bodies)
        };
        let (files, pictures) = rayon::join(write, || Pictures::new(design, vibration));
        let (fields, contents) = Fields::of(files?);
        *fresh.lock().unwrap_or_else(PoisonError::into_inner) = contents;
        Ok((pictures, fields))
    };
    let options = Options::default();
    let (mut run, (mut pictures, mut fields)) =
        pipeline::run_telling(design, options, cache, observer, OF_BODIES, tell)?;
    let mut kept = Vec::new();
    if !of_bodies.exists() {
        match fields.wanted(folder, cache) {
            Some(wanted) => kept = wanted,
            None => {
                observer.stage("the fields are no longer kept: the bodies once more");
                let vibration;
                (run, vibration) = pipeline::run_in_full(design, options, cache, observer)?;
                (pictures, fields) = tell(&vibration, &run.record)?;
            }
        }
    }
    observer.stage("writing files");
    let contents = fresh.into_inner().unwrap_or_else(PoisonError::into_inner);
    let keep = || {
        if !contents.is_empty() {
            cache.put(FIELDS, &fields.key(), &contents);
        }
    };
    let (files, ()) = rayon::join(|| write(&others, design, &run, &pictures, draw), keep);
    drop(contents);
    let bundle = Bundle {
        files: files?,
        json: read_text(&others.join(LAST))?,
        text: words(&run),
        checks: run.result.checks,
        fields,
    };
    let place = || {
        let _whole = interrupt::undisturbed();
        bundle.place(folder, &kept, Some(&unfinished))
    };
    let (placed, ()) = rayon::join(place, || cache.put(STAGE, &key, &bundle));
    cache.take_notes().iter().for_each(|note| observer.note(note));
    placed?;
    Ok((bundle, false))
}

/// Everything the files depend on: all values, what is said about them, and which files are asked for.
fn key(design: &Design, draw: bool) -> Result<Key, Error> {
    let entries: Vec<_> = design
        .entries()
        .into_iter()
        .map(|entry| {
            (
                entry.key,
                entry.value,
                entry.range,
                entry.provenance,
                entry.source,
                entry.note,
            )
        })
        .collect();
    let entries = serde_json::to_string(&entries).map_err(Error::Json)?;
    // The digest follows the content of the files that the design names.
    Ok(Key::new()
        .with(design.name())
        .with(&design.digest())
        .with(&entries)
        .with(&draw))
}

/// Writes all files but the fields, and returns them.
fn write(folder: &Path, design: &Design, run: &Run, pictures: &Pictures, draw: bool) -> Result<Vec<File>, Error> {
    output::write_run(folder, run)?;
    if draw {
        let level = run.result.total.lwa_db;
        let level = level.map_or_else(|| "silent".to_owned(), |level| format!("L_WA,1s {level:.1} dB"));
        let subject = format!("{}: one shot, {level}", design.name());
        figures::write(&folder.join("figures"), &figures::sound(&subject, design, run))?;
    }
    let recordings = heard_at(folder, run, IN_THE_REPORT)?;
    let mut files = read_all(folder)?;
    let report = File {
        path: "report.html".into(),
        content: Bytes(report::run(design, run, pictures, &recordings).into_bytes()),
    };
    output::write(&folder.join(&report.path), &report.content.0)?;
    files.push(report);
    Ok(files)
}

/// What one microphone hears of all sources and of each.
fn heard_at(folder: &Path, run: &Run, microphone: usize) -> Result<Vec<Recording>, Error> {
    let sources = run.microphones.signals.iter().rev();
    let recording = |source: &String| {
        let path = folder.join(format!("microphones/{source}-{microphone}.wav"));
        let wav = fs::read(&path).map_err(|source| Error::Unreadable { path, source })?;
        Ok(Recording {
            name: source.clone(),
            wav,
        })
    };
    sources.map(|(source, _)| recording(source)).collect()
}

impl Bundle {
    /// Brings the files into `folder`, those that are there already excepted: from where a run has just written them, or
    /// else the bundle's own and these `fields`.
    fn place(&self, folder: &Path, fields: &[File], unfinished: Option<&Unfinished>) -> Result<(), Error> {
        let [of_bodies, others] = unfinished.map(Unfinished::parts).unwrap_or_default();
        let written = unfinished.map(|_| others.as_path());
        let same = |file: &File| fs::read(folder.join(&file.path)).is_ok_and(|there| there == file.content.0);
        let task = |file| Bring::task(file, written);
        let is_last = |file: &&File| file.path == Path::new(LAST);
        let differing = self.files.par_iter().filter(|file| !is_last(file) && !same(file));
        let mut tasks: Vec<(&Path, Bring<'_>)> = differing.map(task).collect();
        if of_bodies.exists() {
            let paths = self.fields.0.iter().map(|(path, _)| path.as_path());
            tasks.extend(paths.map(|path| (path, Bring::Move(of_bodies.join(path)))));
        } else {
            tasks.extend(fields.iter().map(|file| Bring::task(file, None)));
        }
        let last = self.files.iter().find(is_last);
        if tasks.is_empty() && last.is_none_or(same) {
            return Ok(());
        }
        // While files of two runs are side by side there is no result.
        let result = folder.join(LAST);
        match fs::remove_file(&result) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                return Err(Error::Write { path: result, source });
            }
            _ => {}
        }
        let bring = |(path, how): &(&Path, Bring<'_>)| {
            let to = folder.join(path);
            if let Some(parent) = to.parent() {
                output::create(parent)?;
            }
            how.bring(&to).map_err(|source| Error::Write { path: to, source })
        };
        tasks.par_iter().try_for_each(bring)?;
        last.map(task).iter().try_for_each(bring)
    }
}

/// How a file comes to its place.
enum Bring<'a> {
    /// From where it was written a moment ago.
    Move(PathBuf),
    /// From what is kept.
    Write(&'a [u8]),
}

impl<'a> Bring<'a> {
    /// A file, and how it comes.
    fn task(file: &'a File, written: Option<&Path>) -> (&'a Path, Self) {
        let how = written.map_or(Self::Write(&file.content.0), |at| Self::Move(at.join(&file.path)));
        (&file.path, how)
    }

    fn bring(&self, to: &Path) -> io::Result<()> {
        match self {
            Self::Move(from) => fs::rename(from, to),
            Self::Write(content) => write_atomic(to, content),
        }
    }
}

/// A folder that is gone when the run is over, however it ends.
struct Unfinished {
    path: PathBuf,
    _cleaning: interrupt::Cleaning,
}

impl Unfinished {
    fn within(folder: &Path) -> Result<Self, Error> {
        output::create(folder)?;
        sweep(folder);
        let path = folder.join(format!("{UNFINISHED}{}", std::process::id()));
        let cleaning = interrupt::Cleaning::of(&path);
        output::create(&path)?;
        Ok(Self {
            path,
            _cleaning: cleaning,
        })
    }

    /// Where the files of the bodies in motion and all others are written.
    fn parts(&self) -> [PathBuf; 2] {
        ["bodies", "others"].map(|part| self.path.join(part))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // What is left of it does no harm; a later run sweeps it away.
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// Removes what killed processes left; a folder of the last hour may belong to a run under way.
fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let old = entry.metadata().and_then(|data| data.modified());
        let old = old.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > ABANDONED));
        if old && entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// All files under a folder, by their paths in it.
fn read_all(folder: &Path) -> Result<Vec<File>, Error> {
    let mut files = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(inner) = folders.pop() {
        let at = folder.join(&inner);
        let unreadable = |path: &Path| {
            let path = path.to_owned();
            |source| Error::Unreadable { path, source }
        };
        for entry in fs::read_dir(&at).map_err(unreadable(&at))? {
            let entry = entry.map_err(unreadable(&at))?;
            let path = inner.join(entry.file_name());
            if entry.path().is_dir() {
                folders.push(path);
            } else {
                let content = fs::read(entry.path()).map_err(unreadable(&entry.path()))?;
                files.push(File {
                    path,
                    content: Bytes(content),
                });
            }
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

fn read_text(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|source| Error::Unreadable {
        path: path.to_owned(),
        source,
    })
}
