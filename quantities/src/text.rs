//! A quantity as text: a number with its unit, converted to SI.

use crate::dimension::{Dimension, NUMBER, PRESSURE};
use crate::units::{Unit, UnitError};

/// A quantity in SI units; a gauge pressure remains relative to ambient pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Value in the SI unit of its dimension.
    pub si: f64,
    /// Whether it is a gauge pressure.
    pub gauge: bool,
}

impl Measured {
    /// The absolute value, with ambient pressure `ambient` \[Pa\].
    pub fn absolute(self, ambient: f64) -> f64 {
        if self.gauge { self.si + ambient } else { self.si }
    }
}

/// Why a text is not the expected quantity.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// No number, or a number followed by characters that cannot start a unit.
    #[error("not a number with a unit")]
    Number,
    /// Infinite, too large for a double, or not a number.
    #[error("the number is not finite")]
    NotFinite,
    /// A number without a unit although a dimension is expected.
    #[error("the unit is missing")]
    NoUnit,
    /// A unit cannot be parsed.
    #[error(transparent)]
    Unit(UnitError),
    /// A unit of the wrong dimension.
    #[error("`{unit}` is {found}")]
    Dimension {
        /// The unit given.
        unit: String,
        /// Its dimension.
        found: Dimension,
    },
    /// A gauge pressure although only absolute pressures make sense.
    #[error("`{unit}` is a unit of gauge pressure")]
    Gauge {
        /// The unit given.
        unit: String,
    },
}

/// Parses "763.2 kPa" as a quantity of `dimension`; `gauge` permits gauge pressures.
///
/// # Errors
/// [`QuantityError`] if the text is invalid.
pub fn quantity(text: &str, dimension: Dimension, gauge: bool) -> Result<Measured, QuantityError> {
    let (number, unit) = split(text)?;
    let (unit, text) = (Unit::parse(unit).map_err(QuantityError::Unit)?, unit);
    if text.is_empty() && dimension != NUMBER {
        return Err(QuantityError::NoUnit);
    }
    convert(number, unit, text, dimension, gauge)
}

/// Reads "0.129 .. 0.133 kg": two quantities. A unit at the end may apply to both.
///
/// # Errors
/// Same as [`quantity`].
pub fn range(text: &str, dimension: Dimension, gauge: bool) -> Result<[Measured; 2], QuantityError> {
    let (low, high) = text.split_once("..").ok_or(QuantityError::Number)?;
    let (_, shared) = split(high)?;
    let (number, own) = split(low)?;
    if own.is_empty() {
        let unit = Unit::parse(shared).map_err(QuantityError::Unit)?;
        let low = convert(number, unit, shared, dimension, gauge)?;
        return Ok([low, quantity(high, dimension, gauge)?]);
    }
    Ok([quantity(low, dimension, gauge)?, quantity(high, dimension, gauge)?])
}

fn convert(number: &str, unit: Unit, text: &str, dimension: Dimension, gauge: bool) -> Result<Measured, QuantityError> {
    if unit.dimension != dimension {
        return Err(QuantityError::Dimension {
            unit: text.to_owned(),
            found: unit.dimension,
        });
    }
    if unit.gauge && !(gauge && dimension == PRESSURE) {
        return Err(QuantityError::Gauge { unit: text.to_owned() });
    }
    let si = scaled(number, unit.exponent).ok_or(QuantityError::Number)? * unit.factor + unit.offset;
    if si.is_finite() {
        Ok(Measured { si, gauge: unit.gauge })
    } else {
        Err(QuantityError::NotFinite)
    }
}

/// The number times a power of ten, rounded only once.
fn scaled(number: &str, power: i32) -> Option<f64> {
    let (mantissa, exponent) = match number.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i64>().ok()?),
        None => (number, 0),
    };
    format!(
        "{mantissa}e{}",
        exponent.saturating_add(i64::from(power)).clamp(-9999, 9999)
    )
    .parse()
    .ok()
}

