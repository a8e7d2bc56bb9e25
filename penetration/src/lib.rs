//! Penetration resistance force of a nail in wood.
//!
//! ```text
//! F_r = H_M NL max(0, C0 + C1 x + ... + C7 x^7 + C8 Pi3 + C9 Pi4)^2
//! x = y/NL,  Pi3 = NL rho v^2/H_M,  Pi4 = D/NL
//! ```
//! Nili Ahmadabadi (2016), Eq. 2.2, Tables 2-6 and 2-8 (plywood), Eq. 4.59 (solid wood). The laws are quasi-static:
//! they are valid for penetration speeds of 20 to 500 mm/min, and a dynamic run uses the upper limit,
//! [`REFERENCE_SPEED`].

#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod dual;
mod envelope;
mod error;
mod extension;
pub mod fit;
mod law;
mod penetration_curve;
mod rate;
mod resistance;
mod resistance_law;
mod rings;
mod shanks;
mod speed_terms;
mod table;
mod tables;
mod wood;

pub use dual::{Dual, Real};
pub use envelope::Envelope;
pub use error::RangeError;
pub use extension::LENGTH_FACTOR;
pub use law::{Curve, PenetrationLaw, Specimen};
pub use penetration_curve::{CurveError, CurveLaw, PenetrationCurve};
pub use rate::HeadContact;
pub use resistance::{Driven, Resistance};
pub use resistance_law::ResistanceLaw;
pub use shanks::Shanks;
pub use speed_terms::SpeedTerms;
pub use table::{ForceTable, TableError};
pub use tables::{FitQuality, NAILS, NailSize, Shank, WOODS, WoodKind};
pub use wood::{HeadLaw, NailedWood, RateLaw, Wood};

/// Lowest penetration speed of the tests behind the laws, 20 mm/min \[m/s\].
pub const LOWEST_SPEED: f64 = 20e-3 / 60.0;

/// Highest penetration speed at which the laws are used, 8.4 mm/s (500 mm/min, rounded up) \[m/s\].
pub const HIGHEST_SPEED: f64 = 8.4e-3;

/// Penetration speed at which a dynamic run evaluates the quasi-static laws, 500 mm/min \[m/s\].
pub const REFERENCE_SPEED: f64 = 500e-3 / 60.0;
