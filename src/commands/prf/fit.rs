//! `nailnoise prf fit`: a penetration law from measured drives.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use nailnoise_dynamics::prf::fit::{
    Cleaning, Drive, FitError, FitFile, FittedLaw, Form, Leave, Method, Reduction, Scatter, Split, Start, Validation,
    Variable, fit, reduce, split, validate,
};
use nailnoise_quantities::dimension::FORCE;
use nailnoise_quantities::measure;
use rayon::prelude::*;
use serde::Serialize;

use crate::commands::table::table;
use crate::commands::{message, print, print_json};
use crate::error::Error;
use crate::figures;
use crate::output;
use crate::penetration::PenetrationError;
use crate::penetration::drives::{Row, check, clean, hole, rows};
use crate::staging::Staging;

/// The form of the published general law (Eq. 2.2).
const FORM: &str = "poly(x,7) + rate + slender";

/// VIF from which a coefficient alone has little meaning (Belsley, Kuh and Welsch, 1980).
const HIGH_VIF: f64 = 1e3;

/// The file that is written last.
const FIT: &str = "fit.toml";

#[derive(Args)]
pub(super) struct Arguments {
    /// CSV files with a row a drive: id, group, repeat, nail, wood, speed, file, ...
    #[arg(value_name = "DRIVES", required = true)]
    data: Vec<PathBuf>,
    /// Terms of s = sqrt(F_r/(H_M NL)): products of powers of x, rate, slender, inertia, decay, energy
    #[arg(long, value_name = "TERMS", default_value = FORM)]
    form: String,
    /// How the coefficients are found [default: within-between where the form has decay, else least-squares]
    #[arg(long, value_name = "METHOD", value_enum)]
    method: Option<MethodName>,
    /// Drop terms from the end while the standard error grows by 5 % at most, and list every step
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
    /// Folder for fit.toml, residuals.csv and the figures [default: out/prf-fit]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
    /// Null where the data have one group only.
    validation: Option<Validation>,
    reduction: Vec<Reduction>,
    split: Option<Split>,
    /// Force, 95 % band and work at full depth under each condition of the data.
    conditions: Vec<Condition>,
    notes: Vec<String>,
    files: Vec<String>,
}

