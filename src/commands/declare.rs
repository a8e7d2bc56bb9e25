//! `nailnoise declare`: the noise declaration of a design as one page to print, and as a document.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{Changes, Keeping, Memory, Shown, Status, Threads, given_or_named, message, print_json, status_of};
use crate::artifacts::Delivery;
use crate::atomic_write;
use crate::comparison::{self, ComparisonError};
use crate::declaration::{self, Finished, Use};
use crate::error::Error;
use crate::output::Exports;
use crate::report;
use crate::result::{Check, Declaration, EarReport};

/// Names of the page and of the document in the folder of a run.
const PAGE: &str = "declaration.html";
const DOCUMENT: &str = "declaration.docx";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise declare my-tool.toml" => "the declared levels; the sheet is out/my-tool/declaration.html and .docx",
    "nailnoise declare out/my-tool --rate 2 --shots-a-day 1500" => "of a finished run, with the exposure of a day",
))]
pub(super) struct Arguments {
    /// Design file or finished result (a folder with result.json, or the file)
    design: PathBuf,
    /// Shots a second, for the levels in use
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = positive)]
    rate: f64,
    /// Shots of a working day, for the daily noise exposure
    #[arg(long, value_name = "N", default_value_t = 1000.0, value_parser = positive)]
    shots_a_day: f64,
    /// Print exactly one JSON value instead of text
    #[arg(long)]
    json: bool,
    /// Folder for the output files [default: out/NAME, or the folder of the result]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    keeping: Keeping,
    #[command(flatten)]
    memory: Memory,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    shown: Shown,
}

/// A number above zero.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("expected a number above zero".to_owned()),
    }
}

/// Layout of `declare --json`.
#[derive(serde::Serialize)]
struct Layout<'a> {
    schema: &'static str,
    design: &'a str,
    declaration: &'a Declaration,
    ear: &'a EarReport,
    shots_per_second: f64,
    shots_a_day: f64,
    lwa_db: Option<f64>,
    lpa_db: Option<f64>,
    lex_8h_db: Option<f64>,
    page: String,
    document: String,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.threads.start()?;
    let mut checks: Vec<Check> = Vec::new();
    let (text, path) = match comparison::Finished::is_at(&arguments.design) {
        Some(file) => {
            let unreadable = |source| Error::Unreadable {
                path: file.clone(),
                source,
            };
            comparison::Finished::read(&file)?;
            (std::fs::read_to_string(&file).map_err(unreadable)?, file)
        }
        None => computed(arguments, &mut checks)?,
    };
    let of: Finished = serde_json::from_str(&text).map_err(|error| ComparisonError::NotAResult {
        path: path.clone(),
        reason: error.to_string(),
    })?;
    let usage = Use {
        rate: arguments.rate,
        shots_a_day: arguments.shots_a_day,
    };
    let folder = arguments.out.clone().or_else(|| path.parent().map(Path::to_owned));
    let folder = folder.unwrap_or_default();
    let [page, document] = [PAGE, DOCUMENT].map(|name| folder.join(name));
    let units = arguments.shown.units;
    atomic_write::write(&page, report::declaration(&of, usage, units).as_bytes())?;
    atomic_write::write(&document, &report::declaration_document(&of, usage, units)?)?;
    let levels = usage.levels(of.total.lwa_db, of.ear.lpa_1s_db);
    if arguments.json {
        print_json(&Layout {
            schema: "nailnoise-declaration/1",
            design: &of.design.name,
            declaration: &of.declaration,
            ear: &of.ear,
            shots_per_second: usage.rate,
            shots_a_day: usage.shots_a_day,
            lwa_db: levels.power_db,
            lpa_db: levels.pressure_db,
            lex_8h_db: levels.exposure_db,
            page: page.display().to_string(),
            document: document.display().to_string(),
        })?;
    } else {
        let [power, peak] = declaration::lines(&of.declaration, &of.ear);
        let exposure = levels.exposure_db;
        let exposure = exposure.map_or_else(|| "silent".to_owned(), |db| format!("{db:.0} dB"));
        arguments.shown.print(&format!(
            "{}: declared values\n\n  {power}\n  {peak}\n  L_EX,8h {exposure} by {} shots a day\n\n  as a page to \
             print: {}\n  as a document to edit: {}\n",
            of.design.name,
            usage.shots_a_day,
            page.display(),
            document.display()
        ))?;
    }
    let status = status_of(&checks);
    if status == Status::SUCCESS && of.outcome != "drives" {
        message(&format!(
            "the shot {}: its levels must not be declared",
            of.outcome.replace('_', " ")
        ));
        return Ok(Status::from(1));
    }
    Ok(status)
}

/// Runs the design like `nailnoise run`; its `result.json`, and where that is.
fn computed(arguments: &Arguments, checks: &mut Vec<Check>) -> Result<(String, PathBuf), Error> {
    let design = arguments.changes.load(&arguments.design)?;
    let folder = given_or_named(arguments.out.as_deref(), design.name(), design.path())?;
    let progress = arguments.shown.progress();
    let delivery = Delivery {
        design: &design,
        folder: &folder,
        exports: Exports {
            units: arguments.shown.units,
            ..Exports::default()
        },
        screening: true,
        printer: super::run::printed,
        store: &arguments.keeping.cache()?,
        memory: arguments.memory.limit(),
        progress: &progress,
    };
    let artifacts = delivery.deliver()?.artifacts;
    progress.end();
    checks.extend(artifacts.checks);
    Ok((artifacts.json, folder.join(crate::output::LAST)))
}
