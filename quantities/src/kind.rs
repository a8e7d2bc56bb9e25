//! The kind of a key's value, and its domain.

use crate::dimension::{Dimension, NUMBER, PRESSURE};

/// Sign constraint on the values of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Any finite number.
    Any,
    /// Zero or above.
    NonNegative,
    /// Greater than zero.
    Positive,
    /// From 0 to 1.
    Fraction,
    /// From -1 to 1.
    Component,
}

/// The kind of a key's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A physical quantity, stored in SI units.
    Quantity {
        /// Its dimension; the unit in the file must have it.
        dimension: Dimension,
        /// Constraint on its sign.
        sign: Sign,
        /// Its domain in SI units, if narrower than that implied by sign and dimension.
        within: Option<[f64; 2]>,
        /// Whether a gauge pressure is accepted; the ambient pressure is then added.
        gauge: bool,
    },
    /// An integer from 1 to this.
    Count(u32),
    /// `true` or `false`.
    Switch,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// The name of a file, relative to the design file that gives it, or "" for none.
    File,
    /// A name that is not listed here, such as that of a block of an assembly.
    Name,
}

impl Kind {
    const fn quantity(dimension: Dimension, sign: Sign) -> Self {
        Self::Quantity {
            dimension,
            sign,
            within: None,
            gauge: false,
        }
    }

    /// The same quantity with the domain `low` to `high` in SI units.
    ///
    /// # Panics
    /// At compile time, if this is not a quantity.
    #[must_use]
    pub const fn within(self, low: f64, high: f64) -> Self {
        let Self::Quantity {
            dimension, sign, gauge, ..
        } = self
        else {
            panic!("only quantities have a domain")
        };
        Self::Quantity {
            dimension,
            sign,
            within: Some([low, high]),
            gauge,
        }
    }

    /// The same quantity, which may also be given relative to the ambient pressure if it is a pressure.
    #[must_use]
    pub fn or_gauge(self) -> Self {
        match self {
            Self::Quantity {
                dimension: PRESSURE,
                sign,
                within,
                ..
            } => Self::Quantity {
                dimension: PRESSURE,
                sign,
                within,
                gauge: true,
            },
            kind => kind,
        }
    }

    /// Smallest and largest value that the program can handle for this kind, in SI units. This hard domain applies to
    /// every design, unlike the plausible range given in a design. None unless the value is a quantity or a count.
    pub fn domain(self) -> Option<[f64; 2]> {
        match self {
            Self::Quantity {
                within: Some(domain), ..
            } => Some(domain),
            Self::Quantity { dimension, sign, .. } => {
                let [least, most] = dimension.magnitudes();
                Some(match sign {
                    Sign::Any => [-most, most],
                    Sign::NonNegative => [0.0, most],
                    Sign::Positive => [least, most],
                    Sign::Fraction => [0.0, 1.0],
                    Sign::Component => [-1.0, 1.0],
                })
            }
            Self::Count(most) => Some([1.0, f64::from(most)]),
            Self::Switch | Self::Choice(_) | Self::File | Self::Name => None,
        }
    }

    /// Whether the domain contains `value`, in SI units; false unless `value` is finite.
    pub fn allows(self, value: f64) -> bool {
        // The tolerance allows for rounding in unit conversion.
        self.domain().is_some_and(|[low, high]| {
            let slack = 1e-12 * low.abs().max(high.abs()).min(value.abs());
            value >= low - slack && value <= high + slack
        })
    }

    /// The domain in words, such as "from 0.001 to 100 m"; empty if there is none.
    pub fn allowed(self) -> String {
        let unit = match self {
            Self::Quantity { dimension, .. } => dimension.unit(),
            _ => String::new(),
        };
        self.domain().map_or_else(String::new, |[low, high]| {
            format!("from {} to {} {unit}", short(low), short(high))
                .trim_end()
                .to_owned()
        })
    }
}

/// Formats a bound of a domain.
fn short(bound: f64) -> String {
    if bound == 0.0 || (1e-3..1e6).contains(&bound.abs()) {
        format!("{bound}")
    } else {
        format!("{bound:e}")
    }
}

/// A quantity of any sign.
pub const fn any(dimension: Dimension) -> Kind {
    Kind::quantity(dimension, Sign::Any)
}

/// A nonnegative quantity.
pub const fn nonnegative(dimension: Dimension) -> Kind {
    Kind::quantity(dimension, Sign::NonNegative)
}

/// A quantity greater than zero.
pub const fn positive(dimension: Dimension) -> Kind {
    Kind::quantity(dimension, Sign::Positive)
}

/// A positive absolute pressure that may also be given as gauge pressure. The maximum of 10 MPa exceeds that of any
/// compressor.
pub const fn gas_pressure() -> Kind {
    Kind::Quantity {
        dimension: PRESSURE,
        sign: Sign::Positive,
        within: Some([1e3, 1e7]),
        gauge: true,
    }
}

/// A modulus of elasticity, from that of a soft foam to above that of diamond.
pub const fn modulus() -> Kind {
    positive(PRESSURE).within(1e4, 2e12)
}

/// A plain number from 0 to 1.
pub const fn fraction() -> Kind {
    Kind::quantity(NUMBER, Sign::Fraction)
}

/// A component of a direction, from -1 to 1.
pub const fn component() -> Kind {
    Kind::quantity(NUMBER, Sign::Component)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimension::LENGTH;

    #[test]
    fn a_domain_follows_from_sign_and_dimension_or_is_given() {
        let [least, most] = LENGTH.magnitudes();
        assert_eq!(positive(LENGTH).domain(), Some([least, most]));
        assert_eq!(nonnegative(LENGTH).domain(), Some([0.0, most]));
        assert_eq!(any(LENGTH).domain(), Some([-most, most]));
        assert_eq!(positive(LENGTH).within(0.1, 2.0).domain(), Some([0.1, 2.0]));
        assert_eq!(Kind::Switch.domain(), None);
    }

    #[test]
    fn a_domain_holds_its_ends_and_no_number_that_is_not_finite() {
        let kind = positive(LENGTH).within(0.1, 2.0);
        for (value, allowed) in [(0.1, true), (2.0 + 1e-15, true), (0.09, false), (2.1, false)] {
            assert_eq!(kind.allows(value), allowed, "{value}");
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!any(LENGTH).allows(value), "{value}");
        }
    }

    #[test]
    fn a_domain_is_described_with_its_unit() {
        assert_eq!(positive(LENGTH).within(1e-6, 100.0).allowed(), "from 1e-6 to 100 m");
        assert_eq!(Kind::Count(20).allowed(), "from 1 to 20");
    }
}
