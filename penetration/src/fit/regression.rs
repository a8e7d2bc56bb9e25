//! Regression of s = sqrt(F_r/(H_M NL)) on the terms of a law.
//!
//! Ordinary least squares serves for quasi-static tests. The group `decay` = v/v0 depends on the drive itself: in
//! harder wood the nail is slower, so the specimen's deviation biases the least-squares coefficient. A law with `decay`
//! is therefore fitted in two steps. First, the terms that vary during a drive are fitted within drives, after
//! subtracting the mean of each drive. Then the means of the drives, equally weighted, are fitted to the terms that are
//! constant within a drive. The covariance of the first step is propagated to the second (Mundlak 1978, Econometrica
//! 46; Hausman and Taylor 1981, Econometrica 49).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::drive::Drive;
use super::error::FitError;
use super::form::{Form, Term, Values, Variable};
use super::least_squares::LeastSquares;

/// How the coefficients are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Ordinary least squares over all points.
    LeastSquares,
    /// First the terms that vary within drives, then the means of the drives.
    WithinBetween,
}

impl Method {
    /// The method required by a form and its data. How deep and how fast a projectile drives a nail depends on the
    /// specimen. Least squares over all points would mistake the influence of soft specimens, which are penetrated
    /// deeper, for an effect of depth or speed.
    pub fn of(form: &Form, drives: &[Drive]) -> Self {
        if form.uses(Variable::Decay) || drives.iter().any(|drive| !drive.conditions.driving.is_constant()) {
            Self::WithinBetween
        } else {
            Self::LeastSquares
        }
    }
}

/// A regression problem: drives and terms without the measured forces.
#[derive(Debug, Clone)]
pub struct Regression {
    method: Method,
    form: Form,
    /// Range of points of each drive.
    drives: Vec<Range<usize>>,
    /// Whether each term varies within a drive.
    varying: Vec<bool>,
    /// Sum of squares of each term's column about its mean, in the step that estimates the term.
    spread: Vec<f64>,
    steps: Steps,
}

#[derive(Debug, Clone)]
enum Steps {
    One(LeastSquares),
    Two {
        /// The varying terms, with the mean of each drive subtracted.
        within: LeastSquares,
        /// The terms constant within a drive, one row per drive.
        between: Option<LeastSquares>,
        /// Means of the varying terms over each drive.
        means: DMatrix<f64>,
        places: [Vec<usize>; 2],
    },
}

/// Coefficients with their covariance.
#[derive(Debug, Clone)]
pub struct Solution {
    /// C, one per term.
    pub coefficients: DVector<f64>,
    /// Covariance allowing for errors correlated within a drive; the classical one for a single drive.
    pub covariance: DMatrix<f64>,
    /// Covariance if all points were independent.
    pub classical: DMatrix<f64>,
    /// Measured s minus fitted s, by point.
    pub residuals: DVector<f64>,
    /// sigma_b, standard deviation between drives.
    pub sigma_between: f64,
    /// sigma_w, standard deviation within a drive.
    pub sigma_within: f64,
    /// SEE = sqrt(SSE/(n - p)).
    pub standard_error: f64,
    /// Degrees of freedom of the covariance: drives - 1, or n - p for one drive.
    pub degrees_of_freedom: f64,
}

