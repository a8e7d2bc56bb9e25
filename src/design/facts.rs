//! Facts about keys beyond their declaration: plausible values for tools of this class, the consequence of a value
//! outside, and how the quantity is measured. The data are in `keys.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use nailnoise_quantities::range;
use serde::{Deserialize, Serialize};

use super::show::show;
use super::{Design, Entry, KeySpec, Kind, Value, Values, Warning};
use nailnoise_quantities::Group;
use nailnoise_quantities::dimension::NUMBER;

/// Facts about a key.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyFacts {
    /// Plausible range of values for tools of this class, with its unit; none if there is no such range.
    #[serde(default)]
    plausible: Option<String>,
    /// The consequence of a value outside.
    #[serde(default)]
    outside: String,
    /// How it is measured; empty if the quantity cannot be measured by simple means.
    #[serde(default)]
    how: String,
    #[serde(default)]
    instrument: String,
    #[serde(default)]
    minutes: u32,
    #[serde(default)]
    accuracy: String,
}

/// How a quantity is measured on a tool at hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Measurement {
    /// How it is measured.
    pub how: &'static str,
    /// The instrument needed.
    pub instrument: &'static str,
    /// Time needed by one person \[min\].
    pub minutes: u32,
    /// Accuracy, with its unit.
    pub accuracy: &'static str,
}

/// A value outside a range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutsideValue {
    /// The key.
    pub key: String,
    /// Its value, with a readable unit.
    pub value: String,
    /// The range, with readable units.
    pub range: [String; 2],
    /// Origin of the range: `class` for tools of this class, `design` for the range given in the design.
    pub of: &'static str,
    /// The consequence.
    pub consequence: String,
}

/// The data; a file that cannot be parsed would be a fault of the program, which a test rules out.
static FACTS: LazyLock<BTreeMap<String, KeyFacts>> =
    LazyLock::new(|| toml::from_str(include_str!("keys.toml")).unwrap_or_default());

/// Facts about a key.
pub fn facts(key: &str) -> Option<&'static KeyFacts> {
    FACTS.get(key)
}

impl KeyFacts {
    /// The plausible range in SI units, if any.
    pub fn plausible(&self, kind: Kind) -> Option<[f64; 2]> {
        let dimension = match kind {
            Kind::Quantity { dimension, .. } => dimension,
            _ => NUMBER,
        };
        let ends = range(self.plausible.as_deref()?, dimension, false).ok()?;
        Some(ends.map(|end| end.si))
    }

    /// The plausible range as stated in the data.
    pub fn plausible_in_words(&self) -> Option<&str> {
        self.plausible.as_deref()
    }

    /// How the quantity is measured; none if it cannot be measured by simple means.
    pub fn measurement(&'static self) -> Option<Measurement> {
        (!self.how.is_empty()).then_some(Measurement {
            how: &self.how,
            instrument: &self.instrument,
            minutes: self.minutes,
            accuracy: &self.accuracy,
        })
    }
}

/// The declaration of every key by its full name.
fn declarations() -> BTreeMap<String, &'static KeySpec> {
    let mut declared = BTreeMap::new();
    Values::SPEC.each_key("", &mut |key, spec| {
        declared.insert(key.to_owned(), spec);
    });
    declared
}

impl Design {
    /// Values outside the ranges for tools of this class, and outside those given in the design.
    pub fn outside_values(&self) -> Vec<OutsideValue> {
        let declared = declarations();
        let of_class = |entry: &Entry| {
            let (facts, spec) = (facts(&entry.key)?, declared.get(&entry.key)?);
            let [low, high] = facts.plausible(spec.kind)?;
            let value = match entry.value {
                Value::Number(value) => value,
                Value::Count(count) => f64::from(count),
                _ => return None,
            };
            let slack = 1e-9 * low.abs().max(high.abs());
            let dimension = match spec.kind {
                Kind::Quantity { dimension, .. } => dimension,
                _ => NUMBER,
            };
            (value < low - slack || value > high + slack).then(|| OutsideValue {
                key: entry.key.clone(),
                value: show(value, dimension),
                range: [low, high].map(|end| show(end, dimension)),
                of: "class",
                consequence: facts.outside.clone(),
            })
        };
        let mut found: Vec<OutsideValue> = self.entries().iter().filter_map(of_class).collect();
        for warning in self.warnings() {
            if let Warning::OutsideRange {
                key, value, low, high, ..
            } = warning
                && found.iter().all(|own| own.key != *key)
            {
                found.push(OutsideValue {
                    key: key.clone(),
                    value: value.clone(),
                    range: [low.clone(), high.clone()],
                    of: "design",
                    consequence:
                        "draws of a study come from this range and leave the value out; give the value its own range"
                            .to_owned(),
                });
            }
        }
        found
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn data() -> BTreeMap<String, KeyFacts> {
        toml::from_str(include_str!("keys.toml")).unwrap()
    }

    #[test]
    fn every_fact_is_of_a_key_and_its_range_has_the_unit_of_that_key() {
        let declared = declarations();
        for (key, facts) in data() {
            let spec = declared.get(&key).unwrap_or_else(|| panic!("{key} is not a key"));
            let Some(words) = facts.plausible_in_words() else {
                continue;
            };
            let [low, high] = facts.plausible(spec.kind).unwrap_or_else(|| panic!("{key}: {words}"));
            assert!(
                low < high && spec.kind.allows(low) && spec.kind.allows(high),
                "{key}: {words}"
            );
            assert!(!facts.outside.is_empty(), "{key}: the consequence is missing");
        }
    }

    #[test]
    fn a_measurement_states_instrument_time_and_accuracy() {
        for (key, facts) in data() {
            let whole = !facts.instrument.is_empty() && facts.minutes > 0 && !facts.accuracy.is_empty();
            assert_eq!(!facts.how.is_empty(), whole, "{key}");
        }
    }

    /// The uncertainty of a single tool's value is smaller than the scatter over all tools.
    #[test]
    fn the_shipped_tool_and_its_ranges_are_plausible() {
        let design = Design::shipped("n80cb.toml").unwrap();
        assert_eq!(design.outside_values(), []);
        let declared = declarations();
        for entry in design.entries() {
            let plausible = facts(&entry.key).and_then(|facts| facts.plausible(declared.get(&entry.key)?.kind));
            if let (Some([low, high]), Some(own)) = (plausible, entry.range) {
                let slack = 1e-9 * high.abs();
                assert!(
                    low - slack <= own[0] && own[1] <= high + slack,
                    "{}: {own:?}",
                    entry.key
                );
            }
        }
    }

    /// A user's range does not make a value plausible.
    #[test]
    fn a_piston_heavier_than_any_is_outside_with_its_consequence() {
        let text = "base = \"n80cb.toml\"\npiston.mass = { value = \"700 g\", range = \"690 .. 710 g\" }\n";
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/own.toml");
        let found = Design::parse(text, path).unwrap().outside_values();
        let [mass] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((mass.key.as_str(), mass.of), ("piston.mass", "class"));
        assert!(mass.consequence.contains("kg or g"), "{}", mass.consequence);
    }
}
