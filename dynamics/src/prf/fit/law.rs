//! A fitted law: coefficients with their covariance, the range of the data, force, work and bands.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};
use thiserror::Error;

use super::drive::{Conditions, Driving};
use super::form::{Form, FormError, Term, VARIABLES, Variable};
use super::regression::Method;

/// The layout of a fit in a file.
pub const FIT_SCHEMA: &str = "nailnoise-fit/1";

/// Negative eigenvalues of a covariance up to this part of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// Part of a range by which a value may lie beyond it, for the rounding of units.
const SLACK: f64 = 1e-6;

/// What is known of a term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TermFit {
    /// The term, as `x^2*decay`.
    pub name: String,
    /// C \[-\].
    pub coefficient: f64,
    /// Its standard error, allowing for deviations common to a drive.
    pub standard_error: f64,
    /// Its standard error as if all points were independent.
    pub classical_error: f64,
    /// t = C/standard error.
    pub t: f64,
    /// Probability of a larger |t| if C were 0 (two-sided).
    pub p: f64,
    /// Factor by which dependence on other terms raises its variance; 0 for a constant.
    pub vif: f64,
    /// F of the classical test that drops the term alone.
    pub f_dropped: f64,
}

/// Quality of a fit, of s = sqrt(F_r/(H_M NL)) where it has no other unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// 1 - SSE/SST about the mean.
    pub r_squared: f64,
    /// SEE = sqrt(SSE/(n - p)).
    pub standard_error: f64,
    /// MAE = mean |e|.
    pub mean_absolute_error: f64,
    /// Mean |e|/s \[%\], over points with a force.
    pub mean_percentage_error: f64,
    /// Root mean square error of the force \[N\], with n - p.
    pub standard_error_n: f64,
    /// Mean |error| of the force \[N\].
    pub mean_absolute_error_n: f64,
    /// Mean |error|/force \[%\], over points with a force.
    pub mean_percentage_error_force: f64,
}

/// How much was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Points.
    pub points: usize,
    /// Drives.
    pub drives: usize,
    /// Groups of drives that repeat a condition.
    pub groups: usize,
}

/// Lowest and highest value in the data; NaN is not written, a variable that no drive has is absent.
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

/// The file as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitFile {
    /// `nailnoise-fit/1`.
    pub schema: String,
    /// The form, as `poly(x,7) + rate`, written out.
    pub form: String,
    /// How the coefficients were found.
    pub method: Method,
    /// Whether a design may use the law beyond the range of its data.
    pub extrapolate: bool,
    /// Standard deviation between drives of one condition: specimens.
    pub sigma_between: f64,
    /// Standard deviation within a drive.
    pub sigma_within: f64,
    /// Degrees of freedom of the covariance.
    pub degrees_of_freedom: f64,
    /// Deviation of one specimen from the law, of s; only in a drawn law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specimen_deviation: Option<f64>,
    /// H_M that the law is used with, in place of the wood's \[N/m\]; only in a drawn law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hardness_modulus: Option<f64>,
    /// V, covariance of the coefficients in the order of the terms.
    pub covariance: Vec<Vec<f64>>,
    /// Digests (SHA-256) of the files of data, by name.
    #[serde(default)]
    pub data: Vec<(String, String)>,
    /// How much was fitted.
    pub counts: Counts,
    /// Quality.
    pub quality: Quality,
    /// Range of the data.
    pub ranges: Ranges,
    /// The terms.
    pub terms: Vec<TermFit>,
}

