//! The keys of a design that have a range, and how a number between 0 and 1 becomes a value.

use serde::Serialize;

use super::normal;
use crate::chain::engine;
use crate::design::{Design, Distribution, Entry, Provenance, Value};
use crate::error::Error;
use crate::stages::cycle::Engine;

/// Number of standard deviations at which a normal distribution is truncated.
pub(crate) const CUT: f64 = 3.0;

/// A key with a range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Full name, such as `piston.mass`.
    pub key: String,
    /// Symbol; empty if there is none.
    pub symbol: &'static str,
    /// SI unit; empty for plain numbers and counts.
    pub unit: String,
    /// Value in the design: a quantity in SI units, or a count.
    pub value: Value,
    /// Ends of the range.
    pub range: [f64; 2],
    /// Distribution over the range.
    #[serde(skip)]
    pub distribution: Distribution,
    /// Numbers of standard deviations at which a normal distribution is truncated below and above its centre.
    #[serde(skip)]
    pub(crate) cut: [f64; 2],
    /// Name under which a draw sets it, if that is not the key: for a derived quantity.
    #[serde(skip)]
    pub(crate) change: Option<&'static str>,
}

impl Parameter {
    /// The parameter of an entry, if its range is more than a point.
    pub(crate) fn of(entry: Entry) -> Option<Self> {
        let range = entry.range.filter(|range| range[0] < range[1])?;
        matches!(entry.value, Value::Number(_) | Value::Count(_)).then_some(Self {
            key: entry.key,
            symbol: entry.symbol,
            unit: entry.unit,
            value: entry.value,
            range,
            distribution: entry.distribution,
            cut: [-CUT, CUT],
            change: None,
        })
    }

    /// The parameters of a design whose range is more than a point: keys, and derived quantities that are drawn. They
    /// include properties of the numerical method.
    pub(crate) fn all(design: &Design) -> Vec<(Self, Provenance)> {
        let own = design.entries().into_iter().filter_map(|entry| {
            let provenance = entry.provenance;
            Some((Self::of(entry)?, provenance))
        });
        let derived = design.drawn_derived().filter_map(|(entry, solution)| {
            let provenance = entry.provenance;
            let change = Some(solution.change);
            Some((
                Self {
                    change,
                    ..Self::of(entry)?
                },
                provenance,
            ))
        });
        own.chain(derived).collect()
    }

    /// The name for [`set`](crate::design::Values::set).
    pub fn change(&self) -> &str {
        self.change.unwrap_or(&self.key)
    }

    /// Smallest and largest value of the distribution.
    pub(super) fn support(&self) -> [f64; 2] {
        let [low, high] = self.range;
        match self.distribution {
            Distribution::Normal => {
                let (middle, deviation) = (0.5 * (low + high), 0.25 * (high - low));
                self.cut.map(|cut| middle + cut * deviation)
            }
            Distribution::Uniform if self.is_count() => [low.ceil(), high.floor()],
            _ => self.range,
        }
    }

    fn is_count(&self) -> bool {
        matches!(self.value, Value::Count(_))
    }

    /// Probability density at a value; for a uniform count, the probability.
    pub(super) fn density(&self, x: f64) -> f64 {
        let [low, high] = self.support();
        if x < low || x > high {
            return 0.0;
        }
        match self.distribution {
            Distribution::Uniform if self.is_count() => 1.0 / (high - low + 1.0),
            Distribution::Uniform => 1.0 / (high - low),
            Distribution::Triangular => {
                let mode = self.number();
                let height = 2.0 / (high - low);
                match x < mode {
                    true => height * (x - low) / (mode - low),
                    false if high > mode => height * (high - x) / (high - mode),
                    false => height,
                }
            }
            Distribution::Normal => {
                let [below, above] = self.cut;
                let deviation = (high - low) / (above - below);
                let z = (x - low) / deviation + below;
                let within = 1.0 - normal::cumulative(below) - normal::cumulative(-above);
                (-0.5 * z * z).exp() / (deviation * (2.0 * std::f64::consts::PI).sqrt() * within)
            }
            Distribution::LogUniform => 1.0 / (x * (high / low).ln()),
        }
    }

    /// The parameter after a measurement of its value with a standard deviation: normal, truncated to the range.
    pub(crate) fn measured(self, value: f64, deviation: f64) -> Self {
        let cut = self.range.map(|end| ((end - value) / deviation).clamp(-CUT, CUT));
        Self {
            range: [value - 2.0 * deviation, value + 2.0 * deviation],
            distribution: Distribution::Normal,
            cut,
            ..self
        }
    }

    /// Half the range.
    pub fn half_range(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }

