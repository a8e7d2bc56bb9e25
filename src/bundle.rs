//! All output of a run as one value, stored from run to run: an unchanged design is not computed again.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io, thread};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::chain::{Chain, Options};
use crate::cost::{self, MemoryLimit};
use crate::design::Design;
use crate::design::inputs::{self, located};
use crate::error::Error;
use crate::graph::{Graph, first_cause};
use crate::output::{BodyFields, Exports, Fields, File};
use crate::report::{self, BodyPictures, Pictures, Recording};
use crate::result::{Check, RunResult};
use crate::run::Run;
use crate::stages::headline::Headline;
use crate::stages::{Digest, Postcard, Progress, Stage, Stored};
use crate::staging::{self, Staging};
use crate::store::{Checksum, Key, Store, checksum};
use crate::study::StudySource;
use crate::threads::beside;
use crate::{figures, output};

/// The last file to be written, so that a folder with it has all the rest.
const LAST: &str = "result.json";

/// The microphone whose sound the report contains: in front of the device, half way up.
const IN_THE_REPORT: usize = 1;

/// Names of the entries in the store: all files of a run, and the checksums of the files of its fields.
const RUN: &str = "run";
const CHECKSUMS: &str = "checksums of fields";

/// The output of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bundle {
    /// `result.json`.
    pub json: String,
    /// The result as a person reads it.
    pub text: Text,
    /// The checks of the computation.
    pub checks: Vec<Check>,
    /// The check that fails if the design contradicts the draws of its study.
    pub contradiction: Option<Check>,
    files: Vec<File>,
    fields: FieldFiles,
}

/// A result as a terminal shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// The headline of a shot that does not drive.
    pub headline: Option<Headline>,
    /// Levels with their intervals, and the declaration.
    pub levels: String,
    /// Notes on the shot and on sources.
    pub notes: Vec<String>,
    /// The checks.
    pub checks: String,
    /// The parts of the sources.
    pub parts: String,
}

/// Paths and checksums of the files of [`Fields`]. They are most of a run's bytes and the same in all runs whose bodies
/// move alike: their inputs are stored once, and files in place are not touched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct FieldFiles {
    /// Key of the fields in the store.
    key: Digest,
    files: Vec<(PathBuf, Checksum)>,
}

impl FieldFiles {
    /// Writes all files.
    fn write(staging: &Staging, key: Digest, fields: &Fields) -> Result<Self, Error> {
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

    /// Those that are not in their places under a folder.
    fn missing(&self, folder: &Path) -> Vec<usize> {
        let there = |bytes: &mut Vec<u8>, (path, expected): &(PathBuf, Checksum)| {
            bytes.clear();
            let read = fs::File::open(folder.join(path)).and_then(|mut file| io::copy(&mut file, bytes));
            read.is_ok() && checksum(bytes) == *expected
        };
        let there: Vec<bool> = self.files.par_iter().map_init(Vec::new, there).collect();
        (0..there.len()).filter(|&file| !there[file]).collect()
    }

    /// Those that are not in their places, and their inputs from the store; nothing if it has lost them.
    fn wanted(&self, folder: &Path, store: &Store) -> Option<Wanted> {
        let missing = self.missing(folder);
        if missing.is_empty() {
            store.renew(BodyFields::NAME, &self.key);
            return Some(Wanted::default());
        }
        let fields = store.load::<Fields, Postcard>(BodyFields::NAME, &self.key)?;
        Some(Wanted {
            missing,
            fields: Arc::new(fields),
        })
    }
}

/// Files of fields that are to be put in their places.
#[derive(Default)]
struct Wanted {
    missing: Vec<usize>,
    fields: Arc<Fields>,
}

impl Wanted {
    fn write(&self, staging: &Staging) -> Result<(), Error> {
        let write = |bytes: &mut Vec<u8>, &file: &usize| {
            self.fields.render(file, bytes)?;
            staging.write_unsynced(self.fields.path(file), bytes)
        };
        let written = self.missing.par_iter().map_init(Vec::new, write);
        written.collect()
    }
}

/// A result in words.
pub type Words = fn(&RunResult) -> Text;

/// A request for a run and its files.
pub struct Delivery<'a> {
    /// The design.
    pub design: &'a Design,
    /// The folder for the files.
    pub folder: &'a Path,
    /// The files on request.
    pub exports: Exports,
    /// Whether a few draws are made for a design that no study serves.
    pub screening: bool,
    /// The result in words.
    pub words: Words,
    /// The store of the results.
    pub store: &'a Store,
    /// The memory that the run may use.
    pub memory: MemoryLimit,
    /// Target of the progress.
    pub progress: &'a Progress,
}

