//! `nailnoise study`: levels and rankings over designs drawn from the ranges of one.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::Serialize;

use super::study_text::text;
use super::{Common, Keeping, message, print, print_json};
use super::{Status, python::Cluster};
use crate::atomic_write::{self, AtomicWrite};
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::headline::{self, Headline};
use crate::stages::Progress;
use crate::store::Store;
use crate::study::StudyError;
use crate::study::{self, Draws, Estimate, ProvidedStudy, Request, StudyResult, Subset};
use crate::{figures, report, shipped};

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "study.json";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise study my-tool.toml" => "256 draws from the ranges of the design",
    "nailnoise study my-tool.toml -n 2048 --until order=0.05" => "more draws, until the probabilities of the order \
        are known to 0.05",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// Number of draws
    #[arg(short = 'n', long, value_name = "N", default_value_t = 256,
        value_parser = clap::value_parser!(u32).range(1..=60_000))]
    draws: u32,
    /// Seed of the draws; the same seed draws the same designs
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Draw the structures (block, table, tool body), too, each for N of the draws; without it they are those of the
    /// design. Modes and radiation of a new structure take minutes
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "8")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    structures: Option<u16>,
    /// Begin with 32 draws and double them, up to N, until half of the 90 % interval is below a limit: order=0.05 for
    /// the probability of being first, p50=0.3 for the median of the total in dB, or both
    #[arg(long, value_name = "WHAT=LIMIT", value_delimiter = ',', conflicts_with_all = ["no_cache", "task"])]
    until: Vec<Until>,
    /// Keep the draws in this folder, which tasks on several machines may share, and not in the cache
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    store: Option<PathBuf>,
    /// Compute only task K of N of the draws, without printing a result: for the jobs of an array that share a store
    #[arg(long, value_name = "K/N", requires = "store", conflicts_with_all = ["collect", "figures"])]
    task: Option<Task>,
    /// State the result of draws that are in the store, and compute none
    #[arg(long, requires = "store", conflicts_with = "until")]
    collect: bool,
    /// State which groups of inputs decide each level, by two more draws for each draw and group, as `exhaust` or
    /// `wood`
    #[arg(long, conflicts_with_all = ["task", "collect"])]
    groups: bool,
    /// State the effect of each input on the levels of the design itself. Two shots for each input: at the 5th and the
    /// 95th percentile of its distribution, with all others as in the design
    #[arg(long, conflicts_with_all = ["task", "collect"])]
    one_at_a_time: bool,
    /// Also write the study of a shipped design to this file, as those in designs/studies that `nailnoise run` uses
    #[arg(long, value_name = "FILE", conflicts_with = "task")]
    provide: Option<PathBuf>,
    /// Compute the draws on a cluster of Dask, by the address of its scheduler (needs the Python package); with
    /// --store, in that folder, which its workers share
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["no_cache", "task", "collect"])]
    scheduler: Option<String>,
    /// Draw the charts of the page as SVG
    #[arg(long)]
    figures: bool,
}

/// One of the tasks into which the draws are divided.
#[derive(Debug, Clone, Copy)]
struct Task {
    number: u32,
    of: u32,
}

impl FromStr for Task {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(number, of)| Some((number.trim().parse().ok()?, of.trim().parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err("give K/N with K from 1 to N, as in 3/16".to_owned()),
        }
    }
}

/// Layout of `study --task --json`.
#[derive(Serialize)]
struct TaskResult {
    schema: &'static str,
    task: [u32; 2],
    /// Draws of this task whose levels are in the store.
    draws: usize,
    /// Draws that cannot be computed, with their messages.
    failures: Vec<(usize, String)>,
    store: PathBuf,
}

/// Number of draws in the first step, if a limit determines the final number.
const AT_FIRST: usize = 32;

/// A limit on half of an interval.
#[derive(Debug, Clone, Copy)]
enum Until {
    /// For the probability of being first, for each source.
    Order(f64),
    /// For the median of the total \[dB\].
    Median(f64),
}

impl FromStr for Until {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = "give order=0.05 or p50=0.3";
        let (what, limit) = text.split_once('=').ok_or(known)?;
        let limit = limit
            .trim()
            .parse()
            .ok()
            .filter(|limit: &f64| *limit > 0.0 && limit.is_finite());
        let limit = limit.ok_or_else(|| format!("the limit of `{what}` is not a number above 0"))?;
        match what.trim() {
            "order" => Ok(Self::Order(limit)),
            "p50" => Ok(Self::Median(limit)),
            other => Err(format!("there is no limit of `{other}`: {known}")),
        }
    }
}

