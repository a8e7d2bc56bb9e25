//! A fitted law: coefficients with their covariance, the range of the data, force, work and confidence bands.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::clean::BIN;
use super::distributions::student_t;
use super::drive::{Conditions, Driving};
use super::file::{FitFile, check};
use super::form::{Form, Variable};
use super::law_error::{FIT_SCHEMA, LawError};
use super::rate_fit::FittedRate;

/// Negative eigenvalues of a covariance up to this fraction of the largest are attributed to rounding.
const ROUNDING: f64 = 1e-9;

/// Tolerance at the ends of a range, as a fraction of it, for rounding in unit conversion.
pub(super) const SLACK: f64 = 1e-6;

/// A fitted law of penetration resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "FitFile", into = "FitFile")]
pub struct FittedLaw {
    file: FitFile,
    form: Form,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Matrix square root of the covariance: V = root root^T.
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
        // Eigenvectors of the correlation matrix, because coefficients differ greatly in magnitude.
        let scale: Vec<f64> = covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        let unit = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
        let correlation = DMatrix::from_fn(size, size, |i, j| covariance[(i, j)] * unit(i) * unit(j));
        let skew = (&correlation - correlation.transpose()).amax();
        let eigen = SymmetricEigen::new(correlation);
        let largest = eigen.eigenvalues.max().max(0.0);
        if covariance.diagonal().min() < 0.0 || skew > ROUNDING || eigen.eigenvalues.min() < -ROUNDING * largest {
            return Err(failure);
        }
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let root = DMatrix::from_fn(size, size, |i, j| {
            let j = order[j];
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

/// Sources of scatter included in a band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scatter {
    /// Uncertainty of the law only.
    Law,
    /// One drive into one specimen: adds sigma_b.
    Shot,
    /// One measured point: adds sigma_w.
    Point,
}

/// Position of a value relative to the range of the data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// Name of the variable.
    pub variable: &'static str,
    /// Its value.
    pub value: f64,
    /// Range of the data.
    pub range: [f64; 2],
    /// Whether the value lies within it.
    pub inside: bool,
}

impl FittedLaw {
    /// The contents of the law's file.
    pub fn file(&self) -> &FitFile {
        &self.file
    }

    /// Adds the digests of the data files, by name, and whether the law may be used beyond their range.
    #[must_use]
    pub fn with_data(mut self, data: Vec<(String, String)>, extrapolate: bool) -> Self {
        (self.file.data, self.file.extrapolate) = (data, extrapolate);
        self
    }

    /// Adds the dependence on speed by which the data were divided.
    #[must_use]
    pub fn with_rate(mut self, rate: FittedRate) -> Self {
        self.file.rate = Some(rate);
        self
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

    /// Whether the law needs the impact speed.
    pub fn needs_impact(&self) -> bool {
        self.dynamic()
            && Variable::ALL
                .iter()
                .any(|v| (v.needs_impact() || *v == Variable::Rate) && self.form.uses(*v))
    }

    /// Whether the data are from impacts.
    pub fn dynamic(&self) -> bool {
        self.file.ranges.impact_speed_m_s.is_some()
    }

    /// Speed at which a dynamic run uses a law from constant-speed tests: the highest in the data \[m/s\].
    pub fn reference_speed(&self) -> f64 {
        self.file.ranges.speed_m_s[1]
    }

    /// Number of random values needed to draw a law: one for the specimen and one per term.
    pub fn draw_size(&self) -> usize {
        self.coefficients.len() + 1
    }

    /// Draws a law within the uncertainty of this one from [`draw_size`](Self::draw_size) samples of N(0, 1). The first
    /// sample gives the specimen's deviation b ~ N(0, sigma_b^2), the others give C ~ N(C, V) along the principal
    /// components of the correlation matrix of C, the largest first. Missing samples count as 0.
    ///
    /// sigma_b includes the scatter of the specimens' hardness, so H_M must not be drawn as well.
    #[must_use]
    pub fn drawn(&self, normal: &[f64]) -> Self {
        let terms = self.coefficients.len();
        let mut law = self.clone();
        let number = |place: usize| normal.get(place).copied().unwrap_or(0.0);
        law.coefficients += &self.root * DVector::from_fn(terms, |place, _| number(place + 1));
        for (term, coefficient) in law.file.terms.iter_mut().zip(law.coefficients.iter()) {
            term.coefficient = *coefficient;
        }
        law.file.specimen_deviation = Some(self.file.sigma_between * number(0));
        law
    }

    /// b, the specimen deviation of a drawn law.
    pub(super) fn specimen_deviation(&self) -> f64 {
        self.file.specimen_deviation.unwrap_or(0.0)
    }

    fn row(&self, conditions: &Conditions, depth: f64, speed: f64) -> DVector<f64> {
        let values = conditions.values(depth, speed);
        DVector::from_iterator(
            self.coefficients.len(),
            self.form.terms().iter().map(|term| term.value(&values)),
        )
    }

    /// s at a depth \[m\] and speed \[m/s\], not clipped at zero.
    pub fn root(&self, conditions: &Conditions, depth: f64, speed: f64) -> f64 {
        self.row(conditions, depth, speed).dot(&self.coefficients) + self.specimen_deviation()
    }

    /// F_r = H_M NL max(0, s)^2 \[N\].
    pub fn force(&self, conditions: &Conditions, depth: f64, speed: f64) -> f64 {
        conditions.force_scale() * self.root(conditions, depth, speed).max(0.0).powi(2)
    }

    /// Two-sided band of the force \[N\] at `confidence` (0..1): H_M NL max(0, z C -+ t u)^2, where u^2 is z V z plus
    /// the variances of `scatter`.
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

    /// Work over the nail's length at constant speed and its standard error \[J\]: W = H_M NL^2 C^T G C with G_jk = int
    /// m_j m_k dx, var W = h^T V h, h = 2 H_M NL^2 G C. None for a law with `decay`, because its work depends on the
    /// drive. Also none if s becomes negative, because the force is then cut off.
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

    /// Position of a drive's conditions in the range of the data, for each variable of the form.
    pub fn placement(&self, conditions: &Conditions) -> Vec<Placement> {
        let speed = match conditions.driving {
            Driving::Constant { speed } | Driving::Impact { speed, .. } => speed,
        };
        let values = conditions.values(conditions.specimen.length, speed);
        let mut found = Vec::new();
        for variable in Variable::ALL {
            let value = values[variable as usize];
            // Depth and speed pass through their ranges; for depth, only the deepest point matters.
            if matches!(variable, Variable::Decay) || value.is_nan() || !self.form.uses(variable) {
                continue;
            }
            if let Some(range) = self.file.ranges.of(variable) {
                let [mut low, high] = range;
                if matches!(variable, Variable::X) || (variable == Variable::Rate && self.dynamic()) {
                    low = 0.0;
                }
                let mut slack = SLACK * high.abs();
                if variable == Variable::X {
                    // A point is the mean over a bin.
                    slack += BIN;
                }
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
}