/// The output of a run whose files are in their places.
pub struct Delivered {
    /// The output.
    pub bundle: Bundle,
    /// Whether the store contained it, so that nothing was computed.
    pub unchanged: bool,
}

impl Delivery<'_> {
    /// Runs the design and leaves its files in the folder, those of the exports among them: all of them, or the folder as
    /// it was. Nothing is computed if the store contains the output of this very design and of its study.
    ///
    /// All files are of one result, whose intervals are decided before the first is written. If they need a screening, the
    /// files first state that it has not ended, so that an interrupted command leaves a complete result; then those that
    /// show intervals are rendered again from the complete one.
    ///
    /// # Errors
    /// [`Problem::TooCostly`](crate::design::Problem::TooCostly) before anything is computed that needs more than the
    /// memory. Those of [`Chain::run`], and [`Error::Write`] with the file that could not be written.
    pub fn deliver(&self) -> Result<Delivered, Error> {
        let Self {
            design,
            folder,
            exports,
            store,
            progress,
            ..
        } = *self;
        // Also where no file differs and none is written.
        staging::sweep(folder);
        let source = StudySource::find(store, design, self.screening);
        let key = key(design, exports, &source)?;
        let kept = store.load::<Bundle, Postcard>(RUN, &key).and_then(|bundle| {
            let fields = bundle.fields.wanted(folder, store)?;
            Some((bundle, fields))
        });
        store.take_notes().iter().for_each(|note| progress.note(note));
        let outdated = output::outdated_fields(folder, &design.digest(), exports.films);
        if let Some((bundle, fields)) = kept {
            progress.stage("the design has not changed: its files are those kept from the last run");
            bundle.restore(folder, &fields, &outdated)?;
            return Ok(Delivered {
                bundle,
                unchanged: true,
            });
        }
        let costs = cost::of_run(design)?;
        cost::refuse(design, &costs, self.memory)?;
        if let Some(announcement) = cost::announcement(&costs) {
            progress.note(&announcement);
        }
        let staging = Staging::within(folder)?;
        let made = made(design, exports, (folder, &staging), store, progress);
        let Made {
            mut run,
            pictures,
            fields: (fields, wanted),
            of_cycle,
        } = made.map_err(|error| located(design, error))?;
        let study = source.of_run(design, &run.result);
        run.result.state_study(study);
        progress.stage("writing files");
        let of_microphones = output::of_microphones(&run)?;
        let recordings = heard_at(&of_microphones, &run, IN_THE_REPORT);
        let (rest, shown) = rayon::join(
            || of_shot(design, &run, exports),
            || of_result(design, &run, &pictures, &recordings),
        );
        let mut bundle = Bundle {
            json: String::new(),
            text: (self.words)(&run.result),
            checks: run.result.numerical_checks().cloned().collect(),
            contradiction: run.result.study.contradiction(),
            files: [of_cycle, of_microphones, rest?].concat(),
            fields,
        };
        bundle.take(shown?);
        let place = || {
            // Every file, whether or not it is the same as before: a comparison would cost more.
            let write = |file: &File| staging.write_unsynced(&file.path, &file.content);
            bundle.files.par_iter().try_for_each(write)?;
            wanted.write(&staging)?;
            staging.place(&outdated, Path::new(LAST))
        };
        let save = |key: &Digest, bundle: &Bundle| store.save::<_, Postcard>(RUN, key, bundle);
        let pending = source.awaits_screening(design, &run.result);
        let (placed, ()) = rayon::join(place, || {
            if !pending {
                save(&key, &bundle)
            }
        });
        store.take_notes().iter().for_each(|note| progress.note(note));
        placed?;
        if pending {
            let source = source.screened(store, design, progress);
            let study = source.of_run(design, &run.result);
            run.result.state_study(study);
            progress.stage("writing the intervals");
            bundle.take(of_result(design, &run, &pictures, &recordings)?);
            bundle.text = (self.words)(&run.result);
            bundle.contradiction = run.result.study.contradiction();
            if let Err(error) = bundle.restore(folder, &Wanted::default(), &[]) {
                progress.note(&format!("the files lack the intervals of the levels: {error}"));
            }
            // A screening that failed is tried again by the next run.
            if run.result.study.known().is_some() {
                save(&self::key(design, exports, &source)?, &bundle);
                store.take_notes().iter().for_each(|note| progress.note(note));
            }
        }
        Ok(Delivered {
            bundle,
            unchanged: false,
        })
    }
}

