//! `nailnoise completions`: what a shell completes.

use std::process::ExitCode;

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;

use super::{Cli, print};
use crate::error::Error;

#[derive(Args)]
pub(super) struct Arguments {
    /// The shell; save the output where this shell looks for completions
    shell: Shell,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "nailnoise", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(ExitCode::SUCCESS)
}
