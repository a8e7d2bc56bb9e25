//! A tool whose values are known, and the rated pressures of all tools.

use super::fastener::Fastener;
use super::rules::Class;
use crate::design::length_in_words;
use crate::wording::trimmed;

/// Rated gauge pressures of all tool classes \[Pa\]: 70 to 120 psig, as for the N80CB.
pub const RATED: [f64; 2] = [70.0 * PSI, 120.0 * PSI];

/// Pound-force per square inch \[Pa\].
pub const PSI: f64 = 6_894.757_293_168;

/// A value, either given or taken from the class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chosen {
    /// The value in SI units.
    pub(crate) value: f64,
    /// Whether it was given.
    pub(crate) given: bool,
}

/// A tool whose values are known.
#[derive(Debug, Clone)]
pub(crate) struct Tool<'a> {
    pub(crate) name: &'a str,
    pub(crate) class: &'a Class,
    pub(crate) base: &'static str,
    pub(crate) bore: Chosen,
    pub(crate) stroke: Chosen,
    pub(crate) mass: Chosen,
    pub(crate) fastener: Fastener,
}

impl Tool<'_> {
    /// Description, such as "finish-nailer of 38 mm bore, 95 mm stroke and 1.2 kg".
    pub(super) fn words(&self) -> String {
        let [bore, stroke] = [self.bore, self.stroke].map(|chosen| length_in_words(chosen.value));
        let mass = trimmed(self.mass.value, 3);
        format!("{} of {bore} bore, {stroke} stroke and {mass} kg", self.name)
    }
}
