//! Woods, nails and worktables by name: which keys are set by `wood.species`, `nail.kind` and
//! `support.worktable.preset`.
//!
//! The values are fragments of design files embedded in the program (`woods.toml`, `nails.toml`, `worktables.toml`),
//! each with range and provenance. An entry may take the values of another (`like`) and give only those that differ. A
//! name replaces the values that bases of the file give to these keys. A key given together with the name, in the same
//! file or on the same command line, takes precedence over it. The combination of wood and shank determines the
//! penetration law and its share of friction (`pairs.toml`).

mod names;

use std::path::Path;

use nailnoise_quantities::{Group as _, Value};
use toml::de::{DeTable, DeValue};

use super::assembly::AssemblyKeys;
use super::error::DesignError;
use super::groups::Values;
use super::settings::{Given, Layer, Setting};
use super::source::File;
use nailnoise_documents::Place;

pub use names::{NailKind, Species, WorktablePreset};

/// Keys whose value is a name.
const SPECIES: &str = "wood.species";
const KIND: &str = "nail.kind";
const PRESET: &str = "support.worktable.preset";

/// The name for values without a catalogue name.
const OWN: &str = "own";

/// A file of names with the settings of each.
struct Catalogue {
    file: &'static str,
    text: &'static str,
    /// The key, in addition to `sets`, by which combinations are looked up.
    sort: &'static str,
}

const WOODS: Catalogue = Catalogue {
    file: "woods.toml of nailnoise",
    text: include_str!("woods.toml"),
    sort: "class",
};

const NAILS: Catalogue = Catalogue {
    file: "nails.toml of nailnoise",
    text: include_str!("nails.toml"),
    sort: "shank",
};

const WORKTABLES: Catalogue = Catalogue {
    file: "worktables.toml of nailnoise",
    text: include_str!("worktables.toml"),
    sort: "what",
};

const PAIRS: Catalogue = Catalogue {
    file: "pairs.toml of nailnoise",
    text: include_str!("pairs.toml"),
    sort: "",
};

/// Properties of a name.
#[derive(Debug, Default)]
struct Meaning {
    /// Class of a wood, shank of a nail, a worktable in words.
    sort: String,
    /// How a tool feeds a nail; empty for a wood.
    magazine: String,
    sets: Vec<Setting>,
}

impl Catalogue {
    /// Meaning under a path of tables; empty if there is none.
    fn meaning(&self, path: &[&str]) -> Result<Meaning, DesignError> {
        let file = File::new(Path::new(self.file), self.text);
        let root = file.table()?;
        let mut table: &DeTable<'_> = &root;
        for name in path {
            match table.get(*name).map(|value| value.get_ref()) {
                Some(DeValue::Table(inner)) => table = inner,
                _ => return Ok(Meaning::default()),
            }
        }
        let text = |key: &str| table.get(key).and_then(|value| value.get_ref().as_str());
        let own = match table.get("sets").map(|value| value.get_ref()) {
            Some(DeValue::Table(sets)) => Layer::read(&file, sets, &Values::SPEC, &AssemblyKeys::default())?.settings,
            _ => Vec::new(),
        };
        let mut sets = match text("like") {
            Some(other) => self.meaning(&[other])?.sets,
            None => Vec::new(),
        };
        for setting in own {
            match sets.iter_mut().find(|other| other.key == setting.key) {
                Some(other) => *other = setting,
                None => sets.push(setting),
            }
        }
        Ok(Meaning {
            sort: text(self.sort).unwrap_or_default().to_owned(),
            magazine: text("magazine").unwrap_or_default().to_owned(),
            sets,
        })
    }
}

/// The names given so far by a chain of files.
#[derive(Debug, Clone)]
pub(crate) struct Names {
    /// Class of the wood; none until it is named.
    class: Option<String>,
    shank: String,
}

impl Default for Names {
    fn default() -> Self {
        Self {
            class: None,
            shank: OWN.to_owned(),
        }
    }
}

impl Names {
    /// Expands the names in a file's settings; the resulting settings precede the file's other settings.
    ///
    /// Wood and shank set their common keys only if one of them changes, so a law from the user's tests remains for
    /// another nail with the same shank.
    ///
    /// # Errors
    /// Cannot occur with a tested catalogue.
    pub(crate) fn expand(&mut self, settings: &[&Setting]) -> Result<Vec<Setting>, DesignError> {
        let mut sets = Vec::new();
        for (name, meaning) in self.meanings(|key| named(settings, key).map(|(word, _)| word))? {
            let Some((_, at)) = named(settings, name) else { continue };
            sets.extend(meaning.into_iter().map(|setting| placed(setting, at)));
        }
        Ok(sets)
    }

