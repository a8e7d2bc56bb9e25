//! `nailnoise provide`: makes or checks the studies of all shipped designs that come with the program. It is for
//! developers of the program and is not listed by `--help`.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Keeping, Threads, message, print, progress};
use super::{Status, table::table};
use crate::atomic_write;
use crate::design::Design;
use crate::error::Error;
use crate::shipped;
use crate::stages::Progress;
use crate::store::Store;
use crate::study::{self, ProvidedStudy, Request};

/// Smallest number of draws in a provided study, on which pages and the intervals of `run` are based.
const FEWEST: usize = 128;

/// Number of draws that are recomputed if the code has changed, or values that the study does not draw. Each draw
/// passes through all of the code.
const REPEATED: usize = 8;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise provide designs/studies" => "makes the studies of all shipped designs that are not of today",
    "nailnoise provide designs/studies --anew" => "makes all of them",
    "nailnoise provide --check" => "lists which are in the program, and whether they are of today",
))]
pub(super) struct Arguments {
    /// Folder for the studies, designs/studies of the sources
    #[arg(value_name = "DIR", required_unless_present = "check")]
    folder: Option<PathBuf>,
    /// Number of draws
    #[arg(short = 'n', long, value_name = "N", default_value_t = 128,
        value_parser = clap::value_parser!(u32).range(1..=4096))]
    draws: u32,
    /// Seed of the draws
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Make all studies, also those whose first draws have the same levels with the code of today
    #[arg(long, conflicts_with = "check")]
    anew: bool,
    /// Compute nothing: list the studies that are in the program, with status 1 if one is missing, small or outdated
    #[arg(long, conflicts_with = "folder")]
    check: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    keeping: Keeping,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let Some(folder) = &arguments.folder else {
        return check();
    };
    arguments.threads.start()?;
    let request = Request::new(arguments.draws as usize, arguments.seed);
    let studies = Studies {
        folder,
        anew: arguments.anew,
        store: arguments.keeping.cache()?,
        request,
        progress: progress(),
    };
    studies.provide()
}

/// File name of a design's study: `quieter-muffler.json` for `quieter/muffler.toml`.
fn file_name(path: &str) -> String {
    path.trim_end_matches(".toml").replace('/', "-") + ".json"
}

/// The studies of all shipped designs in a folder.
struct Studies<'a> {
    folder: &'a Path,
    /// Whether to remake studies that are up to date.
    anew: bool,
    store: Store,
    request: Request,
    progress: Progress,
}

/// Status of a shipped design's study after an update.
enum Current {
    /// It was up to date in design and code.
    Unchanged,
    /// The code has changed, but its first draws have the same levels.
    Renewed,
    /// It was remade; with the number of draws that cannot be computed.
    Made(usize),
}

impl Studies<'_> {
    /// Updates the study of each shipped design, one after another; they share shots and structures through the cache.
    /// If a study fails, its design is reported and the others are still made.
    fn provide(&self) -> Result<Status, Error> {
        let (mut failed, mut counts) = (Vec::new(), [0; 3]);
        let all = shipped::studied().count();
        for (number, path) in (1..).zip(shipped::studied()) {
            self.progress.note(&format!("study {number} of {all}: {path}"));
            let Some(design) = Design::shipped(path) else {
                failed.push(format!("{path}: the design cannot be read"));
                continue;
            };
            match self.of(path, &design) {
                Ok(Current::Unchanged) => counts[0] += 1,
                Ok(Current::Renewed) => counts[1] += 1,
                Ok(Current::Made(0)) => counts[2] += 1,
                Ok(Current::Made(failures)) => {
                    failed.push(format!("{path}: {failures} draws or shots cannot be computed"))
                }
                Err(error) => failed.push(format!("{path}: {error}")),
            }
        }
        self.progress.end();
        failed.iter().for_each(|reason| message(reason));
        let [unchanged, renewed, made] = counts;
        print(&format!(
            "{made} studies made, {renewed} renewed because {REPEATED} draws repeated their levels, {unchanged} \
             unchanged, {} failed, \
             in {}; a program that is built now has them\n",
            failed.len(),
            self.folder.display()
        ))?;
        Ok(if failed.is_empty() {
            Status::SUCCESS
        } else {
            Status::from(3)
        })
    }

    /// Updates the study of a design.
    fn of(&self, path: &str, design: &Design) -> Result<Current, Error> {
        let (file, request) = (self.folder.join(file_name(path)), &self.request);
        let there = match fs::read_to_string(&file) {
            Ok(text) if !self.anew => ProvidedStudy::read(&text)?,
            _ => None,
        };
        if let Some(there) = there
            && there.has_draws(request.draws, request.seed)
        {
            if there.is_of_this_code() && there.is_of(design)? {
                return Ok(Current::Unchanged);
            }
            let few = Request::new(REPEATED.min(request.draws), request.seed);
            let (few, made) = study::study(&self.store, design, &few, &self.progress)?;
            if let Some(renewed) = there.renewed(design, &few, &made)? {
                atomic_write::write(&file, renewed.file()?.as_bytes())?;
                return Ok(Current::Renewed);
            }
            self.progress.note(&format!("{path}: the levels have changed"));
        }
        let (result, made) = study::study(&self.store, design, request, &self.progress)?;
        let result = result.with_surrogates(design, &made);
        let command = super::study::command(path, &result, "");
        let provided = ProvidedStudy::new(path, design, &command, &result, &made)?;
        atomic_write::write(&file, provided.file()?.as_bytes())?;
        Ok(Current::Made(result.candidates.failures))
    }
}

/// Lists the studies contained in the program. The status is 1 if a design has no study, or one with too few draws or
/// for a different design or code.
fn check() -> Result<Status, Error> {
    let states = ProvidedStudy::states()?;
    let is_good =
        |draws: Option<usize>, changed: &[&str]| draws.is_some_and(|draws| draws >= FEWEST) && changed.is_empty();
    let rows: Vec<Vec<String>> = states
        .iter()
        .map(|own| {
            let state = match (own.draws, own.changed.as_slice()) {
                (None, _) => "none".to_owned(),
                (Some(draws), []) if draws < FEWEST => format!("fewer than {FEWEST} draws"),
                (Some(_), []) => own.repeated.map_or_else(
                    || "of today".to_owned(),
                    |repeated| format!("of today: {repeated} draws repeated their levels"),
                ),
                (Some(_), changed) => format!("{} changed since", changed.join(" and ")),
            };
            let draws = own.draws.map_or_else(|| "-".to_owned(), |draws| draws.to_string());
            vec![own.design.to_owned(), draws, state]
        })
        .collect();
    print(&table(&["design", "draws", "study"], &rows))?;
    Ok(if states.iter().all(|own| is_good(own.draws, &own.changed)) {
        Status::SUCCESS
    } else {
        message("`nailnoise provide designs/studies` makes them anew; then build the program");
        Status::from(1)
    })
}
