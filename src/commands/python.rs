//! Commands that the Python package does: optimisers and schedulers are at home there.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

use super::Common;
use crate::design::Design;
use crate::error::Error;

/// Variable that names the interpreter.
const PYTHON: &str = "NAILNOISE_PYTHON";

/// Calls `python -m nailnoise COMMAND`, which needs a package beside nailnoise; the exit status.
pub(super) fn call(needed: &'static str, command: &str, arguments: &[OsString]) -> Result<ExitCode, Error> {
    let status = status(needed, command, arguments)?;
    Ok(ExitCode::from(status))
}

fn status(needed: &'static str, command: &str, arguments: &[OsString]) -> Result<u8, Error> {
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let missing = |reason: String| Error::NoPython {
        python: python.to_string_lossy().into_owned(),
        needed,
        reason,
    };
    let probe = format!("import nailnoise, {needed}");
    let probe = Command::new(&python).args(["-c", &probe]).output();
    let probe = probe.map_err(|error| missing(error.to_string()))?;
    if !probe.status.success() {
        let said = String::from_utf8_lossy(&probe.stderr);
        return Err(missing(said.trim().lines().last().unwrap_or_default().to_owned()));
    }
    let status = Command::new(&python)
        .args(["-m", "nailnoise", command])
        .args(arguments)
        .status()
        .map_err(|error| missing(error.to_string()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.unwrap_or(1))
}

/// A cluster of Dask that fills the store of a command, which then states its result as it would alone.
pub(super) struct Cluster<'a> {
    /// Address of its scheduler.
    pub(super) scheduler: &'a str,
    /// The folder of the command's store.
    pub(super) folder: &'a Path,
    /// Whether its workers share that folder.
    pub(super) shared: bool,
}

impl Cluster<'_> {
    /// Computes on the cluster what `python -m nailnoise COMMAND DESIGN` computes with these arguments.
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
        for assignment in &common.changes.set {
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
