//! Column headings: a name and a unit, which is in brackets, after a slash or in the row below.

use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{FORCE, TIME};

use super::label::{dimension_of, si_of};
use super::number::number;

/// Lower-case names of a time column.
const TIMES: [&str; 6] = ["t", "time", "times", "zeit", "x_value", "timestamp"];

/// A quantity to find among the columns.
#[derive(Debug, Clone, Copy)]
pub struct ColumnOf {
    /// Its name in lower case.
    pub name: &'static str,
    /// Dimension of its values.
    pub dimension: Dimension,
}

/// A heading, its name without the unit, and the unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Heading {
    /// The complete heading.
    pub text: String,
    /// The name without the unit.
    pub name: String,
    /// The unit; empty if there is none.
    pub unit: String,
}

impl Heading {
    /// Parses headings such as `N [g]`, `N (g)`, `p / Pa` and `time_ms`.
    pub fn of(field: &str) -> Self {
        let text = field.trim().to_owned();
        let bracket = [('[', ']'), ('(', ')'), ('{', '}')]
            .into_iter()
            .find_map(|(open, close)| {
                let (name, unit) = text.strip_suffix(close)?.rsplit_once(open)?;
                // "N / (m/s2)", but "V/(m/s2)" is a unit.
                let quotient = name.trim_end().strip_suffix('/');
                let quotient = quotient.filter(|own| own.ends_with(' ') || dimension_of(&text).is_none());
                Some((quotient.unwrap_or(name), unit))
            });
        // ISO 80000: a quantity divided by its unit. "m/s2" is a unit, not an m in s2.
        let slash = || {
            let place = text.char_indices().find(|(place, letter)| {
                matches!(letter, '/' | ',')
                    && dimension_of(&text[place + 1..]).is_some()
                    && dimension_of(&text).is_none()
            });
            place.map(|(place, _)| (&text[..place], &text[place + 1..]))
        };
        let underscore = || {
            let (name, unit) = text.split_once('_')?;
            (name.eq_ignore_ascii_case("time") && si_of(unit, TIME).is_ok()).then_some((name, unit))
        };
        let (name, unit) = bracket
            .or_else(slash)
            .or_else(underscore)
            .unwrap_or((text.as_str(), ""));
        Self {
            name: name.trim().to_owned(),
            unit: unit.trim().to_owned(),
            text: text.clone(),
        }
    }

    /// Whether the heading names a time column.
    pub fn is_time(&self) -> bool {
        let name = self.name.to_lowercase();
        TIMES.contains(&name.as_str()) || name.starts_with("time ")
    }

    /// Whether the heading names this quantity: `depth_mm`, `Depth [mm]`, `force / kN`.
    pub fn is_of(&self, of: ColumnOf) -> bool {
        let own = self.name.to_lowercase();
        own == of.name || (of.dimension == TIME && self.is_time()) || suffix(&own, of).is_some()
    }

    /// Factor from the unit of the column to SI; 1 without a unit.
    ///
    /// # Errors
    /// A description of the error in the unit.
    pub fn factor(&self, of: ColumnOf) -> Result<f64, String> {
        match suffix(&self.name.to_lowercase(), of) {
            Some(factor) if self.unit.is_empty() => Ok(factor),
            _ if self.unit.is_empty() => Ok(1.0),
            _ => si_of(&self.unit, of.dimension),
        }
    }

    /// Whether the heading is a number. The table then has no headings.
    pub(super) fn is_number(&self) -> bool {
        number(&self.text).is_some()
    }

    /// Whether the unit is a unit of time.
    pub(super) fn is_in_time(&self) -> bool {
        !self.unit.is_empty() && si_of(&self.unit, TIME).is_ok()
    }
}

/// Factor to SI of a unit appended to the name of a column: `depth_mm`, `force_kn`.
fn suffix(name: &str, of: ColumnOf) -> Option<f64> {
    let unit = name.strip_prefix(of.name)?.strip_prefix('_')?;
    let unit = if of.dimension == FORCE {
        unit.replace('n', "N")
    } else {
        unit.to_owned()
    };
    si_of(&unit, of.dimension).ok()
}

/// Index of the time column: the one named so, or else the only one in a unit of time.
pub fn time(headings: &[Heading]) -> Option<usize> {
    headings.iter().position(Heading::is_time).or_else(|| {
        let mut found = headings.iter().enumerate().filter(|(_, heading)| heading.is_in_time());
        match (found.next(), found.next()) {
            (Some((place, _)), None) => Some(place),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_is_a_name_and_a_unit() {
        for (text, name, unit) in [
            ("N [g]", "N", "g"),
            ("time (ms)", "time", "ms"),
            ("p / Pa", "p", "Pa"),
            ("t/s", "t", "s"),
            ("a/(m/s2)", "a", "m/s2"),
            ("N / (m/s2)", "N", "m/s2"),
            ("a / m/s²", "a", "m/s²"),
            ("Time, s", "Time", "s"),
            ("time_ms", "time", "ms"),
            ("m/s2", "m/s2", ""),
            ("top/left", "top/left", ""),
            ("N", "N", ""),
            ("mic_m", "mic_m", ""),
        ] {
            let heading = Heading::of(text);
            assert_eq!((heading.name.as_str(), heading.unit.as_str()), (name, unit), "{text}");
        }
    }

    #[test]
    fn the_only_column_in_a_unit_of_time_is_that_of_times() {
        let headings: Vec<Heading> = ["x-axis [second]", "1 [Volt]"].map(Heading::of).into();
        assert_eq!(time(&headings), Some(0));
        assert_eq!(time(&["x", "1"].map(Heading::of)), None);
    }
}
