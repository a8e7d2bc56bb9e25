//! Run-time checks: a number and its limit.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number that must stay within its limit, checked at run time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Check {
    /// The checked quantity, with unit.
    pub name: Cow<'static, str>,
    /// Value found; null if it is not a number.
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Largest magnitude allowed.
    pub limit: f64,
    /// Whether `value` is within `limit`; never true for NaN.
    pub ok: bool,
}

impl Check {
    /// A check that passes if `|value| <= limit`.
    pub fn at_most(name: impl Into<Cow<'static, str>>, value: f64, limit: f64) -> Self {
        Self {
            name: name.into(),
            value,
            limit,
            ok: value.abs() <= limit,
        }
    }

    /// The same check, with its name prefixed by the part it belongs to.
    #[must_use]
    pub fn of(self, part: &str) -> Self {
        Self {
            name: format!("{part}: {}", self.name).into(),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_within_its_limit_on_either_side() {
        for (value, ok) in [(1.0, true), (-1.0, true), (1.1, false), (-1.1, false)] {
            assert_eq!(Check::at_most("", value, 1.0).ok, ok, "{value}");
        }
    }

    #[test]
    fn no_limit_holds_a_value_that_is_not_a_number() {
        assert!(!Check::at_most("", f64::NAN, f64::INFINITY).ok);
    }
}