/// Why a file holds no fitted law.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LawError {
    /// Another layout.
    #[error("its schema is \"{found}\", not \"{FIT_SCHEMA}\"")]
    Schema {
        /// The schema found.
        found: String,
    },
    /// A form or term that is none.
    #[error(transparent)]
    Form(#[from] FormError),
    /// Terms that are not those of the form.
    #[error("term {place} is \"{found}\", and the form has \"{expected}\" there")]
    Term {
        /// Place of the term, from 1.
        place: usize,
        /// The term found.
        found: String,
        /// The term of the form.
        expected: String,
    },
    /// A number out of its domain.
    #[error("{what} is {value}, and must be {rule}")]
    Value {
        /// The quantity.
        what: String,
        /// The number.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// A covariance of another size, not symmetric, or with a negative eigenvalue.
    #[error("the covariance is no symmetric matrix of {size} rows without negative eigenvalues")]
    Covariance {
        /// Number of terms.
        size: usize,
    },
}

/// A fitted law of penetration resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "FitFile", into = "FitFile")]
pub struct FittedLaw {
    file: FitFile,
    form: Form,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Square root of the covariance: V = root root^T.
    root: DMatrix<f64>,
}

impl TryFrom<FitFile> for FittedLaw {
    type Error = LawError;

    fn try_from(file: FitFile) -> Result<Self, LawError> {
        if file.schema != FIT_SCHEMA {
            let found = file.schema.chars().take(40).collect();
            return Err(LawError::Schema { found });
        }
        let form: Form = file.form.parse()?;
        let size = form.terms().len();
        for place in 0..size.max(file.terms.len()) {
            let expected = form
                .terms()
                .get(place)
                .map_or_else(|| "none".to_owned(), ToString::to_string);
            let found = file
                .terms
                .get(place)
                .map_or_else(|| "none".to_owned(), |term| term.name.clone());
            if found != expected {
                let place = place + 1;
                return Err(LawError::Term { place, found, expected });
            }
        }
        check(&file, &form)?;
        let covariance = &file.covariance;
        let square = covariance.len() == size && covariance.iter().all(|row| row.len() == size);
        let failure = LawError::Covariance { size };
        if !square || covariance.iter().flatten().any(|value| !value.is_finite()) {
            return Err(failure);
        }
        let covariance = DMatrix::from_fn(size, size, |i, j| covariance[i][j]);
        // Eigenvectors of the correlations, because coefficients of different size would hide each other.
        let scale: Vec<f64> = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        let unit = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
        let correlation = DMatrix::from_fn(size, size, |i, j| covariance[(i, j)] * unit(i) * unit(j));
        let skew = (&correlation - correlation.transpose()).amax();
        let eigen = SymmetricEigen::new(correlation);
        let largest = eigen.eigenvalues.max().max(0.0);
        if covariance.diagonal().min() < 0.0 || skew > ROUNDING || eigen.eigenvalues.min() < -ROUNDING * largest {
            return Err(failure);
        }
        let root = DMatrix::from_fn(size, size, |i, j| {
            scale[i] * eigen.eigenvectors[(i, j)] * eigen.eigenvalues[j].max(0.0).sqrt()
        });
        Ok(Self {
            coefficients: DVector::from_iterator(size, file.terms.iter().map(|term| term.coefficient)),
            covariance,
            root,
            form,
            file,
        })
    }
}

impl From<FittedLaw> for FitFile {
    fn from(law: FittedLaw) -> Self {
        law.file
    }
}

/// Numbers in their domains.
fn check(file: &FitFile, form: &Form) -> Result<(), LawError> {
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
        if !(value >= 0.0 && value.is_finite()) {
            return refuse(what, value, "finite and not negative");
        }
    }
    if let Some(deviation) = file.specimen_deviation
        && !deviation.is_finite()
    {
        return refuse("specimen_deviation", deviation, "finite");
    }
    if let Some(modulus) = file.hardness_modulus
        && !(modulus > 0.0 && modulus.is_finite())
    {
        return refuse("hardness_modulus", modulus, "above 0");
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
            _ => {}
        }
    }
    for (name, range) in [
        ("ranges.speed_m_s", Some(file.ranges.speed_m_s)),
        ("ranges.impact_speed_m_s", file.ranges.impact_speed_m_s),
    ] {
        if let Some([low, high]) = range
            && !(low.is_finite() && high.is_finite() && low <= high && high > 0.0)
        {
            return refuse(name, low, "at most the upper end, which is above 0");
        }
    }
    Ok(())
}

/// Which scatter a band holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scatter {
    /// Uncertainty of the law alone.
    Law,
    /// One shot into a specimen: and sigma_b.
    Shot,
    /// One measured point: and sigma_w.
    Point,
}

/// Where a value lies in the range of the data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// Name of the variable.
    pub variable: &'static str,
    /// Its value.
    pub value: f64,
    /// Range of the data.
    pub range: [f64; 2],
    /// Whether the value lies in it.
    pub inside: bool,
}

impl FittedLaw {
    /// The fit as it is written.
    pub fn file(&self) -> &FitFile {
        &self.file
    }

    /// The form.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// C, in the order of the terms.
    pub fn coefficients(&self) -> &DVector<f64> {
        &self.coefficients
    }

