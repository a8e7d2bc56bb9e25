//! Keys that a design may leave out, so that designs written before these keys existed keep their meaning.

use std::collections::HashMap;

use nailnoise_quantities::{Group, KeySpec, Measured, Value};

use super::groups::Values;
use super::merged::Merged;
use super::settings::Given;

/// Keys that take the value and the range of another one: the cap has the material of the housing.
const SAME: [(&str, &str); 3] = [
    ("body.cap.young_modulus", "body.housing.young_modulus"),
    ("body.cap.poisson_ratio", "body.housing.poisson_ratio"),
    ("body.cap.density", "body.housing.density"),
];

/// Keys that are 0: the passage has the common coefficient.
const ZERO: [&str; 4] = [
    "supply.hose_coefficient",
    "chambers.check_hole_coefficient",
    "chambers.return_hole_coefficient",
    "chambers.leak_coefficient",
];

/// A key with the word that it has where none is given, and a key of its group: the outflow fills the fitting.
const WORD: (&str, &str, &str) = ("exhaust.fitting.gas", "outflow", "exhaust.fitting.kind");

/// The key whose value the keys of [`ZERO`] select.
const COMMON: &str = "chambers.discharge_coefficient";

/// Adds those of these keys to which no file gives a value.
pub(super) fn add_missing(merged: &mut HashMap<String, Merged>) {
    let zeros = ZERO.map(|key| (key, COMMON));
    let (word_key, word, of_group) = WORD;
    for (key, other) in SAME.into_iter().chain(zeros).chain([(word_key, of_group)]) {
        let given = merged.get(key).is_some_and(|merged| merged.value.is_some());
        let Some(other) = merged.get(other).filter(|other| !given && other.value.is_some()) else {
            continue;
        };
        let mut added = other.clone();
        added.spec = spec(key).unwrap_or(added.spec);
        if ZERO.contains(&key) {
            added.forget_range();
            if let Some((value, text, _)) = &mut added.value {
                *value = Given::Quantity(Measured { si: 0.0, gauge: false });
                "0".clone_into(text);
            }
        }
        if key == word_key
            && let Some((value, text, _)) = &mut added.value
        {
            *value = Given::Other(Value::Choice(word));
            word.clone_into(text);
        }
        merged.insert(key.to_owned(), added);
    }
}

fn spec(key: &str) -> Option<&'static KeySpec> {
    let mut found = None;
    Values::SPEC.each_key("", &mut |name, spec| {
        if name == key {
            found = Some(spec);
        }
    });
    found
}
