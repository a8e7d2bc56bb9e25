#![doc = include_str!("../README.md")]

mod check;
pub mod dimension;
mod group;
mod kind;
mod measure;
mod spec;
mod text;
mod units;
mod value;

pub use check::Check;
pub use dimension::Dimension;
#[doc(hidden)]
pub use group::visit_key;
pub use group::{Found, Group, members, read_key};
pub use kind::{Kind, Sign, any, component, fraction, gas_pressure, modulus, nonnegative, positive};
pub use measure::measure;
pub use spec::{GroupSpec, KeySpec, MEMBER, dotted};
pub use text::{Measured, QuantityError, quantity, range, rounded};
pub use units::UnitError;
pub use value::{Assign, Held, Name, Value};
