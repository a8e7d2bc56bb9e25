//! From drives to a fitted law: statistics, model reduction and cross-validation.

use std::collections::BTreeMap;

use nalgebra::DVector;
use serde::Serialize;

use super::distributions::probability_beyond;
use super::drive::{Drive, Driving};
use super::error::FitError;
use super::file::{Counts, FitFile, Quality, Ranges, TermFit};
use super::form::{Form, Variable};
use super::law::FittedLaw;
use super::law_error::{FIT_SCHEMA, LawError};
use super::regression::{Method, Regression, Solution};

/// A fitted law with its residuals.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The law.
    pub law: FittedLaw,
    /// Measured s minus fitted s, by point in the order of the drives.
    pub residuals: Vec<f64>,
}

/// Fits `form` to drives with `method`.
///
/// # Errors
/// [`FitError`] if the drives do not determine the terms.
pub fn fit(form: &Form, drives: &[Drive], method: Method) -> Result<Fitted, FitError> {
    let regression = Regression::new(form, drives, method)?;
    let solution = regression.solve(&roots(drives));
    let file = FitFile {
        schema: FIT_SCHEMA.to_owned(),
        form: form.to_string(),
        method,
        extrapolate: false,
        sigma_between: solution.sigma_between,
        sigma_within: solution.sigma_within,
        degrees_of_freedom: solution.degrees_of_freedom,
        specimen_deviation: None,
        rate: None,
        covariance: solution
            .covariance
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
        data: Vec::new(),
        counts: Counts {
            points: solution.residuals.len(),
            drives: drives.len(),
            groups: distinct(drives, |drive| &drive.group).len(),
        },
        quality: quality(drives, &solution),
        ranges: ranges(drives),
        terms: terms(&regression, &solution),
    };
    // The covariance of a regression is symmetric and positive semidefinite to rounding.
    let law = FittedLaw::try_from(file).map_err(|error| match error {
        LawError::Covariance { .. } => FitError::Covariance,
        error => FitError::NoLaw(error),
    })?;
    Ok(Fitted {
        law,
        residuals: solution.residuals.as_slice().to_vec(),
    })
}

/// The roots s of all points, in the order of the drives.
pub fn roots(drives: &[Drive]) -> DVector<f64> {
    let all = drives
        .iter()
        .flat_map(|drive| drive.points.iter().map(|point| point.root));
    DVector::from_iterator(drives.iter().map(|drive| drive.points.len()).sum(), all)
}

fn terms(regression: &Regression, solution: &Solution) -> Vec<TermFit> {
    let inflation = regression.variance_inflation();
    let term = |(place, term): (usize, &super::Term)| {
        let coefficient = solution.coefficients[place];
        let [standard_error, classical_error] =
            [&solution.covariance, &solution.classical].map(|v| v[(place, place)].max(0.0).sqrt());
        let t = coefficient / standard_error;
        TermFit {
            name: term.to_string(),
            coefficient,
            standard_error,
            classical_error,
            t: finite(t),
            p: probability_beyond(t, solution.degrees_of_freedom),
            vif: inflation[place].unwrap_or(0.0),
            f_dropped: finite((coefficient / classical_error).powi(2)),
        }
    };
    regression.form().terms().iter().enumerate().map(term).collect()
}

/// A ratio, or the largest number if noise-free data make it infinite.
fn finite(ratio: f64) -> f64 {
    if ratio.is_finite() {
        ratio
    } else {
        f64::MAX.copysign(ratio)
    }
}

