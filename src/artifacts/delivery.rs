//! Delivers a run: computes its files or restores them from the store.

use std::path::Path;
use std::sync::Arc;
use std::thread;

use nailnoise_pipeline::{beside, first_cause};
use rayon::prelude::*;

use super::fields::{FieldFiles, PendingFields, field_files};
use super::reported::{ReportedRun, with_pictures};
use super::{PrintedResult, RunArtifacts};
use crate::atomic_write::{self, AtomicWrite};
use crate::cost::{self, MemoryLimit};
use crate::design::Design;
use crate::design::inputs::located;
use crate::error::Error;
use crate::graph::{Graph, program_key};
use crate::output::{self, BodyFields, Exports, File, LAST, RunView};
use crate::result::RunResult;
use crate::stages::{Digest, Postcard, Progress};
use crate::store::Store;
use crate::study::StudySource;

/// Name of the entries in the store with the artifacts of runs.
const RUN: &str = "run";

/// Formats a result as text.
pub type Printer = fn(&RunResult) -> PrintedResult;

/// A request for a run and its files.
pub struct Delivery<'a> {
    /// The design.
    pub design: &'a Design,
    /// The folder for the files.
    pub folder: &'a Path,
    /// Optional files.
    pub exports: Exports,
    /// Whether to make a few draws if no study applies to the design.
    pub screening: bool,
    /// Formats the result as text.
    pub printer: Printer,
    /// The store of the results.
    pub store: &'a Store,
    /// The memory limit of the run.
    pub memory: MemoryLimit,
    /// Where progress is reported.
    pub progress: &'a Progress,
}

/// A run whose files are in place.
pub struct Delivered {
    /// Its artifacts.
    pub artifacts: RunArtifacts,
    /// Whether it came from the store, so that nothing was computed.
    pub unchanged: bool,
    /// Why the files do not contain intervals of the levels; none if they do.
    pub incomplete: Option<Error>,
}

