//! Ranges: the forms of a range in a file, and the default range of a value that is given without one.
//!
//! A value without a range has a range in proportion to that of its base. With the base's value v_0 and its range low
//! .. high, the range of another value v is
//!
//! ```text
//! low v/v_0 .. high v/v_0           0 is not inside low .. high, and v is 0 or has the sign of v_0
//! v - w .. v + w, w = (high-low)/2  otherwise: there is no relative width
//! ```
//!
//! Both are cut at the ends of the key's domain. v_0 and the range are those of the file that states the range, so that
//! values in intermediate files do not matter. The range always includes the value, because the base's range includes
//! v_0.

use nailnoise_quantities::{Dimension, Measured, QuantityError, quantity, range};

/// Relative tolerance for equal values; unit conversion causes rounding.
const SAME: f64 = 1e-12;

/// Relative tolerance at the ends of a range: "96 psig" as a value and in a range may differ by rounding.
const SLACK: f64 = 1e-9;

/// A range as a file gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GivenRange {
    /// Two ends; gauge pressures are still relative to the ambient pressure.
    Ends([Measured; 2]),
    /// A relative deviation to either side: "+-10 %".
    Relative(f64),
    /// An absolute deviation to either side, in SI units: "+-2 mm".
    Within(f64),
    /// Only the value itself.
    Exact,
}

impl GivenRange {
    /// Reads a text. After `+-`, percent always means a fraction of the value.
    ///
    /// # Errors
    /// A [`QuantityError`] for a faulty text.
    pub(crate) fn parse(text: &str, dimension: Dimension, gauge: bool) -> Result<Self, QuantityError> {
        let text = text.trim();
        if text == "exact" {
            return Ok(Self::Exact);
        }
        let Some(width) = text.strip_prefix("+-").or_else(|| text.strip_prefix('\u{b1}')) else {
            return range(text, dimension, gauge).map(Self::Ends);
        };
        let width = width.trim();
        let positive = |width: f64| match width {
            _ if !width.is_finite() => Err(QuantityError::NotFinite),
            _ if width < 0.0 => Err(QuantityError::Number),
            _ => Ok(width),
        };
        match width.strip_suffix('%') {
            Some(percent) => {
                let percent: f64 = percent.trim().parse().map_err(|_| QuantityError::Number)?;
                positive(percent / 100.0).map(Self::Relative)
            }
            None => positive(difference(width, dimension)?).map(Self::Within),
        }
    }

    /// Its ends in SI units, if it is given by two ends.
    pub(crate) fn ends(self) -> Option<[f64; 2]> {
        match self {
            Self::Ends(ends) => Some(ends.map(|end| end.si)),
            Self::Relative(_) | Self::Within(_) | Self::Exact => None,
        }
    }

    /// The range in SI units around this value, with the ambient pressure \[Pa\].
    pub(crate) fn of(self, value: f64, ambient: f64) -> [f64; 2] {
        let around = |half: f64| [value - half, value + half];
        match self {
            Self::Ends(ends) => ends.map(|end| end.absolute(ambient)),
            Self::Relative(share) => around(share * value.abs()),
            Self::Within(half) => around(half),
            Self::Exact => around(0.0),
        }
    }
}

/// The range of a value that is given without one, if a base states a range.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) enum DefaultRange {
    /// In proportion to that of the base.
    #[default]
    Base,
    /// The same for all such values.
    Own(GivenRange),
}

/// Reads "2 mm" as a difference of two quantities, without the offset of the unit: 5 degC is 5 K.
fn difference(text: &str, dimension: Dimension) -> Result<f64, QuantityError> {
    let ends = (1..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    let number = ends
        .map(|end| text.split_at(end))
        .find(|(number, _)| number.parse::<f64>().is_ok());
    let (_, unit) = number.ok_or(QuantityError::Number)?;
    let zero = quantity(&format!("0 {unit}"), dimension, false)?.si;
    Ok(quantity(text, dimension, false)?.si - zero)
}

/// Origin of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub enum RangeOrigin {
    /// A file states it for this value.
    #[serde(rename = "given")]
    Given,
    /// The value is given without a range; the range is in proportion to that of the base.
    #[serde(rename = "assumed from base")]
    AssumedFromBase,
    /// The value is given without a range; the range is `study.default_range`.
    #[serde(rename = "assumed by study.default_range")]
    AssumedByDefault,
}

impl RangeOrigin {
    /// Text for the user.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::AssumedFromBase => "assumed from base",
            Self::AssumedByDefault => "assumed by study.default_range",
        }
    }
}

/// A range with its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ranged {
    pub(crate) range: [f64; 2],
    pub(crate) origin: RangeOrigin,
    /// The range that the base states, if the value is given without one.
    pub(crate) of_base: Option<[f64; 2]>,
}

/// Whether a range includes a value, apart from rounding.
pub(crate) fn includes([low, high]: [f64; 2], value: f64) -> bool {
    let slack = SLACK * low.abs().max(high.abs());
    value >= low - slack && value <= high + slack
}

