//! All artifacts of a run as one value, stored between runs, so that an unchanged design is not recomputed.

mod delivery;
mod fields;
mod reported;

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::output::{self, File, LAST};
use crate::result::Check;
use crate::stages::headline::Headline;
use fields::{FieldFiles, PendingFields};

pub use delivery::{Delivered, Delivery, Printer};
pub use reported::ReportedRun;

/// The artifacts of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunArtifacts {
    /// `result.json`.
    pub json: String,
    /// The result as shown in a terminal.
    pub printed: PrintedResult,
    /// The checks of the computation.
    pub checks: Vec<Check>,
    /// A check that fails if the design is inconsistent with the draws of its study.
    pub contradiction: Option<Check>,
    files: Vec<File>,
    fields: FieldFiles,
}

/// A result as shown in a terminal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrintedResult {
    /// The headline of a shot that does not drive its nail.
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

impl RunArtifacts {
    /// Replaces the files that have the same paths.
    fn take(&mut self, files: Vec<File>) {
        self.files
            .retain(|own| files.iter().all(|other| other.path != own.path));
        self.files.extend(files);
        let json = self.files.iter().find(|file| is_last(file));
        self.json = json.map_or_else(String::new, |file| String::from_utf8_lossy(&file.content).into_owned());
    }

    /// Outdated files of fields, and outputs in a folder that another run left and this one does not have.
    fn outdated(&self, folder: &Path, fields: &[PathBuf]) -> Vec<PathBuf> {
        let is_left = |path: &&Path| self.files.iter().all(|own| own.path != **path) && folder.join(path).is_file();
        let left = output::fixed_names().filter(is_left).map(Path::to_owned);
        fields.iter().cloned().chain(left).collect()
    }

    /// Writes the files that differ from those in `folder`; writes nothing if all are in place.
    fn restore(&self, folder: &Path, fields: &PendingFields, outdated: &[PathBuf]) -> Result<(), Error> {
        let outdated = &self.outdated(folder, outdated)[..];
        let differs = |file: &&File| !fs::read(folder.join(&file.path)).is_ok_and(|there| there == file.content);
        let mut differing: Vec<&File> = self.files.par_iter().filter(differs).collect();
        if differing.is_empty() && fields.is_empty() && outdated.is_empty() {
            return Ok(());
        }
        if !differing.iter().any(|file| is_last(file)) {
            differing.extend(self.files.iter().find(|file| is_last(file)));
        }
        let staging = AtomicWrite::within(folder)?;
        let write = |file: &&File| staging.write_unsynced(&file.path, &file.content);
        differing.par_iter().try_for_each(write)?;
        fields.write(&staging)?;
        staging.place(outdated, Path::new(LAST))
    }
}

fn is_last(file: &File) -> bool {
    file.path == Path::new(LAST)
}