    /// V, covariance of C.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Whether the law needs the speed of an impact.
    pub fn needs_impact(&self) -> bool {
        self.dynamic()
            && Variable::ALL
                .iter()
                .any(|v| (v.needs_impact() || *v == Variable::Rate) && self.form.uses(*v))
    }

    /// Whether the data are of impacts.
    pub fn dynamic(&self) -> bool {
        self.file.ranges.impact_speed_m_s.is_some()
    }

    /// Speed at which a law of constant-speed tests is used in a dynamic run: the highest of the data \[m/s\].
    pub fn reference_speed(&self) -> f64 {
        self.file.ranges.speed_m_s[1]
    }

    /// Coefficients in the number of values of a law's draw: one a term, and one of the specimen.
    pub fn draw_size(&self) -> usize {
        self.coefficients.len() + 1
    }

    /// A law drawn with the uncertainty of this one: C from N(C, V), and the specimen's deviation b from
    /// N(0, sigma_b^2), from [`draw_size`](Self::draw_size) independent numbers of N(0, 1).
    ///
    /// sigma_b holds the scatter of the specimens' hardness, so that the drawn law keeps `hardness_modulus` \[N/m\]
    /// whatever H_M is drawn beside it.
    #[must_use]
    pub fn drawn(&self, normal: &[f64], hardness_modulus: f64) -> Self {
        let terms = self.coefficients.len();
        let mut law = self.clone();
        let z = DVector::from_iterator(terms, normal.iter().copied().chain(std::iter::repeat(0.0)).take(terms));
        law.coefficients += &self.root * z;
        for (term, coefficient) in law.file.terms.iter_mut().zip(law.coefficients.iter()) {
            term.coefficient = *coefficient;
        }
        law.file.specimen_deviation = Some(self.file.sigma_between * normal.get(terms).copied().unwrap_or(0.0));
        law.file.hardness_modulus = Some(hardness_modulus);
        law
    }

    /// b, deviation of the specimen of a drawn law.
    fn specimen_deviation(&self) -> f64 {
        self.file.specimen_deviation.unwrap_or(0.0)
    }

    fn row(&self, conditions: &Conditions, depth: f64, speed: f64) -> DVector<f64> {
        let values = conditions.values(depth, speed);
        DVector::from_iterator(
            self.coefficients.len(),
            self.form.terms().iter().map(|term| term.value(&values)),
        )
    }

    /// s at a depth \[m\] and speed \[m/s\], not clipped.
    pub fn root(&self, conditions: &Conditions, depth: f64, speed: f64) -> f64 {
        self.row(conditions, depth, speed).dot(&self.coefficients) + self.specimen_deviation()
    }

    /// F_r = H_M NL max(0, s)^2 \[N\].
    pub fn force(&self, conditions: &Conditions, depth: f64, speed: f64) -> f64 {
        conditions.force_scale() * self.root(conditions, depth, speed).max(0.0).powi(2)
    }

    /// The force's two-sided band \[N\] at `confidence` (0..1): H_M NL max(0, z C -+ t u)^2 with u^2 = z V z, and the
    /// variances of `scatter`.
    pub fn band(
        &self,
        conditions: &Conditions,
        (depth, speed): (f64, f64),
        confidence: f64,
        scatter: Scatter,
    ) -> [f64; 2] {
        let z = self.row(conditions, depth, speed);
        let mut variance = z.dot(&(&self.covariance * &z)).max(0.0);
        if scatter != Scatter::Law {
            variance += self.file.sigma_between.powi(2);
        }
        if scatter == Scatter::Point {
            variance += self.file.sigma_within.powi(2);
        }
        let half = student_t(confidence, self.file.degrees_of_freedom) * variance.sqrt();
        let root = z.dot(&self.coefficients) + self.specimen_deviation();
        [root - half, root + half].map(|root| conditions.force_scale() * root.max(0.0).powi(2))
    }

