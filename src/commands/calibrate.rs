//! `nailnoise calibrate`: the ranges of a design conditioned on measurements.

use std::path::{Path, PathBuf};

use clap::Args;
use nailnoise_quantities::rounded;
use serde::Serialize;

use super::table::{table, texts};
use super::{
    Keeping, Options, Shown, Status, calibration_check, given_or_named, message, print, print_json, progress,
    structures,
};
use crate::atomic_write::AtomicWrite;
use crate::calibration::{
    self, CalibrationResult, CheckCost, CheckRequest, ConflictRow, LevelRow, NOT_CONVERGED, NextRow, Redrawn, Request,
    StructuresRequest, Treatment, calibrate_structures,
};
use crate::error::Error;
use crate::store::Store;
use crate::{figures, report};

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "calibration.json";

/// Inputs and further measurements that are printed.
const SHOWN: usize = 12;
const NEXT_SHOWN: usize = 8;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise calibrate my-tool.toml --measured my-shots.toml" => "the inputs that the shots determine, and what is \
        predicted now",
    "nailnoise calibrate my-tool.toml --measured my-shots.toml --hold-out depth-60" => "with one measurement as a \
        check",
    "nailnoise calibrate my-tool.toml --next" => "what to measure first",
    "nailnoise calibrate my-tool.toml --measured my-shots.toml --redraw board" => "a design for other boards of the \
        same wood",
    "nailnoise calibrate my-tool.toml --measured my-shots.toml --draws 256 --moves 12" => "a quick look",
    "nailnoise calibrate my-tool.toml --measured my-shots.toml --check 20" => "whether the calibrations of 20 virtual \
        tools contain their truth",
    "nailnoise calibrate --structures examples/plates/spruce.toml" => "elastic constants of plates from tap tests",
))]
pub(super) struct Arguments {
    /// Design file (TOML)
    #[arg(required_unless_present = "structures")]
    design: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    keeping: Keeping,
    #[command(flatten)]
    shown: Shown,
    /// File of measurements (TOML)
    #[arg(long, value_name = "FILE", required_unless_present_any = ["next", "structures"])]
    measured: Option<PathBuf>,
    /// Determine elastic constants of plates from tap tests in a file (TOML), without a design
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "design", "measured", "hold_out", "conflict", "next", "levels", "store", "set", "no_cache",
    ])]
    structures: Option<PathBuf>,
    /// Number of draws from the posterior; an odd number is raised by one
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(64..=16_384))]
    draws: u32,
    /// Seed of the draws; the same seed draws the same inputs
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Most moves of the draws in a step of the sampler
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u16).range(3..=1000))]
    moves: u16,
    /// Only predict these measurements, as a check
    #[arg(long, value_name = "ID,..", value_delimiter = ',')]
    hold_out: Vec<String>,
    /// Treatment of measurements that contradict each other
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Treatment::LeaveOut)]
    conflict: Treatment,
    /// Rank further measurements by how much an hour of work on each narrows the levels; needs no measurements
    #[arg(long)]
    next: bool,
    /// Check the calibration instead: K tools drawn from the ranges are measured with the stated errors and calibrated
    #[arg(long, value_name = "K", conflicts_with_all = ["next", "structures", "conflict"], requires = "measured",
        value_parser = clap::value_parser!(u16).range(1..=1000))]
    check: Option<u16>,
    /// Number of draws whose levels are computed, for measured levels and for --next
    #[arg(long, value_name = "K", default_value_t = 128, value_parser = clap::value_parser!(u32).range(8..=4096))]
    levels: u32,
    /// Draw these anew in `calibrated.toml`, from the ranges of the design, for shots with others than those measured
    #[arg(long, value_name = "WHAT,..", value_enum, value_delimiter = ',',
        conflicts_with_all = ["check", "structures"])]
    redraw: Vec<Redrawn>,
    /// Keep candidates and draws in this folder, and not in the cache
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    store: Option<PathBuf>,
}

