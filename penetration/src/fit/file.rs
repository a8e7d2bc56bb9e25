//! The file of a fit: its contents, and the domains of its values.

use serde::{Deserialize, Serialize};

use super::form::{Form, VARIABLES, Values, Variable};
use super::law_error::LawError;
use super::rate_fit::FittedRate;
use super::regression::Method;

/// The results for a term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TermFit {
    /// The term, such as `x^2*decay`.
    pub name: String,
    /// C \[-\].
    pub coefficient: f64,
    /// Its standard error, allowing for errors correlated within a drive.
    pub standard_error: f64,
    /// Its standard error if all points were independent.
    pub classical_error: f64,
    /// t = C/standard error.
    pub t: f64,
    /// Probability of a larger |t| if C were 0 (two-sided).
    pub p: f64,
    /// Variance inflation factor: how much dependence on other terms raises its variance; 0 for a constant.
    pub vif: f64,
    /// F of the classical test for dropping only this term.
    pub f_dropped: f64,
}

/// Quality of a fit, in terms of s = sqrt(F_r/(H_M NL)) unless another unit is stated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// 1 - SSE/SST about the mean.
    pub r_squared: f64,
    /// SEE = sqrt(SSE/(n - p)).
    pub standard_error: f64,
    /// MAE = mean |e|.
    pub mean_absolute_error: f64,
    /// Mean |e|/s \[%\], over points with a nonzero force.
    pub mean_percentage_error: f64,
    /// Root mean square error of the force \[N\], with n - p degrees of freedom.
    pub standard_error_n: f64,
    /// Mean absolute error of the force \[N\].
    pub mean_absolute_error_n: f64,
    /// Mean absolute error relative to the force \[%\], over points with a nonzero force.
    pub mean_percentage_error_force: f64,
}

/// Amount of data fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Points.
    pub points: usize,
    /// Drives.
    pub drives: usize,
    /// Groups of drives under the same condition.
    pub groups: usize,
}

/// Lowest and highest values in the data. Variables that no drive has are NaN here and omitted from the file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranges {
    /// y/NL.
    pub x: [f64; 2],
    /// NL rho v^2/H_M.
    pub rate: [f64; 2],
    /// D/NL.
    pub slender: [f64; 2],
    /// NL rho v0^2/H_M.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 2]>,
    /// v/v0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decay: Option<[f64; 2]>,
    /// M v0^2/(H_M NL^2).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<[f64; 2]>,
    /// v, speed of penetration \[m/s\].
    pub speed_m_s: [f64; 2],
    /// v0 \[m/s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impact_speed_m_s: Option<[f64; 2]>,
}

impl Ranges {
    /// The range of a variable.
    pub fn of(&self, variable: Variable) -> Option<[f64; 2]> {
        match variable {
            Variable::X => Some(self.x),
            Variable::Rate => Some(self.rate),
            Variable::Slender => Some(self.slender),
            Variable::Inertia => self.inertia,
            Variable::Decay => self.decay,
            Variable::Energy => self.energy,
        }
    }
}

/// The file of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitFile {
    /// `nailnoise-fit/1`.
    pub schema: String,
    /// The form, such as `poly(x,7) + rate`.
    pub form: String,
    /// How the coefficients were estimated.
    pub method: Method,
    /// Whether a design may use the law beyond the range of its data.
    pub extrapolate: bool,
    /// Standard deviation between drives under one condition, which reflects differences between specimens.
    pub sigma_between: f64,
    /// Standard deviation within a drive.
    pub sigma_within: f64,
    /// Degrees of freedom of the covariance.
    pub degrees_of_freedom: f64,
    /// Deviation of one specimen from the law, in s; only in a law drawn at random.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specimen_deviation: Option<f64>,
    /// Dependence on speed by which the forces of the tests were divided; the law is then quasi-static.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<FittedRate>,
    /// V, covariance of the coefficients in the order of the terms.
    pub covariance: Vec<Vec<f64>>,
    /// Digests (SHA-256) of the files of data, by name.
    #[serde(default)]
    pub data: Vec<(String, String)>,
    /// Amount of data fitted.
    pub counts: Counts,
    /// Quality of the fit.
    pub quality: Quality,
    /// Range of the data.
    pub ranges: Ranges,
    /// The terms.
    pub terms: Vec<TermFit>,
}

/// Largest |C m| of a term, largest |s| of the law and largest deviation of s, within the range of the data \[-\]. A
/// steel nail yields at s below 1, but data of several variables seldom fill all corners of their ranges, and terms of
/// opposite sign may leave larger values there. Terms above the first limit lose most digits to cancellation.
const LARGEST_TERM: f64 = 1e6;
const LARGEST_ROOT: f64 = 1e3;
const LARGEST_DEVIATION: f64 = 100.0;

/// Number of depths, across the range of the data, at which s is checked.
const DEPTHS: usize = 100;

/// Domains of the variables in the order of [`Variable::ALL`], followed by that of the speed \[m/s\]. They cover every
/// drive that `prf fit` reads.
const DOMAINS: [f64; VARIABLES] = [10.0, 1e6, 1.0, 1e6, 10.0, 1e9];
const HIGHEST_SPEED: f64 = 1e3;