/// The range of a `value` given without one, where the base states `range` for the value `base`.
pub(crate) fn inherited(
    value: f64,
    (base, range): (f64, [f64; 2]),
    default: DefaultRange,
    domain: Option<[f64; 2]>,
) -> Ranged {
    let given = Ranged {
        range,
        origin: RangeOrigin::Given,
        of_base: None,
    };
    // A range that does not include the base's own value is meant for the value of a file nearer to the design.
    if (value - base).abs() <= SAME * base.abs() || !includes(range, base) {
        return given;
    }
    let (assumed, origin) = match default {
        DefaultRange::Base => (in_proportion(value, base, range), RangeOrigin::AssumedFromBase),
        DefaultRange::Own(own) => (own.of(value, 0.0), RangeOrigin::AssumedByDefault),
    };
    let [least, most] = domain.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    Ranged {
        range: [assumed[0].max(least).min(value), assumed[1].min(most).max(value)],
        origin,
        of_base: Some(range),
    }
}

fn in_proportion(value: f64, base: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    let of_one_sign = (low >= 0.0 && base > 0.0 && value >= 0.0) || (high <= 0.0 && base < 0.0 && value <= 0.0);
    if of_one_sign {
        let ratio = value / base;
        return [ratio * low, ratio * high];
    }
    let half = 0.5 * (high - low);
    [value - half, value + half]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nailnoise_quantities::dimension::{LENGTH, NUMBER, TEMPERATURE};
    use proptest::prelude::*;

    use super::*;

    fn assumed(value: f64, base: f64, range: [f64; 2], domain: [f64; 2]) -> [f64; 2] {
        inherited(value, (base, range), DefaultRange::Base, Some(domain)).range
    }

    proptest! {
        #[test]
        fn a_range_that_is_assumed_includes_its_value(
            base in -10.0..10.0_f64, below in 0.0..5.0_f64, above in 0.0..5.0_f64, value in -20.0..20.0_f64
        ) {
            let domain = [-20.0, 20.0];
            let [low, high] = assumed(value, base, [base - below, base + above], domain);
            prop_assert!(low <= value && value <= high);
            prop_assert!(domain[0] <= low && high <= domain[1]);
        }

        #[test]
        fn a_range_that_is_assumed_does_not_depend_on_the_unit(
            base in 0.1..10.0_f64, below in 0.0..1.0_f64, above in 0.0..5.0_f64, value in 0.0..20.0_f64,
                unit in 1e-3..1e3_f64
        ) {
            let range = [base * (1.0 - below), base + above];
            let domain = [0.0, 1e9];
            let own = assumed(value, base, range, domain);
            let other = assumed(unit * value, unit * base, range.map(|end| unit * end), domain);
            for (own, other) in own.into_iter().zip(other) {
                prop_assert!((unit * own - other).abs() <= 1e-9 * other.abs());
            }
        }

        #[test]
        fn a_positive_value_has_the_relative_width_of_its_base(
            base in 0.1..10.0_f64, below in 0.0..1.0_f64, above in 0.0..5.0_f64, value in 0.1..20.0_f64
        ) {
            let [low, high] = assumed(value, base, [base * (1.0 - below), base * (1.0 + above)], [0.0, 1e9]);
            prop_assert!((low / value - (1.0 - below)).abs() < 1e-9 && (high / value - (1.0 + above)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_range_around_zero_keeps_its_width() {
        assert_eq!(assumed(2.0, 0.0, [0.0, 5.0], [0.0, 100.0]), [0.0, 4.5]);
        assert_eq!(assumed(0.5, 0.0, [-1.0, 1.0], [-1.0, 1.0]), [-0.5, 1.0]);
    }

    #[test]
    fn zero_in_place_of_a_positive_value_is_exact() {
        assert_eq!(assumed(0.0, 15.0, [0.0, 40.0], [0.0, 100.0]), [0.0, 0.0]);
    }

    #[test]
    fn the_value_of_the_base_has_its_range_as_it_is() {
        let own = inherited(5.0, (5.0, [1.0, 20.0]), DefaultRange::Own(GivenRange::Exact), None);
        assert_eq!((own.range, own.origin), ([1.0, 20.0], RangeOrigin::Given));
    }

    #[test]
    fn a_default_range_takes_the_place_of_that_of_the_base() {
        let own = |default| inherited(10.0, (5.0, [1.0, 20.0]), DefaultRange::Own(default), None).range;
        assert_eq!(own(GivenRange::Relative(0.25)), [7.5, 12.5]);
        assert_eq!(own(GivenRange::Exact), [10.0, 10.0]);
    }

    #[test]
    fn percent_behind_a_sign_are_a_share_and_other_units_a_distance() {
        let of = |text: &str, dimension| GivenRange::parse(text, dimension, false);
        assert_eq!(of("+-10 %", NUMBER), Ok(GivenRange::Relative(0.1)));
        assert_eq!(of("\u{b1} 5%", LENGTH), Ok(GivenRange::Relative(0.05)));
        assert_eq!(of("+-2 mm", LENGTH), Ok(GivenRange::Within(0.002)));
        assert_eq!(of(" exact ", LENGTH), Ok(GivenRange::Exact));
        let GivenRange::Within(half) = of("+-5 degC", TEMPERATURE).unwrap() else {
            panic!("a distance");
        };
        assert!((half - 5.0).abs() < 1e-9);
        for wrong in ["+-", "+--2 mm", "+-2", "+-10", "exactly", "+-nan %"] {
            assert!(of(wrong, LENGTH).is_err(), "{wrong}");
        }
    }
}
