//! Penetration laws from measured drives: regression, quality, uncertainty.
//!
//! Source of the forms and of the quality measures: Nili Ahmadabadi (2016), ch. 2 (quasi-static) and ch. 3 (the groups
//! at high speed, of which no coefficients are published).

mod basis;
mod clean;
mod drive;
mod error;
mod fitting;
mod form;
mod law;
mod least_squares;
mod regression;
mod split;

pub use clean::{CleanError, Cleaned, Cleaning, Masses, Start, Trace};
pub use drive::{Conditions, Drive, Driving, Point};
pub use error::FitError;
pub use fitting::{DROP_BELOW, Fitted, Leave, Reduction, Validation, fit, reduce, roots, validate};
pub use form::{Form, FormError, HIGHEST_DEGREE, Term, VARIABLES, Values, Variable};
pub use law::{
    Counts, FIT_SCHEMA, FitFile, FittedLaw, LawError, LawOfDrive, Placement, Quality, Ranges, Resisting, Scatter,
    TermFit, probability_beyond, standard_normal, student_t,
};
pub use regression::{Method, Regression, Solution};
pub use split::{Split, split};
