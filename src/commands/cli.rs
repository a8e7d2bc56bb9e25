//! The commands of the program, and the entry point of a process.

use std::ffi::OsString;

use clap::{CommandFactory as _, Parser, Subcommand};

use super::{
    Status, cache, calibrate, check, coloured, compare, compare_measured, completions, cycle, declare, faults, init,
    list, manual, measure, mesh, migrate, modes, optimise, penetration, printed, progress, provide, report, run,
    schema, study, sweep, test, verify, watch,
};
use crate::error::Error;

/// The text of `--version`.
const BUILD: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\ncommit: ",
    env!("NAILNOISE_COMMIT"),
    "\nsources (SHA-256): ",
    env!("NAILNOISE_SOURCES"),
    "\nbuild: ",
    env!("NAILNOISE_PROFILE"),
    "\ntarget: ",
    env!("NAILNOISE_TARGET"),
    "\nfeatures: ",
    env!("NAILNOISE_FEATURES"),
);

/// Predicts the sound power of each source of a pneumatic nailer from its design.
#[derive(Parser)]
#[command(name = "nailnoise", version, long_version = BUILD, about, max_term_width = 120)]
#[command(after_help = concat!(
    examples!(
        "nailnoise init my-tool.toml" => "a design to start from",
        "nailnoise watch my-tool.toml" => "its report in the browser, anew at every save",
        "nailnoise run my-tool.toml" => "the ranked sources, with all files in out/my-tool/",
    ),
    "\n\nExit status: 0 done; 1 done, but a limit is not met; 2 wrong usage or input; 3 a numerical check failed; \
     101 a fault of the program; 130 interrupted."
))]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print warnings and errors only, without progress and notes
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Write a commented design to start from
    Init(init::Arguments),
    /// Rank the sources of a design by their sound power
    Run(run::Arguments),
    /// Run a design whenever it is saved, and show its report with the changes in the browser
    Watch(watch::Arguments),
    /// Compare designs or finished results: the differences and their effect on each source
    Compare(compare::Arguments),
    /// Write the noise declaration of a design as one page to print
    Declare(declare::Arguments),
    /// Draw designs from the ranges: intervals of the levels, probability of each order, and the inputs that decide
    Study(study::Arguments),
    /// Condition the ranges of a design on measurements of the tool: depths, times, pressures, air
    Calibrate(calibrate::Arguments),
    /// Compute the levels over a grid of values
    Sweep(sweep::Arguments),
    /// Look for the design of the lowest level under constraints
    Optimise(optimise::Arguments),
    /// Compute one nailing cycle: pressures, motions, forces and events; with --json, files are written only with --out
    /// or --figures
    Cycle(cycle::Arguments),
    /// Compute the vibration modes of a body
    Modes(modes::Arguments),
    /// Build, read or convert the mesh of a body
    Mesh(mesh::Arguments),
    /// Explain a design, or check the quality of a mesh, and estimate the cost of the computation
    Check(check::Arguments),
    /// Penetration laws: evaluate published ones, fit own tests, plan tests, compute a test machine
    #[command(visible_alias = "prf")]
    Penetration(penetration::Arguments),
    /// Record a virtual wrapping test of a design as EN 12549 measures it
    Test(test::Arguments),
    /// Levels of the sources from the recordings of a wrapping test
    Measure(measure::Arguments),
    /// Compute public benchmarks on this machine and compare them with their references
    Verify(verify::Arguments),
    /// Rename the keys of earlier versions in a design file
    Migrate(migrate::Arguments),
    /// Print the woods, nails, worktables and designs that the program knows by name
    List(list::Arguments),
    /// List, verify or clear cached results
    Cache(cache::Arguments),
    /// Print the JSON Schema of the design file, for editors, or of the result
    Schema(schema::Arguments),
    /// Print the completions for a shell, or install them
    Completions(completions::Arguments),
    /// Print the manual page of a command, or install all
    Manual(manual::Arguments),
    /// Make the studies of all shipped designs that come with the program, or check that they are those of today
    #[command(hide = true)]
    Provide(provide::Arguments),
}

/// Runs the command line of this process.
pub fn main() -> Status {
    main_with(std::env::args_os())
}

/// Runs a command line whose first argument is the name of the program. Installs signal and panic handlers for the
/// process; wrong usage ends the process with status 2.
pub fn main_with(arguments: impl IntoIterator<Item = OsString>) -> Status {
    install_error_style();
    faults::install();
    crate::interrupt::install();
    faults::announce_limits();
    let status = faults::caught(|| {
        let outcome = match Cli::try_parse_from(arguments) {
            Ok(cli) => execute(&cli),
            Err(wrong) if wrong.use_stderr() => wrong.exit(), // with status 2
            Err(help) => printed(help.print()).map(|()| Status::SUCCESS),
        };
        outcome.unwrap_or_else(|error| {
            crate::interrupt::give_way();
            let status = error.exit_status();
            report(error);
            Status::from(status)
        })
    });
    status.unwrap_or_else(|status| {
        crate::interrupt::give_way();
        Status::from(status)
    })
}