    /// Values, with the settings of names among them added; explicit values take precedence over names.
    ///
    /// # Errors
    /// Cannot occur with a tested catalogue.
    pub(super) fn with_values(&self, values: Vec<(String, Value)>) -> Result<Vec<(String, Value)>, DesignError> {
        let word = |key: &str| match values.iter().find(|(own, _)| own == key) {
            Some((_, Value::Choice(word))) => Some(*word),
            _ => None,
        };
        let meanings = self.clone().meanings(word)?;
        let sets = meanings.into_iter().flat_map(|(_, sets)| sets);
        let mut all: Vec<(String, Value)> = sets.filter_map(value_of).map(|own| (own.key, own.value)).collect();
        all.retain(|(key, _)| !values.iter().any(|(own, _)| own == key));
        all.extend(values);
        Ok(all)
    }

    /// Settings of the `word` of each key whose value is a name, and those of wood and nail together under the last of
    /// the two keys.
    fn meanings<'w>(
        &mut self,
        word: impl Fn(&str) -> Option<&'w str>,
    ) -> Result<Vec<(&'static str, Vec<Setting>)>, DesignError> {
        let [species, kind] = [SPECIES, KIND].map(&word);
        let before = (self.class.clone(), self.shank.clone());
        let mut sets = Vec::new();
        if let Some(word) = species {
            let meaning = WOODS.meaning(&[word])?;
            self.class = (word != OWN).then_some(meaning.sort);
            sets.push((SPECIES, meaning.sets));
        }
        if let Some(word) = kind {
            let meaning = NAILS.meaning(&[word])?;
            self.shank = if word == OWN { OWN.to_owned() } else { meaning.sort };
            sets.push((KIND, meaning.sets));
        }
        if let Some(class) = &self.class
            && before != (self.class.clone(), self.shank.clone())
        {
            let pair = PAIRS.meaning(&[class, &self.shank])?;
            sets.push((if kind.is_some() { KIND } else { SPECIES }, pair.sets));
        }
        if let Some(word) = word(PRESET) {
            sets.push((PRESET, WORKTABLES.meaning(&[word])?.sets));
        }
        Ok(sets)
    }
}

/// The last name that settings give for a key, and where.
fn named<'a>(settings: &[&'a Setting], key: &str) -> Option<(&'static str, &'a Place)> {
    settings
        .iter()
        .rev()
        .find(|setting| setting.key == key)
        .and_then(|setting| {
            let (given, _, at) = setting.value.as_ref()?;
            match given {
                Given::Other(Value::Choice(word)) => Some((*word, &**at)),
                _ => None,
            }
        })
}

/// A catalogue setting located at the place of its name, for errors and warnings.
fn placed(mut setting: Setting, at: &Place) -> Setting {
    if let Some((.., own)) = &mut setting.value {
        **own = at.clone();
    }
    if let Some((_, own)) = &mut setting.range {
        **own = at.clone();
    }
    setting
}

/// One value set by a name, for lists.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct NamedValue {
    /// Full name of the key.
    pub key: String,
    /// Symbol in the field; empty if there is none.
    pub symbol: &'static str,
    /// The value, quantities in SI units.
    pub value: Value,
    /// SI unit; empty for plain numbers and choices.
    pub unit: String,
    /// Range of plausible values, in SI units.
    pub range: Option<[f64; 2]>,
    /// Origin of the values.
    pub provenance: super::Provenance,
    /// The source in words; may be empty.
    pub source: String,
}

/// A name and everything that it sets, for lists.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Named {
    /// The word for the design file.
    pub name: &'static str,
    /// Class of a wood (`solid`, `plywood`), shank of a nail (`smooth`, `annular`, `helical`, `slender`, `staple`), a
    /// worktable in words.
    pub sort: String,
    /// How a tool feeds a nail: from a `stick`, a `coil`, or either.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub magazine: String,
    /// Values that the name sets.
    pub sets: Vec<NamedValue>,
}

/// The woods that `wood.species` can name.
///
/// # Errors
/// Cannot occur with a tested catalogue.
pub fn woods() -> Result<Vec<Named>, DesignError> {
    listed(&WOODS, Species::WORDS)
}

/// The nails that `nail.kind` can name.
///
/// # Errors
/// Cannot occur with a tested catalogue.
pub fn nails() -> Result<Vec<Named>, DesignError> {
    listed(&NAILS, NailKind::WORDS)
}