/// Splits a text into its number and the rest.
fn split(text: &str) -> Result<(&str, &str), QuantityError> {
    let text = text.trim();
    let unsigned = text.trim_start_matches(['+', '-']);
    let word: String = unsigned
        .chars()
        .take_while(|c| c.is_alphabetic())
        .flat_map(char::to_lowercase)
        .collect();
    if matches!(word.as_str(), "nan" | "inf" | "infinity") {
        return Err(QuantityError::NotFinite);
    }
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = digits(start);
    let mut count = end - start;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        count += fraction - (end + 1);
        end = fraction;
    }
    if count == 0 {
        return Err(QuantityError::Number);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    let unit = text[end..].trim_start();
    // "1,5 mm", "1 000 Pa", "1.2.3": another number begins where a unit should.
    if unit.starts_with(|c: char| c.is_ascii_digit() || matches!(c, ',' | '.' | '+' | '-' | '_')) {
        return Err(QuantityError::Number);
    }
    Ok((&text[..end], unit))
}

/// Formats a number to `digits` significant digits without trailing zeros, in exponential form below 0.001 and from
/// `large` upwards.
pub fn rounded(value: f64, digits: usize, large: f64) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..large).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimension::*;

    #[test]
    fn decimal_units_round_once() {
        for (text, dimension, si) in [
            ("763.2 kPa", PRESSURE, 763_200.0),
            ("60 mm", LENGTH, 0.06),
            ("66.3mm", LENGTH, 0.0663),
            ("5.1e5 N/mm", STIFFNESS, 5.1e8),
            ("1.1E+05 N/mm", STIFFNESS, 1.1e8),
            ("50 mm2", AREA, 50e-6),
            ("1.5 cm3", VOLUME, 1.5e-6),
            ("4.6 mm2", AREA, 4.6e-6),
            ("131 g", MASS, 0.131),
            ("4 us", TIME, 4e-6),
            (".5", NUMBER, 0.5),
            ("2 %", NUMBER, 0.02),
            ("-122.91 m2/s2", VELOCITY_SQUARED, -122.91),
            ("20 degC", TEMPERATURE, 293.15),
        ] {
            assert_eq!(quantity(text, dimension, false).unwrap().si, si, "{text}");
        }
    }

    #[test]
    fn gauge_pressure_counts_from_ambient() {
        let gauge = quantity("96 psig", PRESSURE, true).unwrap().absolute(101_325.0);
        let absolute = quantity("763.2 kPa", PRESSURE, true).unwrap().absolute(101_325.0);
        assert!((gauge - absolute).abs() < 50.0, "{gauge} and {absolute}");
        assert!(matches!(
            quantity("96 psig", PRESSURE, false),
            Err(QuantityError::Gauge { .. })
        ));
    }

    #[test]
    fn what_is_no_quantity_is_refused() {
        use QuantityError as E;
        assert_eq!(quantity("1,5 mm", LENGTH, false), Err(E::Number));
        assert_eq!(quantity("1 000 Pa", PRESSURE, false), Err(E::Number));
        assert_eq!(quantity("mm", LENGTH, false), Err(E::Number));
        assert_eq!(quantity("", LENGTH, false), Err(E::Number));
        assert_eq!(quantity("-", LENGTH, false), Err(E::Number));
        assert_eq!(quantity("NaN mm", LENGTH, false), Err(E::NotFinite));
        assert_eq!(quantity("-inf", NUMBER, false), Err(E::NotFinite));
        assert_eq!(quantity("1e999 m", LENGTH, false), Err(E::NotFinite));
        assert_eq!(quantity("12", LENGTH, false), Err(E::NoUnit));
        assert!(matches!(quantity("3 kg", LENGTH, false), Err(E::Dimension { .. })));
        assert!(matches!(quantity("3 deg", NUMBER, false), Err(E::Dimension { .. })));
        assert!(matches!(quantity("3 furlongs", LENGTH, false), Err(E::Unit(_))));
    }

    #[test]
    fn a_range_shares_its_unit_or_gives_two() {
        let pair = |text| range(text, LENGTH, false).map(|[low, high]| (low.si, high.si));
        assert_eq!(pair("10 .. 16 mm"), Ok((0.01, 0.016)));
        assert_eq!(pair("10 mm .. 1.6 cm"), Ok((0.01, 0.016)));
        assert!(pair("10 mm").is_err());
        assert!(pair("10 mm .. 16").is_err());
    }
}
