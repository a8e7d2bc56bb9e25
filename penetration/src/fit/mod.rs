//! Penetration laws from measured drives: regression, quality, uncertainty.
//!
//! The forms and quality measures are those of Nili Ahmadabadi (2016), ch. 2 (quasi-static) and ch. 3 (groups at high
//! speed, without published coefficients).

mod basis;
mod clean;
mod distributions;
mod drive;
mod drive_law;
mod error;
mod file;
mod fitting;
mod form;
mod law;
mod law_error;
mod least_squares;
mod rate_fit;
mod regression;
mod split;

pub use clean::{CleanError, Cleaned, Cleaning, Flag, Masses, Start, Trace};
pub use distributions::{probability_beyond, standard_normal, student_t};
pub use drive::{Conditions, Drive, Driving, Point};
pub use drive_law::{LawOfDrive, Resisting};
pub use error::FitError;
pub use file::{Counts, FitFile, Quality, Ranges, TermFit};
pub use fitting::{DROP_BELOW, Fitted, Leave, Reduction, Validation, fit, reduce, roots, validate};
pub use form::{Form, FormError, HIGHEST_DEGREE, Term, VARIABLES, Values, Variable};
pub use law::{FittedLaw, Placement, Scatter};
pub use law_error::{FIT_SCHEMA, LawError};
pub use rate_fit::{FittedRate, RateChoice, WithoutRate, without_rate};
pub use regression::{Method, Regression, Solution};
pub use split::{Split, split};