impl Regression {
    /// Sets up the fit of `form` to the points of `drives` with `method`.
    ///
    /// # Errors
    /// [`FitError`] if the drives do not determine the terms.
    pub fn new(form: &Form, drives: &[Drive], method: Method) -> Result<Self, FitError> {
        let points: usize = drives.iter().map(|drive| drive.points.len()).sum();
        if points == 0 {
            return Err(FitError::Empty);
        }
        let terms = form.terms();
        check(form, drives, points)?;
        let mut ranges = Vec::with_capacity(drives.len());
        let mut start = 0;
        for drive in drives {
            ranges.push(start..start + drive.points.len());
            start += drive.points.len();
        }
        let constant_speed = drives.iter().all(|drive| drive.conditions.driving.is_constant());
        let varying: Vec<bool> = terms.iter().map(|term| term.varies(constant_speed)).collect();
        let constants = varying.iter().filter(|varies| !**varies).count();
        // The terms constant within a drive are fitted to the means of the drives with every method. A form that is
        // only a polynomial can be fitted to one drive.
        if constants > 1 && drives.len() <= constants {
            return Err(FitError::TooFewDrives {
                drives: drives.len(),
                terms: constants,
            });
        }
        let rows = || {
            drives.iter().flat_map(|drive| {
                let row = |point: &super::Point| drive.conditions.values(point.depth, point.speed);
                drive.points.iter().map(row)
            })
        };
        let (steps, spread) = match method {
            Method::LeastSquares => one_step(terms, points, rows)?,
            Method::WithinBetween => two_steps(terms, &varying, &ranges, rows)?,
        };
        Ok(Self {
            method,
            form: form.clone(),
            drives: ranges,
            varying,
            spread,
            steps,
        })
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The form.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// Range of points of each drive.
    pub fn drives(&self) -> &[Range<usize>] {
        &self.drives
    }

    /// Fits the roots s of all points, in the order of the drives.
    pub fn solve(&self, s: &DVector<f64>) -> Solution {
        let (n, p) = (s.len() as f64, self.form.terms().len() as f64);
        let groups = self.drives.len() as f64;
        match &self.steps {
            Steps::One(fit) => {
                let projected = fit.project(s);
                let residuals = s - fit.q() * &projected;
                let variance = residuals.norm_squared() / (n - p);
                let classical = fit.inverse_gram() * variance;
                let one = self.drives.len() < 2;
                let [sigma_between, sigma_within] = self.components(&residuals);
                Solution {
                    coefficients: fit.coefficients(&projected),
                    covariance: if one {
                        classical.clone()
                    } else {
                        fit.clustered(&residuals, &self.drives)
                    },
                    classical,
                    sigma_between,
                    sigma_within,
                    standard_error: variance.sqrt(),
                    degrees_of_freedom: if one { n - p } else { groups - 1.0 },
                    residuals,
                }
            }
            Steps::Two {
                within,
                between,
                means,
                places,
            } => self.solve_two(s, within, between.as_ref(), means, places),
        }
    }

    fn solve_two(
        &self,
        s: &DVector<f64>,
        within: &LeastSquares,
        between: Option<&LeastSquares>,
        means: &DMatrix<f64>,
        [varying, constant]: &[Vec<usize>; 2],
    ) -> Solution {
        let (n, p) = (s.len() as f64, self.form.terms().len());
        let groups = self.drives.len();
        let mut demeaned = s.clone();
        let mut level = DVector::zeros(groups);
        for (drive, range) in self.drives.iter().enumerate() {
            let mut part = demeaned.rows_mut(range.start, range.len());
            level[drive] = part.mean();
            part.add_scalar_mut(-level[drive]);
        }
        let projected = within.project(&demeaned);
        let first_residuals = &demeaned - within.q() * &projected;
        let free = (n - groups as f64 - varying.len() as f64).max(1.0);
        let sigma_within = (first_residuals.norm_squared() / free).sqrt();
        let first = within.coefficients(&projected);
        level -= means * &first;

        let (mut coefficients, mut covariance, mut classical) =
            (DVector::zeros(p), DMatrix::zeros(p, p), DMatrix::zeros(p, p));
        let mut put = |rows: &[usize], columns: &[usize], block: &DMatrix<f64>, classic: &DMatrix<f64>| {
            for (i, row) in rows.iter().enumerate() {
                for (j, column) in columns.iter().enumerate() {
                    covariance[(*row, *column)] = block[(i, j)];
                    classical[(*row, *column)] = classic[(i, j)];
                }
            }
        };
        for (value, place) in first.iter().zip(varying) {
            coefficients[*place] = *value;
        }
        let v1 = within.clustered(&first_residuals, &self.drives);
        let c1 = within.inverse_gram() * sigma_within.powi(2);
        put(varying, varying, &v1, &c1);
        let mut second_residuals = level.clone();
        let mut sigma_between = 0.0;
        if let Some(between) = between {
            let projected = between.project(&level);
            second_residuals -= between.q() * &projected;
            for (value, place) in between.coefficients(&projected).iter().zip(constant) {
                coefficients[*place] = *value;
            }
            let free = groups as f64 - constant.len() as f64;
            let variance = second_residuals.norm_squared() / free;
            let point_part = self.drives.iter().map(|range| 1.0 / range.len() as f64).sum::<f64>() / groups as f64;
            sigma_between = (variance - sigma_within.powi(2) * point_part).max(0.0).sqrt();
            let singles: Vec<Range<usize>> = (0..groups).map(|drive| drive..drive + 1).collect();
            // dC_2/dC_1
            let slope = -(between.inverse() * between.q().tr_mul(means));
            let v2 = between.clustered(&second_residuals, &singles) + &slope * &v1 * slope.transpose();
            let c2 = between.inverse_gram() * variance + &slope * &c1 * slope.transpose();
            put(constant, constant, &v2, &c2);
            let (v21, c21) = (&slope * &v1, &slope * &c1);
            put(constant, varying, &v21, &c21);
            put(varying, constant, &v21.transpose(), &c21.transpose());
        }
        let mut residuals = first_residuals;
        for (drive, range) in self.drives.iter().enumerate() {
            residuals
                .rows_mut(range.start, range.len())
                .add_scalar_mut(second_residuals[drive]);
        }
        Solution {
            coefficients,
            covariance,
            classical,
            sigma_between,
            sigma_within,
            standard_error: (residuals.norm_squared() / (n - p as f64)).sqrt(),
            degrees_of_freedom: groups as f64 - 1.0,
            residuals,
        }
    }

    /// Variance inflation factor of each term, by which its dependence on others raises its variance; none for
    /// constants.
    pub fn variance_inflation(&self) -> Vec<Option<f64>> {
        let diagonal = |fit: &LeastSquares| fit.inverse_gram().diagonal();
        let mut gram = vec![0.0; self.spread.len()];
        match &self.steps {
            Steps::One(fit) => gram.copy_from_slice(diagonal(fit).as_slice()),
            Steps::Two {
                within,
                between,
                places,
                ..
            } => {
                for (fit, places) in [(Some(within), &places[0]), (between.as_ref(), &places[1])] {
                    if let Some(fit) = fit {
                        places
                            .iter()
                            .zip(diagonal(fit).iter())
                            .for_each(|(place, value)| gram[*place] = *value);
                    }
                }
            }
        }
        gram.iter()
            .zip(&self.spread)
            .map(|(gram, spread)| (*spread > 0.0).then_some(gram * spread))
            .collect()
    }

    /// sigma_b and sigma_w of the residuals, by one-way analysis of variance for unbalanced data (Searle, Casella and
    /// McCulloch, Variance Components, 1992, sec. 3.6), less the degrees of freedom taken by the terms.
    fn components(&self, residuals: &DVector<f64>) -> [f64; 2] {
        let (n, groups) = (residuals.len() as f64, self.drives.len() as f64);
        let (mut inside, mut outside, mut squares) = (0.0, 0.0, 0.0);
        for range in &self.drives {
            let part = residuals.rows(range.start, range.len());
            let (count, mean) = (range.len() as f64, part.mean());
            inside += part.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
            outside += count * mean * mean;
            squares += count * count;
        }
        let varying = self.varying.iter().filter(|varies| **varies).count() as f64;
        let constant = self.varying.len() as f64 - varying;
        let within = inside / (n - groups - varying).max(1.0);
        if groups - constant < 1.0 || groups < 2.0 {
            return [0.0, within.sqrt()];
        }
        let typical = (n - squares / n) / (groups - 1.0);
        let between = (outside / (groups - constant) - within) / typical;
        [between.max(0.0).sqrt(), within.sqrt()]
    }
}

/// Rejects data that cannot be fitted, before any decomposition.
fn check(form: &Form, drives: &[Drive], points: usize) -> Result<(), FitError> {
    for drive in drives {
        let s = &drive.conditions.specimen;
        let positive = [
            ("the nail's length (m)", s.length),
            ("the nail's diameter (m)", s.diameter),
            ("the hardness modulus (N/m)", s.hardness_modulus),
            ("the density of the wood (kg/m3)", s.density),
        ];
        let driving = match drive.conditions.driving {
            super::Driving::Constant { speed } => [("the speed (m/s)", speed), ("the speed (m/s)", speed)],
            super::Driving::Impact { mass, speed } => [
                ("the projectile's mass (kg)", mass),
                ("the speed of impact (m/s)", speed),
            ],
        };
        for (what, value) in positive.into_iter().chain(driving) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(FitError::Value {
                    drive: drive.id.clone(),
                    what,
                    value,
                    rule: "above 0",
                });
            }
        }
        for point in &drive.points {
            for (what, value) in [
                ("a depth (m)", point.depth),
                ("a speed (m/s)", point.speed),
                ("a root", point.root),
            ] {
                if !value.is_finite() {
                    return Err(FitError::Value {
                        drive: drive.id.clone(),
                        what,
                        value,
                        rule: "finite",
                    });
                }
            }
        }
        if drive.conditions.driving.is_constant()
            && let Some(term) = form
                .terms()
                .iter()
                .find(|term| Variable::ALL.iter().any(|v| v.needs_impact() && term.power(*v) != 0.0))
        {
            return Err(FitError::NoImpact {
                term: term.to_string(),
                drive: drive.id.clone(),
            });
        }
    }
    let degree = form.degree();
    let mut depths: Vec<f64> = drives
        .iter()
        .flat_map(|drive| {
            drive
                .points
                .iter()
                .map(|point| point.depth / drive.conditions.specimen.length)
        })
        .collect();
    depths.sort_by(f64::total_cmp);
    depths.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    if (depths.len() as f64) <= degree {
        return Err(FitError::TooFewDepths {
            depths: depths.len(),
            degree,
        });
    }
    let terms = form.terms().len();
    if points <= terms {
        return Err(FitError::TooFewPoints { points, terms });
    }
    Ok(())
}

