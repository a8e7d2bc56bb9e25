//! The command line: one file per command, and their common parts (arguments, threads, progress, exit status).
//!
//! Results go to standard output, progress and warnings to standard error. Exit status: 0 done; 1 done, but a limit is
//! not met; 2 wrong usage or input; 3 a numerical check failed; 101 a fault of the program; 130 interrupted.

/// Example commands with their purpose, shown at the end of a help text.
macro_rules! examples {
    ($($command:literal => $what:literal),+ $(,)?) => {
        concat!("Examples:", $("\n  ", $command, "\n      ", $what),+)
    };
}

mod assembly;
mod bodies;
mod cache;
mod calibrate;
mod calibration_check;
mod check;
mod cli;
mod compare;
mod compare_measured;
mod comparison_page;
mod comparison_sounds;
mod completions;
mod cycle;
mod declare;
mod draw;
mod drawing;
mod effects;
mod explain;
mod faults;
mod init;
mod list;
mod manual;
mod measure;
mod mesh;
mod migrate;
mod modes;
mod next_lines;
mod optimise;
mod penetration;
mod progress;
mod provide;
mod python;
mod red;
mod run;
mod schema;
mod sensitivity;
mod stage_words;
mod status;
mod structures;
mod study;
mod study_text;
mod surface_records;
mod sweep;
mod table;
mod test;
mod user_folders;
mod verify;
mod watch;

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use crate::atomic_write::is_file_name;
use crate::cost::MemoryLimit;
use crate::design::inputs::assembly::AssembledTool;
use crate::design::{Assignment, Design, OutsideValue, Warning};
use crate::error::Error;
use crate::result::Check;
use crate::store::{Store, StoreError};
use crate::units::Units;
use crate::wording::visible;
pub use cli::{main, main_with};
pub(super) use progress::progress;
use red::red;
pub use status::Status;
use table::words;

/// Arguments common to all commands that compute from a design.
#[derive(Args)]
struct Common {
    /// Design file (TOML)
    design: PathBuf,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    shown: Shown,
}

/// Options common to all commands that compute.
#[derive(Args)]
struct Options {
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    /// Folder for the output files [default: out/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    memory: Memory,
    #[command(flatten)]
    changes: Changes,
}

impl Common {
    /// Starts the threads, reads the design and prints warnings. Refuses an assembly.
    fn begin(&self) -> Result<Design, Error> {
        self.options.begin(&self.design)
    }

    /// Starts the threads, reads the design and prints warnings.
    fn begin_with_any_tool(&self) -> Result<Design, Error> {
        self.options.begin_with_any_tool(&self.design)
    }

    /// The folder for the output files of this design.
    fn out(&self, design: &Design) -> Result<PathBuf, Error> {
        self.options.out(design)
    }
}

impl Options {
    /// Starts the threads, reads a design and prints warnings. Refuses an assembly.
    fn begin(&self, path: &Path) -> Result<Design, Error> {
        let design = self.begin_with_any_tool(path)?;
        design.refuse_assembly()?;
        Ok(design)
    }

    /// Starts the threads, reads a design and prints warnings.
    fn begin_with_any_tool(&self, path: &Path) -> Result<Design, Error> {
        self.threads.start()?;
        self.changes.load(path)
    }

    /// The folder for the output files of a design.
    fn out(&self, design: &Design) -> Result<PathBuf, Error> {
        given_or_named(self.out.as_deref(), design.name(), design.path())
    }
}

/// Units of the printed output of a command.
#[derive(Args, Clone, Copy)]
struct Shown {
    /// Units of the terminal, of pages and of charts; JSON and CSV are in SI
    #[arg(long, value_enum, value_name = "SYSTEM", default_value_t)]
    #[arg(env = "NAILNOISE_UNITS", hide_env_values = true)]
    units: Units,
}

impl Shown {
    /// Writes text to standard output in these units.
    fn print(self, text: &str) -> Result<(), Error> {
        print(&self.units.text(text))
    }
}

