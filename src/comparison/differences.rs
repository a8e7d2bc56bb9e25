//! Inputs of designs that differ: values of keys, and fields and blocks of their assemblies.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nailnoise_dynamics::network::{AssemblyText, CYCLE, FieldText, FieldType};
use nailnoise_quantities::rounded;
use serde::Serialize;
use serde_json::Value;

use super::finished::{Finished, in_order};
use crate::wording::readable_at;

/// Significant digits of the numbers in the text of a block.
const DIGITS: usize = 6;

/// The assembly to which the keys of a design without one belong.
const OF_KEYS: &str = "n80cb";

/// A key, or a field or block of an assembly, whose values differ.
#[derive(Debug, Clone, Serialize)]
pub struct InputRow {
    /// Its full name.
    pub key: String,
    /// Unit of its values; empty if they have none.
    pub unit: String,
    /// Its values, those of formulas and blocks as text; null if a design does not have the key.
    pub values: Vec<Value>,
}

/// Fields and values of a design.
struct Subject<'a> {
    result: &'a Finished,
    /// Fields that are text.
    fields: Cow<'a, BTreeMap<String, String>>,
    /// Numbers of the assembly of the keys, which the result of a design without an assembly does not list.
    numbers: BTreeMap<String, f64>,
}

impl<'a> Subject<'a> {
    /// A design. Its assembly is that of its keys if it gives none and another design gives one.
    fn new(result: &'a Finished, keys: &[FieldText]) -> Self {
        if !result.assembly.is_empty() || keys.is_empty() {
            return Self {
                result,
                fields: Cow::Borrowed(&result.assembly),
                numbers: BTreeMap::new(),
            };
        }
        let texts = keys.iter().map(|field| (field.path.clone(), field.text.clone()));
        let numbers = keys
            .iter()
            .filter_map(|field| Some((field.path.clone(), field.number()?)));
        Self {
            result,
            fields: Cow::Owned(texts.collect()),
            numbers: numbers.collect(),
        }
    }

    fn number(&self, key: &str) -> Option<Value> {
        let input = self.result.inputs.iter().find(|input| input.key == key);
        let own = || self.numbers.get(key).map(|number| (*number).into());
        input.map(|input| input.value.clone()).or_else(own)
    }

    /// The value of a key. For a number of the assembly of the keys, it is the text, unless another design gives a
    /// number.
    fn value(&self, key: &str, numeric: bool) -> Value {
        let text = || self.fields.get(key).map(|text| Value::String(text.clone()));
        let found = match numeric {
            true => self.number(key).or_else(text),
            false => text(),
        };
        let default = || (is_switch(key) && self.has(block(key)?)).then(|| Value::String("false".to_owned()));
        found.or_else(default).unwrap_or(Value::Null)
    }

    fn keys(&self) -> impl Iterator<Item = &str> {
        let inputs = self.result.inputs.iter().map(|input| input.key.as_str());
        inputs.chain(self.fields.keys().map(String::as_str))
    }

    /// Whether it has a block.
    fn has(&self, block: &str) -> bool {
        self.keys().any(|key| in_block(key, block))
    }

    /// Fields of a block as text; null if it has none of them.
    fn fields_of(&self, block: &str) -> Value {
        let mut fields = BTreeMap::new();
        for (path, text) in self.fields.iter().filter(|(path, _)| in_block(path, block)) {
            fields.insert(&path[block.len() + 1..], text.clone());
        }
        for input in self.result.inputs.iter().filter(|input| in_block(&input.key, block)) {
            let value = match input.value.as_f64() {
                Some(number) => {
                    let (unit, factor) = readable_at(&input.unit, number);
                    format!("{} {unit}", rounded(factor * number, DIGITS, 1e7))
                }
                None => input.value.to_string(),
            };
            fields.insert(&input.key[block.len() + 1..], value.trim_end().to_owned());
        }
        if fields.is_empty() {
            return Value::Null;
        }
        let fields: Vec<String> = fields.iter().map(|(name, text)| format!("{name} {text}")).collect();
        Value::String(fields.join(", "))
    }
}

