//! Values of the keys that formulas refer to.

use std::collections::BTreeMap;

use nailnoise_quantities::dimension::{AREA, DAMPING, NUMBER, STIFFNESS};
use nailnoise_quantities::{Dimension, Group, GroupSpec, KeySpec, Kind, Name, Value};

use crate::{
    Ambient, Block, Chambers, Contacts, Exhaust, Hand, HeadValve, Model, Nail, NailedWood, Parameters, Piston, Supply,
    Support, Tool, Trigger,
};

/// Value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyValue {
    /// A quantity.
    Quantity {
        /// Value in SI.
        si: f64,
        /// Dimension.
        dimension: Dimension,
    },
    /// A switch.
    Switch(bool),
    /// A choice.
    Choice {
        /// Chosen word.
        word: &'static str,
        /// All words.
        words: &'static [&'static str],
    },
    /// A text.
    Word(String),
}

impl KeyValue {
    /// The value of a declared key.
    pub fn of(spec: &KeySpec, value: &Value) -> Self {
        let dimension = match spec.kind {
            Kind::Quantity { dimension, .. } => dimension,
            _ => NUMBER,
        };
        match value {
            Value::Number(si) => Self::Quantity { si: *si, dimension },
            Value::Count(count) => Self::Quantity {
                si: f64::from(*count),
                dimension,
            },
            Value::Switch(on) => Self::Switch(*on),
            Value::Choice(word) => Self::Choice {
                word,
                words: match spec.kind {
                    Kind::Choice(words) => words,
                    _ => &[],
                },
            },
            Value::File(name) | Value::Name(Name(name)) => Self::Word(name.clone()),
        }
    }
}

impl Support {
    /// The keys of the support that assemblies read, for a block of wood of this mass \[kg\] on it.
    pub fn keys(&self, mass: f64) -> impl Iterator<Item = (String, KeyValue)> {
        let keys = [
            ("support.stiffness", self.stiffness, STIFFNESS),
            ("support.damping", self.dashpot(mass), DAMPING),
            ("support.damping_ratio", self.damping_ratio(mass), NUMBER),
        ];
        let keys = keys.into_iter();
        keys.map(|(path, si, dimension)| (path.to_owned(), KeyValue::Quantity { si, dimension }))
    }
}

/// Provides the values of keys by their full names: those of a design, and those that replace a literal of an assembly.
pub trait Keys {
    /// The value of `path` (`piston.bore`, or `cycle.volume.gas.dead` for a literal), if there is one.
    fn value(&self, path: &str) -> Option<KeyValue>;
    /// All full names, for suggestions in messages.
    fn names(&self) -> Vec<String>;
}

impl Keys for BTreeMap<String, KeyValue> {
    fn value(&self, path: &str) -> Option<KeyValue> {
        self.get(path).cloned()
    }

    fn names(&self) -> Vec<String> {
        self.keys().cloned().collect()
    }
}

impl Parameters {
    /// Values of all keys of the cycle, including `support.stiffness`, `support.damping` and `support.damping_ratio` of
    /// the support in use, the muffler's kind and area, and the share of friction in the resistance.
    pub fn keys(&self) -> BTreeMap<String, KeyValue> {
        let mut keys = BTreeMap::new();
        self.visit(&mut |path, spec, value| {
            keys.insert(path.to_owned(), KeyValue::of(spec, &value));
        });
        keys.extend(self.support.keys(self.workpiece.mass(self.wood.density)));
        let word = if self.muffler_area.is_some() { "given" } else { "none" };
        let words = &["given", "none"];
        keys.insert("exhaust.muffler.kind".to_owned(), KeyValue::Choice { word, words });
        let area = KeyValue::Quantity {
            si: self.muffler_area.unwrap_or(0.0),
            dimension: AREA,
        };
        keys.insert("exhaust.muffler.flow_area".to_owned(), area);
        let coefficient = KeyValue::Quantity {
            si: self.exhaust.coefficient(&self.chambers),
            dimension: NUMBER,
        };
        keys.insert("exhaust.discharge_coefficient".to_owned(), coefficient);
        let share = KeyValue::Quantity {
            si: self.friction_share,
            dimension: NUMBER,
        };
        keys.insert("wood.friction_share".to_owned(), share);
        keys
    }
}

/// Groups whose keys every assembly may use without declaring them.
const STANDARD: [(&str, &GroupSpec); 14] = [
    ("supply", &Supply::SPEC),
    ("piston", &Piston::SPEC),
    ("head_valve", &HeadValve::SPEC),
    ("chambers", &Chambers::SPEC),
    ("exhaust", &Exhaust::SPEC),
    ("trigger", &Trigger::SPEC),
    ("nail", &Nail::SPEC),
    ("wood", &NailedWood::SPEC),
    ("workpiece", &Block::SPEC),
    ("contacts", &Contacts::SPEC),
    ("tool", &Tool::SPEC),
    ("hand", &Hand::SPEC),
    ("ambient", &Ambient::SPEC),
    ("model", &Model::SPEC),
];

/// The declaration of a standard key.
pub(super) fn standard(path: &str) -> Option<&'static KeySpec> {
    let mut names = path.split('.');
    let first = names.next()?;
    let mut group = STANDARD
        .iter()
        .find(|(name, _)| *name == first)
        .map(|(_, group)| *group)?;
    let mut names = names.peekable();
    while let Some(name) = names.next() {
        if names.peek().is_none() {
            return group.key(name);
        }
        group = group.group(name)?;
    }
    None
}