/// Memory limit of a command.
#[derive(Args)]
struct Memory {
    /// Largest memory that one stage may need, such as 8GB [default: three quarters of the free memory]
    #[arg(long, value_name = "LIMIT")]
    memory: Option<MemoryLimit>,
}

impl Memory {
    fn limit(&self) -> MemoryLimit {
        self.memory.unwrap_or_default()
    }
}

/// The folder below `out` that is named after the design in the file `path`.
fn folder_of(out: &Path, name: &str, path: &Path) -> Result<PathBuf, Error> {
    if is_file_name(name) {
        return Ok(out.join(name));
    }
    Err(Error::NoFolderName {
        path: path.to_owned(),
        name: name.to_owned(),
    })
}

/// The folder given by `--out`, or `out/NAME` for the subject of the file `path`.
fn given_or_named(given: Option<&Path>, name: &str, path: &Path) -> Result<PathBuf, Error> {
    match given {
        Some(folder) => Ok(folder.to_owned()),
        None => folder_of(Path::new("out"), name, path),
    }
}

/// Whether cached results are used.
#[derive(Args)]
struct Keeping {
    /// Compute everything anew and store nothing in the cache
    #[arg(long)]
    no_cache: bool,
}

impl Keeping {
    /// The user's cache. If it cannot be used, a warning is printed and nothing is cached.
    fn cache(&self) -> Result<Store, Error> {
        if self.no_cache {
            return Ok(Store::none());
        }
        match Store::of_user() {
            Err(cause) if cause.is_dispensable() => {
                report(WithoutCache { cause });
                Ok(Store::none())
            }
            found => Ok(found?),
        }
    }
}

/// A run has no cache although the user did not request that.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("results are not cached: {cause}")]
#[diagnostic(
    severity(Warning),
    help("set NAILNOISE_CACHE to a folder, or leave the cache out with --no-cache")
)]
struct WithoutCache {
    cause: StoreError,
}

/// Values that override those of a design file.
#[derive(Args)]
struct Changes {
    /// Another value for a key of the design, as supply.pressure=80psig; may be repeated, the last one for a key counts
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Assignment>,
}

impl Changes {
    /// Reads a design with these values and prints its warnings.
    fn load(&self, path: &Path) -> Result<Design, Error> {
        let design = self.load_without_ranges(path)?;
        let outside: Vec<&Warning> = design.warnings().iter().filter(|own| is_outside(own)).collect();
        if outside.len() <= AT_THEIR_PLACE {
            outside.into_iter().for_each(|warning| report(warning.clone()));
        } else {
            message(&format!(
                "warning: {} values are outside the ranges that the design gives:\n\n{}\n  give each its own range if \
                 it is meant; \
                 `nailnoise check` states the consequences",
                outside.len(),
                outside_table(&design.outside_values(), Units::Si)
            ));
        }
        Ok(design)
    }

    /// Same as `load`, without warnings about values outside their ranges, which the command shows itself.
    fn load_without_ranges(&self, path: &Path) -> Result<Design, Error> {
        let design = Design::load_with(path, &self.set)?;
        let warnings = design.warnings().iter().filter(|own| !is_outside(own));
        warnings.for_each(|warning| report(warning.clone()));
        Ok(design)
    }
}

/// Prints the warnings about the file of an assembly, without those about values outside their ranges.
fn warn(tool: &AssembledTool) {
    let warnings = tool.warnings.iter().filter(|own| !is_outside(own));
    warnings.for_each(|warning| report(warning.clone()));
}

/// Largest number of out-of-range values that are shown at their places in the file; more are shown as a table.
const AT_THEIR_PLACE: usize = 3;

/// Whether a warning concerns a value outside its range.
fn is_outside(warning: &Warning) -> bool {
    matches!(warning, Warning::OutsideRange { .. })
}

