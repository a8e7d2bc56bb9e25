//! Everything a run leaves behind as one value, kept from run to run: an unchanged design is not computed again.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fs, io};

use nailnoise_meshes::write_atomic;
use serde::{Deserialize, Serialize};

use crate::cache::{Bytes, Cache, Key};
use crate::design::Design;
use crate::error::Error;
use crate::pipeline::{self, Observer, Options, Run};
use crate::report::{self, Pictures, Recording};
use crate::result::Check;
use crate::{figures, interrupt, output};

/// The file that is written last, so that a folder that holds it holds all the rest.
const LAST: &str = "result.json";

/// Beginning of the name of the folder in which a run writes before all of its files take their places at once.
const UNFINISHED: &str = ".unfinished-";

/// The microphone whose sound the report holds: in front of the device, half way up.
const IN_THE_REPORT: usize = 1;

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
}

/// A file by its path in the run's folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct File {
    path: PathBuf,
    content: Bytes,
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
    let mut fresh = None;
    let bundle = cache.get_or("run", key(design, draw)?, || {
        let place = Unfinished::within(folder)?;
        let (run, (pictures, fields)) = pipeline::run_telling(
            design,
            Options::default(),
            cache,
            observer,
            "sound and pictures of the bodies",
            |vibration, record| {
                output::write_fields(&place.path, vibration, &record.events)?;
                Ok((Pictures::new(design, vibration), read_all(&place.path)?))
            },
        )?;
        observer.stage("writing files");
        let mut files = write(&place.path, design, &run, &pictures, draw)?;
        files.retain(|file| fields.iter().all(|field| field.path != file.path));
        for file in &fields {
            let to = place.path.join(&file.path);
            if !to.exists() {
                output::create(to.parent().unwrap_or(&place.path))?;
                output::write(&to, &file.content.0)?;
            }
        }
        files.extend(fields);
        let bundle = Bundle {
            json: read_text(&place.path.join(LAST))?,
            text: words(&run),
            checks: run.result.checks,
            files,
        };
        fresh = Some(place);
        Ok::<_, Error>(bundle)
    })?;
    cache.take_notes().iter().for_each(|note| observer.note(note));
    let _whole = interrupt::undisturbed();
    match &fresh {
        Some(place) => bundle.place(folder, |file, to| fs::rename(place.path.join(&file.path), to))?,
        None => {
            observer.stage("the design has not changed: its files are those kept from the last run");
            bundle.place(folder, |file, to| write_atomic(to, &file.content.0))?;
        }
    }
    Ok((bundle, fresh.is_none()))
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
    files.retain(|file| !file.path.starts_with(output::FIELDS));
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
    /// Brings the files into `folder` by `bring`, those that are there already excepted.
    fn place(&self, folder: &Path, bring: impl Fn(&File, &Path) -> io::Result<()>) -> Result<(), Error> {
        let same = |file: &File| fs::read(folder.join(&file.path)).is_ok_and(|there| there == file.content.0);
        if self.files.iter().all(same) {
            return Ok(());
        }
        // While files of two runs are side by side there is no result.
        let last = folder.join(LAST);
        match fs::remove_file(&last) {
            Err(source) if source.kind() != ErrorKind::NotFound => return Err(Error::Write { path: last, source }),
            _ => {}
        }
        let (last, others): (Vec<&File>, Vec<&File>) = self.files.iter().partition(|file| file.path == Path::new(LAST));
        for file in others.into_iter().chain(last) {
            let to = folder.join(&file.path);
            if let Some(parent) = to.parent() {
                output::create(parent)?;
            }
            bring(file, &to).map_err(|source| Error::Write { path: to, source })?;
        }
        Ok(())
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
