//! The JSON schema of the design file accepts every shipped design and assembly, and refuses the files that the reader
//! refuses.

use std::fs;
use std::path::{Path, PathBuf};

use nailnoise::design::json_schema;
use nailnoise_dynamics::network::{BUILT_IN, CYCLE, FieldType};
use serde_json::{Value, json};

use crate::common::ROOT;

/// First keyword of a schema that a value does not satisfy, with the path of the value. It knows the keywords that the
/// schema of designs uses, except `pattern`.
fn violation(root: &Value, schema: &Value, value: &Value, path: &str) -> Option<String> {
    let Value::Object(keywords) = schema else {
        return (*schema == json!(false)).then(|| format!("{path}: nothing is allowed"));
    };
    let check = |schema: &Value| violation(root, schema, value, path);
    let wrong = |what: &str| Some(format!("{path}: {what}: {value}"));
    let inner = |schema: &Value, value: &Value, name: &str| violation(root, schema, value, &format!("{path}.{name}"));
    for (keyword, expected) in keywords {
        let found = match keyword.as_str() {
            "$ref" => {
                let name = expected.as_str().unwrap().replace("%20", " ");
                let target = root.pointer(name.strip_prefix('#').unwrap()).unwrap();
                check(target)
            }
            "type" => {
                let types = match expected {
                    Value::Array(types) => types.clone(),
                    one => vec![one.clone()],
                };
                let is = |of: &Value| match of.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "number" => value.is_number(),
                    "integer" => value.is_i64() || value.is_u64(),
                    other => panic!("type {other}"),
                };
                (!types.iter().any(is)).then(|| format!("{path}: is no {expected}: {value}"))
            }
            "enum" => match expected.as_array().unwrap().contains(value) {
                true => None,
                false => wrong("is none of the words"),
            },
            "const" => match expected
                .as_f64()
                .zip(value.as_f64())
                .map_or(expected == value, |(a, b)| a == b)
            {
                true => None,
                false => wrong("has another value"),
            },
            "anyOf" => {
                let found: Vec<Option<String>> = expected.as_array().unwrap().iter().map(check).collect();
                match found.iter().any(Option::is_none) {
                    true => None,
                    false => found.into_iter().flatten().max_by_key(|found| found.find(':')),
                }
            }
            "if" => match (check(expected), keywords.get("then"), keywords.get("else")) {
                (None, Some(then), _) => check(then),
                (Some(_), _, Some(other)) => check(other),
                _ => None,
            },
            "required" => {
                let names = expected.as_array().unwrap().iter();
                let absent = names
                    .map(|name| name.as_str().unwrap())
                    .find(|name| value.get(name).is_none());
                absent.and_then(|name| wrong(&format!("has no `{name}`")))
            }
            "properties" => value.as_object().and_then(|own| {
                let known = expected.as_object().unwrap();
                own.iter()
                    .find_map(|(name, value)| inner(known.get(name)?, value, name))
            }),
            "additionalProperties" => value.as_object().and_then(|own| {
                let known = keywords.get("properties").and_then(Value::as_object);
                let others = own
                    .iter()
                    .filter(|(name, _)| known.is_none_or(|known| !known.contains_key(*name)));
                others
                    .map(|(name, value)| inner(expected, value, name))
                    .find_map(|found| found)
            }),
            "propertyNames" => value.as_object().and_then(|own| {
                let mut names = own.keys();
                names.find_map(|name| inner(expected, &json!(name), name))
            }),
            "items" => value.as_array().and_then(|own| {
                let first = keywords
                    .get("prefixItems")
                    .and_then(Value::as_array)
                    .map_or(0, Vec::len);
                own.iter().skip(first).find_map(|item| inner(expected, item, "item"))
            }),
            "prefixItems" => value.as_array().and_then(|own| {
                let mut pairs = own.iter().zip(expected.as_array().unwrap());
                pairs.find_map(|(item, schema)| inner(schema, item, "item"))
            }),
            "minItems" => match value
                .as_array()
                .is_none_or(|own| own.len() as u64 >= expected.as_u64().unwrap())
            {
                true => None,
                false => wrong("has too few items"),
            },
            "maxItems" => match value
                .as_array()
                .is_none_or(|own| own.len() as u64 <= expected.as_u64().unwrap())
            {
                true => None,
                false => wrong("has too many items"),
            },
            "minimum" => match value.as_f64().is_none_or(|own| own >= expected.as_f64().unwrap()) {
                true => None,
                false => wrong("is too small"),
            },
            "maximum" => match value.as_f64().is_none_or(|own| own <= expected.as_f64().unwrap()) {
                true => None,
                false => wrong("is too large"),
            },
            // The one pattern that decides between a word and a formula.
            "pattern" if expected == "^\\s*=" => {
                let is_formula = value.as_str().is_none_or(|text| text.trim_start().starts_with('='));
                (!is_formula).then(|| format!("{path}: is no formula: {value}"))
            }
            "then" | "else" | "pattern" | "description" | "title" | "$schema" | "$defs" => None,
            other => panic!("keyword {other} in {path}"),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

/// The part of a file that the schema refuses; nothing if it accepts the file.
fn refused(text: &str) -> Option<String> {
    let schema = json_schema();
    let value: toml::Table = toml::from_str(text).unwrap();
    violation(&schema, &schema, &serde_json::to_value(value).unwrap(), "file")
}

/// All files with this extension in a folder and the folders within it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| match path.is_dir() {
        true => files(&path),
        false => vec![path],
    };
    let all = entries.flat_map(of);
    all.filter(|path| path.extension().is_some_and(|own| own == "toml"))
        .collect()
}