    /// Work over the nail's length at constant speed and its standard error \[J\]: W = H_M NL^2 C^T G C with
    /// G_jk = int m_j m_k dx, var W = h^T V h, h = 2 H_M NL^2 G C. None for a law with `decay`, whose work depends on the
    /// drive, and where s falls below 0, where the force is cut off.
    pub fn work(&self, conditions: &Conditions, speed: f64) -> Option<[f64; 2]> {
        let length = conditions.specimen.length;
        if self.form.uses(Variable::Decay)
            || (0..=200).any(|i| self.root(conditions, length * f64::from(i) / 200.0, speed) < 0.0)
        {
            return None;
        }
        let values = conditions.values(length, speed);
        let terms = self.form.terms();
        let cofactor: Vec<f64> = terms
            .iter()
            .map(|term| term.with_depth_power(0.0).value(&values))
            .collect();
        let power = |k: usize| terms[k].power(Variable::X);
        let n = terms.len();
        let gram = DMatrix::from_fn(n, n, |j, k| cofactor[j] * cofactor[k] / (power(j) + power(k) + 1.0));
        let scale = conditions.force_scale() * length;
        let half = &gram * &self.coefficients;
        let work = scale * self.coefficients.dot(&half);
        let h = half * (2.0 * scale);
        Some([work, h.dot(&(&self.covariance * &h)).max(0.0).sqrt()])
    }

    /// Where the conditions of a drive lie in the range of the data, by variable of the form.
    pub fn placement(&self, conditions: &Conditions) -> Vec<Placement> {
        let speed = match conditions.driving {
            Driving::Constant { speed } | Driving::Impact { speed, .. } => speed,
        };
        let values = conditions.values(conditions.specimen.length, speed);
        let mut found = Vec::new();
        for variable in Variable::ALL {
            let value = values[variable as usize];
            // Depth and speeds run through their ranges; what counts of the depth is how deep the data go.
            if matches!(variable, Variable::Decay) || value.is_nan() || !self.form.uses(variable) {
                continue;
            }
            if let Some(range) = self.file.ranges.of(variable) {
                let [mut low, high] = range;
                if matches!(variable, Variable::X) || (variable == Variable::Rate && self.dynamic()) {
                    low = 0.0;
                }
                let slack = SLACK * high.abs();
                found.push(Placement {
                    variable: variable.name(),
                    value,
                    range: [low, high],
                    inside: value >= low - slack && value <= high + slack,
                });
            }
        }
        found
    }

    /// The law for a nail in a wood, driven by a mass \[kg\].
    pub fn of(&self, specimen: &crate::prf::Specimen, mass: f64) -> LawOfDrive {
        let mut specimen = *specimen;
        specimen.hardness_modulus = self.file.hardness_modulus.unwrap_or(specimen.hardness_modulus);
        LawOfDrive::new(self, &specimen, mass)
    }
}

/// C times a product of powers of depth, speed and speed of impact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Monomial {
    coefficient: f64,
    depth: f64,
    speed: f64,
    impact: f64,
}

/// A fitted law for one nail, wood and mass: the force over depth, speed and speed of impact.
#[derive(Debug, Clone, PartialEq)]
pub struct LawOfDrive {
    terms: Vec<Monomial>,
    length: f64,
    scale: f64,
    /// Range of v/v0 in the data, to which the speed is held; none for a law without speed.
    decay: Option<[f64; 2]>,
    /// Speed of impact in the middle of the data \[m/s\].
    usual_impact: f64,
    /// Speeds of impact that the law may be used at \[m/s\].
    impacts: [f64; 2],
}

/// Force and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resisting {
    /// F_r \[N\].
    pub force: f64,
    /// dF_r/dy \[N/m\].
    pub by_depth: f64,
    /// dF_r/dv \[N s/m\].
    pub by_speed: f64,
}