fn execute(cli: &Cli) -> Result<Status, Error> {
    if cli.quiet {
        progress::silence();
    }
    match &cli.command {
        Command::Init(arguments) => init::execute(arguments),
        Command::Run(arguments) => run::execute(arguments),
        Command::Watch(arguments) => watch::execute(arguments),
        Command::Compare(arguments) => match &arguments.measured {
            Some(file) => compare_measured::execute(arguments, file),
            None => compare::execute(arguments),
        },
        Command::Declare(arguments) => declare::execute(arguments),
        Command::Study(arguments) => study::execute(arguments),
        Command::Calibrate(arguments) => calibrate::execute(arguments),
        Command::Sweep(arguments) => sweep::execute(arguments),
        Command::Optimise(arguments) => optimise::execute(arguments),
        Command::Cycle(arguments) => cycle::execute(arguments),
        Command::Modes(arguments) => modes::execute(arguments),
        Command::Mesh(arguments) => mesh::execute(arguments),
        Command::Check(arguments) => check::execute(arguments),
        Command::Penetration(arguments) => penetration::execute(arguments),
        Command::Test(arguments) => test::execute(arguments),
        Command::Measure(arguments) => measure::execute(arguments),
        Command::Verify(arguments) => verify::execute(arguments),
        Command::Migrate(arguments) => migrate::execute(arguments),
        Command::List(arguments) => list::execute(arguments),
        Command::Cache(arguments) => cache::execute(arguments),
        Command::Schema(arguments) => schema::execute(arguments),
        Command::Completions(arguments) => completions::execute(arguments, &mut Cli::command()),
        Command::Manual(arguments) => manual::execute(arguments, Cli::command()),
        Command::Provide(arguments) => provide::execute(arguments),
    }
}

/// Prints errors with a caret below the position in the design; without colour if the output is not a terminal.
fn install_error_style() {
    let colour = coloured();
    // The hook can only be set once per process; a second command in the same process keeps the first style.
    let _ = miette::set_hook(Box::new(move |_| {
        Box::new(
            miette::MietteHandlerOpts::new()
                .color(colour)
                .unicode(colour)
                .terminal_links(false)
                .width(100)
                .context_lines(1)
                .build(),
        )
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls `visit` with every command.
    fn each<'a>(command: &'a clap::Command, visit: &mut impl FnMut(&'a clap::Command)) {
        visit(command);
        command.get_subcommands().for_each(|own| each(own, visit));
    }

    /// The words of a shell command up to a pipe or redirection, without preceding variables.
    fn words(line: &str) -> Vec<String> {
        let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
        for letter in line.chars().chain([' ']) {
            match letter {
                '"' => quoted = !quoted,
                ' ' if !quoted => words.push(std::mem::take(&mut word)),
                letter => word.push(letter),
            }
        }
        let end = words.iter().position(|word| ["|", ">"].contains(&word.as_str()));
        words.truncate(end.unwrap_or(words.len()));
        words.into_iter().skip_while(|word| word != "nailnoise").collect()
    }

    #[test]
    fn every_command_has_examples_and_each_can_be_parsed() {
        let mut count = 0;
        each(&Cli::command(), &mut |command| {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<&str> = help
                .lines()
                .filter(|line| line.starts_with("  ") && !line.starts_with("   ") && line.contains("nailnoise "))
                .collect();
            // The examples of the subcommands of `cache` are at their parent.
            let parent = ["list", "verify", "clear"].contains(&command.get_name());
            assert!(!examples.is_empty() || parent, "{} has no examples", command.get_name());
            for line in examples {
                let parsed = Cli::try_parse_from(words(line));
                assert!(
                    parsed.is_ok(),
                    "{line}: {}",
                    parsed.err().map_or_else(String::new, |error| error.to_string())
                );
                count += 1;
            }
        });
        assert!(count > 35, "{count} examples");
    }

    /// Commands that compute or read a design have the same flags with the same names.
    #[test]
    fn flags_are_alike() {
        let has = |command: &clap::Command, flag: &str| command.get_arguments().any(|own| own.get_long() == Some(flag));
        let of = |name: &str| -> clap::Command {
            let found = Cli::command().find_subcommand(name).cloned();
            found.unwrap_or_else(|| panic!("no command {name}"))
        };
        for name in [
            "run", "compare", "study", "sweep", "cycle", "modes", "test", "mesh", "check", "watch",
        ] {
            for flag in ["set", "memory", "threads"] {
                assert!(has(&of(name), flag), "{name} has no --{flag}");
            }
        }
        for name in ["run", "compare", "study", "sweep", "cycle", "modes", "test", "measure"] {
            for flag in ["json", "out", "threads"] {
                assert!(has(&of(name), flag), "{name} has no --{flag}");
            }
        }
        for name in ["mesh", "check", "cache", "list"] {
            assert!(has(&of(name), "json"), "{name} has no --json");
        }
        assert!(
            Cli::command()
                .get_arguments()
                .any(|own| own.get_long() == Some("quiet") && own.is_global_set())
        );
    }
}
