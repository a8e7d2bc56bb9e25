//! Work that the Python package does: schedulers of clusters are at home there.

use std::ffi::OsString;
use std::path::Path;

use nailnoise_meshes::child;

use super::Common;
use crate::design::Design;
use crate::error::Error;

/// Environment variable that names the interpreter.
const PYTHON: &str = "NAILNOISE_PYTHON";

/// Runs `python -m nailnoise COMMAND`, which needs the Python package `needed`; returns the exit status. The child ends
/// when this process ends, however that happens.
fn status(needed: &'static str, command: &str, arguments: &[OsString]) -> Result<u8, Error> {
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let missing = |reason: String| Error::NoPython {
        python: python.to_string_lossy().into_owned(),
        needed,
        reason,
    };
    let probe = format!("import nailnoise, {needed}");
    let probe = child::output(child::command(&python).args(["-c", &probe]));
    let probe = probe.map_err(|error| missing(error.to_string()))?;
    if !probe.status.success() {
        let said = String::from_utf8_lossy(&probe.stderr);
        return Err(missing(said.trim().lines().last().unwrap_or_default().to_owned()));
    }
    let status = child::status(
        child::command(&python)
            .args(["-m", "nailnoise", command])
            .args(arguments),
    );
    let code = status.map_err(|error| missing(error.to_string()))?.code();
    match code.and_then(|code| u8::try_from(code).ok()) {
        Some(code) if code < KILLED => Ok(code),
        code => Err(Error::PythonEnded {
            signal: code.map_or(0, |code| code - KILLED),
        }),
    }
}

/// The offset that a shell adds to the number of the signal that ended a program.
const KILLED: u8 = 128;

/// A Dask cluster that fills the store of a command, which then reports the same result as without the cluster.
pub(super) struct Cluster<'a> {
    /// Address of its scheduler.
    pub(super) scheduler: &'a str,
    /// The folder of the command's store.
    pub(super) folder: &'a Path,
    /// Whether its workers share that folder.
    pub(super) shared: bool,
}

impl Cluster<'_> {
    /// Computes the same on the cluster as `python -m nailnoise COMMAND DESIGN` with these arguments.
    pub(super) fn fill(
        &self,
        command: &str,
        (common, design): (&Common, &Design),
        arguments: &[String],
    ) -> Result<(), Error> {
        let mut all: Vec<OsString> = vec![design.path().into(), "--scheduler".into(), self.scheduler.into()];
        all.extend([OsString::from("--folder"), self.folder.into()]);
        if self.shared {
            all.push("--shared".into());
        }
        for assignment in &common.options.changes.set {
            all.extend(["--set".to_owned(), assignment.to_string()].map(OsString::from));
        }
        all.extend(arguments.iter().map(OsString::from));
        match status("distributed", command, &all)? {
            0 => Ok(()),
            status => Err(Error::OnCluster {
                scheduler: self.scheduler.to_owned(),
                status,
            }),
        }
    }
}