impl Until {
    /// Whether a study satisfies the limit.
    fn is_met(self, result: &StudyResult) -> bool {
        let within = |estimate: &Estimate, limit: f64| estimate.half_width().is_some_and(|half| half <= limit);
        match self {
            Self::Order(limit) => result.sources.iter().all(|source| within(&source.first, limit)),
            Self::Median(limit) => within(&result.total.level_db.p50, limit),
        }
    }
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let design = common.begin_with_any_tool()?;
    let folder = common.out(&design)?.join("study");
    let shipped = shipped::design(design.name()).map(|(path, _)| path);
    if arguments.provide.is_some() && shipped.is_none() {
        return Err(Error::NotShipped {
            design: design.name().to_owned(),
        });
    }
    if arguments.groups && arguments.structures.is_some() {
        return Err(StudyError::GroupsOfStructures {
            study: format!("nailnoise study {}", design.path().display()),
        }
        .into());
    }
    cost::refuse(&design, &cost::of_run(&design)?, common.options.memory.limit())?;
    let progress = common.shown.progress();
    let most = arguments.draws as usize;
    let draws_at_first = match arguments.until.as_slice() {
        [] => most,
        _ => most.min(AT_FIRST),
    };
    let mut request = Request {
        shots_a_structure: arguments.structures.map(usize::from),
        part: match (arguments.task, arguments.collect) {
            (Some(Task { number, of }), _) => Subset::Task { number, of },
            (None, true) => Subset::Kept,
            (None, false) => Subset::All,
        },
        ..Request::new(draws_at_first, arguments.seed)
    };
    let cache = arguments.keeping.cache()?;
    let store = match &arguments.store {
        Some(folder) if arguments.collect => Store::in_folder(folder, u64::MAX)?,
        Some(folder) => Store::shared(folder)?,
        None => cache.clone(),
    };
    if let (Some(task), Some(folder)) = (arguments.task, &arguments.store) {
        return execute_task(
            task,
            &study::draws(&Graph::quiet(&store, progress.observer()), &design, &request, &progress)?,
            folder,
            common.options.json,
            &progress,
        );
    }
    let (mut result, made) = loop {
        if let (Some(scheduler), Some(folder)) = (&arguments.scheduler, store.folder()) {
            progress.stage("draws on the cluster");
            let shared = arguments.store.is_some();
            let cluster = Cluster {
                scheduler,
                folder,
                shared,
            };
            cluster.fill("study-on", (common, &design), &arguments_of(&request))?;
        }
        let (result, made) = study::study(&store, &design, &request, &progress)?;
        // If candidates run out, more draws cannot be made.
        if request.draws >= most
            || result.draws < request.draws
            || arguments.until.iter().all(|own| own.is_met(&result))
        {
            break (result, made);
        }
        request.draws = most.min(2 * request.draws);
    };
    result = result.with_surrogates(&design, &made);
    let mut partners = None;
    if arguments.groups {
        let graph = Graph::quiet(&store, progress.observer());
        let (groups, table) = study::group_study(&graph, &design, &request, &made, &progress)?;
        (result.groups, partners) = (Some(groups), Some(table));
    }
    if arguments.one_at_a_time {
        let graph = Graph::quiet(&store, progress.observer());
        match study::nominal(&graph, &design, &request)? {
            Some(nominal) => {
                let own = study::one_at_a_time(&graph, &design, &request, (&made, &nominal), &progress)?;
                result.one_at_a_time = Some(own);
            }
            None => message("the design itself has no levels from which one input at a time could change them"),
        }
    }
    if arguments.store.is_some() || arguments.groups || arguments.one_at_a_time {
        study::store_study(&cache, &design, &result, &made)?;
    }
    let graph = Graph::quiet(&store, progress.observer());
    result.headline = headline::headline_of(&graph, &design)?;
    let within = arguments.until.iter().all(|own| own.is_met(&result));
    let json = serde_json::to_string_pretty(&result).map_err(Error::Json)? + "\n";
    progress.stage("writing files");
    let staging = AtomicWrite::within(&folder)?;
    let units = common.shown.units;
    let [charts, scatter] =
        [figures::study(&result), figures::scatter(&result, &made)].map(|own| figures::in_units(own, units));
    if arguments.figures {
        figures::write(&staging, "figures".as_ref(), &[&charts[..], &scatter[..]].concat())?;
    }
    staging.write(
        "study.html".as_ref(),
        report::study(&result, &charts, &scatter, units).as_bytes(),
    )?;
    for (name, bytes) in ["draws.csv", "draws.h5"].into_iter().zip(study::draw_files(&made)?) {
        staging.write(name.as_ref(), &bytes)?;
    }
    if let Some(partners) = partners {
        staging.write("groups.csv".as_ref(), &partners)?;
    }
    if let Some(own) = &result.one_at_a_time {
        staging.write("one-at-a-time.csv".as_ref(), &study::one_at_a_time_csv(own)?)?;
    }
    staging.write(LAST.as_ref(), json.as_bytes())?;
    staging.place(&[], LAST.as_ref())?;
    if let (Some(file), Some(path)) = (&arguments.provide, shipped) {
        provide(file, (arguments, path), (&design, &result, &made))?;
    }
    progress.end();
    report_failures("draw", &made.failures);
    report_failures("the shot of candidate", &made.tally.failures);
    if common.options.json {
        print(&json)?;
    } else {
        let lines = result.headline.as_ref().map(Headline::lines).unwrap_or_default();
        common.shown.print(&super::alarm(&lines))?;
        common.shown.print(&text(&result))?;
        print(&format!(
            "\n  files in {}; open study.html for the charts\n",
            folder.display()
        ))?;
    }
    Ok(if result.candidates.failures > 0 {
        Status::from(3)
    } else if within {
        Status::SUCCESS
    } else {
        Status::from(1)
    })
}

