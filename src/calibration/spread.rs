//! Standard deviations that depend on the value.

/// An error of the model, or the scatter of repeats: a fraction of the measured value plus an amount in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    pub(super) share: f64,
    pub(super) amount: f64,
}

impl Spread {
    /// The standard deviation at a value.
    pub(super) fn at(self, value: f64) -> f64 {
        self.share * value.abs() + self.amount
    }
}