/// A run with the inputs of its report.
pub struct Reported {
    /// The run.
    pub run: Run,
    pictures: Arc<Pictures>,
    recordings: Vec<Recording>,
}

impl Reported {
    /// Runs a design and writes no file.
    ///
    /// # Errors
    /// Those of [`Chain::run`].
    pub fn new(graph: &Graph, design: &Design) -> Result<Self, Error> {
        let made = || {
            let (chain, pictures) = with_pictures(graph, design)?;
            let mut outputs = chain.outputs();
            outputs.push(&pictures);
            graph.prepare(&outputs)?;
            let run = chain.run(design)?;
            let recordings = heard_at(&output::of_microphones(&run)?, &run, IN_THE_REPORT);
            Ok(Self {
                pictures: pictures.get()?,
                recordings,
                run,
            })
        };
        made().map_err(|error| located(design, error))
    }

    /// Its report, by the current state of the result.
    pub fn page(&self, design: &Design) -> String {
        report::run(design, &self.run, &self.pictures, &self.recordings)
    }
}

/// The chain of a design whose bodies a run can use, and the pictures of its report.
fn with_pictures(graph: &Graph, design: &Design) -> Result<(Chain, Stored<Pictures>), Error> {
    let chain = Chain::new(graph, design, Options::default())?;
    let pictures = graph.add(BodyPictures {
        moving: chain.moving.clone(),
        surroundings: inputs::exports::surroundings(design)?,
    });
    chain.check_bodies()?;
    Ok((chain, pictures))
}

/// A run with the inputs of its files.
struct Made {
    run: Run,
    pictures: Arc<Pictures>,
    fields: (FieldFiles, Wanted),
    /// Files of the cycle.
    of_cycle: Vec<File>,
}

/// Runs a design and the exports of its bodies side by side. Files of fields that are new are written at once.
fn made(
    design: &Design,
    exports: Exports,
    (folder, staging): (&Path, &Staging),
    store: &Store,
    progress: &Progress,
) -> Result<Made, Error> {
    let graph = Graph::new(Arc::new(store.clone()), progress.observer());
    let (chain, pictures) = with_pictures(&graph, design)?;
    let fields = graph.add(BodyFields {
        moving: chain.moving.clone(),
        cycle: chain.cycle.clone(),
        films: exports.films,
    });
    // The cycle's tables are the longest of all.
    let of_cycle = || {
        let record = chain.cycle.get()?;
        output::of_cycle(&record, exports.histories)
    };
    let files = || field_files(&fields, folder, staging, store);
    thread::scope(|scope| {
        let (of_cycle, files) = (beside(scope, &of_cycle), beside(scope, &files));
        let mut outputs = chain.outputs();
        outputs.push(&pictures);
        let prepared = graph.prepare(&outputs);
        let (of_cycle, files) = (of_cycle.join(), files.join());
        match (prepared, of_cycle, files) {
            (Ok(()), Ok(of_cycle), Ok(fields)) => Ok(Made {
                run: chain.run(design)?,
                pictures: pictures.get()?,
                fields,
                of_cycle,
            }),
            (prepared, of_cycle, files) => {
                first_cause([prepared.err(), of_cycle.err(), files.err()].into_iter().flatten())?;
                unreachable!("one of them has failed")
            }
        }
    })
}

/// Paths and checksums of the files of fields, and those that are to be rendered. Files that are not in the store are
/// rendered at once.
fn field_files(
    fields: &Stored<Fields>,
    folder: &Path,
    staging: &Staging,
    store: &Store,
) -> Result<(FieldFiles, Wanted), Error> {
    let key = fields.key();
    // Its layout is of this file, which is not in the key of the fields.
    let of_checksums = Key::new().with(key).digest();
    if let Some(files) = store.load::<FieldFiles, Postcard>(CHECKSUMS, &of_checksums) {
        let missing = files.missing(folder);
        let fields = if missing.is_empty() {
            store.renew(BodyFields::NAME, key);
            Arc::default()
        } else {
            fields.get()?
        };
        return Ok((files, Wanted { missing, fields }));
    }
    let files = FieldFiles::write(staging, *key, &*fields.get()?)?;
    store.save::<_, Postcard>(CHECKSUMS, &of_checksums, &files);
    Ok((files, Wanted::default()))
}