fn names(terms: &[Term]) -> Vec<String> {
    terms.iter().map(ToString::to_string).collect()
}

/// Values of the basis at all points.
fn fill<I: Iterator<Item = Values>>(basis: &Basis, points: usize, columns: usize, rows: I) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(points, columns);
    for (row, values) in rows.enumerate() {
        for (column, value) in basis.row(&values).enumerate() {
            matrix[(row, column)] = value;
        }
    }
    matrix
}

fn column_norms(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.column_iter().map(|column| column.norm()).collect()
}

/// Sum of squares of each column about its mean; zero if that is within rounding.
fn spreads(matrix: &DMatrix<f64>) -> Vec<f64> {
    let spread = |column: nalgebra::DVectorView<'_, f64>| {
        let (mean, scale) = (column.mean(), column.norm_squared());
        let sum: f64 = column.iter().map(|value| (value - mean).powi(2)).sum();
        if sum > 1e-20 * scale { sum } else { 0.0 }
    };
    matrix.column_iter().map(spread).collect()
}

fn term_matrix<I: Iterator<Item = Values>>(terms: &[Term], points: usize, rows: I) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(points, terms.len());
    for (row, values) in rows.enumerate() {
        for (column, term) in terms.iter().enumerate() {
            matrix[(row, column)] = term.value(&values);
        }
    }
    matrix
}