    /// The value in the design as a number.
    pub fn number(&self) -> f64 {
        match self.value {
            Value::Number(value) => value,
            Value::Count(count) => f64::from(count),
            Value::Switch(_) | Value::Choice(_) | Value::File(_) | Value::Name(_) => f64::NAN,
        }
    }

    /// The value `x` in the form for this key; a count is rounded and at least 1.
    pub(crate) fn hold(&self, x: f64) -> Value {
        match self.value {
            Value::Count(_) => Value::Count(x.round().clamp(1.0, f64::from(u32::MAX)) as u32),
            _ => Value::Number(x),
        }
    }

    /// The share of the distribution below a value, the inverse of [`at`](Self::at); 0 or 1 outside.
    pub(crate) fn share_below(&self, x: f64) -> f64 {
        let [low, high] = self.range;
        let share = match self.distribution {
            Distribution::Uniform if self.is_count() => (x - low.ceil() + 0.5) / (high.floor() - low.ceil() + 1.0),
            Distribution::Uniform => (x - low) / (high - low),
            Distribution::Triangular => {
                let mode = self.number();
                match x < mode {
                    true => (x - low).max(0.0).powi(2) / ((high - low) * (mode - low)),
                    false => 1.0 - (high - x).max(0.0).powi(2) / ((high - low) * (high - mode)),
                }
            }
            Distribution::Normal => {
                let [below, above] = [normal::cumulative(self.cut[0]), normal::cumulative(-self.cut[1])];
                let z = (x - 0.5 * (low + high)) / (0.25 * (high - low));
                (normal::cumulative(z) - below) / (1.0 - below - above)
            }
            Distribution::LogUniform => (x / low).ln() / (high / low).ln(),
        };
        // A triangle with its mode at an end has no share beyond it.
        if share.is_nan() { 1.0 } else { share.clamp(0.0, 1.0) }
    }

    /// The quantile `u` of the distribution, 0 < u < 1.
    pub fn at(&self, u: f64) -> Value {
        let [low, high] = self.range;
        let mode = self.number();
        let x = match self.distribution {
            // Every integer in the range is equally likely.
            Distribution::Uniform if matches!(self.value, Value::Count(_)) => (low.ceil()
                + u * (high.floor() - low.ceil() + 1.0))
                .floor()
                .min(high.floor()),
            Distribution::Uniform => low + u * (high - low),
            Distribution::Triangular => {
                let rising = (mode - low) / (high - low);
                if u < rising {
                    low + (u * (high - low) * (mode - low)).sqrt()
                } else {
                    high - ((1.0 - u) * (high - low) * (high - mode)).sqrt()
                }
            }
            Distribution::Normal => {
                let [below, above] = [normal::cumulative(self.cut[0]), normal::cumulative(-self.cut[1])];
                let inside = 1.0 - below - above;
                0.5 * (low + high) + 0.25 * (high - low) * normal::quantile(below + u * inside)
            }
            Distribution::LogUniform => low * (high / low).powf(u),
        };
        self.hold(x)
    }
}