impl LawOfDrive {
    fn new(law: &FittedLaw, specimen: &crate::prf::Specimen, mass: f64) -> Self {
        let inertia = specimen.length * specimen.density / specimen.hardness_modulus;
        let energy = mass / (specimen.hardness_modulus * specimen.length * specimen.length);
        let dynamic = law.dynamic();
        let reference = law.reference_speed();
        let monomial = |(term, coefficient): (&Term, &f64)| {
            let power: [f64; VARIABLES] = Variable::ALL.map(|variable| term.power(variable));
            let [x, rate, slender, pi3, decay, pi6] = power;
            let fixed = coefficient
                * (specimen.diameter / specimen.length).powf(slender)
                * inertia.powf(rate + pi3)
                * energy.powf(pi6);
            Monomial {
                // A law of constant-speed tests is used at their highest speed.
                coefficient: if dynamic {
                    fixed
                } else {
                    fixed * reference.powf(2.0 * rate)
                },
                depth: x,
                speed: decay + if dynamic { 2.0 * rate } else { 0.0 },
                impact: 2.0 * (pi3 + pi6) - decay,
            }
        };
        let mut terms: Vec<Monomial> = law
            .form
            .terms()
            .iter()
            .zip(law.coefficients.iter())
            .map(monomial)
            .collect();
        if law.specimen_deviation() != 0.0 {
            terms.push(Monomial {
                coefficient: law.specimen_deviation(),
                depth: 0.0,
                speed: 0.0,
                impact: 0.0,
            });
        }
        let mut impacts = [0.0, f64::INFINITY];
        for (variable, per_square) in [(Variable::Inertia, inertia), (Variable::Energy, energy)] {
            if let Some([low, high]) = law.file.ranges.of(variable)
                && law.form.uses(variable)
                && !law.file.extrapolate
            {
                impacts[0] = f64::max(impacts[0], (low / per_square).sqrt() * (1.0 - SLACK));
                impacts[1] = f64::min(impacts[1], (high / per_square).sqrt() * (1.0 + SLACK));
            }
        }
        let varies = terms.iter().any(|term| term.speed != 0.0);
        Self {
            decay: law.file.ranges.decay.filter(|_| varies),
            usual_impact: law
                .file
                .ranges
                .impact_speed_m_s
                .map_or(reference, |[low, high]| 0.5 * (low + high)),
            terms,
            impacts,
            length: specimen.length,
            scale: specimen.hardness_modulus * specimen.length,
        }
    }

    /// Whether the force depends on the speed of the nail.
    pub fn depends_on_speed(&self) -> bool {
        self.decay.is_some()
    }

    /// Speeds of impact that the law may be used at \[m/s\]: those of the data of `inertia` and `energy`.
    pub fn impacts(&self) -> [f64; 2] {
        self.impacts
    }

    /// Speed of impact in the middle of the data, where none is known \[m/s\].
    pub fn usual_impact(&self) -> f64 {
        self.usual_impact
    }

    /// The force at `depth` \[m\] and speed \[m/s\] after an impact at `impact` \[m/s\]. v/v0 is held to the range of the
    /// data: the gas behind a piston pushes on, which the similarity of Eq. 3.1 lacks.
    #[inline]
    pub fn evaluate(&self, depth: f64, speed: f64, impact: f64) -> Resisting {
        let x = depth / self.length;
        let (held, free) = match self.decay {
            Some([low, high]) => {
                let held = speed.clamp(low * impact, high * impact);
                (held, held == speed)
            }
            None => (1.0, false),
        };
        let (mut root, mut by_x, mut by_v) = (0.0, 0.0, 0.0);
        for term in &self.terms {
            let rest = term.coefficient * power(impact, term.impact);
            let of_speed = power(held, term.speed);
            root += rest * of_speed * power(x, term.depth);
            if term.depth != 0.0 {
                by_x += rest * of_speed * term.depth * power(x, term.depth - 1.0);
            }
            if free && term.speed != 0.0 {
                by_v += rest * power(x, term.depth) * term.speed * power(held, term.speed - 1.0);
            }
        }
        if root > 0.0 {
            Resisting {
                force: self.scale * root * root,
                by_depth: 2.0 * self.scale * root * by_x / self.length,
                by_speed: 2.0 * self.scale * root * by_v,
            }
        } else {
            Resisting {
                force: 0.0,
                by_depth: 0.0,
                by_speed: 0.0,
            }
        }
    }
}

#[inline]
fn power(value: f64, power: f64) -> f64 {
    match power {
        0.0 => 1.0,
        1.0 => value,
        2.0 => value * value,
        // Steps of an integration may look above the surface.
        _ if power == power.trunc() => value.powi(power as i32),
        _ => value.max(0.0).powf(power),
    }
}

/// The two-sided quantile of Student's t: |t| is larger with the probability 1 - `confidence`.
pub fn student_t(confidence: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * confidence))
}

/// The number of N(0, 1) below which lies this share (0..1).
pub fn standard_normal(share: f64) -> f64 {
    // A share of 0 has no finite number; 2^-54 is less than half of the smallest other one.
    let share = share.max(0.5 * f64::EPSILON * 0.25);
    -f64::sqrt(2.0) * statrs::function::erf::erfc_inv(2.0 * share)
}

/// The probability of a larger |t| than this (two-sided).
pub fn probability_beyond(t: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::NAN, |law| 2.0 * law.sf(t.abs()))
}
