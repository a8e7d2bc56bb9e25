//! Fits a law to files of drives, with its quality, validation and notes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nailnoise_penetration::fit::{
    Cleaning, Drive, FitError, FittedLaw, Flag, Form, Leave, Method, RateChoice, Reduction, Scatter, Split, Validation,
    Variable, WithoutRate, fit, reduce, split, validate, without_rate,
};
use nailnoise_penetration::{REFERENCE_SPEED, SpeedTerms};
use rayon::prelude::*;
use serde::Serialize;

use super::PenetrationError;
use super::drives::{Row, check, hole, rows};
use super::recordings::clean;

/// VIF above which a single coefficient has little meaning (Belsley, Kuh and Welsch, 1980).
const HIGH_VIF: f64 = 1e3;

/// The published general law (Eq. 2.2), which has its own term of the speed.
const GENERAL_FORM: &str = "poly(x,7) + rate + slender";

/// The general law without its term of the speed, for fits with a separate law of the speed.
const QUASI_STATIC_FORM: &str = "poly(x,7) + slender";

/// Share of friction without second drives: `wood.friction_share` of the base design.
const FRICTION_SHARE: f64 = 0.6;

/// The form that is fitted if none is given.
pub fn default_form(rate: Option<&Rate>) -> &'static str {
    match rate {
        None => GENERAL_FORM,
        Some(_) => QUASI_STATIC_FORM,
    }
}

/// Settings of a fit.
#[derive(Debug, Clone)]
pub struct Options {
    /// Terms of the law.
    pub form: Form,
    /// How the coefficients are found; `None` selects the method that suits the form.
    pub method: Option<Method>,
    /// Whether terms are dropped from the end as long as SEE hardly increases.
    pub reduce: bool,
    /// What cross-validation leaves out; `None` means groups, if there are several.
    pub leave: Option<Leave>,
    /// Whether friction and deformation are separated.
    pub split: bool,
    /// The law of the speed by which forces are divided; `None` if the form has the effect of speed.
    pub rate: Option<Rate>,
    /// How recordings become points.
    pub cleaning: Cleaning,
    /// Whether designs may use the law outside the range of its data.
    pub extrapolate: bool,
}

/// Settings of a fit with a law of the speed.
#[derive(Debug, Clone, Copy)]
pub struct Rate {
    /// Share of friction in the force at full depth; `None` takes that of second drives, else 0.6.
    pub share: Option<f64>,
    /// Whether beta and v_m are estimated.
    pub estimate: bool,
}

/// A fitted law, with its quality and notes.
#[derive(Debug, Clone, Serialize)]
pub struct Fitting {
    /// The law.
    #[serde(skip)]
    pub law: FittedLaw,
    /// Its data.
    #[serde(skip)]
    pub drives: Vec<Drive>,
    /// s minus the law, by point in the order of the drives.
    #[serde(skip)]
    pub residuals: Vec<f64>,
    /// Cross-validation; `None` if the data have only one group.
    pub validation: Option<Validation>,
    /// Steps of the reduction.
    pub reduction: Vec<Reduction>,
    /// Friction and deformation.
    pub split: Option<Split>,
    /// Force, 95 % bands and work for each condition of the data.
    pub conditions: Vec<Condition>,
    /// Notes that a reader must know.
    pub notes: Vec<String>,
}

/// The law for a condition of the data, at the deepest point.
#[derive(Debug, Clone, Serialize)]
pub struct Condition {
    /// Name of the condition.
    pub group: String,
    /// Number of drives with this condition.
    pub drives: usize,
    /// Deepest point \[m\].
    pub depth: f64,
    /// Force of the law there \[N\].
    pub force: f64,
    /// 95 % band of the law \[N\].
    pub law: [f64; 2],
    /// 95 % band of one shot \[N\].
    pub shot: [f64; 2],
    /// Work over the nail's length and its standard error \[J\]; null for a law with decay or a force that is cut off.
    pub work: Option<[f64; 2]>,
}

