//! Quantities given on the command line.

use crate::dimension::Dimension;
use crate::text::{QuantityError, quantity};

/// Parses "500 mm/min" as a quantity of `dimension` in SI units; a number without a unit is in SI units.
///
/// # Errors
/// A description of the error, with the units allowed.
pub fn measure(text: &str, dimension: Dimension) -> Result<f64, String> {
    if let Ok(number) = text.trim().parse::<f64>()
        && number.is_finite()
    {
        return Ok(number);
    }
    let units = dimension.examples();
    quantity(text, dimension, false)
        .map(|measured| measured.si)
        .map_err(|error| match error {
            QuantityError::Unit(error) => format!("{error}; units of {dimension} are {units}"),
            QuantityError::Dimension { unit, found } => format!("`{unit}` is {found}, expected {dimension} in {units}"),
            QuantityError::NotFinite => "the number is not finite".to_owned(),
            _ => format!(
                "expected a number with a unit ({units}) or a number alone ({})",
                dimension.unit()
            ),
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dimension::{LENGTH, VELOCITY};

    #[test]
    fn numbers_are_si_and_units_are_converted() {
        assert_eq!(measure("0.01", LENGTH), Ok(0.01));
        assert_eq!(measure("10 mm", LENGTH), Ok(0.01));
        assert!((measure("500 mm/min", VELOCITY).unwrap() - 500e-3 / 60.0).abs() < 1e-18);
    }

    #[test]
    fn what_is_no_length_is_told_apart() {
        for (text, word) in [
            ("ten", "a number with a unit"),
            ("3 Pa", "a pressure"),
            ("3 parsec", "parsec"),
            ("inf", ""),
        ] {
            let error = measure(text, LENGTH).unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
