//! What a key holds, and the limits of its value.

use crate::dimension::{Dimension, NUMBER, PRESSURE};

/// The limits that hold for a key in every design, apart from the range that a design gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Any finite number.
    Any,
    /// Zero or above.
    NonNegative,
    /// Above zero.
    Positive,
    /// From 0 to 1.
    Fraction,
    /// From -1 to 1.
    Component,
}

impl Sign {
    /// Whether `value` keeps the limit.
    pub fn allows(self, value: f64) -> bool {
        match self {
            Self::Any => value.is_finite(),
            Self::NonNegative => value.is_finite() && value >= 0.0,
            Self::Positive => value.is_finite() && value > 0.0,
            Self::Fraction => (0.0..=1.0).contains(&value),
            Self::Component => (-1.0..=1.0).contains(&value),
        }
    }

    /// The limit in words: "must be ...".
    pub fn describe(self) -> &'static str {
        match self {
            Self::Any => "any finite number",
            Self::NonNegative => "zero or above",
            Self::Positive => "above zero",
            Self::Fraction => "from 0 to 1",
            Self::Component => "from -1 to 1",
        }
    }
}

/// What a key holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A physical quantity, stored in SI units.
    Quantity {
        /// Its dimension; the unit in the file must have it.
        dimension: Dimension,
        /// Limits that hold in every design.
        sign: Sign,
        /// Whether a gauge pressure may be given, to which the ambient pressure is added.
        gauge: bool,
    },
    /// A whole number above zero.
    Count,
    /// `true` or `false`.
    Switch,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// The name of a file, relative to the design file that gives it, or "" for none.
    File,
}

/// A quantity of any sign.
pub const fn any(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::Any,
        gauge: false,
    }
}

/// A quantity of zero or above.
pub const fn nonnegative(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::NonNegative,
        gauge: false,
    }
}

/// A quantity above zero.
pub const fn positive(dimension: Dimension) -> Kind {
    Kind::Quantity {
        dimension,
        sign: Sign::Positive,
        gauge: false,
    }
}

/// An absolute pressure above zero that may also be given as gauge pressure.
pub const fn gas_pressure() -> Kind {
    Kind::Quantity {
        dimension: PRESSURE,
        sign: Sign::Positive,
        gauge: true,
    }
}

/// A plain number from 0 to 1.
pub const fn fraction() -> Kind {
    Kind::Quantity {
        dimension: NUMBER,
        sign: Sign::Fraction,
        gauge: false,
    }
}

/// A component of a direction, from -1 to 1.
pub const fn component() -> Kind {
    Kind::Quantity {
        dimension: NUMBER,
        sign: Sign::Component,
        gauge: false,
    }
}
