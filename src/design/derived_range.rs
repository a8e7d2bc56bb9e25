//! Ranges of derived quantities: a study may draw one instead of the primary quantity that follows from it.
//!
//! ```toml
//! exhaust.area = { range = "100 .. 1000 mm2", distribution = "log-uniform", follows = "hole_diameter" }
//! ```
//!
//! The file closest to the design takes precedence: a range of the follower in a closer file removes that of the
//! derived quantity, and vice versa. If primary quantities are given new values without a range, the range is scaled in
//! proportion (`range.rs`).

use std::collections::HashMap;

use nailnoise_quantities::{Value, positive};

use super::Entry;
use super::derived::{Derived, Solution};
use super::distribution::Distribution;
use super::error::{DesignError, Problem};
use super::groups::Values;
use super::merged::Merged;
use super::provenance::Provenance;
use super::range::{DefaultRange, GivenRange, Ranged, includes, inherited};
use super::settings::{Given, GivenDerived};
use super::show::show;
use nailnoise_documents::Place;

/// A derived quantity that a study draws.
#[derive(Debug, Clone)]
pub(crate) struct DerivedRange {
    derived: &'static Derived,
    pub(super) solution: &'static Solution,
    ranged: Ranged,
    distribution: Distribution,
    provenance: Provenance,
    source: String,
    note: String,
    place: Box<Place>,
}

impl DerivedRange {
    /// Its entry in a design with these values.
    pub(super) fn entry(&self, values: &Values) -> Entry {
        Entry {
            key: self.derived.key.to_owned(),
            symbol: self.derived.symbol,
            value: Value::Number((self.derived.value)(values)),
            unit: self.derived.dimension.unit(),
            range: Some(self.ranged.range),
            range_origin: Some(self.ranged.origin),
            distribution: self.distribution,
            provenance: self.provenance,
            source: self.source.clone(),
            note: self.note.clone(),
            file: self.place.file().to_owned(),
            line: self.place.line(),
        }
    }
}

/// Ranges of derived quantities given so far by the files.
#[derive(Debug, Default)]
pub(crate) struct MergedDerived {
    found: Vec<Draft>,
}

#[derive(Debug)]
struct Draft {
    given: GivenDerived,
    range: GivenRange,
    place: Box<Place>,
    solution: &'static Solution,
    /// Values of the primary quantities in the file that gives the range.
    primaries: Vec<(&'static str, Given)>,
}

impl MergedDerived {
    /// Whether a study draws this derived quantity.
    pub(crate) fn draws(&self, key: &str) -> bool {
        self.found.iter().any(|own| own.given.derived.key == key)
    }

    /// Removes a derived quantity whose follower has a range in a closer file.
    pub(crate) fn drop_of_follower(&mut self, follower: &str) {
        self.found.retain(|own| own.solution.follower != follower);
    }

    /// Adds the ranges of one file, after its other settings are merged. The same file gives a range for the keys in
    /// `ranged`.
    ///
    /// # Errors
    /// If a derived quantity has no follower, or its follower has a range in the same file.
    pub(crate) fn take(
        &mut self,
        given: GivenDerived,
        merged: &mut HashMap<String, Merged>,
        ranged: &[String],
    ) -> Result<(), DesignError> {
        let key = given.derived.key;
        let Some((range, place)) = given.range.clone() else {
            return Ok(());
        };
        let solution = given.solution("a range", &place)?;
        if ranged.iter().any(|key| key == solution.follower) {
            return Err(Problem::WrongKind {
                key: solution.follower.to_owned(),
                found: "a range".to_owned(),
                expected: format!("without a range: it follows from `{key}`, which has one in the same file"),
            }
            .at(place));
        }
        if let Some(follower) = merged.get_mut(solution.follower) {
            follower.forget_range();
        }
        let primaries = given.derived.primaries.iter();
        let primaries = primaries.filter_map(|primary| Some((*primary, merged.get(*primary)?.given()?)));
        let primaries = primaries.collect();
        self.found.retain(|own| own.given.derived.key != key);
        self.found.push(Draft {
            given,
            range,
            place,
            solution,
            primaries,
        });
        Ok(())
    }

    /// The derived quantities of a design with these values.
    ///
    /// # Errors
    /// If a range excludes the value given by the same file, or a distribution is not compatible with the range.
    pub(crate) fn resolved(
        self,
        values: &Values,
        default: DefaultRange,
        ambient: f64,
    ) -> Result<Vec<DerivedRange>, DesignError> {
        let resolved = |draft: Draft| {
            let derived = draft.given.derived;
            let mut base = values.clone();
            let absolute = |given: &Given| match given {
                Given::Quantity(measured) => Value::Number(measured.absolute(ambient)),
                Given::Other(value) => value.clone(),
            };
            let primaries: Vec<_> = draft
                .primaries
                .iter()
                .map(|(key, given)| (*key, absolute(given)))
                .collect();
            // Values in the files of the chain have the kinds of their keys.
            let _ = base.set(&primaries);
            if let Some((value, _)) = &draft.given.value {
                // As in the design, a number of holes is rounded.
                let _ = base.set(&[(draft.solution.change, Value::Number(value.si))]);
            }
            let [own, base] = [values, &base].map(|values| (derived.value)(values));
            let range = draft.range.of(base, ambient);
            let [low, high] = range.map(|end| show(end, derived.dimension));
            if range[0] > range[1] {
                let key = derived.key.to_owned();
                return Err(Problem::BadRange { key, low, high }.at(draft.place));
            }
            let ranged = inherited(own, (base, range), default, positive(derived.dimension).domain());
            if !includes(ranged.range, own) {
                return Err(Problem::RangeWithoutValue {
                    key: derived.key.to_owned(),
                    value: show(own, derived.dimension),
                    low,
                    high,
                }
                .at(draft.place));
            }
            let distribution = draft.given.distribution.clone();
            if let Some((distribution, at)) = &distribution
                && let Some(because) = distribution.problem(own, ranged.range)
            {
                return Err(Problem::BadDistribution {
                    key: derived.key.to_owned(),
                    distribution: distribution.as_str(),
                    because,
                }
                .at(at.clone()));
            }
            let (provenance, source) = draft
                .given
                .provenance
                .clone()
                .unwrap_or((Provenance::Design, String::new()));
            Ok(DerivedRange {
                derived,
                solution: draft.solution,
                ranged,
                distribution: distribution.map_or_else(Distribution::default, |(distribution, _)| distribution),
                provenance,
                source,
                note: draft.given.note.clone().unwrap_or_default(),
                place: draft.place,
            })
        };
        self.found.into_iter().map(resolved).collect()
    }
}
