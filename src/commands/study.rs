//! `nailnoise study`: levels and orders over designs drawn from the ranges of one.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use super::progress::noted;
use super::python::Cluster;
use super::table::{decibels, table};
use super::{Common, Keeping, message, print, print_json, progress};
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::{Progress, WithoutStages};
use crate::staging::{self, Staging};
use crate::store::Store;
use crate::study::{
    self, Contributions, Draws, Estimate, GroupStudy, InputChanges, InputEnd, OneAtATime, Part, ProvidedStudy, Request,
    StudyResult, Surrogate, SurrogateIndex,
};
use crate::wording::drawn_structures;
use crate::{figures, report, shipped};

/// The file that is written last, so that a folder that holds it holds all the rest.
const LAST: &str = "study.json";

/// Contributions printed for each level.
const PRINTED: usize = 6;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise study my-tool.toml" => "256 draws from the ranges of the design",
    "nailnoise study my-tool.toml -n 2048 --until order=0.05" => "more draws, until the probabilities of the order are known to 0.05",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// Number of draws
    #[arg(short = 'n', long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    draws: u32,
    /// Seed of the draws; the same seed draws the same designs
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Draw the structures (block, table, tool body), too, each for N of the draws; without it they are those of the design.
    /// Modes and radiation of a new structure take minutes
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "8")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    structures: Option<u16>,
    /// Begin with 32 draws and double them until half of the 90 % interval is below a limit, with N draws at most: order=0.05 for
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
    /// State which groups of inputs decide each level, by two more draws for each draw and group, as `exhaust` or `wood`
    #[arg(long, conflicts_with_all = ["task", "collect"])]
    groups: bool,
    /// State what each input does to the levels of the design itself, by two shots for each: at the 5th and the 95th percentile of its
    /// distribution, all others as in the design
    #[arg(long, conflicts_with_all = ["task", "collect"])]
    one_at_a_time: bool,
    /// Also write the study of a shipped design to this file, as those in designs/studies that `nailnoise run` uses
    #[arg(long, value_name = "FILE", conflicts_with = "task")]
    provide: Option<PathBuf>,
    /// Compute the draws on a cluster of Dask, by the address of its scheduler (needs the Python package); with --store, in that
    /// folder, which its workers share
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
    /// Draws that cannot be computed, with the message.
    failures: Vec<(usize, String)>,
    store: PathBuf,
}

/// Draws at first, where a limit says how many there are at last.
const AT_FIRST: usize = 32;

/// A limit for half of an interval.
#[derive(Debug, Clone, Copy)]
enum Until {
    /// Of the probability of being first, for each source.
    Order(f64),
    /// Of the median of the total \[dB\].
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
        let limit = limit.ok_or_else(|| format!("the limit of `{what}` is no number above 0"))?;
        match what.trim() {
            "order" => Ok(Self::Order(limit)),
            "p50" => Ok(Self::Median(limit)),
            other => Err(format!("there is no limit of `{other}`: {known}")),
        }
    }
}