/// Reports the points or draws that cannot be computed, each reason once, in order of first appearance.
fn report_failures<N: std::fmt::Display>(what: &str, failures: &[(N, String)]) {
    let mut reasons: Vec<(&str, &N, usize)> = Vec::new();
    for (number, reason) in failures {
        match reasons.iter_mut().find(|(own, ..)| own == reason) {
            Some((.., more)) => *more += 1,
            None => reasons.push((reason, number, 0)),
        }
    }
    for (reason, number, more) in reasons {
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        message(&format!("{what} {number}{more} cannot be computed: {reason}"));
    }
}

/// Writes a study of a shipped design, to be included in the program.
fn provide(
    file: &Path,
    (arguments, path): (&Arguments, &str),
    (design, result, made): (&Design, &StudyResult, &Draws),
) -> Result<(), Error> {
    let structures = arguments
        .structures
        .map_or_else(String::new, |each| format!(" --structures={each}"));
    let groups = if arguments.groups { " --groups" } else { "" };
    let command = command(path, result, &format!("{structures}{groups}"));
    let provided = ProvidedStudy::new(path, design, &command, result, made)?;
    atomic_write::write(file, provided.file()?.as_bytes())
}

/// A request as arguments of the Python package.
fn arguments_of(request: &Request) -> Vec<String> {
    let numbers = [("--draws", request.draws as u64), ("--seed", request.seed)];
    let each = request.shots_a_structure.map(|each| ("--structures", each as u64));
    let pairs = numbers.into_iter().chain(each);
    pairs
        .flat_map(|(name, number)| [name.to_owned(), number.to_string()])
        .collect()
}

/// Reports the result of a task.
fn execute_task(task: Task, made: &Draws, folder: &Path, json: bool, progress: &Progress) -> Result<Status, Error> {
    progress.end();
    report_failures("draw", &made.failures);
    if json {
        print_json(&TaskResult {
            schema: "nailnoise-study-task/1",
            task: [task.number, task.of],
            draws: made.draws.len(),
            failures: made.failures.clone(),
            store: folder.to_owned(),
        })?;
    } else {
        print(&format!(
            "task {} of {}: the levels of {} draws are in {}; `--collect` states the result when all tasks are done\n",
            task.number,
            task.of,
            made.draws.len(),
            folder.display()
        ))?;
    }
    Ok(Status::SUCCESS)
}

/// The command that made a study.
pub(super) fn command(path: &str, result: &StudyResult, options: &str) -> String {
    format!(
        "nailnoise study designs/{path} -n {} --seed {}{options}",
        result.draws, result.seed
    )
}
