//! `nailnoise optimise`: finds the designs with the lowest level, using the optimiser of the Python package.
//!
//! Well-maintained optimisers with constraints, integers, choices and Pareto fronts are available in Python (Optuna).
//! The package `nailnoise` calls them; this command passes its arguments on.

use std::ffi::OsString;

use clap::Args;

use super::{Status, progress, python};
use crate::error::Error;

#[derive(Args)]
#[command(disable_help_flag = true)]
#[command(after_help = examples!(
    "nailnoise optimise my-tool.toml --vary exhaust.holes=3..12 --subject-to \"penetration >= 80 mm\"" =>
        "the quietest number of holes that still drives the nail",
))]
pub(super) struct Arguments {
    /// DESIGN --vary KEY=LOW..HIGH [--minimise WHAT] [--subject-to "penetration >= 80 mm"] [--pareto=-drive_energy]
    /// [--trials N]; --help lists all
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    // The flag `--quiet` may precede the command's name, and is then not among the arguments.
    let quiet = progress::is_quiet().then(|| OsString::from("--quiet"));
    let all: Vec<OsString> = quiet.into_iter().chain(arguments.arguments.iter().cloned()).collect();
    python::call("optuna", "optimise", &all)
}
