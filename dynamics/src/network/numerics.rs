//! Method, tolerance and sampling of a simulation.

use super::error::RunError;
use crate::Method;
use serde::Serialize;

/// Settings for integrating and sampling an assembly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Numerics {
    /// Integration method.
    pub method: Method,
    /// Integration tolerance as a fraction of the characteristic size of each state \[-\].
    pub relative_tolerance: f64,
    /// Sampling interval \[s\]; none to compute only events and ledger.
    pub sample_interval: Option<f64>,
    /// Names of the channels to record, as `piston.travel`; none for all.
    pub channels: Option<&'static [&'static str]>,
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            method: Method::Switching,
            relative_tolerance: 1e-7,
            sample_interval: Some(4e-6),
            channels: None,
        }
    }
}

impl Numerics {
    /// Checks the settings for a simulation that ends at `end` \[s\].
    ///
    /// # Errors
    /// [`RunError::Value`], a value outside its range.
    pub(super) fn check(&self, end: f64) -> Result<(), RunError> {
        let interval = self.sample_interval.unwrap_or(1.0);
        let rules = [
            (
                "relative_tolerance",
                self.relative_tolerance,
                self.relative_tolerance > 0.0 && self.relative_tolerance <= 1e-2,
                "above 0 and at most 0.01",
            ),
            ("sample_interval", interval, interval >= 1e-8, "at least 10 ns"),
            ("end", end, end > 0.0 && end <= 10.0, "above 0 s and at most 10 s"),
        ];
        match rules.into_iter().find(|(.., ok, _)| !ok) {
            Some((name, value, _, rule)) => Err(RunError::Value { name, value, rule }),
            None => Ok(()),
        }
    }
}
