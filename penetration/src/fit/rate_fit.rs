//! Fit of the quasi-static law to drives at any known speed: the forces are divided by the law of the speed.
//!
//! ```text
//! F(z, v) = F_def c(v) + F_fric q(v)      F_fric = min(phi F_L x, F),  F_def = F - F_fric
//! F(z) = [F(z, v) - phi F_L x (q - c)]/c  where that is above phi F_L x, else F(z, v)/q
//! ```
//!
//! c and q are the factors of [`SpeedTerms`], and F_L is the quasi-static force at full depth. F_L follows from the fit
//! and also enters it, so both are repeated until F_L does not change. beta and v_m minimise the squares of the
//! residuals of s at the speed of the tests. The method is Gauss-Newton on the residuals of the fit at given beta and
//! v_m (variable projection of G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 413, 1973). Their errors allow for
//! deviations common to a drive.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::distributions::student_t;
use super::drive::{Conditions, Drive, Driving, Point};
use super::error::FitError;
use super::form::{Form, Variable};
use super::regression::{Method, Regression};
use crate::REFERENCE_SPEED;
use crate::speed_terms::SpeedTerms;

/// Relative change of F_L at which the repetition ends, and the largest number of repetitions. Each one leaves about
/// phi |q - c|/c of the change, which is 0.4 or less with the published values.
const CLOSE: f64 = 1e-11;
const REPETITIONS: usize = 200;

/// Steps of the estimation, and the change of beta and ln v_m at which it ends.
const STEPS: usize = 60;
const STILL: f64 = 1e-7;

/// Smallest ratio of the highest to the lowest speed for an estimation.
const SPREAD: f64 = 10.0;

/// Largest ratio of the upper end of the 95 % interval of v_m to the estimate: beyond it the drives do not determine
/// v_m. The value is a choice: the range of `wood.friction_speed` in the base design, 0.3 to 3 m/s.
const UNKNOWN: f64 = 10.0;

/// Bounds of beta, and of v_m \[m/s\].
const CRUSHING: [f64; 2] = [0.0, 1.0];
const WIDTH: [f64; 2] = [1e-3, 1e3];

/// The law of the speed by which forces are divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateChoice {
    /// phi, share of friction in the quasi-static force at full depth.
    pub friction_share: f64,
    /// Its coefficients; beta and v_m are the initial values of an estimation.
    pub speed: SpeedTerms,
    /// Whether beta and v_m are estimated.
    pub estimate: bool,
}

/// The law of the speed in a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedRate {
    /// phi, share of friction in the quasi-static force at full depth.
    pub friction_share: f64,
    /// Lowest and highest speed of the points \[m/s\].
    pub speeds_m_s: [f64; 2],
    /// 95 % interval of beta, if estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crushing_interval: Option<[f64; 2]>,
    /// 95 % interval of v_m \[m/s\], if estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_interval_m_s: Option<[f64; 2]>,
    /// Its coefficients.
    pub speed: SpeedTerms,
}

impl FittedRate {
    /// Its values with their domains.
    pub(super) fn domains(&self) -> [(&'static str, f64, [f64; 2], &'static str); 5] {
        [
            ("rate.friction_share", self.friction_share, [0.0, 1.0], "from 0 to 1"),
            ("rate.speed.crushing", self.speed.crushing, CRUSHING, "from 0 to 1"),
            ("rate.speed.rest", self.speed.rest, [0.01, 2.0], "from 0.01 to 2"),
            ("rate.speed.sliding", self.speed.sliding, [0.01, 2.0], "from 0.01 to 2"),
            ("rate.speed.width", self.speed.width, WIDTH, "from 0.001 to 1000 m/s"),
        ]
    }
}

/// Drives without the effect of speed.
#[derive(Debug, Clone)]
pub struct WithoutRate {
    /// The drives as they would be at [`REFERENCE_SPEED`].
    pub drives: Vec<Drive>,
    /// The law by which they are divided.
    pub rate: FittedRate,
}