impl Arguments {
    /// Number of draws; even.
    fn draws(&self) -> usize {
        self.draws.next_multiple_of(2) as usize
    }
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    match (&arguments.structures, &arguments.design) {
        (Some(file), _) => of_plates(arguments, file),
        (None, Some(design)) => of_design(arguments, design),
        // Ruled out by the command line.
        (None, None) => Ok(Status::from(2)),
    }
}

/// The plates of a file.
fn of_plates(arguments: &Arguments, file: &Path) -> Result<Status, Error> {
    arguments.options.threads.start()?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let folder = given_or_named(arguments.options.out.as_deref(), &name, file)?.join("structures");
    let request = StructuresRequest {
        draws: arguments.draws(),
        moves: usize::from(arguments.moves),
        seed: arguments.seed,
    };
    let progress = progress();
    let result = calibrate_structures(file, &request, &progress)?;
    progress.stage("writing files");
    let staging = AtomicWrite::within(&folder)?;
    staging.write("modes.csv".as_ref(), &structures::modes(&result)?)?;
    place(staging, structures::RESULT, &result)?;
    progress.end();
    for (plate, fault) in result.faults() {
        message(&format!("plate {plate} not converged: {fault}"));
    }
    if arguments.options.json {
        print_json(&result)?;
    } else {
        let units = arguments.shown.units;
        arguments.shown.print(&structures::text(&result, units))?;
        print(&format!("\n  files in {}\n", folder.display()))?;
    }
    Ok(status(result.converged(), result.has_conflict()))
}

/// Writes the result last, and puts all files in their place.
fn place(staging: AtomicWrite, name: &str, result: &impl Serialize) -> Result<(), Error> {
    let json = serde_json::to_string_pretty(result).map_err(Error::Json)? + "\n";
    staging.write(name.as_ref(), json.as_bytes())?;
    staging.place(&[], name.as_ref())
}

/// Status 3 for draws that have not converged, 1 for measurements that contradict each other.
fn status(converged: bool, has_conflict: bool) -> Status {
    match (converged, has_conflict) {
        (false, _) => Status::from(3),
        (true, true) => Status::from(1),
        (true, false) => Status::SUCCESS,
    }
}

fn of_design(arguments: &Arguments, path: &Path) -> Result<Status, Error> {
    let options = &arguments.options;
    let design = options.begin_with_any_tool(path)?;
    let folder = options.out(&design)?.join("calibration");
    let store = match &arguments.store {
        Some(folder) => Store::shared(folder)?,
        None => arguments.keeping.cache()?,
    };
    let request = Request {
        draws: arguments.draws(),
        moves: usize::from(arguments.moves),
        seed: arguments.seed,
        hold_out: arguments.hold_out.clone(),
        treatment: arguments.conflict,
        next: arguments.next,
        levels: arguments.levels as usize,
        redraw: arguments.redraw.clone(),
    };
    let progress = progress();
    let set = &options.changes.set;
    if let (Some(runs), Some(measured)) = (arguments.check, &arguments.measured) {
        let asked = CheckRequest {
            measured,
            request: &request,
            runs: usize::from(runs),
            folder: &folder.join(calibration_check::RUNS),
        };
        let said = |cost: CheckCost| message(&calibration_check::ahead(&asked, cost));
        let result = calibration::check(&store, &design, set, asked, &progress, said)?;
        place(AtomicWrite::within(&folder)?, calibration_check::RESULT, &result)?;
        progress.end();
        if options.json {
            print_json(&result)?;
        } else {
            arguments.shown.print(&calibration_check::text(&result))?;
            print(&format!("\n  files in {}\n", folder.display()))?;
        }
        // A check that fails is a numerical failure.
        return Ok(status(result.is_uniform != Some(false), false));
    }
    let (result, files) = calibration::calibrate(
        &store,
        &design,
        set,
        arguments.measured.as_deref(),
        (&request, None),
        &progress,
    )?;
    progress.stage("writing files");
    let staging = AtomicWrite::within(&folder)?;
    let shown = result.shown(arguments.shown.units);
    let page = report::calibration(&shown, &figures::calibration(&result), arguments.shown.units);
    staging.write("calibration.html".as_ref(), page.as_bytes())?;
    staging.write("posterior.csv".as_ref(), &files.draws)?;
    staging.write(calibration::JOINT.as_ref(), &files.joint)?;
    staging.write("calibrated.toml".as_ref(), files.design(&folder).as_bytes())?;
    place(staging, LAST, &result)?;
    progress.end();
    for fault in &result.faults {
        message(&format!("not converged: {fault}"));
    }
    if options.json {
        print_json(&result)?;
    } else {
        arguments.shown.print(&text(&shown))?;
        print(&format!(
            "\n  files in {}; open calibration.html for the charts\n",
            folder.display()
        ))?;
    }
    Ok(status(result.converged, result.has_conflict()))
}

