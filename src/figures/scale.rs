//! Axes: from values to the grid of a drawing, and the round values at which ticks stand.

/// A linear map from values to grid units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// Values at the ends.
    pub(super) values: [f64; 2],
    /// Their grid units; descending where values rise upwards.
    pub(super) units: [i32; 2],
}

impl Scale {
    /// The grid unit of a value.
    pub(super) fn at(&self, value: f64) -> i32 {
        let [low, high] = self.values;
        let [from, to] = self.units.map(f64::from);
        (from + (value - low) / (high - low) * (to - from)).round() as i32
    }

    /// Whether a value lies on the axis.
    pub(super) fn holds(&self, value: f64) -> bool {
        (self.values[0]..=self.values[1]).contains(&value)
    }
}

/// About `count` round values within `low..high`, with the decimals they need.
pub(super) fn ticks([low, high]: [f64; 2], count: usize) -> (Vec<f64>, usize) {
    let rough = (high - low) / count.max(1) as f64;
    let power = rough.log10().floor();
    let decade = 10f64.powf(power);
    let factor = [1.0, 2.0, 2.5, 5.0]
        .into_iter()
        .find(|f| f * decade >= rough * (1.0 - 1e-9))
        .unwrap_or(10.0);
    let step = factor * decade;
    let decimals = (-power).max(0.0) as usize + usize::from(factor == 2.5 && power <= 0.0);
    let decimals = if factor == 10.0 {
        decimals.saturating_sub(1)
    } else {
        decimals
    };
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    ((first..=last).map(|i| i as f64 * step).collect(), decimals)
}

/// A range that holds all values, with a margin of 5 % where it does not end at zero.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|value| value.is_finite());
    let [low, high] = finite.fold([0.0f64; 2], |[low, high], value| [low.min(value), high.max(value)]);
    let margin = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    let ends = |end: f64, margin: f64| if end == 0.0 { 0.0 } else { end + margin };
    if low == high {
        [0.0, 1.0]
    } else {
        [ends(low, -margin), ends(high, margin)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let shown = |range, count| {
            let (values, decimals) = ticks(range, count);
            values
                .iter()
                .map(|v| format!("{v:.decimals$}"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(shown([0.0, 86.0], 9), "0 10 20 30 40 50 60 70 80");
        assert_eq!(shown([-0.3, 1.05], 5), "0.0 0.5 1.0");
        assert_eq!(shown([0.0, 5.0], 4), "0 2 4");
        assert_eq!(shown([0.0, 0.1], 4), "0.000 0.025 0.050 0.075 0.100");
        assert_eq!(shown([0.0, 9.0], 4), "0.0 2.5 5.0 7.5");
        assert_eq!(shown([-12.0, 31.0], 5), "-10 0 10 20 30");
    }

    #[test]
    fn a_scale_may_rise_upwards() {
        let scale = Scale {
            values: [0.0, 10.0],
            units: [100, 0],
        };
        assert_eq!([0.0, 2.5, 10.0].map(|v| scale.at(v)), [100, 75, 0]);
        assert!(scale.holds(10.0) && !scale.holds(10.1));
    }

    #[test]
    fn a_range_holds_zero_and_every_finite_value() {
        assert_eq!(range([1.0, f64::NAN, 2.0].into_iter()), [0.0, 2.1]);
        assert_eq!(range([-1.0, 1.0].into_iter()), [-1.1, 1.1]);
        assert_eq!(range(std::iter::empty()), [0.0, 1.0]);
    }
}