/// The keys of the cycle that have a range, in the order of the reference.
///
/// A key belongs to the cycle if setting it changes the cycle's parameters. The parameters do not show which form of
/// the physics uses a key. Keys of other forms than the chosen one are therefore included; they have no effect on the
/// cycle.
///
/// # Errors
/// If the values of the design do not yield valid inputs.
pub fn taking_part(design: &Design) -> Result<Vec<Parameter>, Error> {
    let base = engine(design)?;
    let is_same = |other: &Engine| match (&base, other) {
        (Engine::Keys(base), Engine::Keys(other)) => base.parameters == other.parameters,
        (Engine::Assembly(base), Engine::Assembly(other)) => base.assembly == other.assembly,
        _ => false,
    };
    let takes_part = |parameter: &Parameter| {
        let [low, high] = parameter.range;
        let other = if low == parameter.number() { high } else { low };
        let mut changed = design.clone();
        changed.set(&[(parameter.change(), parameter.hold(other))]).is_ok()
            && engine(&changed).is_ok_and(|engine| !is_same(&engine))
    };
    let parameters = Parameter::all(design).into_iter().map(|(parameter, _)| parameter);
    Ok(parameters.filter(takes_part).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: Value, range: [f64; 2], distribution: Distribution) -> Parameter {
        Parameter {
            key: "key".to_owned(),
            symbol: "",
            unit: String::new(),
            value,
            range,
            distribution,
            cut: [-CUT, CUT],
            change: None,
        }
    }

    /// Mean and variance, by the midpoint rule over u.
    fn moments(parameter: &Parameter) -> [f64; 2] {
        const N: u32 = 200_000;
        let value = |k: u32| match parameter.at((f64::from(k) + 0.5) / f64::from(N)) {
            Value::Number(value) => value,
            Value::Count(count) => f64::from(count),
            other => panic!("{other:?}"),
        };
        let mean = (0..N).map(value).sum::<f64>() / f64::from(N);
        let variance = (0..N).map(|k| (value(k) - mean).powi(2)).sum::<f64>() / f64::from(N);
        [mean, variance]
    }

    fn assert_moments(distribution: Distribution, value: f64, range: [f64; 2], expected: [f64; 2]) {
        let [mean, variance] = moments(&parameter(Value::Number(value), range, distribution));
        assert!((mean - expected[0]).abs() < 1e-4, "{distribution:?}: mean {mean}");
        assert!(
            (variance - expected[1]).abs() < 1e-4,
            "{distribution:?}: variance {variance}"
        );
    }

    #[test]
    fn a_uniform_quantity_has_a_twelfth_of_its_width_squared_as_variance() {
        assert_moments(Distribution::Uniform, 3.0, [2.0, 5.0], [3.5, 9.0 / 12.0]);
    }

    #[test]
    fn a_triangular_quantity_has_the_mean_of_its_corners() {
        let [a, b, c] = [2.0, 5.0, 3.0_f64];
        let variance = (a * a + b * b + c * c - a * b - a * c - b * c) / 18.0;
        assert_moments(Distribution::Triangular, c, [a, b], [(a + b + c) / 3.0, variance]);
    }

    #[test]
    fn a_normal_quantity_cut_at_three_deviations_has_97_per_cent_of_its_variance() {
        // 1 - 6 phi(3)/(2 Phi(3) - 1), Johnson, Kotz and Balakrishnan 1994, section 13.10.1.
        assert_moments(Distribution::Normal, 0.0, [-2.0, 2.0], [0.0, 0.973_336_9]);
    }

    #[test]
    fn a_measured_parameter_is_normal_within_its_range() {
        let of = |range| parameter(Value::Number(1.0), range, Distribution::Triangular).measured(2.0, 0.5);
        let free = moments(&of([-9.0, 9.0]));
        assert!(
            (free[0] - 2.0).abs() < 1e-4 && (free[1] / 0.25 - 0.973_336_9).abs() < 1e-4,
            "{free:?}"
        );
        // Truncated at its mean and at three deviations below: mean -(phi(0) - phi(3))/(Phi(3) - 1/2) standard
        // deviations.
        let half = of([-9.0, 2.0]);
        assert!(
            (moments(&half)[0] - (2.0 - 0.5 * 0.791_16)).abs() < 1e-3,
            "{:?}",
            moments(&half)
        );
        assert!((0..99).all(|k| matches!(half.at((f64::from(k) + 0.5) / 99.0), Value::Number(x) if x <= 2.0)));
    }

    #[test]
    fn the_share_below_a_value_is_the_inverse_of_the_value_at_a_share() {
        let measured = parameter(Value::Number(3.0), [2.0, 5.0], Distribution::Uniform).measured(2.2, 0.3);
        let all = [
            Distribution::Uniform,
            Distribution::Triangular,
            Distribution::Normal,
            Distribution::LogUniform,
        ];
        let all = all.map(|distribution| parameter(Value::Number(3.0), [2.0, 5.0], distribution));
        for own in all.iter().chain([&measured]) {
            for share in [1e-6, 0.1, 0.5, 0.77, 1.0 - 1e-6] {
                let Value::Number(value) = own.at(share) else {
                    panic!("a number");
                };
                let found = own.share_below(value);
                assert!(
                    (found - share).abs() < 1e-9,
                    "{:?}: {found}, expected {share}",
                    own.distribution
                );
            }
            assert_eq!([own.share_below(0.1), own.share_below(9.0)], [0.0, 1.0]);
        }
        let count = parameter(Value::Count(2), [1.0, 5.0], Distribution::Uniform);
        assert!((1..=5).all(|own| count.at(count.share_below(f64::from(own))) == Value::Count(own)));
    }

    #[test]
    fn the_logarithm_of_a_log_uniform_quantity_is_uniform() {
        assert_moments(
            Distribution::LogUniform,
            1.0,
            [1.0, 4.0],
            [3.0 / 4.0_f64.ln(), 0.727_026],
        );
    }

    #[test]
    fn every_whole_number_of_a_range_is_as_likely() {
        let count = parameter(Value::Count(2), [1.0, 5.0], Distribution::Uniform);
        let [mean, variance] = moments(&count);
        assert!(
            (mean - 3.0).abs() < 1e-9 && (variance - 2.0).abs() < 1e-9,
            "{mean} {variance}"
        );
    }
}
