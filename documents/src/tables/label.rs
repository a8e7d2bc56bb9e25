//! Labels of units as instruments and spreadsheets write them: "sec", "(m/s^2)", "m/s²", "Volts".

use nailnoise_quantities::{Dimension, QuantityError, dimension, quantity};

/// Lower-case words for units, with their SI spelling.
const WORDS: &[(&str, &str)] = &[
    ("sec", "s"),
    ("secs", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("sekunden", "s"),
    ("msec", "ms"),
    ("msecs", "ms"),
    ("millisecond", "ms"),
    ("milliseconds", "ms"),
    ("usec", "us"),
    ("µsec", "us"),
    ("μsec", "us"),
    ("microsecond", "us"),
    ("microseconds", "us"),
    ("minute", "min"),
    ("minutes", "min"),
    ("pascal", "Pa"),
    ("pascals", "Pa"),
    ("pa", "Pa"),
    ("kpa", "kPa"),
    ("volt", "V"),
    ("volts", "V"),
    ("millivolt", "mV"),
    ("millivolts", "mV"),
    ("newton", "N"),
    ("newtons", "N"),
    ("kilonewton", "kN"),
    ("kilonewtons", "kN"),
    ("kn", "kN"),
    ("meter", "m"),
    ("meters", "m"),
    ("metre", "m"),
    ("metres", "m"),
    ("millimeter", "mm"),
    ("millimeters", "mm"),
    ("millimetre", "mm"),
    ("millimetres", "mm"),
    ("inches", "in"),
    ("gs", "g"),
    ("gn", "g"),
];

/// Rewrites a label as in the design file: without brackets, with symbols for words and `^` for `**`.
pub fn spelled(label: &str) -> String {
    let label = label.trim();
    let inner = [('(', ')'), ('[', ']'), ('{', '}')]
        .into_iter()
        .find_map(|(open, close)| {
            let inner = label.strip_prefix(open)?.strip_suffix(close)?;
            // Not "(m)/(s)", whose outer brackets are not a pair.
            (!inner.contains([open, close]) || open == '(' && balanced(inner)).then_some(inner)
        });
    let label = inner
        .unwrap_or(label)
        .trim()
        .replace("**", "^")
        .replace('⁻', "^-")
        .replace('¹', "1");
    let mut text = String::with_capacity(label.len());
    let mut rest = label.as_str();
    while !rest.is_empty() {
        let end = rest.find(|letter: char| !is_letter(letter)).unwrap_or(rest.len());
        let (word, more) = rest.split_at(end);
        let lower = word.to_lowercase();
        let symbol = WORDS.iter().find(|(own, _)| *own == lower).map(|(_, symbol)| *symbol);
        text.push_str(symbol.unwrap_or(word));
        let end = more.find(is_letter).unwrap_or(more.len());
        text.push_str(&more[..end]);
        rest = &more[end..];
    }
    // `⁻²` has become `^-²`.
    text.replace("^-²", "^-2").replace("^-³", "^-3")
}

fn balanced(text: &str) -> bool {
    let mut depth = 0;
    text.chars().all(|letter| {
        depth += match letter {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        depth >= 0
    })
}

fn is_letter(letter: char) -> bool {
    letter.is_alphabetic() || letter == 'µ'
}

/// The dimension of a label; none if the label is not a unit.
pub fn dimension_of(label: &str) -> Option<Dimension> {
    let unit = spelled(label);
    if unit.is_empty() || unit.starts_with(|letter: char| letter.is_ascii_digit()) {
        return None;
    }
    // The error names the dimension found; the expected dimension is a dummy that needs no unit here.
    match quantity(&format!("1 {unit}"), dimension::HEAT_TRANSFER, false) {
        Ok(_) => Some(dimension::HEAT_TRANSFER),
        Err(QuantityError::Dimension { found, .. }) => Some(found),
        Err(_) => None,
    }
}

/// Factor from the unit of a label to SI.
///
/// # Errors
/// A description of the error in the label.
pub fn si_of(label: &str, dimension: Dimension) -> Result<f64, String> {
    let unit = spelled(label);
    if dimension == dimension::TIME && unit == "S" {
        return Ok(1.0);
    }
    if unit.is_empty() {
        return Err("it is empty".to_owned());
    }
    nailnoise_quantities::measure(&format!("1 {unit}"), dimension)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_quantities::dimension::{ACCELERATION, FORCE, LENGTH, MASS, PRESSURE, TIME, VOLTAGE};

    #[test]
    fn words_are_the_units_that_they_mean() {
        for (label, dimension, si) in [
            ("sec", TIME, 1.0),
            ("Sec", TIME, 1.0),
            ("seconds", TIME, 1.0),
            ("S", TIME, 1.0),
            ("[msec]", TIME, 1e-3),
            ("µs", TIME, 1e-6),
            ("Microseconds", TIME, 1e-6),
            ("m/s²", ACCELERATION, 1.0),
            ("(m/s^2)", ACCELERATION, 1.0),
            ("m/s**2", ACCELERATION, 1.0),
            ("m/sec^2", ACCELERATION, 1.0),
            ("m/s/s", ACCELERATION, 1.0),
            ("m·s⁻²", ACCELERATION, 1.0),
            ("m/(s2)", ACCELERATION, 1.0),
            ("Pascal", PRESSURE, 1.0),
            ("KPA", PRESSURE, 1e3),
            ("Volts", VOLTAGE, 1.0),
            ("(mV)", VOLTAGE, 1e-3),
            ("kN", FORCE, 1e3),
            ("inches", LENGTH, 0.0254),
        ] {
            let found = si_of(label, dimension).unwrap_or(f64::NAN);
            assert!((found / si - 1.0).abs() < 1e-15, "{label}: {found}");
        }
    }

    #[test]
    fn a_label_has_the_dimension_of_its_unit_or_none() {
        for (label, dimension) in [
            ("m/s2", Some(ACCELERATION)),
            ("N", Some(FORCE)),
            ("g", Some(MASS)),
            ("EU", None),
            ("", None),
            ("counts", None),
            ("12", None),
        ] {
            assert_eq!(dimension_of(label), dimension, "{label}");
        }
    }
}