/// Values outside their ranges: key, value, range, consequence.
fn outside_table(values: &[OutsideValue], units: Units) -> String {
    let row = |own: &OutsideValue| {
        let [low, high] = &own.range;
        let of = if own.of == "class" { "such tools" } else { "the design" };
        vec![
            own.key.clone(),
            own.value.clone(),
            format!("{low} .. {high}"),
            of.to_owned(),
            own.consequence.clone(),
        ]
    };
    let rows: Vec<Vec<String>> = values.iter().map(row).collect();
    words(&["key", "value", "range", "of", "consequence"], &rows, units)
}

/// Threads that a command may use.
#[derive(Args)]
struct Threads {
    /// Number of threads; results do not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)))]
    threads: Option<u16>,
}

impl Threads {
    /// Sets the size of the process's thread pool; by default all cores.
    fn start(&self) -> Result<(), Error> {
        let number = match self.threads {
            Some(number) => usize::from(number),
            None => of_environment()?,
        };
        rayon::ThreadPoolBuilder::new()
            .num_threads(number)
            .build_global()
            .map_err(Error::Threads)
    }
}

/// Largest number of threads that a command starts.
const MOST_THREADS: u16 = 1024;

/// Number of threads from the thread pool's environment variable; 0, which means all cores, if it is not set.
fn of_environment() -> Result<usize, Error> {
    let Some(found) = std::env::var_os("RAYON_NUM_THREADS").filter(|found| !found.is_empty()) else {
        return Ok(0);
    };
    let found = found.to_string_lossy().into_owned();
    match found.trim().parse() {
        Ok(number) if number <= usize::from(MOST_THREADS) => Ok(number),
        _ => Err(Error::NumberOfThreads { found }),
    }
}

/// Whether messages have colours.
fn coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Status 0 if all checks pass, else 3; failed checks are printed to standard error.
fn status_of(checks: &[Check]) -> Status {
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.ok).collect();
    for check in &failed {
        // Errors of the coupling in time are those of its step.
        let remedy = if check.name.starts_with("coupling: work difference") {
            "; a smaller `analysis.time_step` reduces it, about with the square of the step"
        } else {
            ""
        };
        message(&format!(
            "check failed: {} is {:.3e}, limit {:.3e}; do not rely on the result{remedy}",
            check.name, check.value, check.limit
        ));
    }
    if failed.is_empty() {
        Status::SUCCESS
    } else {
        Status::from(3)
    }
}

/// Writes a line to standard error. If nobody can read it, the work continues.
fn message(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", visible(text, coloured()));
}

/// Prints an error or a warning with its place and remedy to standard error.
fn report(diagnostic: impl miette::Diagnostic + Send + Sync + 'static) {
    message(format!("{:?}", miette::Report::new(diagnostic)).trim_end_matches('\n'));
}

/// The headline of a shot for standard output, in red; empty for a shot that drives its nail.
fn alarm(lines: &[String]) -> String {
    let (first, rest) = lines.split_at(lines.len().min(1));
    let first = first.iter().map(|line| red(line));
    let lines: String = first
        .chain(rest.iter().cloned())
        .map(|line| format!("{line}\n"))
        .collect();
    if lines.is_empty() { lines } else { format!("{lines}\n") }
}

/// Writes text to standard output.
fn print(text: &str) -> Result<(), Error> {
    printed(std::io::stdout().lock().write_all(visible(text, false).as_bytes()))
}

/// Result of writing to standard output. If the reader stops reading (`| head`), this is not an error.
fn printed(outcome: std::io::Result<()>) -> Result<(), Error> {
    match outcome.and_then(|()| std::io::stdout().flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(Error::Output { source }),
        _ => Ok(()),
    }
}

/// Prints one JSON value.
fn print_json<T: serde::Serialize>(value: &T) -> Result<(), Error> {
    let mut text = serde_json::to_string_pretty(value).map_err(Error::Json)?;
    text.push('\n');
    print(&text)
}