fn quality(drives: &[Drive], solution: &Solution) -> Quality {
    let points = drives
        .iter()
        .flat_map(|drive| drive.points.iter().map(move |point| (drive, point)));
    let n = solution.residuals.len() as f64;
    let mean = drives
        .iter()
        .flat_map(|drive| &drive.points)
        .map(|point| point.root)
        .sum::<f64>()
        / n;
    let free = n - solution.coefficients.len() as f64;
    let [
        mut total,
        mut absolute,
        mut share,
        mut square_n,
        mut absolute_n,
        mut share_n,
        mut loaded,
    ] = [0.0; 7];
    for ((drive, point), e) in points.zip(solution.residuals.iter()) {
        let scale = drive.conditions.force_scale();
        let law = (point.root - e).max(0.0);
        let error_n = scale * (point.root.powi(2) - law * law);
        total += (point.root - mean).powi(2);
        absolute += e.abs();
        square_n += error_n * error_n;
        absolute_n += error_n.abs();
        if point.root > 0.0 {
            loaded += 1.0;
            share += e.abs() / point.root;
            share_n += error_n.abs() / (scale * point.root.powi(2));
        }
    }
    let loaded = f64::max(loaded, 1.0);
    let r_squared = 1.0 - solution.residuals.norm_squared() / total;
    Quality {
        r_squared: if r_squared.is_finite() { r_squared } else { 0.0 },
        standard_error: solution.standard_error,
        mean_absolute_error: absolute / n,
        mean_percentage_error: 100.0 * share / loaded,
        standard_error_n: (square_n / free).sqrt(),
        mean_absolute_error_n: absolute_n / n,
        mean_percentage_error_force: 100.0 * share_n / loaded,
    }
}

fn ranges(drives: &[Drive]) -> Ranges {
    let mut found = [[f64::INFINITY, f64::NEG_INFINITY]; 8];
    let mut widen = |place: usize, value: f64| {
        if !value.is_nan() {
            let [low, high] = &mut found[place];
            (*low, *high) = (low.min(value), high.max(value));
        }
    };
    for drive in drives {
        for point in &drive.points {
            let values = drive.conditions.values(point.depth, point.speed);
            values
                .into_iter()
                .enumerate()
                .for_each(|(place, value)| widen(place, value));
            widen(6, point.speed);
        }
        if let Driving::Impact { speed, .. } = drive.conditions.driving {
            widen(7, speed);
        }
    }
    let optional = |place: usize| (found[place][0] <= found[place][1]).then_some(found[place]);
    Ranges {
        x: found[Variable::X as usize],
        rate: found[Variable::Rate as usize],
        slender: found[Variable::Slender as usize],
        inertia: optional(Variable::Inertia as usize),
        decay: optional(Variable::Decay as usize),
        energy: optional(Variable::Energy as usize),
        speed_m_s: found[6],
        impact_speed_m_s: optional(7),
    }
}

/// One step of a reduction: a form and the quality of its fit.
#[derive(Debug, Clone, Serialize)]
pub struct Reduction {
    /// The form.
    pub form: String,
    /// The term dropped last; none for the full form.
    pub dropped: Option<String>,
    /// R2.
    pub r_squared: f64,
    /// SEE.
    pub standard_error: f64,
    /// Increase in SEE from dropping that term \[%\].
    pub growth: f64,
    /// F of the classical test for dropping that term.
    pub f: Option<f64>,
    /// Clustered two-sided p-value of the dropped term.
    pub p: Option<f64>,
    /// Whether this form was chosen.
    pub chosen: bool,
}

/// Largest acceptable increase in SEE from dropping a term \[%\].
pub const DROP_BELOW: f64 = 5.0;