/// All combinations of the lowest and highest values of the variables in the data, with x between its ends.
fn corners(ranges: &Ranges) -> impl Iterator<Item = Values> {
    let ends = Variable::ALL.map(|variable| ranges.of(variable).unwrap_or([0.0; 2]));
    (0..1 << (VARIABLES - 1)).flat_map(move |corner: usize| {
        let mut values: Values = std::array::from_fn(|place| ends[place][(corner >> place.saturating_sub(1)) & 1]);
        (0..=DEPTHS).map(move |step| {
            let [low, high] = ends[Variable::X as usize];
            values[Variable::X as usize] = low + (high - low) * step as f64 / DEPTHS as f64;
            values
        })
    })
}

/// Checks that the law has a plausible magnitude throughout the range of its data.
fn check_size(file: &FitFile, form: &Form) -> Result<(), LawError> {
    let refuse = |what: String, value: f64, rule: &'static str| Err(LawError::Value { what, value, rule });
    // A variable may start at 0, and a term may divide by it.
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    for values in corners(&file.ranges) {
        let mut root = 0.0;
        for (term, own) in form.terms().iter().zip(&file.terms) {
            let factor = finite(term.value(&values));
            if factor != 0.0 && (own.coefficient * factor).abs() > LARGEST_TERM {
                return refuse(
                    format!("the term {} in the range of the data", own.name),
                    own.coefficient * factor,
                    "1e6 in magnitude at most",
                );
            }
            root += own.coefficient * factor;
        }
        if root.abs() > LARGEST_ROOT {
            return refuse(
                "the root s = sqrt(F_r/(H_M NL)) in the range of the data".to_owned(),
                root,
                "1000 in magnitude at most",
            );
        }
    }
    Ok(())
}

/// Checks the values that only describe the fit.
fn check_statistics(file: &FitFile) -> Result<(), LawError> {
    let q = &file.quality;
    let quality = [
        ("quality.r_squared", q.r_squared),
        ("quality.standard_error", q.standard_error),
        ("quality.mean_absolute_error", q.mean_absolute_error),
        ("quality.mean_percentage_error", q.mean_percentage_error),
        ("quality.standard_error_n", q.standard_error_n),
        ("quality.mean_absolute_error_n", q.mean_absolute_error_n),
        ("quality.mean_percentage_error_force", q.mean_percentage_error_force),
    ];
    let quality = quality.map(|(name, value)| (name.to_owned(), value));
    let terms = file.terms.iter().flat_map(|term| {
        let own = [
            ("standard_error", term.standard_error),
            ("classical_error", term.classical_error),
            ("t", term.t),
            ("p", term.p),
            ("vif", term.vif),
            ("f_dropped", term.f_dropped),
        ];
        own.map(|(name, value)| (format!("{name} of {}", term.name), value))
    });
    match quality.into_iter().chain(terms).find(|(_, value)| !value.is_finite()) {
        Some((what, value)) => Err(LawError::Value {
            what,
            value,
            rule: "finite",
        }),
        None => Ok(()),
    }
}

/// Checks that all values lie in their domains.
pub(super) fn check(file: &FitFile, form: &Form) -> Result<(), LawError> {
    let refuse = |what: &str, value: f64, rule: &'static str| {
        let what = what.to_owned();
        Err(LawError::Value { what, value, rule })
    };
    for term in &file.terms {
        if !term.coefficient.is_finite() {
            return refuse(&format!("the coefficient of {}", term.name), term.coefficient, "finite");
        }
    }
    for (what, value) in [
        ("sigma_between", file.sigma_between),
        ("sigma_within", file.sigma_within),
    ] {
        if !(0.0..=LARGEST_DEVIATION).contains(&value) {
            return refuse(what, value, "from 0 to 100");
        }
    }
    if let Some(deviation) = file.specimen_deviation
        && (deviation.is_nan() || deviation.abs() > LARGEST_DEVIATION)
    {
        return refuse("specimen_deviation", deviation, "100 in magnitude at most");
    }
    if !(file.degrees_of_freedom >= 1.0 && file.degrees_of_freedom.is_finite()) {
        return refuse("degrees_of_freedom", file.degrees_of_freedom, "1 or more");
    }
    for variable in Variable::ALL {
        let range = file.ranges.of(variable);
        let name = format!("ranges.{}", variable.name());
        match range {
            None if form.uses(variable) => return refuse(&name, f64::NAN, "a range, because the form has it"),
            Some([low, high]) if !(low.is_finite() && high.is_finite() && low <= high && high >= 0.0) => {
                return refuse(&name, low, "at most the upper end, both finite");
            }
            Some([_, high]) if high > DOMAINS[variable as usize] => {
                return refuse(&name, high, "within the values that nails, woods and projectiles give");
            }
            _ => {}
        }
    }
    for (name, range) in [
        ("ranges.speed_m_s", Some(file.ranges.speed_m_s)),
        ("ranges.impact_speed_m_s", file.ranges.impact_speed_m_s),
    ] {
        if let Some([low, high]) = range
            && !(low.is_finite() && low <= high && high > 0.0 && high <= HIGHEST_SPEED)
        {
            return refuse(
                name,
                low,
                "at most the upper end, which is above 0 and at most 1000 m/s",
            );
        }
    }
    if let Some(rate) = &file.rate {
        for (what, value, [low, high], rule) in rate.domains() {
            if !(low..=high).contains(&value) {
                return refuse(what, value, rule);
            }
        }
    }
    check_statistics(file)?;
    check_size(file, form)
}
