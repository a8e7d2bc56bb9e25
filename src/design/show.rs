//! Numbers in readable form.

use std::fmt::{self, Display};

use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::LENGTH;

use crate::wording::rounded;

/// A number with six significant digits, without trailing zeros.
pub(crate) struct Short(pub(crate) f64);

impl Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&rounded(self.0, 6, 1e6))
    }
}

/// The value with a readable unit of its dimension: 0.06 m is "60 mm".
pub(crate) fn show(value: f64, dimension: Dimension) -> String {
    let (scale, unit) = dimension.readable();
    format!("{} {unit}", Short(value * scale)).trim_end().to_owned()
}

/// A length with its unit.
pub(crate) fn mm(length: f64) -> String {
    show(length, LENGTH)
}
