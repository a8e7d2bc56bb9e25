//! Levels of repeated shots: mean, standard uncertainty, confidence interval.

use std::f64::consts::LN_10;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Confidence of the intervals.
pub const CONFIDENCE: f64 = 0.95;

/// Standard deviation of reproducibility of the method \[dB\]: engineering grade (ISO 3744:2010, 9.3).
pub const METHOD_DB: f64 = 1.5;

/// Coverage factor of the combined uncertainty (ISO 3744:2010, 9.1).
pub const COVERAGE: f64 = 2.0;

/// A level from repeated shots \[dB\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct RepeatedLevel {
    /// Mean of the levels \[dB\].
    pub db: f64,
    /// Number of shots with a level.
    pub repeats: usize,
    /// Standard uncertainty of the mean from the scatter of the repeats (type A) \[dB\]; none for one shot.
    pub standard_db: Option<f64>,
    /// Half width of the 95 % confidence interval of the mean, by Student's t distribution \[dB\]; none for one shot.
    pub half_width_db: Option<f64>,
    /// Expanded combined uncertainty (k = 2) from scatter and method \[dB\].
    pub expanded_db: f64,
}

impl RepeatedLevel {
    /// The mean of levels; `None` without any.
    pub fn of(levels: &[f64]) -> Option<Self> {
        let count = levels.len();
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = levels.iter().sum::<f64>() / n;
        let standard = (count > 1).then(|| {
            let squares: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
            (squares / (n - 1.0) / n).sqrt()
        });
        Some(Self::new(mean, count, standard))
    }

    /// A level with its standard uncertainty from `repeats` shots.
    fn new(db: f64, repeats: usize, standard_db: Option<f64>) -> Self {
        Self {
            db,
            repeats,
            standard_db,
            half_width_db: standard_db.map(|u| student(repeats) * u),
            expanded_db: COVERAGE * METHOD_DB.hypot(standard_db.unwrap_or(0.0)),
        }
    }

    /// The level of `first` minus the energies of `others`, whose errors are independent; `None` if nothing is left.
    ///
    /// ```text
    /// U = E_1 - sum_i E_i,    u(U)^2 = sum_i u(E_i)^2,    u(E) = E (ln 10/10) u(L)
    /// ```
    pub fn less(first: &Self, others: &[Self]) -> Option<Self> {
        let energy = |level: &Self| (0.1 * LN_10 * level.db).exp();
        let left = energy(first) - others.iter().map(energy).sum::<f64>();
        if left <= 0.0 {
            return None;
        }
        let all = || [first].into_iter().chain(others);
        let error = |level: &Self| level.standard_db.map(|u| (energy(level) * u).powi(2));
        let squares: Option<f64> = all().map(error).sum();
        let repeats = all().map(|level| level.repeats).min().unwrap_or(1);
        Some(Self::new(
            10.0 * left.log10(),
            repeats,
            squares.map(|sum| sum.sqrt() / left),
        ))
    }
}

/// Factor of Student's t distribution for the confidence interval of a mean of this many values.
fn student(count: usize) -> f64 {
    StudentsT::new(0.0, 1.0, (count.max(2) - 1) as f64).map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * CONFIDENCE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(db: f64, standard: f64) -> RepeatedLevel {
        RepeatedLevel::new(db, 5, Some(standard))
    }

    #[test]
    fn the_mean_of_five_has_students_interval() {
        let found = RepeatedLevel::of(&[100.2, 100.6, 100.1, 100.9, 100.4]).unwrap_or_else(|| panic!("a level"));
        assert!((found.db - 100.44).abs() < 1e-12);
        assert!((found.standard_db.unwrap_or(0.0) - 0.1435).abs() < 5e-5);
        assert!((found.half_width_db.unwrap_or(0.0) - 0.398).abs() < 5e-4);
    }

    #[test]
    fn one_shot_has_no_scatter_but_the_uncertainty_of_the_method() {
        let found = RepeatedLevel::of(&[90.0]).unwrap_or_else(|| panic!("a level"));
        assert_eq!((found.standard_db, found.expanded_db), (None, 3.0));
        assert_eq!(RepeatedLevel::of(&[]), None);
    }

    #[test]
    fn a_difference_of_energies_has_the_errors_of_all() {
        let found = RepeatedLevel::less(&level(105.5, 0.2), &[level(100.5, 0.3), level(95.0, 0.4)]);
        let found = found.unwrap_or_else(|| panic!("a level"));
        assert!((found.db - 103.243).abs() < 5e-4, "{}", found.db);
        assert!((found.standard_db.unwrap_or(0.0) - 0.377).abs() < 5e-4);
    }

    #[test]
    fn nothing_is_left_of_less_than_is_taken() {
        assert_eq!(RepeatedLevel::less(&level(90.0, 0.1), &[level(91.0, 0.1)]), None);
    }
}