#[test]
fn the_schema_accepts_every_assembly_that_comes_with_the_program() {
    for (name, text) in BUILT_IN {
        assert_eq!(refused(text), None, "{name}");
    }
    let all_blocks = fs::read_to_string(Path::new(ROOT).join("dynamics/tests/network/everything.toml")).unwrap();
    assert_eq!(refused(&all_blocks), None);
}

#[test]
fn the_schema_accepts_every_shipped_design() {
    let designs: Vec<PathBuf> = files(&Path::new(ROOT).join("designs"))
        .into_iter()
        .filter(|path| {
            !["measured", "site"]
                .iter()
                .any(|other| path.iter().any(|part| part == *other))
        })
        .collect();
    assert!(designs.len() > 12, "{designs:?}");
    for path in designs {
        assert_eq!(refused(&fs::read_to_string(&path).unwrap()), None, "{}", path.display());
    }
}

#[test]
fn the_schema_refuses_names_types_and_words_that_the_reader_refuses() {
    for (text, part) in [
        ("[cycle.volum.vessel]\ndead = \"200 cm3\"", "file.cycle.volum:"),
        (
            "[cycle.volume.vessel]\nded = \"200 cm3\"",
            "file.cycle.volume.vessel.ded:",
        ),
        ("[cycle.volume.vessel]\ndead = 200", "file.cycle.volume.vessel.dead"),
        (
            "[cycle.volume.vessel]\ndead = { value = \"1 l\", rnge = \"1 .. 2 l\" }",
            "rnge",
        ),
        (
            "[cycle.contact.bumper]\nacts = { onn = \"piston\" }",
            "file.cycle.contact.bumper.acts.onn:",
        ),
        (
            "[cycle.contact.bumper]\nstop = \"left\"",
            "file.cycle.contact.bumper.stop",
        ),
        (
            "[cycle.passage.valve]\nbetween = \"hose\"",
            "file.cycle.passage.valve.between",
        ),
        ("[cycle.passage.valve]\nseat = { boddy = \"piston\" }", "boddy"),
        (
            "[cycle.trigger.pulled]\nschedule = [[\"1 ms\"]]",
            "file.cycle.trigger.pulled.schedule",
        ),
        ("[cycle]\nschema = 2", "file.cycle.schema"),
        ("[pistn]\nmass = \"131 g\"", "file.pistn:"),
        ("[piston]\nmas = \"131 g\"", "file.piston.mas:"),
        ("[study]\nrequire = \"flies\"", "file.study.require"),
    ] {
        let found = refused(text).unwrap_or_else(|| panic!("accepted: {text}"));
        assert!(found.contains(part), "{text}\n  {found}\n  lacks: {part}");
    }
}

#[test]
fn a_design_with_an_assembly_may_give_values_of_its_keys() {
    let own = "[staple]\nlength = { value = \"12 mm\", range = \"6 .. 14 mm\" }\n[nail]\nforce = \"500 N\"\n";
    assert!(refused(own).is_some());
    assert_eq!(refused(&format!("{own}[cycle]\nassembly = \"stapler\"")), None);
}

/// The page lists the fields of every block.
#[test]
fn the_page_of_assemblies_names_every_field() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/another-tool.md")).unwrap();
    for family in CYCLE.fields {
        let FieldType::Blocks(block) = &family.of else { continue };
        if block.fields.is_empty() {
            continue;
        }
        let line = page
            .lines()
            .find(|line| line.starts_with(&format!("| {} |", family.name)));
        let line = line.unwrap_or_else(|| panic!("the page lacks {}", family.name));
        let words: Vec<&str> = line.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
        for field in block.fields {
            assert!(words.contains(&field.name), "{}.{} in {line}", family.name, field.name);
        }
    }
}