fn one_step<I: Iterator<Item = Values>>(
    terms: &[Term],
    points: usize,
    rows: impl Fn() -> I,
) -> Result<(Steps, Vec<f64>), FitError> {
    let basis = Basis::new(terms);
    let matrix = fill(&basis, points, terms.len(), rows());
    let norms = column_norms(&matrix);
    let fit = LeastSquares::new(matrix, basis.conversion(), &norms, &names(terms))?;
    Ok((Steps::One(fit), spreads(&term_matrix(terms, points, rows()))))
}

fn two_steps<I: Iterator<Item = Values>>(
    terms: &[Term],
    varying: &[bool],
    drives: &[Range<usize>],
    rows: impl Fn() -> I,
) -> Result<(Steps, Vec<f64>), FitError> {
    let points = drives.last().map_or(0, |range| range.end);
    let places = [true, false].map(|kind| (0..terms.len()).filter(|i| varying[*i] == kind).collect::<Vec<_>>());
    let [first, second] = [0, 1].map(|step: usize| places[step].iter().map(|i| terms[*i].clone()).collect::<Vec<_>>());
    let demean = |mut matrix: DMatrix<f64>| {
        let mut means = DMatrix::zeros(drives.len(), matrix.ncols());
        for (drive, range) in drives.iter().enumerate() {
            for column in 0..matrix.ncols() {
                let mut part = matrix.view_mut((range.start, column), (range.len(), 1));
                means[(drive, column)] = part.mean();
                part.add_scalar_mut(-means[(drive, column)]);
            }
        }
        (matrix, means)
    };
    let basis = Basis::new(&first);
    let matrix = fill(&basis, points, first.len(), rows());
    let norms = column_norms(&matrix);
    let (matrix, _) = demean(matrix);
    let within = LeastSquares::new(matrix, basis.conversion(), &norms, &names(&first))?;
    let (demeaned_terms, means) = demean(term_matrix(&first, points, rows()));

    let mut spread = vec![0.0; terms.len()];
    let mut keep = |places: &[usize], values: Vec<f64>| {
        places
            .iter()
            .zip(values)
            .for_each(|(place, value)| spread[*place] = value);
    };
    keep(&places[0], spreads(&demeaned_terms));
    let between = if second.is_empty() {
        None
    } else {
        let all: Vec<Values> = rows().collect();
        let own = || drives.iter().map(|range| all[range.start]);
        let matrix = term_matrix(&second, drives.len(), own());
        keep(&places[1], spreads(&matrix));
        let norms = column_norms(&matrix);
        let identity = DMatrix::identity(second.len(), second.len());
        Some(LeastSquares::new(matrix, &identity, &norms, &names(&second))?)
    };
    Ok((
        Steps::Two {
            within,
            between,
            means,
            places,
        },
        spread,
    ))
}