fn number(value: f64) -> String {
    if value.is_finite() {
        rounded(value, 3, 1e5)
    } else {
        "-".to_owned()
    }
}

fn ends([low, high]: [f64; 2]) -> String {
    format!("{} .. {}", number(low), number(high))
}

/// Formats a reading, which may be open-ended.
fn reading([low, high]: [Option<f64>; 2]) -> String {
    match (low, high) {
        (Some(low), Some(high)) if low == high => number(low),
        (Some(low), Some(high)) => ends([low, high]),
        (Some(low), None) => format!(">= {}", number(low)),
        (None, Some(high)) => format!("<= {}", number(high)),
        (None, None) => "-".to_owned(),
    }
}

/// Formats the result for the terminal.
fn text(result: &CalibrationResult) -> String {
    let mut text = format!(
        "{}: {} draws given {} ({} of {} candidates have the observed outcomes)\n",
        result.design.name, result.draws, result.measured, result.draws, result.candidates
    );
    if !result.converged {
        text.push_str(&format!("NOT CONVERGED: {NOT_CONVERGED}\n"));
    }
    let rows = result.measurements.iter().map(|own| {
        let held_out = if own.counts { "" } else { "not used" };
        vec![
            own.name.clone(),
            reading(own.reading),
            own.unit.clone(),
            ends(own.before),
            ends(own.now),
            format!("{:+.1}", own.left_over),
            own.verdict.as_str().to_owned(),
            held_out.to_owned(),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let headings = [
        "measurement",
        "value",
        "unit",
        "before, 90 %",
        "now, 90 %",
        "left over, sd",
        "verdict",
        "",
    ];
    if !rows.is_empty() {
        text.push_str(&format!("\n{}", texts(&headings, &rows)));
    }
    for own in &result.conflicts {
        text.push_str(&format!("\n{}", conflict(own)));
    }
    let moved: Vec<Vec<String>> = result
        .inputs
        .iter()
        .filter(|own| own.ratio < result.moved_below)
        .take(SHOWN)
        .map(|own| {
            let ratio = format!("{:.2}", own.ratio);
            vec![
                own.name.clone(),
                own.unit.clone(),
                ends(own.before),
                ends(own.now),
                ratio,
            ]
        })
        .collect();
    let more = result
        .inputs
        .iter()
        .filter(|own| own.ratio < result.moved_below)
        .count()
        .saturating_sub(SHOWN);
    text.push_str(&format!(
        "\n{}",
        texts(
            &["input", "unit", "before, 90 %", "now, 90 %", "ratio of widths"],
            &moved
        )
    ));
    if more > 0 {
        text.push_str(&format!("  and {more} more on the page\n"));
    }
    for own in &result.pairs {
        let [a, b] = &own.inputs;
        text.push_str(&format!(
            "  {a} and {b}: rank correlation {:+.2}\n",
            own.rank_correlation
        ));
    }
    text.push_str(&format!(
        "  {} inputs are not identified by these measurements\n\n",
        result.unidentified
    ));
    let rows: Vec<Vec<String>> = result
        .figures
        .iter()
        .map(|own| {
            let words = |[low, middle, high]: [f64; 3]| format!("{} ({})", number(middle), ends([low, high]));
            vec![
                format!("{} [{}]", own.name, own.unit),
                words(own.before),
                words(own.now),
            ]
        })
        .collect();
    text.push_str(&table(&["the shot of the design", "before, P50 (90 %)", "now"], &rows));
    text.push_str(&levels(result));
    text.push_str(&next(&result.next));
    for note in &result.notes {
        text.push_str(&format!("  - {note}\n"));
    }
    text
}

/// Levels of the design's own shot.
fn levels(result: &CalibrationResult) -> String {
    let Some(work) = result.level_work else {
        return String::new();
    };
    let words = |[low, middle, high]: [f64; 3]| format!("{middle:.1} ({low:.1} .. {high:.1})");
    let first = |own: &LevelRow, place: usize| own.first.map_or_else(String::new, |own| format!("{:.2}", own[place]));
    let rows: Vec<Vec<String>> = result
        .levels
        .iter()
        .map(|own| {
            vec![
                own.output.clone(),
                own.ranges.map_or_else(|| "-".to_owned(), words),
                words(own.before),
                first(own, 0),
                words(own.now),
                first(own, 1),
            ]
        })
        .collect();
    let headings = [
        "L_WA,1s dB, P50 (90 %)",
        "study of the ranges",
        "without levels",
        "P(first)",
        "now",
        "P(first)",
    ];
    let mut text = format!("\n{}", texts(&headings, &rows));
    if let Some(total) = result.levels.last() {
        let width = |[low, _, high]: [f64; 3]| high - low;
        let of_ranges = total.ranges.map_or_else(String::new, |own| {
            format!(", {:.2} of that of the ranges", width(total.now) / width(own))
        });
        text.push_str(&format!(
            "  the interval of the total is {:.1} dB wide{of_ranges}; {:.0} effective shots of {}\n",
            width(total.now),
            work.effective,
            work.shots
        ));
    }
    text
}

/// What to measure next.
fn next(rows: &[NextRow]) -> String {
    let Some(first) = rows.first() else {
        return String::new();
    };
    let rows: Vec<Vec<String>> = rows
        .iter()
        .take(NEXT_SHOWN)
        .map(|own| {
            let least = if own.is_bound { "at least " } else { "" };
            vec![
                own.measurement.clone(),
                own.condition.clone(),
                format!("{:.0}", own.minutes),
                format!("{:.1}", own.width[1]),
                format!("{:.2}", own.first[1]),
                format!("{least}{:.2}", own.narrower_an_hour),
                format!("{:+.3}", own.surer_an_hour),
            ]
        })
        .collect();
    let headings = [
        "measure next",
        "at",
        "min",
        "total, 90 %, dB",
        "P(first)",
        "narrower, dB/h",
        "surer, 1/h",
    ];
    format!(
        "\n{}  now {:.1} dB and P(first) {:.2}\n",
        texts(&headings, &rows),
        first.width[0],
        first.first[0]
    )
}

/// Describes a conflict.
fn conflict(own: &ConflictRow) -> String {
    let mut text = match (&own.partner, own.nearest, own.distance) {
        (_, Some(nearest), Some(distance)) => format!(
            "  NOT REACHED: no candidate comes near {}; the nearest has {} {}, {distance:.1} sd away\n",
            own.measurement,
            number(nearest),
            own.unit
        ),
        (Some(partner), ..) => format!(
            "  CONFLICT: {} and {partner} contradict each other (probability {:.1e})\n",
            own.measurement, own.probability
        ),
        _ => format!(
            "  CONFLICT: {} contradicts the other measurements (probability {:.1e})\n",
            own.measurement, own.probability
        ),
    };
    text.push_str(&match own.widened {
        Some(factor) => format!("    its errors were widened by a factor {factor:.1}\n"),
        None => "    left out of all intervals\n".to_owned(),
    });
    if let Some(gain) = own.gain {
        text.push_str(&format!("    log evidence without: {gain:+.1}\n"));
    }
    for remedy in &own.remedies {
        text.push_str(&format!("    - {remedy}\n"));
    }
    text
}
