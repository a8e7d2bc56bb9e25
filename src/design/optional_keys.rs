//! Keys that a design may leave out, so that designs written before these keys existed keep their meaning.

use std::collections::HashMap;

use nailnoise_quantities::{Group, KeySpec, Measured, Value};

use super::groups::Values;
use super::merged::Merged;
use super::settings::Given;

/// A key that may be missing.
struct Optional {
    key: &'static str,
    /// A key that requires this one. This one takes over its place and provenance.
    beside: &'static str,
    value: Missing,
}

/// The value of a missing key.
enum Missing {
    /// Value and range of the other key.
    Same,
    /// Zero, which selects the other key.
    Zero,
    /// A word.
    Word(&'static str),
}

const OPTIONAL: [Optional; 8] = [
    // The cap has the material of the housing.
    same("body.cap.young_modulus", "body.housing.young_modulus"),
    same("body.cap.poisson_ratio", "body.housing.poisson_ratio"),
    same("body.cap.density", "body.housing.density"),
    // The passage has the common coefficient.
    zero("supply.hose_coefficient", "chambers.discharge_coefficient"),
    zero("chambers.check_hole_coefficient", "chambers.discharge_coefficient"),
    zero("chambers.return_hole_coefficient", "chambers.discharge_coefficient"),
    zero("chambers.leak_coefficient", "chambers.discharge_coefficient"),
    // The outflow fills the fitting.
    Optional {
        key: "exhaust.fitting.gas",
        beside: "exhaust.fitting.kind",
        value: Missing::Word("outflow"),
    },
];

const fn same(key: &'static str, beside: &'static str) -> Optional {
    let value = Missing::Same;
    Optional { key, beside, value }
}

const fn zero(key: &'static str, beside: &'static str) -> Optional {
    let value = Missing::Zero;
    Optional { key, beside, value }
}

impl Missing {
    /// The value and its text, if they are not those of the other key.
    fn given(&self) -> Option<(Given, &'static str)> {
        match self {
            Self::Same => None,
            Self::Zero => Some((Given::Quantity(Measured { si: 0.0, gauge: false }), "0")),
            Self::Word(word) => Some((Given::Other(Value::Choice(word)), word)),
        }
    }
}

/// Adds those of these keys to which no file gives a value.
pub(super) fn add_missing(merged: &mut HashMap<String, Merged>) {
    for Optional { key, beside, value } in OPTIONAL {
        let given = merged.get(key).is_some_and(|merged| merged.value.is_some());
        let Some(beside) = merged.get(beside).filter(|beside| !given && beside.value.is_some()) else {
            continue;
        };
        let mut added = beside.clone();
        added.spec = spec(key).unwrap_or(added.spec);
        if let Some((own, own_text)) = value.given() {
            added.forget_range();
            if let Some((value, text, _)) = &mut added.value {
                *value = own;
                own_text.clone_into(text);
            }
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