/// The law under a condition of the data, at the deepest point.
#[derive(Serialize)]
struct Condition {
    group: String,
    drives: usize,
    depth: f64,
    force: f64,
    law: [f64; 2],
    shot: [f64; 2],
    /// Work over the nail's length and its standard error \[J\]; null for a law with decay or a force that is cut off.
    work: Option<[f64; 2]>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<ExitCode, Error> {
    let form: Form = arguments.form.parse().map_err(PenetrationError::Form)?;
    let mut all: Vec<Row> = Vec::new();
    let mut digests: Vec<(String, String)> = Vec::new();
    for path in &arguments.data {
        let (own, digest) = rows(path)?;
        all.extend(own);
        digests.push((name_of(path), digest));
    }
    check(&all)?;
    let how = Cleaning {
        start: arguments.start.unwrap_or(Start::Automatic),
        slope_samples: arguments.slope_samples,
        ..Cleaning::default()
    };
    let cleaned: Vec<_> = all.par_iter().map(|row| clean(row, &how)).collect::<Result<_, _>>()?;
    let mut notes = Vec::new();
    let (mut drives, mut again) = (Vec::new(), Vec::new());
    let mut noisiest: Option<f64> = None;
    for (row, (drive, cleaned, digest)) in all.iter().zip(cleaned) {
        notes.extend(cleaned.flags.iter().map(|flag| format!("drive {}: {flag}", row.id)));
        noisiest = noisiest.into_iter().chain(cleaned.speed_error).reduce(f64::max);
        digests.push((name_of(&row.file), digest));
        if row.drive == 1 {
            drives.push(drive)
        } else {
            again.push((hole(row), row, drive))
        }
    }
    if let Some(error) = noisiest {
        notes.push(format!(
            "the speed of the nail has a standard error of up to {error:.2} m/s"
        ));
    }
    let refuse = |error: FitError| refused(error, &all, &arguments.data[0]);
    let (form, reduction) = if arguments.reduce {
        reduce(&form, &drives).map_err(refuse)?
    } else {
        (form, Vec::new())
    };
    let method = arguments.method.map_or_else(
        || Method::of(&form),
        |name| match name {
            MethodName::LeastSquares => Method::LeastSquares,
            MethodName::WithinBetween => Method::WithinBetween,
        },
    );
    let fitted = fit(&form, &drives, method).map_err(refuse)?;
    let mut file = fitted.law.file().clone();
    file.extrapolate = arguments.extrapolate;
    file.data = digests;
    let law = FittedLaw::try_from(file).map_err(|error| PenetrationError::Law {
        path: PathBuf::from(FIT),
        line: None,
        problem: error.to_string(),
    })?;
    let validation = match (
        validate(&form, &drives, arguments.leave.map_or(Leave::Group, Leave::from)),
        arguments.leave,
    ) {
        (Ok(validation), _) => Some(validation),
        (Err(_), None) => None,
        (Err(error), Some(_)) => return Err(refuse(error).into()),
    };
    let split = if arguments.split {
        Some(parts(&all, &drives, &again, &arguments.data[0])?)
    } else {
        None
    };
    notes.extend(remarks(&law, &drives, method));
    notes.iter().for_each(|note| message(&format!("note: {note}")));

    let folder = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join("prf-fit"));
    let staging = Staging::within(&folder)?;
    let subject = format!("{}, {} drives", shortened(&form.to_string()), drives.len());
    let charts = [
        figures::fit(&subject, &law, &drives),
        figures::residuals(&subject, &drives, &fitted.residuals),
    ];
    let mut files = figures::write(&staging, Path::new(""), &charts)?;
    files.push(PathBuf::from("residuals.csv"));
    staging.write(&files[files.len() - 1], &residuals(&drives, &fitted.residuals)?)?;
    files.push(PathBuf::from(FIT));
    staging.write(Path::new(FIT), toml(&law)?.as_bytes())?;
    staging.place(&[], Path::new(FIT))?;
    let result = FitResult {
        schema: "nailnoise-prf-fit/1",
        fit: law.file(),
        validation,
        reduction,
        split,
        conditions: conditions(&law, &drives),
        notes,
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
    Ok(ExitCode::SUCCESS)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn shortened(form: &str) -> String {
    if form.chars().count() > 60 {
        form.chars().take(57).chain("...".chars()).collect()
    } else {
        form.to_owned()
    }
}

/// The error with the line of the drive that it is about.
fn refused(source: FitError, rows: &[Row], data: &Path) -> PenetrationError {
    let about = match &source {
        FitError::Value { drive, .. } | FitError::NoImpact { drive, .. } => rows.iter().find(|row| row.id == *drive),
        _ => None,
    };
    PenetrationError::Fit {
        path: about.map_or_else(|| data.to_owned(), |row| row.place.0.clone()),
        line: about.map(|row| row.place.1),
        source,
    }
}

/// Friction and deformation by the second drives.
fn parts(
    rows: &[Row],
    drives: &[Drive],
    again: &[((&str, &str), &Row, Drive)],
    data: &Path,
) -> Result<Split, PenetrationError> {
    let place = |row: &Row, problem: String, help: &str| PenetrationError::Data {
        path: row.place.0.clone(),
        line: row.place.1,
        problem,
        help: help.to_owned(),
    };
    if let Some((_, row, _)) = again
        .iter()
        .find(|(_, row, _)| row.shank.eq_ignore_ascii_case("helical"))
    {
        return Err(place(
            row,
            "a helical nail turns: its second drive does not measure friction alone".to_owned(),
            "leave helical nails out of --split",
        ));
    }
    let first = |key: (&str, &str)| {
        let row = rows.iter().find(|row| row.drive == 1 && hole(row) == key)?;
        drives.iter().find(|drive| drive.id == row.id)
    };
    let pairs: Vec<(&Drive, &Drive)> = again
        .iter()
        .filter_map(|(key, _, second)| first(*key).map(|first| (first, second)))
        .collect();
    split(&pairs).ok_or_else(|| PenetrationError::Data {
        path: data.to_owned(),
        line: 1,
        problem: "no hole has a first and a second drive over a common depth".to_owned(),
        help: "drive some nails again into their holes, as rows with drive = 2 and the group and repeat of the first"
            .to_owned(),
    })
}

/// What a reader of the fit must know.
fn remarks(law: &FittedLaw, drives: &[Drive], method: Method) -> Vec<String> {
    let mut notes = Vec::new();
    let form = law.form();
    let file = law.file();
    let [slow, fast] = file.ranges.speed_m_s;
    if form.uses(Variable::Rate) && !law.dynamic() && fast <= slow * (1.0 + 1e-9) {
        notes.push(
            "all drives have one speed: the term rate is NL rho/H_M there, of nail and wood, and no effect of the speed"
                .to_owned(),
        );
    }
    if !law.dynamic() {
        notes.push(format!(
            "the tests end at {:.3} mm/s; a design uses the law at that speed, and what the wood does at 25 m/s is not known \
             from them",
            1e3 * fast
        ));
    }
    if form.uses(Variable::Decay) && method == Method::LeastSquares {
        notes.push(
            "least squares is biased with decay, which answers to the specimen: prefer within-between".to_owned(),
        );
    }
    if drives.len() < 2 {
        notes.push("one drive: the standard errors do not hold what differs between specimens".to_owned());
    } else if file.counts.groups == file.counts.drives {
        notes.push("no condition is repeated: sigma_b holds the error of the form too".to_owned());
    }
    if drives.iter().any(|drive| drive.wood.contains("ply")) && drives.iter().any(|drive| !drive.wood.contains("ply")) {
        notes.push("the data mix plywood and solid wood".to_owned());
    }
    if let Some(term) = file.terms.iter().find(|term| term.vif > HIGH_VIF) {
        notes.push(format!(
            "coefficients such as that of {} (VIF {:.0}) have no meaning alone: judge the law by its band",
            term.name, term.vif
        ));
    }
    if let Some(drive) = drives.iter().find(|drive| {
        (0..=100).any(|i| {
            let point = drive.points[(drive.points.len() - 1) * i / 100];
            law.root(&drive.conditions, point.depth, point.speed) < 0.0
        })
    }) {
        notes.push(format!(
            "the law is below zero within the data of {}; the force is 0 there",
            drive.group
        ));
    }
    notes
}

fn conditions(law: &FittedLaw, drives: &[Drive]) -> Vec<Condition> {
    let mut groups: BTreeMap<&str, Vec<&Drive>> = BTreeMap::new();
    for drive in drives {
        groups.entry(&drive.group).or_default().push(drive);
    }
    groups
        .into_iter()
        .filter_map(|(group, own)| {
            let drive = own[0];
            let point = drive.points.last()?;
            let at = (point.depth, point.speed);
            Some(Condition {
                group: group.to_owned(),
                drives: own.len(),
                depth: point.depth,
                force: law.force(&drive.conditions, at.0, at.1),
                law: law.band(&drive.conditions, at, 0.95, Scatter::Law),
                shot: law.band(&drive.conditions, at, 0.95, Scatter::Shot),
                work: law.work(&drive.conditions, point.speed),
            })
        })
        .collect()
}

/// `residuals.csv`: a row a point.
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

/// `fit.toml`.
fn toml(law: &FittedLaw) -> Result<String, PenetrationError> {
    let text = toml::to_string(law).map_err(|error| PenetrationError::Law {
        path: PathBuf::from(FIT),
        line: None,
        problem: error.to_string(),
    })?;
    Ok(format!(
        "# Penetration law fitted by nailnoise prf fit: F_r = H_M NL max(0, s)^2, s = sum of coefficient x term.\n\
         # In a design: wood.penetration_law = \"fitted\" and wood.penetration_fit = \"fit.toml\".\n\
         # Covariance and standard errors allow for deviations common to a drive; sigma_* are of s.\n\n{text}"
    ))
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
    if let Some(validation) = &result.validation {
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
    if !result.reduction.is_empty() {
        text.push('\n');
        let rows: Vec<Vec<String>> = result
            .reduction
            .iter()
            .map(|step| {
                let of = |value: Option<f64>, digits: usize| {
                    value.map_or_else(|| "-".to_owned(), |value| format!("{:.digits$}", value.min(1e12)))
                };
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
    if let Some(split) = &result.split {
        let error = split
            .share_error
            .map_or_else(String::new, |error| format!(" +- {error:.3}"));
        text.push_str(&format!(
            "\n  friction {:.0} N and deformation {:.0} N at full depth (from x = {:.2}), root mean square errors {:.0} and \
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
                c.work
                    .map_or_else(|| "-".to_owned(), |[work, error]| format!("{work:.2} +- {error:.2}")),
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
    if result.conditions.len() > 20 {
        text.push_str(&format!("  and {} more conditions\n", result.conditions.len() - 20));
    }
    text.push('\n');
    result
        .files
        .iter()
        .for_each(|file| text.push_str(&format!("  {file}\n")));
    text
}
