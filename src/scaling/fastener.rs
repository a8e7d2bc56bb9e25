//! The fastener of a scaled tool: a name from the catalogue, or length and diameter.

use std::str::FromStr;

use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::measure;

use crate::design::{self, Named, Value, length_in_words};

/// A fastener.
#[derive(Debug, Clone, PartialEq)]
pub enum Fastener {
    /// A fastener of the catalogue.
    Named(Named),
    /// A shank by its length and diameter \[m\].
    Size {
        /// Length including the head; for a staple, length of its legs.
        length: f64,
        /// Diameter of the shank.
        diameter: f64,
    },
}

impl FromStr for Fastener {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let plain = |text: &str| text.to_lowercase().replace(['-', '_', ' '], "");
        let all = design::nails().map_err(|error| error.to_string())?;
        if let Some(named) = all.into_iter().find(|named| plain(named.name) == plain(text)) {
            return Ok(Self::Named(named));
        }
        let expected =
            || "give a name of `nailnoise list nails`, or length and diameter as in \"64 x 1.6 mm\"".to_owned();
        let (length, diameter) = text.split_once('x').ok_or_else(expected)?;
        // Both have the unit given after the second, unless the first has its own.
        let unit = diameter
            .trim()
            .trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
        let length = match length.trim().parse::<f64>() {
            Ok(number) => format!("{number} {unit}"),
            Err(_) => length.to_owned(),
        };
        let [length, diameter] = [length.as_str(), diameter].map(|text| measure(text.trim(), LENGTH));
        let (length, diameter) = (length.map_err(|_| expected())?, diameter.map_err(|_| expected())?);
        if !(diameter > 0.0 && length > diameter && length < 0.3) {
            return Err(format!(
                "a nail of {} by {} is not one; the length comes first, {}",
                length_in_words(length),
                length_in_words(diameter),
                expected()
            ));
        }
        Ok(Self::Size { length, diameter })
    }
}

impl Fastener {
    /// A numerical value of a key that it sets.
    pub(super) fn number(&self, key: &str) -> Option<f64> {
        match (self, key) {
            (Self::Size { length, .. }, "nail.length") => Some(*length),
            (Self::Size { diameter, .. }, "nail.diameter") => Some(*diameter),
            (Self::Size { .. }, _) => None,
            (Self::Named(named), key) => {
                let value = &named.sets.iter().find(|own| own.key == key)?.value;
                match value {
                    Value::Number(x) => Some(*x),
                    Value::Count(n) => Some(f64::from(*n)),
                    _ => None,
                }
            }
        }
    }

    /// Length \[m\].
    pub(crate) fn length(&self) -> f64 {
        self.number("nail.length").unwrap_or(0.0)
    }

    /// Diameter of the shank \[m\].
    pub(crate) fn diameter(&self) -> f64 {
        self.number("nail.diameter").unwrap_or(0.0)
    }

    /// Its name, or its dimensions.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Named(named) => named.name.to_owned(),
            Self::Size { length, diameter } => {
                format!("{} x {}", length_in_words(*length), length_in_words(*diameter))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_fastener_is_a_name_or_two_lengths() {
        let named: Fastener = "16GA Staple-50".parse().unwrap();
        assert_eq!(named.words(), "16ga staple 50");
        assert_eq!(named.number("nail.legs"), Some(2.0));
        for text in ["64 x 1.6 mm", "64mm x 1.6mm", "64x1.6mm", "0.064 x 0.0016"] {
            let Fastener::Size { length, diameter } = text.parse().unwrap() else {
                panic!("{text} is a size");
            };
            assert!(
                (length - 0.064).abs() < 1e-12 && (diameter - 0.0016).abs() < 1e-12,
                "{text}"
            );
        }
    }

    #[test]
    fn a_diameter_before_the_length_and_words_are_refused_with_the_form() {
        for text in ["1.6 x 64 mm", "64 mm", "large", "64 x 1.6 kg", "64 x -1 mm"] {
            let error = text.parse::<Fastener>().unwrap_err();
            assert!(error.contains("64 x 1.6 mm"), "{text}: {error}");
        }
    }
}
