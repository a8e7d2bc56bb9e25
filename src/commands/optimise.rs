//! `nailnoise optimise`: the designs of the lowest level, by the optimiser of the Python package.
//!
//! Well-kept optimisers with constraints, integers, choices and fronts are at home in Python (Optuna). The package `nailnoise` calls
//! them; this command passes its arguments on.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

use clap::Args;

use crate::error::Error;

/// Variable that names the interpreter.
const PYTHON: &str = "NAILNOISE_PYTHON";

/// Whether the interpreter has the package and the optimiser.
const PROBE: &str = "import nailnoise, optuna";

#[derive(Args)]
#[command(disable_help_flag = true)]
#[command(after_help = examples!(
    "nailnoise optimise my-tool.toml --vary exhaust.holes=3..12 --subject-to \"penetration >= 80 mm\"" =>
        "the quietest number of holes that still drives the nail",
))]
pub(super) struct Arguments {
    /// DESIGN --vary KEY=LOW..HIGH [--minimise WHAT] [--subject-to "penetration >= 80 mm"] [--pareto=-drive_energy] [--trials N];
    /// --help lists all
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let python = std::env::var_os(PYTHON).unwrap_or_else(|| "python3".into());
    let missing = |reason: String| Error::NoOptimiser {
        python: python.to_string_lossy().into_owned(),
        reason,
    };
    let probe = Command::new(&python).args(["-c", PROBE]).output();
    let probe = probe.map_err(|error| missing(error.to_string()))?;
    if !probe.status.success() {
        let said = String::from_utf8_lossy(&probe.stderr);
        return Err(missing(said.trim().lines().last().unwrap_or_default().to_owned()));
    }
    let status = Command::new(&python)
        .args(["-m", "nailnoise", "optimise"])
        .args(&arguments.arguments)
        .status()
        .map_err(|error| missing(error.to_string()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(1)))
}