impl Until {
    /// Whether a study is within the limit.
    fn is_met(self, result: &StudyResult) -> bool {
        let within = |estimate: &Estimate, limit: f64| estimate.half_width().is_some_and(|half| half <= limit);
        match self {
            Self::Order(limit) => result.sources.iter().all(|source| within(&source.first, limit)),
            Self::Median(limit) => within(&result.total.level_db.p50, limit),
        }
    }
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let common = &arguments.common;
    common.start_threads()?;
    let design = common.load()?;
    let folder = common.out(&design)?.join("study");
    let shipped = shipped::design(design.name()).map(|(path, _)| path);
    if arguments.provide.is_some() && shipped.is_none() {
        return Err(Error::NotShipped {
            design: design.name().to_owned(),
        });
    }
    if arguments.groups && arguments.structures.is_some() {
        return Err(Error::GroupsOfStructures {
            study: format!("nailnoise study {}", design.path().display()),
        });
    }
    cost::refuse(&design, &cost::of_run(&design)?, common.memory.limit())?;
    let progress = progress();
    let most = arguments.draws as usize;
    let mut request = Request {
        draws: if arguments.until.is_empty() {
            most
        } else {
            most.min(AT_FIRST)
        },
        seed: arguments.seed,
        shots_a_structure: arguments.structures.map(usize::from),
        part: match (arguments.task, arguments.collect) {
            (Some(Task { number, of }), _) => Part::Task { number, of },
            (None, true) => Part::Kept,
            (None, false) => Part::All,
        },
        workpiece_sensors: false,
    };
    let cache = arguments.keeping.cache()?;
    let store = match &arguments.store {
        Some(folder) => Store::at(folder.clone(), u64::MAX),
        None => cache.clone(),
    };
    if let (Some(task), Some(folder)) = (arguments.task, &arguments.store) {
        return execute_task(
            task,
            &draws(&store, &design, &request, &progress)?.0,
            folder,
            common.json,
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
        let (result, made) = compute(&store, &design, &request, &progress)?;
        // Where candidates run out, more are of no use.
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
        let graph = graph(&store, &progress);
        let (groups, table) = study::group_study(&graph, &design, &request, &made, &progress)?;
        (result.groups, partners) = (Some(groups), Some(table));
    }
    if arguments.one_at_a_time {
        let graph = graph(&store, &progress);
        if let Some(nominal) = study::nominal(&graph, &design, &request)? {
            let own = study::one_at_a_time(&graph, &design, &request, (&made, &nominal), &progress)?;
            result.one_at_a_time = Some(own);
        }
    }
    if arguments.store.is_some() || arguments.groups || arguments.one_at_a_time {
        study::keep(&cache, &design, &result)?;
    }
    let within = arguments.until.iter().all(|own| own.is_met(&result));
    let json = serde_json::to_string_pretty(&result).map_err(Error::Json)? + "\n";
    progress.stage("writing files");
    let staging = Staging::within(&folder)?;
    let (charts, scatter) = (figures::study(&result), figures::scatter(&result, &made));
    if arguments.figures {
        figures::write(&staging, "figures".as_ref(), &[&charts[..], &scatter[..]].concat())?;
    }
    staging.write(
        "study.html".as_ref(),
        report::study(&result, &charts, &scatter).as_bytes(),
    )?;
    staging.write("draws.csv".as_ref(), &study::csv(&made)?)?;
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
    if common.json {
        print(&json)?;
    } else {
        print(&text(&result))?;
        print(&format!(
            "\n  files in {}; open study.html for the charts\n",
            folder.display()
        ))?;
    }
    Ok(if result.candidates.failures > 0 {
        ExitCode::from(3)
    } else if within {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

/// Reports what cannot be computed, each reason once, in the order of the first that has it.
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

/// Writes a study of a shipped design for those who have the program.
fn provide(
    file: &Path,
    (arguments, path): (&Arguments, &str),
    (design, result, made): (&Design, &StudyResult, &Draws),
) -> Result<(), Error> {
    let structures = arguments
        .structures
        .map_or_else(String::new, |each| format!(" --structures={each}"));
    let groups = if arguments.groups { " --groups" } else { "" };
    let command = format!(
        "nailnoise study designs/{path} -n {} --seed {}{structures}{groups}",
        result.draws, result.seed
    );
    let text = ProvidedStudy::new(path, design, &command, result, made)?.file()?;
    staging::write(file, text.as_bytes())
}

/// A request in the words of the Python package.
fn arguments_of(request: &Request) -> Vec<String> {
    let numbers = [("--draws", request.draws as u64), ("--seed", request.seed)];
    let each = request.shots_a_structure.map(|each| ("--structures", each as u64));
    let pairs = numbers.into_iter().chain(each);
    pairs
        .flat_map(|(name, number)| [name.to_owned(), number.to_string()])
        .collect()
}

/// States what a task did.
fn execute_task(task: Task, made: &Draws, folder: &Path, json: bool, progress: &Progress) -> Result<ExitCode, Error> {
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
    Ok(ExitCode::SUCCESS)
}

/// A graph that says nothing of its stages.
fn graph(store: &Store, progress: &Progress) -> Graph {
    Graph::new(Arc::new(store.clone()), Arc::new(WithoutStages(progress.observer())))
}

/// The draws that are asked for, and the graph that made them.
fn draws(store: &Store, design: &Design, request: &Request, progress: &Progress) -> Result<(Draws, Graph), Error> {
    let graph = graph(store, progress);
    Ok((study::draws(&graph, design, request, progress)?, graph))
}

/// A study of a design, kept for later runs, and its draws.
pub(super) fn compute(
    store: &Store,
    design: &Design,
    request: &Request,
    progress: &Progress,
) -> Result<(StudyResult, Draws), Error> {
    let (made, graph) = draws(store, design, request, progress)?;
    if request.part == Part::Kept && !made.failures.is_empty() {
        return Err(Error::NotCollected {
            missing: made.failures.len(),
            draws: made.failures.len() + made.draws.len(),
            store: store.folder().map(Path::to_owned).unwrap_or_default(),
        });
    }
    progress.stage("levels of the design itself");
    let nominal = study::nominal(&graph, design, request)?;
    progress.stage("statistics");
    let result = StudyResult::new(design, request, &made, nominal.as_deref());
    study::keep(store, design, &result)?;
    Ok((result, made))
}

/// A probability with the half width of its interval, `0.83 +-0.04`, or its bound, `1.00, > 0.69`.
pub(super) fn probability(estimate: &Estimate) -> String {
    let value = estimate
        .value
        .map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
    match (estimate.value, estimate.interval, estimate.half_width()) {
        // All draws or none: the interval lies on one side.
        (Some(1.0), [Some(low), _], _) => format!("{value}, > {low:.2}"),
        (Some(0.0), [_, Some(high)], _) => format!("{value}, < {high:.2}"),
        (_, _, Some(half)) => format!("{value} +-{half:.2}"),
        _ => value,
    }
}

/// A level with the half width of its interval.
fn level(estimate: &Estimate) -> String {
    match (estimate.value, estimate.half_width()) {
        (Some(value), Some(half)) => format!("{value:.1} +-{half:.1}"),
        (value, _) => decibels(value),
    }
}

/// A difference of levels with its sign.
fn signed(difference: &Estimate) -> String {
    match difference.value {
        Some(value) if value > 0.0 => format!("+{}", level(difference)),
        _ => level(difference),
    }
}

fn percent(part: u64, whole: u64) -> String {
    format!("{:.1}", 100.0 * part as f64 / whole.max(1) as f64)
}

/// Surrogates: how much they predict, and the total indices of the inputs where that is enough.
fn of_surrogates(surrogates: &[Surrogate]) -> String {
    if surrogates.is_empty() {
        return String::new();
    }
    let degree = surrogates.iter().map(|own| own.degree).max().unwrap_or(0);
    let mut text = format!(
        "\n  polynomial in all inputs, degree {degree}; Q2: part of the variance of draws left out that it predicts\n"
    );
    let common = study::common_reason(surrogates);
    let row = |own: &Surrogate| {
        let total = |input: &SurrogateIndex| format!("{} {}", input.variable, probability(&input.total));
        let indices = match &own.not_resolved {
            Some(reason) => format!("not stated: {reason}"),
            None => own
                .inputs
                .iter()
                .take(PRINTED)
                .map(total)
                .collect::<Vec<_>>()
                .join(", "),
        };
        let mut row = vec![own.output.clone(), format!("{:.2}", own.q2), own.terms.to_string()];
        row.extend(common.is_none().then_some(indices));
        row
    };
    let rows: Vec<Vec<String>> = surrogates.iter().map(row).collect();
    let headings = ["output", "Q2", "terms", "total indices"];
    text.push_str(&table(&headings[..rows[0].len()], &rows));
    if let Some(reason) = common {
        let _ = writeln!(text, "  indices of single inputs are not stated: {reason}");
    }
    text
}

/// What the largest contribution exceeds by chance.
fn by_chance(own: &Contributions) -> String {
    match own.by_chance_of_structures {
        None => format!("{:.2}", own.by_chance),
        Some(limit) => format!("{:.2} of shots, {limit:.2} of structures", own.by_chance),
    }
}

/// What single inputs do to the levels of the design.
fn of_single_inputs(own: &OneAtATime) -> String {
    let mut text = String::from(
        "\n  one input at a time, at the 5th and the 95th percentile of its distribution, all others as in the design; changes in dB\n",
    );
    let change = |change: &Option<f64>| change.map_or_else(|| "-".to_owned(), |change| format!("{change:+.1}"));
    let row = |input: &InputChanges| {
        let [low, high] = &input.ends;
        let changes = low.change_db.iter().zip(&high.change_db);
        let mut row = vec![input.variable.clone()];
        row.extend(changes.map(|(low, high)| format!("{} / {}", change(low), change(high))));
        let shot = |end: &InputEnd| match &end.refused {
            reason if reason.is_empty() => end.outcome.replace('_', " "),
            reason => reason.clone(),
        };
        let shots = [low, high].map(shot);
        row.push(if shots[0] == shots[1] {
            shots[0].clone()
        } else {
            shots.join(" / ")
        });
        row
    };
    let rows: Vec<Vec<String>> = own.inputs.iter().take(PRINTED).map(row).collect();
    let outputs = own.outputs.iter().map(String::as_str);
    let headings: Vec<&str> = std::iter::once("input").chain(outputs).chain(["shot"]).collect();
    text.push_str(&table(&headings, &rows));
    if own.left_out > 0 {
        let _ = writeln!(text, "  {} quantities of bodies are left out", own.left_out);
    }
    text
}

/// The groups of inputs that decide each level.
fn of_groups(study: &GroupStudy) -> String {
    let mut text = format!(
        "\n  groups of inputs, by {} draws with two partners for each group; first-order index: part of the variance that\n  \
         knowing the group takes off; total index: part that remains where all else is known\n",
        study.rows
    );
    if study.incomplete > 0 {
        let _ = writeln!(text, "  {} draws lack a partner and are left out", study.incomplete);
    }
    for own in &study.outputs {
        let _ = writeln!(text, "\n  {}: variance {:.1} dB2", own.output, own.variance_db2);
        let rows = own.groups.iter().map(|group| {
            let quantities = study.groups.iter().find(|known| known.name == group.group);
            vec![
                group.group.clone(),
                quantities.map_or(0, |known| known.variables.len()).to_string(),
                probability(&group.first_order),
                probability(&group.total),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        text.push_str(&table(
            &["group", "quantities", "first-order index", "total index"],
            &rows,
        ));
    }
    text
}

fn text(result: &StudyResult) -> String {
    let structures = drawn_structures(result.structures);
    let drawn = result.variables.iter().filter(|variable| variable.drawn).count();
    let mut text = format!(
        "{}: {} draws of {drawn} quantities, {structures} (seed {})\n\
         A-weighted single-event sound power levels, dB re 1 pW s; +-: half of the 90 % interval of the estimate\n\n",
        result.design.name, result.draws, result.seed
    );
    let place = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), |share| format!("{:.0} %", 100.0 * share));
    let row = |name: &str, own: &crate::study::LevelStudy| {
        vec![
            name.to_owned(),
            decibels(own.nominal_db),
            place(own.below_nominal),
            level(&own.level_db.p05),
            level(&own.level_db.p50),
            level(&own.level_db.p95),
        ]
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    for source in &result.sources {
        let mut cells = row(&source.source, &source.level);
        cells.push(probability(&source.first));
        cells.push(level(&source.loss_db));
        cells.push(level(&source.silencing_db));
        rows.push(cells);
    }
    rows.push(row("total", &result.total));
    let headings = [
        "source",
        "design",
        "draws below",
        "P5",
        "P50",
        "P95",
        "P(first)",
        "loss dB",
        "silenced dB",
    ];
    text.push_str(&table(&headings, &rows));
    text.push_str("\n  loss: expected distance to the loudest source; silenced: expected fall of the total without the source\n\n");
    let orders = result
        .orders
        .iter()
        .map(|own| vec![own.order.join(" > "), probability(&own.probability)]);
    text.push_str(&table(&["order", "probability"], &orders.collect::<Vec<_>>()));
    text.push('\n');
    let louder = result.louder.iter().map(|own| {
        vec![
            format!("{} louder than {}", own.source, own.than),
            probability(&own.probability),
        ]
    });
    text.push_str(&table(&["pair", "probability"], &louder.collect::<Vec<_>>()));
    for own in &result.contributions {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "\n  {}: variance {:.1} dB2; inputs that explain more of it than chance ({}):",
            own.output,
            own.variance_db2,
            by_chance(own)
        );
        let rows = own.inputs.iter().take(PRINTED).map(|input| {
            vec![
                input.variable.clone(),
                probability(&input.part()),
                signed(&input.effect()),
            ]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        if rows.is_empty() {
            text.push_str("  not resolved with so many draws\n");
        } else {
            text.push_str(&table(
                &["input", "part of variance", "upper less lower third dB"],
                &rows,
            ));
        }
    }
    text.push_str(&of_surrogates(&result.surrogates));
    if let Some(groups) = &result.groups {
        text.push_str(&of_groups(groups));
    }
    if let Some(own) = &result.one_at_a_time {
        text.push_str(&of_single_inputs(own));
    }
    let candidates = &result.candidates;
    let shots: u64 = candidates.outcomes.values().sum();
    let _ = writeln!(text, "\n  {} candidates, {shots} shots", candidates.drawn);
    let mut counts: Vec<(&String, &u64)> = candidates.outcomes.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1));
    let rows = counts.into_iter().map(|(name, count)| {
        let counts = result.require.is_empty() || result.require.contains(name);
        let mark = if counts { "counts" } else { "" };
        vec![
            name.replace('_', " "),
            count.to_string(),
            percent(*count, shots),
            mark.to_owned(),
        ]
    });
    text.push_str(&table(&["the shot", "candidates", "%", ""], &rows.collect::<Vec<_>>()));
    let reasons = candidates.refused.iter().chain(&candidates.rejections);
    let rows: Vec<Vec<String>> = reasons
        .map(|(keys, count)| vec![keys.clone(), count.to_string()])
        .collect();
    if !rows.is_empty() {
        text.push_str(&table(&["incompatible values", "drawn anew"], &rows));
    }
    text.push('\n');
    text + &noted(&result.notes)
}