/// Divides the forces of drives by the law of the speed, for a fit of `form` by `method`.
///
/// # Errors
/// [`FitError`] if the form depends on speed, if the drives do not determine it, or, for an estimation, if their speeds
/// do not determine beta and v_m.
pub fn without_rate(
    form: &Form,
    drives: &[Drive],
    method: Method,
    choice: &RateChoice,
) -> Result<WithoutRate, FitError> {
    let of_speed = |variable: &Variable| variable.needs_impact() || *variable == Variable::Rate;
    if let Some(variable) = Variable::ALL.iter().find(|own| of_speed(own) && form.uses(**own)) {
        return Err(FitError::TermOfSpeed {
            term: variable.name().to_owned(),
        });
    }
    let speeds = drives.iter().flat_map(|drive| &drive.points).map(|point| point.speed);
    let speeds = speeds.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], v| {
        [low.min(v), high.max(v)]
    });
    // The conditions of an impact are checked as they are; those of the quasi-static drives are not.
    Regression::new(form, drives, method)?;
    let problem = Problem::new(form, drives, method, choice)?;
    let (mut speed, mut intervals) = (choice.speed, None);
    if choice.estimate {
        if speeds[1] < SPREAD * speeds[0].max(0.0) {
            return Err(FitError::OneSpeed { speeds });
        }
        let estimate = problem.estimate(speeds)?;
        speed = problem.terms(&estimate.at);
        intervals = Some(estimate.intervals());
    }
    Ok(WithoutRate {
        drives: problem.solve(&speed).0,
        rate: FittedRate {
            friction_share: choice.friction_share,
            speeds_m_s: speeds,
            crushing_interval: intervals.map(|[crushing, _]| crushing),
            width_interval_m_s: intervals.map(|[_, width]| width),
            speed,
        },
    })
}

/// Drives and terms.
struct Problem<'a> {
    measured: &'a [Drive],
    /// The drives at the reference speed, with the forces still to be divided.
    drives: Vec<Drive>,
    regression: Regression,
    choice: &'a RateChoice,
}

/// beta and ln v_m with their covariance.
struct Estimate {
    at: Vector2<f64>,
    covariance: Matrix2<f64>,
    degrees_of_freedom: f64,
}

impl Estimate {
    fn intervals(&self) -> [[f64; 2]; 2] {
        let t = student_t(0.95, self.degrees_of_freedom);
        let of = |place: usize| {
            let half = t * self.covariance[(place, place)].max(0.0).sqrt();
            [self.at[place] - half, self.at[place] + half]
        };
        [of(0), of(1).map(f64::exp)]
    }
}

impl<'a> Problem<'a> {
    fn new(form: &Form, measured: &'a [Drive], method: Method, choice: &'a RateChoice) -> Result<Self, FitError> {
        let quasi_static = |drive: &Drive| Drive {
            conditions: Conditions {
                driving: Driving::Constant { speed: REFERENCE_SPEED },
                ..drive.conditions
            },
            points: drive
                .points
                .iter()
                .map(|point| Point {
                    speed: REFERENCE_SPEED,
                    ..*point
                })
                .collect(),
            ..drive.clone()
        };
        let drives: Vec<Drive> = measured.iter().map(quasi_static).collect();
        Ok(Self {
            regression: Regression::new(form, &drives, method)?,
            measured,
            drives,
            choice,
        })
    }

    fn terms(&self, at: &Vector2<f64>) -> SpeedTerms {
        SpeedTerms {
            crushing: at[0],
            width: at[1].exp(),
            ..self.choice.speed
        }
    }

    /// The quasi-static drives for a law of the speed, and measured minus computed s at the speed of the tests.
    fn solve(&self, speed: &SpeedTerms) -> (Vec<Drive>, DVector<f64>) {
        let mut drives = self.drives.clone();
        let start = |drive: &Drive| drive.points.iter().map(|p| p.root * p.root).fold(0.0, f64::max);
        let mut full: Vec<f64> = self.measured.iter().map(start).collect();
        let mut coefficients = DVector::zeros(0);
        for _ in 0..REPETITIONS {
            for ((drive, measured), full) in drives.iter_mut().zip(self.measured).zip(&full) {
                let length = drive.conditions.specimen.length;
                for (point, own) in drive.points.iter_mut().zip(&measured.points) {
                    let friction = self.choice.friction_share * full * (own.depth / length).max(0.0);
                    point.root = divided(own.root * own.root, friction, speed.factors(own.speed)).sqrt();
                }
            }
            coefficients = self.regression.solve(&roots(&drives)).coefficients;
            let new: Vec<f64> = drives
                .iter()
                .map(|drive| self.square(&coefficients, drive, drive.conditions.specimen.length))
                .collect();
            let moved = |(a, b): (&f64, &f64)| (a - b).abs() > CLOSE * b.abs().max(f64::MIN_POSITIVE);
            let done = !full.iter().zip(&new).any(moved);
            full = new;
            if done {
                break;
            }
        }
        let residuals = self.measured.iter().zip(&full).flat_map(|(drive, full)| {
            let (coefficients, length) = (&coefficients, drive.conditions.specimen.length);
            drive.points.iter().map(move |point| {
                let force = self.square(coefficients, drive, point.depth);
                let friction = (self.choice.friction_share * full * (point.depth / length).max(0.0)).min(force);
                let [crushing, sliding] = speed.factors(point.speed);
                point.root - ((force - friction) * crushing + friction * sliding).max(0.0).sqrt()
            })
        });
        let residuals = DVector::from_vec(residuals.collect());
        (drives, residuals)
    }