/// Drops terms from the end of a form one by one and refits. It chooses the shortest form before a dropped term
/// increases SEE by more than [`DROP_BELOW`]. Each form is fitted with `method`, or with the method it needs. The
/// published choice for plywood, made by judgement, is "reduced 5" (Table 2-8).
///
/// # Errors
/// Same as [`fit`].
pub fn reduce(form: &Form, drives: &[Drive], method: Option<Method>) -> Result<(Form, Vec<Reduction>), FitError> {
    let mut steps: Vec<Reduction> = Vec::new();
    let mut chosen = form.clone();
    let (mut current, mut choosing) = (Some(form.clone()), true);
    let mut last: Option<Vec<TermFit>> = None;
    while let Some(form) = current {
        let fitted = fit(&form, drives, method.unwrap_or_else(|| Method::of(&form, drives)))?;
        let file = fitted.law.file();
        let dropped = last.as_ref().and_then(|terms| terms.last());
        let growth = steps.last().map_or(0.0, |before| {
            100.0 * (file.quality.standard_error / before.standard_error - 1.0)
        });
        choosing &= growth <= DROP_BELOW;
        if choosing {
            chosen = form.clone();
            steps.iter_mut().for_each(|step| step.chosen = false);
        }
        steps.push(Reduction {
            form: form.to_string(),
            dropped: dropped.map(|term| term.name.clone()),
            r_squared: file.quality.r_squared,
            standard_error: file.quality.standard_error,
            growth,
            f: dropped.map(|term| term.f_dropped),
            p: dropped.map(|term| term.p),
            chosen: choosing,
        });
        last = Some(file.terms.clone());
        current = form.without_last();
    }
    Ok((chosen, steps))
}

/// Drives that one fold of a cross-validation leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Leave {
    /// All repeats of one condition.
    Group,
    /// All drives of one nail size.
    Nail,
    /// All drives into one wood.
    Wood,
    /// Single drives.
    Drive,
}

impl Leave {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::Nail => "nail",
            Self::Wood => "wood",
            Self::Drive => "drive",
        }
    }

    fn key(self, drive: &Drive) -> &String {
        match self {
            Self::Group => &drive.group,
            Self::Nail => &drive.nail,
            Self::Wood => &drive.wood,
            Self::Drive => &drive.id,
        }
    }
}

/// Prediction errors on data not used in the fit.
#[derive(Debug, Clone, Serialize)]
pub struct Validation {
    /// Drives left out of each fit.
    pub left_out: Leave,
    /// Root mean square error of s.
    pub root_mean_square: f64,
    /// Root mean square error of s in each fold; none if the remaining data do not determine the law.
    pub folds: Vec<(String, Option<f64>)>,
}

fn distinct(drives: &[Drive], key: impl Fn(&Drive) -> &String) -> BTreeMap<&String, Vec<usize>> {
    let mut all: BTreeMap<&String, Vec<usize>> = BTreeMap::new();
    for (index, drive) in drives.iter().enumerate() {
        all.entry(key(drive)).or_default().push(index);
    }
    all
}

/// Cross-validates: each fold is predicted by the law fitted to all others with `method`.
///
/// # Errors
/// [`FitError::OneFold`] if there are no other folds to fit.
pub fn validate(form: &Form, drives: &[Drive], method: Method, leave: Leave) -> Result<Validation, FitError> {
    let folds = distinct(drives, |drive| leave.key(drive));
    if folds.len() < 2 {
        return Err(FitError::OneFold { what: leave.name() });
    }
    let (mut sum, mut count) = (0.0, 0);
    let mut found = Vec::new();
    for (name, members) in folds {
        let rest: Vec<Drive> = drives
            .iter()
            .enumerate()
            .filter(|(index, _)| !members.contains(index))
            .map(|(_, drive)| drive.clone())
            .collect();
        let Ok(fitted) = fit(form, &rest, method) else {
            found.push((name.clone(), None));
            continue;
        };
        let (mut own, mut points) = (0.0, 0);
        for drive in members.iter().map(|index| &drives[*index]) {
            for point in &drive.points {
                let error = point.root - fitted.law.root(&drive.conditions, point.depth, point.speed).max(0.0);
                own += error * error;
                points += 1;
            }
        }
        found.push((name.clone(), Some((own / points as f64).sqrt())));
        sum += own;
        count += points;
    }
    Ok(Validation {
        left_out: leave,
        root_mean_square: if count > 0 {
            (sum / count as f64).sqrt()
        } else {
            f64::NAN
        },
        folds: found,
    })
}
