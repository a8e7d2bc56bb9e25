//! `nailnoise penetration`: penetration laws, published and own.

mod fit;
mod law;
mod limits;
mod machine;
mod plan;
mod specimen;

use clap::{Args, Subcommand};

use crate::commands::Status;
use crate::error::Error;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise penetration law --law smooth,annular --wood pine --nail 8d" => "published laws side by side",
    "nailnoise penetration fit drives.csv --form \"poly(x,7) + rate + slender\"" => "a law fitted to your own tests",
))]
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
    /// Compute a shot of a test machine, or write virtual tests for `fit`
    Machine(machine::Arguments),
    /// Plan tests at high speed: masses, speeds, depths reached, and the terms that the tests can separate
    Plan(plan::Arguments),
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    match &arguments.command {
        Command::Law(arguments) => law::execute(arguments),
        Command::Fit(arguments) => fit::execute(arguments),
        Command::Machine(arguments) => machine::execute(arguments),
        Command::Plan(arguments) => plan::execute(arguments),
    }
}