    /// max(0, s)^2 of the quasi-static law at a depth \[m\].
    fn square(&self, coefficients: &DVector<f64>, drive: &Drive, depth: f64) -> f64 {
        let values = drive.conditions.values(depth, REFERENCE_SPEED);
        let terms = self.regression.form().terms().iter().zip(coefficients.iter());
        let root: f64 = terms.map(|(term, c)| c * term.value(&values)).sum();
        root.max(0.0).powi(2)
    }

    fn residuals(&self, at: &Vector2<f64>) -> DVector<f64> {
        self.solve(&self.terms(at)).1
    }

    /// Derivatives of the residuals with respect to beta and ln v_m.
    fn slopes(&self, at: &Vector2<f64>) -> DMatrix<f64> {
        const STEP: f64 = 1e-4;
        let of = |place: usize| {
            let mut step = Vector2::zeros();
            step[place] = STEP;
            (self.residuals(&(at + step)) - self.residuals(&(at - step))) / (2.0 * STEP)
        };
        DMatrix::from_columns(&[of(0), of(1)])
    }

    fn estimate(&self, speeds: [f64; 2]) -> Result<Estimate, FitError> {
        let bounded = |at: Vector2<f64>| {
            let [low, high] = WIDTH.map(f64::ln);
            Vector2::new(at[0].clamp(CRUSHING[0], CRUSHING[1]), at[1].clamp(low, high))
        };
        let mut at = Vector2::new(self.choice.speed.crushing, self.choice.speed.width.ln());
        let mut residuals = self.residuals(&at);
        for _ in 0..STEPS {
            let slopes = self.slopes(&at);
            let normal = gram(&slopes);
            let inverse = normal.try_inverse().ok_or(FitError::OneSpeed { speeds })?;
            let downhill = inverse * gradient(&slopes, &residuals);
            let (mut share, square) = (1.0, residuals.norm_squared());
            let (next, found) = loop {
                let next = bounded(at - downhill * share);
                let found = self.residuals(&next);
                if found.norm_squared() <= square || share < 1e-6 {
                    break (next, found);
                }
                share *= 0.5;
            };
            let moved = (next - at).amax();
            if found.norm_squared() <= square {
                (at, residuals) = (next, found);
            }
            if moved < STILL || share < 1e-6 {
                return self.judged(at, &residuals, speeds);
            }
        }
        Err(FitError::NoRate { steps: STEPS })
    }

    /// The estimate with its covariance, clustered by drive; the classical one for a single drive.
    fn judged(&self, at: Vector2<f64>, residuals: &DVector<f64>, speeds: [f64; 2]) -> Result<Estimate, FitError> {
        let slopes = self.slopes(&at);
        let inverse = gram(&slopes).try_inverse().ok_or(FitError::OneSpeed { speeds })?;
        let (drives, points) = (self.measured.len() as f64, residuals.len() as f64);
        let (covariance, degrees_of_freedom) = if self.measured.len() < 2 {
            let free = (points - self.regression.form().terms().len() as f64 - 2.0).max(1.0);
            (inverse * (residuals.norm_squared() / free), free)
        } else {
            let of_drive = |range: &std::ops::Range<usize>| {
                let own = slopes.rows(range.start, range.len());
                let sum = own.tr_mul(&residuals.rows(range.start, range.len()));
                Matrix2::from_fn(|i, j| sum[i] * sum[j])
            };
            let meat: Matrix2<f64> = self.regression.drives().iter().map(of_drive).sum();
            (inverse * meat * inverse * (drives / (drives - 1.0)), drives - 1.0)
        };
        let [low, high] = WIDTH.map(f64::ln);
        let inside = at[1] > low + STILL && at[1] < high - STILL;
        let estimate = Estimate {
            at,
            covariance,
            degrees_of_freedom,
        };
        let [_, [_, widest]] = estimate.intervals();
        if inside && widest <= UNKNOWN * at[1].exp() {
            Ok(estimate)
        } else {
            Err(FitError::OneSpeed { speeds })
        }
    }
}

/// s of all points, in the order of the drives.
fn roots(drives: &[Drive]) -> DVector<f64> {
    let all = drives.iter().flat_map(|drive| &drive.points).map(|point| point.root);
    DVector::from_vec(all.collect())
}

/// The square of the quasi-static s, from the square of s at a speed with these factors of deformation and friction.
fn divided(square: f64, friction: f64, [crushing, sliding]: [f64; 2]) -> f64 {
    let force = (square - friction * (sliding - crushing)) / crushing;
    if force > friction {
        force
    } else {
        (square / sliding).max(0.0)
    }
}

fn gram(slopes: &DMatrix<f64>) -> Matrix2<f64> {
    Matrix2::from_fn(|i, j| slopes.column(i).dot(&slopes.column(j)))
}

fn gradient(slopes: &DMatrix<f64>, residuals: &DVector<f64>) -> Vector2<f64> {
    Vector2::from_fn(|i, _| slopes.column(i).dot(residuals))
}