/// Keys, fields and blocks that differ, in the order of the inputs.
pub(super) fn inputs(results: &[Finished]) -> Vec<InputRow> {
    let comparable = without_assembly(results).is_empty();
    let assembled = comparable && results.iter().any(|result| !result.assembly.is_empty());
    let keyed = AssemblyText::built_in(OF_KEYS)
        .filter(|_| assembled)
        .and_then(Result::ok);
    let keyed = keyed.map(|text| text.fields()).unwrap_or_default();
    let of_key = |path: &str| {
        results
            .iter()
            .any(|result| result.inputs.iter().any(|own| own.key == path))
    };
    let subjects: Vec<Subject<'_>> = results.iter().map(|result| Subject::new(result, &keyed)).collect();
    let mut names = in_order(results, |r| r.inputs.iter().map(|input| input.key.clone()).collect());
    if comparable {
        for name in subjects.iter().flat_map(|subject| subject.fields.keys()) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
    }
    let mut rows: Vec<InputRow> = Vec::new();
    for name in names {
        let lacking = block(&name).filter(|block| comparable && subjects.iter().any(|subject| !subject.has(block)));
        let row = match lacking {
            Some(block) if rows.iter().any(|row| row.key == block) => continue,
            Some(block) => InputRow {
                key: block.to_owned(),
                unit: String::new(),
                values: subjects.iter().map(|subject| subject.fields_of(block)).collect(),
            },
            None => {
                let numeric = of_key(&name);
                InputRow {
                    unit: unit(results, &name),
                    values: subjects.iter().map(|subject| subject.value(&name, numeric)).collect(),
                    key: name,
                }
            }
        };
        if row.values.iter().any(|value| *value != row.values[0]) {
            rows.push(row);
        }
    }
    rows
}

/// Unit of a key; empty if it has none.
fn unit(results: &[Finished], key: &str) -> String {
    let mut inputs = results.iter().flat_map(|result| &result.inputs);
    let found = inputs.find(|input| input.key == key);
    found.map_or_else(String::new, |input| input.unit.clone())
}

/// Names of the results of an earlier version that have numbers of an assembly but not its text.
pub(super) fn without_assembly(results: &[Finished]) -> Vec<String> {
    let of_assembly = |result: &&Finished| result.inputs.iter().any(|input| input.key.starts_with("cycle."));
    let lacking = results
        .iter()
        .filter(|result| result.assembly.is_empty())
        .filter(of_assembly);
    lacking.map(|result| result.design.name.clone()).collect()
}

/// That blocks, formulas and switches are not compared.
pub(super) fn warning(names: &[String]) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "blocks, formulas and switches of the assemblies are not compared: the result of {} is of an earlier \
             version and lists only the numbers. Run it again",
            names.join(", ")
        )
    })
}

/// The block of a field, `cycle.passage.vent` of `cycle.passage.vent.one_way`; none for a field without a block.
fn block(path: &str) -> Option<&str> {
    let family = path.strip_prefix("cycle.")?.split('.').next()?;
    let FieldType::Blocks(_) = CYCLE.field(family)?.of else {
        return None;
    };
    let mut dots = path.match_indices('.').map(|(at, _)| at);
    Some(&path[..dots.nth(2)?])
}

fn in_block(path: &str, block: &str) -> bool {
    path.strip_prefix(block).is_some_and(|rest| rest.starts_with('.'))
}

/// Whether a field is a switch of a block. A switch that is not given is off.
fn is_switch(path: &str) -> bool {
    let mut parts = path.split('.').skip(1);
    let (Some(family), Some(_), Some(field), None) = (parts.next(), parts.next(), parts.next(), parts.next()) else {
        return false;
    };
    let Some(FieldType::Blocks(table)) = CYCLE.field(family).map(|family| &family.of) else {
        return false;
    };
    table
        .field(field)
        .is_some_and(|field| matches!(field.of, FieldType::Flag))
}