/// The worktables that `support.worktable.preset` can name.
///
/// # Errors
/// Cannot occur with a tested catalogue.
pub fn worktables() -> Result<Vec<Named>, DesignError> {
    listed(&WORKTABLES, WorktablePreset::WORDS)
}

fn listed(catalogue: &Catalogue, words: &[&'static str]) -> Result<Vec<Named>, DesignError> {
    let of_word = |name: &&'static str| {
        let meaning = catalogue.meaning(&[name])?;
        Ok(Named {
            name,
            sort: meaning.sort,
            magazine: meaning.magazine,
            sets: meaning.sets.into_iter().filter_map(value_of).collect(),
        })
    };
    words.iter().filter(|word| **word != OWN).map(of_word).collect()
}

fn value_of(setting: Setting) -> Option<NamedValue> {
    let (given, ..) = setting.value?;
    let value = match given {
        Given::Quantity(measured) => Value::Number(measured.si),
        Given::Other(value) => value,
    };
    let (provenance, source) = setting.provenance?;
    Some(NamedValue {
        key: setting.key,
        symbol: setting.spec.symbol,
        value,
        unit: setting.spec.unit(),
        range: setting.range.and_then(|(range, _)| range.ends()),
        provenance,
        source,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Names of the tables of a catalogue.
    fn tables(catalogue: &Catalogue) -> Vec<String> {
        let file = File::new(Path::new(catalogue.file), catalogue.text);
        let table = file.table().unwrap();
        let mut names: Vec<String> = table.keys().map(|name| name.get_ref().to_string()).collect();
        names.sort();
        names
    }

    fn sorted(words: &[&str]) -> Vec<String> {
        let mut words: Vec<String> = words
            .iter()
            .filter(|word| **word != OWN)
            .map(|word| (*word).to_owned())
            .collect();
        words.sort();
        words
    }

    #[test]
    fn every_word_stands_in_the_catalogue_and_every_entry_has_a_word() {
        assert_eq!(tables(&WOODS), sorted(Species::WORDS));
        assert_eq!(tables(&NAILS), sorted(NailKind::WORDS));
        assert_eq!(tables(&WORKTABLES), sorted(WorktablePreset::WORDS));
    }

    #[test]
    fn every_value_has_provenance_and_lies_within_its_range() {
        let all = [woods(), nails(), worktables()].map(Result::unwrap);
        for named in all.into_iter().flatten() {
            assert!(named.sets.len() >= 4, "{}", named.name);
            for own in &named.sets {
                let stated = own.provenance == super::super::Provenance::Estimated || !own.source.is_empty();
                assert!(stated, "{}: {} has no source", named.name, own.key);
                if let (Value::Number(value), Some([low, high])) = (&own.value, own.range) {
                    assert!(low <= *value && *value <= high, "{}: {}", named.name, own.key);
                }
            }
        }
    }

    /// A design that names a table and has no base is complete.
    #[test]
    fn every_worktable_sets_the_same_keys() {
        let keys = |named: &Named| -> Vec<String> { named.sets.iter().map(|own| own.key.clone()).collect() };
        let tables = worktables().unwrap();
        for table in &tables {
            assert_eq!(keys(table), keys(&tables[0]), "{}", table.name);
        }
    }

    #[test]
    fn an_entry_like_another_takes_all_values_but_its_own() {
        let tables = worktables().unwrap();
        let [b, c] = [1, 2].map(|place: usize| &tables[place]);
        let differing: Vec<&str> = (b.sets.iter().zip(&c.sets))
            .filter(|(of_b, of_c)| of_b.value != of_c.value)
            .map(|(of_b, _)| of_b.key.as_str())
            .collect();
        assert_eq!(differing, ["support.worktable.top_thickness"]);
    }

    #[test]
    fn every_wood_has_the_same_keys_and_a_law_for_every_shank() {
        let keys = |named: &Named| -> Vec<String> {
            let own = named.sets.iter().map(|own| own.key.clone());
            own.filter(|key| key != "wood.driven").collect()
        };
        let woods = woods().unwrap();
        for wood in &woods {
            assert_eq!(keys(wood), keys(&woods[0]), "{}", wood.name);
            for shank in ["smooth", "annular", "helical", "slender", "staple", OWN] {
                assert_eq!(
                    PAIRS.meaning(&[&wood.sort, shank]).unwrap().sets.len(),
                    2,
                    "{}",
                    wood.name
                );
            }
        }
    }
}
