//! `nailnoise penetration fit`: a penetration law from measured drives.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nailnoise_penetration::fit::{Cleaning, Drive, FitFile, Form, Leave, Method, Start};
use nailnoise_quantities::dimension::FORCE;
use nailnoise_quantities::measure;
use serde::Serialize;

use crate::atomic_write::AtomicWrite;
use crate::commands::Status;
use crate::commands::progress::note;
use crate::commands::table::table;
use crate::commands::{Threads, print, print_json};
use crate::error::Error;
use crate::figures;
use crate::output;
use crate::penetration::fitting::{Fitting, Options, Rate, default_form, fit_files};
use crate::penetration::{PenetrationError, file_of};
use crate::tables::{dash, fixed};

/// The file written last.
const FIT: &str = "fit.toml";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise penetration fit drives.csv --form \"poly(x,7) + rate + slender\"" => "a law fitted to measured drives",
    "nailnoise penetration fit drives.csv --reduce --leave group" => "terms that carry nothing left out; \
        cross-validation by \
        group",
    "nailnoise penetration fit fast.csv --rate estimate --form \"poly(x,4)\"" => "the quasi-static law from drives at \
        known speeds, with the fall of friction and the rise of crushing",
))]
pub(super) struct Arguments {
    /// CSV files with a row a drive: id, group, repeat, nail, wood, speed, file, ...
    #[arg(value_name = "DRIVES", required = true)]
    data: Vec<PathBuf>,
    /// Terms of s = sqrt(F_r/(H_M NL)): products of powers of x, rate, slender, inertia, decay, energy
    ///
    /// [default: poly(x,7) + rate + slender, without rate if --rate is given]
    #[arg(long, value_name = "TERMS")]
    form: Option<String>,
    /// How the resistance depends on the speed of the nail
    #[arg(long, value_name = "LAW", value_enum, default_value = "none")]
    rate: RateName,
    /// With --rate: share of friction in the force at full depth [default: that of --split, else 0.6]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    friction_share: Option<f64>,
    /// How the coefficients are found [default: within-between after impacts, else least-squares]
    #[arg(long, value_name = "METHOD", value_enum)]
    method: Option<MethodName>,
    /// Drop terms from the end while the standard error grows by at most 5 %, and list every step
    #[arg(long)]
    reduce: bool,
    /// What cross-validation leaves out [default: group]
    #[arg(long, value_name = "WHAT", value_enum)]
    leave: Option<LeaveName>,
    /// Separate friction and deformation by second drives into the same holes (drive = 2)
    #[arg(long)]
    split: bool,
    /// Where the tip meets the wood: a force such as "5 N", or "recorded" for depth 0 of the recordings [default: by a
    /// line on the tip at constant speed, recorded after an impact]
    #[arg(long, value_name = "START", value_parser = start)]
    start: Option<Start>,
    /// Samples of the slope that is the speed after an impact; odd
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = odd)]
    slope_samples: usize,
    /// Allow designs to use the law beyond the range of its data
    #[arg(long)]
    extrapolate: bool,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    threads: Threads,
    /// Folder for fit.toml, residuals.csv and the figures [default: out/prf-fit]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum RateName {
    /// By the terms of --form
    None,
    /// As `wood.rate = "speed"` with its published coefficients: forces are divided by it
    Speed,
    /// The same with beta and v_m estimated from drives at different speeds
    Estimate,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    /// Ordinary least squares over all points
    LeastSquares,
    /// Varying terms within drives, then the means of the drives
    WithinBetween,
}

#[derive(Clone, Copy, ValueEnum)]
enum LeaveName {
    /// All repeats of a condition
    Group,
    /// All drives of a nail size
    Nail,
    /// All drives into a wood
    Wood,
    /// Single drives
    Drive,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::LeastSquares => Self::LeastSquares,
            MethodName::WithinBetween => Self::WithinBetween,
        }
    }
}

impl From<LeaveName> for Leave {
    fn from(name: LeaveName) -> Self {
        match name {
            LeaveName::Group => Self::Group,
            LeaveName::Nail => Self::Nail,
            LeaveName::Wood => Self::Wood,
            LeaveName::Drive => Self::Drive,
        }
    }
}

fn start(text: &str) -> Result<Start, String> {
    if text == "recorded" {
        return Ok(Start::Recorded);
    }
    let force = measure(text, FORCE).map_err(|error| error.to_string())?;
    if force > 0.0 && force.is_finite() {
        Ok(Start::Force(force))
    } else {
        Err("give a force above 0, as \"5 N\", or \"recorded\"".to_owned())
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give a number from 0 to 1".to_owned()),
    }
}

fn odd(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(n) if n % 2 == 1 && (3..=10_001).contains(&n) => Ok(n),
        _ => Err("give an odd number from 3 to 10001".to_owned()),
    }
}

