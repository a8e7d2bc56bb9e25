//! Standard deviations that depend on the value.

/// An error of the model, or the scatter of repeats: a fraction of the measured value plus an amount in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    pub(super) share: f64,
    pub(super) amount: f64,
}

impl Spread {
    /// A fraction and an amount.
    pub(super) const fn new(share: f64, amount: f64) -> Self {
        Self { share, amount }
    }

    /// The standard deviation at a value.
    pub(super) fn at(self, value: f64) -> f64 {
        self.share * value.abs() + self.amount
    }
}

/// Model error of depths and travels: an estimate.
pub(super) const LENGTH_ERROR: Spread = Spread::new(0.05, 1e-3);

/// Model error of speeds: an estimate.
pub(super) const SPEED_ERROR: Spread = Spread::new(0.05, 0.0);

/// Model error of the air of a shot, and of all pressures other than that above the piston: an estimate.
pub(super) const GAS_ERROR: Spread = Spread::new(0.04, 0.0);

/// Model error of pressures above the piston, 7.5 % rms in published comparisons of the model.
pub(super) const PRESSURE_ABOVE_ERROR: Spread = Spread::new(0.08, 0.0);

/// Scatter of repeated depths.
pub(super) const DEPTH_SCATTER: Spread = Spread::new(0.0, 1.5e-3);

/// Scatter of repeated pressures and of the air of a shot.
pub(super) const GAS_SCATTER: Spread = Spread::new(0.01, 0.0);

/// Scatter of other repeated readings.
pub(super) const OTHER_SCATTER: Spread = Spread::new(0.03, 0.0);
