//! `nailnoise prf`: penetration laws, published and own.

mod fit;
mod law;

use std::process::ExitCode;

use clap::{Args, Subcommand};

use crate::error::Error;

#[derive(Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Evaluate, compare and plot published laws, constant forces and tables
    Law(law::Arguments),
    /// Fit a law to measured drives, with its quality and uncertainty
    Fit(fit::Arguments),
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    match &arguments.command {
        Command::Law(arguments) => law::execute(arguments),
        Command::Fit(arguments) => fit::execute(arguments),
    }
}