/// Everything the files depend on: all values, their texts, which files are requested, and the study.
fn key(design: &Design, exports: Exports, study: &StudySource) -> Result<Digest, Error> {
    let entries: Vec<_> = design
        .entries()
        .into_iter()
        .map(|entry| {
            (
                entry.key,
                entry.value,
                (entry.range, entry.range_origin),
                entry.provenance,
                entry.source,
                entry.note,
            )
        })
        .collect();
    // The report has the design's text in its head.
    let entries = serde_json::to_string(&(entries, design.report(), exports)).map_err(Error::Json)?;
    // The digest follows the content of the files that the design names.
    Ok(Key::new()
        .with(design.name())
        .with(&design.digest())
        .with(&entries)
        .with(&design.study().require)
        .with(&study.digest())
        .digest())
}

/// Files that show the study of a run: the ranking, the report and the result.
fn of_result(design: &Design, run: &Run, pictures: &Pictures, recordings: &[Recording]) -> Result<Vec<File>, Error> {
    let report = || File::new("report.html", report::run(design, run, pictures, recordings));
    let (files, report) = rayon::join(|| output::of_result(&run.result), report);
    let mut files = files?;
    files.push(report);
    Ok(files)
}

/// Files of a run other than fields and those of cycle, microphones and [`of_result`].
fn of_shot(design: &Design, run: &Run, exports: Exports) -> Result<Vec<File>, Error> {
    let mut files = output::of_shot(run, exports)?;
    if exports.figures {
        let level = run.result.total.lwa_db;
        let level = level.map_or_else(|| "silent".to_owned(), |level| format!("L_{{WA,1s}} {level:.1} dB"));
        let subject = format!("{}: one shot, {level}", design.name());
        let figure = |chart: &figures::Chart| File::new(format!("figures/{}.svg", chart.name), chart.svg());
        files.extend(figures::sound(&subject, run).iter().map(figure));
    }
    Ok(files)
}

/// Sound of all sources and of each at one microphone.
fn heard_at(files: &[File], run: &Run, microphone: usize) -> Vec<Recording> {
    let recording = |source: &String| {
        let path = output::sound(source, microphone - 1);
        let file = files.iter().find(|file| file.path == path)?;
        Some(Recording {
            name: source.clone(),
            wav: file.content.clone(),
        })
    };
    let sources = run.microphones.signals.iter().rev();
    sources.filter_map(|(source, _)| recording(source)).collect()
}

impl Bundle {
    /// Takes files in place of those with the same paths.
    fn take(&mut self, files: Vec<File>) {
        self.files
            .retain(|own| files.iter().all(|other| other.path != own.path));
        self.files.extend(files);
        let json = self.files.iter().find(|file| file.path == Path::new(LAST));
        self.json = json.map_or_else(String::new, |file| String::from_utf8_lossy(&file.content).into_owned());
    }

    /// Writes the files that differ from those in `folder`, and nothing if all are in their places.
    fn restore(&self, folder: &Path, fields: &Wanted, outdated: &[PathBuf]) -> Result<(), Error> {
        let differs = |file: &&File| !fs::read(folder.join(&file.path)).is_ok_and(|there| there == file.content);
        let mut differing: Vec<&File> = self.files.par_iter().filter(differs).collect();
        if differing.is_empty() && fields.missing.is_empty() && outdated.is_empty() {
            return Ok(());
        }
        let is_last = |file: &&File| file.path == Path::new(LAST);
        if !differing.iter().any(is_last) {
            differing.extend(self.files.iter().find(is_last));
        }
        let staging = Staging::within(folder)?;
        let write = |file: &&File| staging.write_unsynced(&file.path, &file.content);
        differing.par_iter().try_for_each(write)?;
        fields.write(&staging)?;
        staging.place(outdated, Path::new(LAST))
    }
}