/// Layout of `prf fit --json`.
#[derive(Serialize)]
struct FitResult<'a> {
    schema: &'static str,
    fit: &'a FitFile,
    #[serde(flatten)]
    fitting: &'a Fitting,
    files: Vec<String>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let rate = (arguments.rate != RateName::None).then_some(Rate {
        share: arguments.friction_share,
        estimate: arguments.rate == RateName::Estimate,
    });
    let form = arguments.form.as_deref().unwrap_or_else(|| default_form(rate.as_ref()));
    let form: Form = form.parse().map_err(PenetrationError::Form)?;
    let options = Options {
        form,
        method: arguments.method.map(Method::from),
        reduce: arguments.reduce,
        leave: arguments.leave.map(Leave::from),
        split: arguments.split,
        rate,
        cleaning: Cleaning {
            start: arguments.start.unwrap_or(Start::Automatic),
            slope_samples: arguments.slope_samples,
            ..Cleaning::default()
        },
        extrapolate: arguments.extrapolate,
    };
    arguments.threads.start()?;
    let fitting = fit_files(&arguments.data, &options)?;
    fitting.notes.iter().for_each(|text| note(text));
    let (law, drives) = (&fitting.law, &fitting.drives);

    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join("prf-fit"));
    let staging = AtomicWrite::within(&folder)?;
    let subject = format!("{}, {} drives", shortened(&law.form().to_string()), drives.len());
    let charts = [
        figures::fit(&subject, law, drives),
        figures::residuals(&subject, drives, &fitting.residuals),
    ];
    let mut files = figures::write(&staging, Path::new(""), &charts)?;
    files.push(PathBuf::from("residuals.csv"));
    staging.write(&files[files.len() - 1], &residuals(drives, &fitting.residuals)?)?;
    files.push(PathBuf::from(FIT));
    staging.write(Path::new(FIT), file_of(law)?.as_bytes())?;
    staging.place(&[], Path::new(FIT))?;
    let result = FitResult {
        schema: "nailnoise-prf-fit/1",
        fit: law.file(),
        fitting: &fitting,
        files: files
            .iter()
            .map(|file| folder.join(file).display().to_string())
            .collect(),
    };
    if arguments.json {
        print_json(&result)?;
    } else {
        print(&text(&result))?;
    }
    Ok(Status::SUCCESS)
}

fn shortened(form: &str) -> String {
    if form.chars().count() > 60 {
        form.chars().take(57).chain("...".chars()).collect()
    } else {
        form.to_owned()
    }
}

/// `residuals.csv`, with one row per point.
fn residuals(drives: &[Drive], residuals: &[f64]) -> Result<Vec<u8>, Error> {
    let points = drives
        .iter()
        .flat_map(|drive| drive.points.iter().map(move |point| (drive, point)));
    let rows = points.zip(residuals).map(|((drive, point), residual)| {
        let scale = drive.conditions.force_scale();
        let law = (point.root - residual).max(0.0);
        [
            drive.id.clone(),
            drive.group.clone(),
            format!("{:.7}", point.depth),
            format!("{:.6e}", point.speed),
            format!("{:.4}", scale * point.root * point.root),
            format!("{:.4}", scale * law * law),
            format!("{:.7}", point.root),
            format!("{residual:.7}"),
        ]
    });
    output::table(
        [
            "id",
            "group",
            "depth_m",
            "speed_m_s",
            "force_n",
            "law_n",
            "root",
            "residual",
        ],
        rows,
    )
}

