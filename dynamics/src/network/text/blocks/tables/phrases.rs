//! Names and choices that tables of several kinds contain.

use crate::network::text::fields::PUSHES;
use crate::network::text::table::words;

pub(super) const BODY_NAME: &str = "body";
pub(super) const BASE: &str = "body, or ground";
/// Directions of the push of a face or a spring.
pub(super) const PUSH: [&str; 2] = words(&PUSHES);
/// Directions of the motion of a body that opens a passage.
pub(super) const OPENS: [&str; 2] = words(&PUSHES);