/// Fits a law to the drives in these files.
///
/// # Errors
/// [`PenetrationError`] with file and line of data that cannot be used, or of drives that do not determine a law.
pub fn fit_files(files: &[PathBuf], options: &Options) -> Result<Fitting, PenetrationError> {
    let mut all: Vec<Row> = Vec::new();
    let mut digests: Vec<(String, String)> = Vec::new();
    for path in files {
        let (own, digest) = rows(path)?;
        all.extend(own);
        digests.push((name_of(path), digest));
    }
    check(&all)?;
    let data = files.first().map_or(Path::new(""), PathBuf::as_path);
    // Collected before the first error is taken, so that the same error is reported regardless of the order of the
    // threads.
    let cleaned: Vec<_> = all.par_iter().map(|row| clean(row, &options.cleaning)).collect();
    let cleaned = cleaned.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut notes = Vec::new();
    let (mut drives, mut again) = (Vec::new(), Vec::new());
    let mut flags: Vec<(Vec<&str>, Flag)> = Vec::new();
    let mut noisiest: Option<f64> = None;
    for (row, (drive, cleaned, digest)) in all.iter().zip(cleaned) {
        for flag in cleaned.flags {
            let kind = std::mem::discriminant(&flag);
            match flags.iter().position(|(_, own)| std::mem::discriminant(own) == kind) {
                Some(place) => flags[place].0.push(&row.id),
                None => flags.push((vec![&row.id], flag)),
            }
        }
        noisiest = noisiest.into_iter().chain(cleaned.speed_error).reduce(f64::max);
        digests.push((name_of(&row.file), digest));
        if row.drive == 1 {
            drives.push(drive)
        } else {
            again.push((hole(row), row, drive))
        }
    }
    notes.extend(flags.iter().map(|(ids, flag)| match ids.as_slice() {
        [id] => format!("drive {id}: {flag}"),
        ids => format!("drive {} and {} more: {flag}", ids[0], ids.len() - 1),
    }));
    if let Some(error) = noisiest {
        notes.push(format!(
            "the speed of the nail has a standard error of up to {error:.2} m/s"
        ));
    }
    let refuse = |error: FitError| refused(error, &all, data);
    let split = match options.split {
        true => Some(parts(&all, &drives, &again, data)?),
        false => None,
    };
    // The law of the speed and the penetration law are fitted by the same method.
    let chosen = match options.rate {
        Some(_) => options.method.or_else(|| Some(Method::of(&options.form, &drives))),
        None => options.method,
    };
    let divided = options.rate.zip(chosen).map(|(rate, method)| {
        let measured = split.as_ref().map(|split| split.friction_share);
        let choice = RateChoice {
            friction_share: rate.share.or(measured).unwrap_or(FRICTION_SHARE),
            speed: SpeedTerms::default(),
            estimate: rate.estimate,
        };
        without_rate(&options.form, &drives, method, &choice)
    });
    let rate = match divided.transpose().map_err(refuse)? {
        Some(WithoutRate { drives: slow, rate }) => {
            drives = slow;
            Some(rate)
        }
        None => None,
    };
    let (form, reduction) = if options.reduce {
        reduce(&options.form, &drives, chosen).map_err(refuse)?
    } else {
        (options.form.clone(), Vec::new())
    };
    let method = chosen.unwrap_or_else(|| Method::of(&form, &drives));
    let fitted = fit(&form, &drives, method).map_err(refuse)?;
    let law = fitted.law.with_data(digests, options.extrapolate);
    let law = match rate {
        Some(rate) => law.with_rate(rate),
        None => law,
    };
    let validation = match (
        validate(&form, &drives, method, options.leave.unwrap_or(Leave::Group)),
        options.leave,
    ) {
        (Ok(validation), _) => Some(validation),
        (Err(_), None) => None,
        (Err(error), Some(_)) => return Err(refuse(error)),
    };
    notes.extend(remarks(&law, &drives, method));
    Ok(Fitting {
        validation,
        reduction,
        split,
        conditions: conditions(&law, &drives),
        notes,
        residuals: fitted.residuals,
        law,
        drives,
    })
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The error, with the line of the drive that caused it.
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

/// Friction and deformation, from the second drives.
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

/// Notes that a reader of the fit must know.
fn remarks(law: &FittedLaw, drives: &[Drive], method: Method) -> Vec<String> {
    let mut notes = Vec::new();
    let form = law.form();
    let file = law.file();
    let [slow, fast] = file.ranges.speed_m_s;
    if form.uses(Variable::Rate) && !law.dynamic() && fast <= slow * (1.0 + 1e-9) {
        notes.push(
            "all drives have the same speed: the term rate varies with NL rho/H_M only and does not show the effect \
             of speed"
                .to_owned(),
        );
    }
    if let Some(rate) = &file.rate {
        notes.push(format!(
            "the law is that at {:.2} mm/s, and residuals.csv has the forces at that speed; a design multiplies it by \
             the law of the speed, whatever its wood.rate",
            1e3 * REFERENCE_SPEED
        ));
        if rate.speeds_m_s[1] < 1.0 {
            notes.push("no drive is faster than 1 m/s: the law of the speed is not that of these tests".to_owned());
        }
    } else if !law.dynamic() {
        notes.push(format!(
            "the tests end at {:.3} mm/s; a design uses the law at that speed, and what the wood does at 25 m/s is \
             not known \
             from them",
            1e3 * fast
        ));
    }
    if form.uses(Variable::Decay) && method == Method::LeastSquares {
        notes.push(
            "least squares is biased for the term decay, because v/v0 depends on the specimen: prefer the \
             within-between method"
                .to_owned(),
        );
    }
    if drives.len() < 2 {
        notes.push("one drive: the standard errors do not include the differences between specimens".to_owned());
    } else if file.counts.groups == file.counts.drives {
        notes.push("no condition is repeated: sigma_b also includes the error of the form".to_owned());
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