fn text(result: &FitResult<'_>) -> String {
    let fit = result.fit;
    let q = &fit.quality;
    let mut text = format!(
        "fitted penetration law: {} drives, {} conditions, {} points, {}\n\n",
        fit.counts.drives,
        fit.counts.groups,
        fit.counts.points,
        match fit.method {
            Method::LeastSquares => "least squares",
            Method::WithinBetween => "within drives, then between them",
        }
    );
    let number = |value: f64| format!("{value:.4e}");
    let rows: Vec<Vec<String>> = fit
        .terms
        .iter()
        .map(|term| {
            vec![
                term.name.clone(),
                number(term.coefficient),
                number(term.standard_error),
                number(term.classical_error),
                format!("{:.2}", term.t.clamp(-1e9, 1e9)),
                format!("{:.4}", term.p),
                if term.vif > 0.0 {
                    format!("{:.1}", term.vif)
                } else {
                    "-".to_owned()
                },
                format!("{:.2}", term.f_dropped.min(1e12)),
            ]
        })
        .collect();
    text.push_str(&table(
        &[
            "term",
            "coefficient",
            "std error",
            "classical",
            "t",
            "p",
            "VIF",
            "F dropped",
        ],
        &rows,
    ));
    text.push_str("\n  std error: clustered by drive; classical: as if all points were independent\n\n");
    let row = |name: &str, s: String, force: String| vec![name.to_owned(), s, force];
    let rows = vec![
        row("R2 %", format!("{:.2}", 100.0 * q.r_squared), "-".to_owned()),
        row(
            "SEE",
            format!("{:.5}", q.standard_error),
            format!("{:.1} N", q.standard_error_n),
        ),
        row(
            "MAE",
            format!("{:.5}", q.mean_absolute_error),
            format!("{:.1} N", q.mean_absolute_error_n),
        ),
        row(
            "MAPE %",
            format!("{:.2}", q.mean_percentage_error),
            format!("{:.2}", q.mean_percentage_error_force),
        ),
        row(
            "sigma between drives",
            format!("{:.5}", fit.sigma_between),
            "-".to_owned(),
        ),
        row(
            "sigma within a drive",
            format!("{:.5}", fit.sigma_within),
            "-".to_owned(),
        ),
    ];
    text.push_str(&table(&["quality", "of s", "of the force"], &rows));
    if let Some(rate) = &fit.rate {
        let interval =
            |of: Option<[f64; 2]>| of.map_or_else(String::new, |[low, high]| format!(" (95 %: {low:.3} .. {high:.3})"));
        text.push_str(&format!(
            "\n  speeds of {:.3e} to {:.3e} m/s divided out: beta {:.3}{}, v_m {:.3} m/s{}, friction {:.2} of the \
             force at full depth\n",
            rate.speeds_m_s[0],
            rate.speeds_m_s[1],
            rate.speed.crushing,
            interval(rate.crushing_interval),
            rate.speed.width,
            interval(rate.width_interval_m_s),
            rate.friction_share
        ));
    }
    if let Some(validation) = &result.fitting.validation {
        text.push_str(&format!(
            "\n  cross-validation, one {} left out at a time: root mean square error of s {:.5}\n",
            validation.left_out.name(),
            validation.root_mean_square
        ));
        let failed = validation.folds.iter().filter(|fold| fold.1.is_none()).count();
        if failed > 0 {
            text.push_str(&format!(
                "  {failed} of {} could not be predicted: the others do not determine the law\n",
                validation.folds.len()
            ));
        }
    }
    if !result.fitting.reduction.is_empty() {
        text.push('\n');
        let rows: Vec<Vec<String>> = result
            .fitting
            .reduction
            .iter()
            .map(|step| {
                let of = |value: Option<f64>, digits: usize| fixed(value.map(|value| value.min(1e12)), digits);
                vec![
                    format!(
                        "{}{}",
                        step.dropped
                            .as_ref()
                            .map_or_else(|| "whole form".to_owned(), |term| format!("without {term}")),
                        if step.chosen { " (chosen)" } else { "" }
                    ),
                    format!("{:.2}", 100.0 * step.r_squared),
                    format!("{:.5}", step.standard_error),
                    format!("{:+.1}", step.growth),
                    of(step.f, 2),
                    of(step.p, 4),
                ]
            })
            .collect();
        text.push_str(&table(
            &["reduction", "R2 %", "SEE", "growth %", "F", "p clustered"],
            &rows,
        ));
    }
    if let Some(split) = &result.fitting.split {
        let error = split
            .share_error
            .map_or_else(String::new, |error| format!(" +- {error:.3}"));
        text.push_str(&format!(
            "\n  friction {:.0} N and deformation {:.0} N at full depth (from x = {:.2}), root mean square errors \
             {:.0} and \
             {:.0} N, {} pairs\n  wood.friction_share = {:.3}{error} (standard error)\n",
            split.friction,
            split.deformation,
            split.knee,
            split.errors[0],
            split.errors[1],
            split.pairs,
            split.friction_share
        ));
    }
    text.push('\n');
    let interval = |[low, high]: [f64; 2]| format!("{low:.0} .. {high:.0}");
    let rows: Vec<Vec<String>> = result
        .fitting
        .conditions
        .iter()
        .take(20)
        .map(|c| {
            vec![
                c.group.clone(),
                c.drives.to_string(),
                format!("{:.1}", 1e3 * c.depth),
                format!("{:.0}", c.force),
                interval(c.law),
                interval(c.shot),
                dash(c.work, |[work, error]| format!("{work:.2} +- {error:.2}")),
            ]
        })
        .collect();
    text.push_str(&table(
        &[
            "condition",
            "drives",
            "depth mm",
            "force N",
            "law 95 %",
            "shot 95 %",
            "work J +- std error",
        ],
        &rows,
    ));
    if result.fitting.conditions.len() > 20 {
        text.push_str(&format!(
            "  and {} more conditions\n",
            result.fitting.conditions.len() - 20
        ));
    }
    text.push('\n');
    result
        .files
        .iter()
        .for_each(|file| text.push_str(&format!("  {file}\n")));
    text
}