impl Delivery<'_> {
    /// Runs the design and writes its files, including the exports, to the folder; on failure, the folder is left
    /// unchanged. Nothing is computed if the store contains the output for the same design and study.
    ///
    /// The intervals are part of the result before the first file is written. If they need a screening, the files are
    /// first written with a note that the screening is in progress, so that an interrupted command leaves a complete
    /// result. The files that show intervals are then rendered again.
    ///
    /// # Errors
    /// [`Problem::TooCostly`](crate::design::Problem::TooCostly) before computing anything that exceeds the memory
    /// limit. Those of [`Chain::run`](crate::chain::Chain::run), and [`Error::Write`] with the file that could not be
    /// written.
    pub fn deliver(&self) -> Result<Delivered, Error> {
        let Self {
            design,
            folder,
            exports,
            store,
            progress,
            ..
        } = *self;
        // Also if no file differs and none is written.
        atomic_write::sweep(folder);
        let source = StudySource::find(store, design, self.screening);
        let key = key(design, exports, &source)?;
        let kept = store.load::<RunArtifacts, Postcard>(RUN, &key).and_then(|artifacts| {
            let fields = artifacts.fields.pending(folder, store)?;
            Some((artifacts, fields))
        });
        store.take_notes().iter().for_each(|note| progress.note(note));
        let outdated = output::outdated_fields(folder, &design.digest(), exports.films);
        if let Some((artifacts, fields)) = kept {
            progress.stage("the design has not changed: its files are those kept from the last run");
            artifacts.restore(folder, &fields, &outdated)?;
            return Ok(Delivered {
                artifacts,
                unchanged: true,
                incomplete: None,
            });
        }
        let costs = cost::of_run(design)?;
        cost::refuse(design, &costs, self.memory)?;
        if let Some(announcement) = cost::announcement(&costs) {
            progress.note(&announcement);
        }
        let staging = AtomicWrite::within(folder)?;
        let computed = self.compute(&staging).map_err(|error| located(design, error))?;
        let ComputedRun {
            mut reported,
            of_cycle,
            fields: (fields, pending),
        } = computed;
        reported.state(design, &source);
        progress.stage("writing files");
        let made = |view: &RunView<'_>| rayon::join(|| output::of_run(view), || output::of_study(view));
        let (of_run, of_study) = reported.show(design, exports, made);
        let result = &reported.run.result;
        let mut artifacts = RunArtifacts {
            json: String::new(),
            printed: (self.printer)(result),
            checks: result.numerical_checks().cloned().collect(),
            contradiction: result.study.contradiction(),
            files: [of_cycle, of_run?].concat(),
            fields,
        };
        artifacts.take(of_study?);
        let place = || {
            // Every file is written, even if unchanged, because comparing would take longer.
            let write = |file: &File| staging.write_unsynced(&file.path, &file.content);
            artifacts.files.par_iter().try_for_each(write)?;
            pending.write(&staging)?;
            staging.place(&artifacts.outdated(folder, &outdated), Path::new(LAST))
        };
        let awaits_screening = source.awaits_screening(design, result);
        let save = || {
            if !awaits_screening {
                store.save::<_, Postcard>(RUN, &key, &artifacts);
            }
        };
        let (placed, ()) = rayon::join(place, save);
        store.take_notes().iter().for_each(|note| progress.note(note));
        placed?;
        let incomplete = if awaits_screening {
            self.complete(&mut artifacts, reported, source)?
        } else {
            None
        };
        Ok(Delivered {
            artifacts,
            unchanged: false,
            incomplete,
        })
    }

    /// Performs the screening of a run whose files have been written, and renders the files that show it again. Returns
    /// the error if these cannot be written.
    fn complete(
        &self,
        artifacts: &mut RunArtifacts,
        mut reported: ReportedRun,
        source: StudySource,
    ) -> Result<Option<Error>, Error> {
        let Self {
            design,
            folder,
            exports,
            store,
            progress,
            ..
        } = *self;
        let source = source.screened(store, design, progress);
        reported.state(design, &source);
        progress.stage("writing the intervals");
        artifacts.take(reported.show(design, exports, output::of_study)?);
        let result = &reported.run.result;
        artifacts.printed = (self.printer)(result);
        artifacts.contradiction = result.study.contradiction();
        let placed = artifacts.restore(folder, &PendingFields::default(), &[]);
        // A failed screening is tried again by the next run.
        if result.study.known().is_some() {
            store.save::<_, Postcard>(RUN, &key(design, exports, &source)?, artifacts);
            store.take_notes().iter().for_each(|note| progress.note(note));
        }
        Ok(placed.err())
    }

    /// Runs the design and the exports of its bodies in parallel. New files of fields are written at once.
    fn compute(&self, staging: &AtomicWrite) -> Result<ComputedRun, Error> {
        let Self { design, exports, .. } = *self;
        let graph = Graph::new(Arc::new(self.store.clone()), self.progress.observer());
        let (chain, pictures) = with_pictures(&graph, design)?;
        let fields = graph.add(BodyFields {
            moving: chain.moving.clone(),
            cycle: chain.cycle.clone(),
            films: exports.films,
            slow_motion: if exports.films { exports.slow_motion } else { 0 },
        });
        // The cycle's tables take longest.
        let of_cycle = || output::of_cycle((&*chain.cycle.get()?).into(), exports);
        let files = || field_files(&fields, self.folder, staging, self.store);
        thread::scope(|scope| {
            let (of_cycle, files) = (beside(scope, &of_cycle), beside(scope, &files));
            let mut outputs = chain.outputs();
            outputs.push(&pictures);
            let prepared = graph.prepare(&outputs);
            let (of_cycle, files) = (of_cycle.join(), files.join());
            match (prepared, of_cycle, files) {
                (Ok(()), Ok(of_cycle), Ok(fields)) => Ok(ComputedRun {
                    reported: ReportedRun::of(chain.run(design)?, pictures.get()?)?,
                    of_cycle,
                    fields,
                }),
                (prepared, of_cycle, files) => {
                    first_cause([prepared.err(), of_cycle.err(), files.err()].into_iter().flatten())?;
                    unreachable!("one of them has failed")
                }
            }
        })
    }
}

/// A run, with the inputs of its files.
struct ComputedRun {
    reported: ReportedRun,
    of_cycle: Vec<File>,
    fields: (FieldFiles, PendingFields),
}

/// Everything that the files depend on: all values and their texts, the files requested, and the study.
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
    // The head of the report contains the text of the design.
    let entries = serde_json::to_string(&(entries, design.report(), exports)).map_err(Error::Json)?;
    // The digest depends on the contents of the files named by the design.
    Ok(program_key()
        .with(design.name())
        .with(&design.digest())
        .with(&entries)
        .with(&design.study().require)
        .with(&study.digest())
        .digest())
}
