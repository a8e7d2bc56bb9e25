//! Settings for integrating and recording a cycle.

use serde::{Deserialize, Serialize};

use crate::CycleError;

/// Integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// An explicit Runge-Kutta pair of order 5 (Tsitouras 2011) where accuracy limits its step, [`Method::Bdf`] where
    /// stability does.
    #[default]
    Switching,
    /// Variable-order backward differentiation formulas (orders 1 to 5).
    Bdf,
    /// Explicit-first-stage singly diagonally implicit Runge-Kutta, order 3 with dense output of the same order.
    Esdirk34,
}

/// Settings for integrating and recording a cycle. The physics is in [`Parameters`](crate::Parameters).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Integration method.
    pub method: Method,
    /// Integration tolerance as a fraction of the characteristic size of each state \[-\].
    pub relative_tolerance: f64,
    /// Interval of the recorded samples \[s\].
    pub sample_interval: f64,
    /// Longest duration of a cycle, from the trigger pull \[s\].
    pub end: f64,
    /// Duration of recording after t18 \[s\].
    pub tail: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Switching,
            relative_tolerance: 1e-7,
            sample_interval: 4e-6,
            end: 0.1,
            tail: 5e-3,
        }
    }
}

impl Settings {
    /// Rejects settings with which no cycle can be computed.
    pub(crate) fn check(&self) -> Result<(), CycleError> {
        let rules = [
            (
                "settings.relative_tolerance",
                self.relative_tolerance,
                self.relative_tolerance > 0.0,
                "above 0",
            ),
            (
                "settings.relative_tolerance",
                self.relative_tolerance,
                self.relative_tolerance <= 1e-2,
                "at most 0.01",
            ),
            (
                "settings.sample_interval",
                self.sample_interval,
                self.sample_interval >= 1e-8,
                "at least 10 ns",
            ),
            (
                "settings.end",
                self.end,
                self.end > 0.0 && self.end <= 10.0,
                "above 0 s and at most 10 s",
            ),
            (
                "settings.tail",
                self.tail,
                self.tail >= 0.0 && self.tail.is_finite(),
                "a time that is not negative",
            ),
        ];
        match rules.into_iter().find(|(.., ok, _)| !ok) {
            Some((name, value, _, rule)) => Err(CycleError::Value {
                name: name.to_owned(),
                value,
                rule: rule.into(),
            }),
            None => Ok(()),
        }
    }
}
