//! JSON schema of the design file for editors, made from the same declarations that read the file.

use nailnoise_quantities::{Group, GroupSpec, KeySpec, Kind};
use serde_json::{Map, Value, json};

use super::assembly_schema::Definitions;
use super::derived::{Derived, SOLUTIONS};
use super::distribution::Distribution;
use super::groups::Values;
use super::provenance::Provenance;
use super::report;
use super::study::SOURCES;
use super::tool_outcomes::outcomes;

/// A JSON Schema (draft 2020-12) of the design file: completion, descriptions and first checks in an editor that
/// supports TOML schemas. Only this program checks units and limits.
pub fn json_schema() -> Value {
    let mut root = group(&Values::SPEC);
    for solution in SOLUTIONS {
        if let Some((group, key)) = solution.key.split_once('.') {
            root["properties"][group]["properties"][key] = derived(solution.key);
        }
    }
    let mut properties = Map::from_iter([(
        "base".to_owned(),
        json!({"type": "string", "description": "The design to inherit from, relative to this file."}),
    )]);
    if let Some(Value::Object(own)) = root.get_mut("properties").map(Value::take) {
        properties.extend(own);
    }
    let mut of_assembly = Definitions::default();
    properties.insert("cycle".to_owned(), of_assembly.cycle());
    properties.insert("keys".to_owned(), of_assembly.keys());
    properties.insert("study".to_owned(), study());
    properties.insert("report".to_owned(), head_of_report());
    let provenances = Provenance::ALL.map(Provenance::as_str).join("|");
    root["properties"] = properties.into();
    // An assembly declares additional keys, in additional groups or in groups of the design. Without one, all names are
    // known.
    root["if"] = json!({"anyOf": [{"required": ["cycle"]}, {"required": ["keys"]}]});
    root["else"] = known_names(&root);
    root["else"]["properties"]["study"]["properties"]["require"] =
        requirement(&json!({"enum": outcomes().collect::<Vec<_>>()}));
    open(&mut root, &of_assembly.own_values());
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    root["title"] = json!("nailnoise design");
    let mut definitions = of_assembly.into_map();
    let Value::Object(common) = json!({
        "provenance": {"type": "string", "pattern": format!("^({provenances})(:.*)?$"),
                       "description": "published, computed, estimated, decided, numerical, constant or design; the \
                           source may follow a colon"},
        "range": {"description": "\"low .. high unit\", a list of two quantities, \"+-10 %\", \"+-2 mm\" \
            or \"exact\"", "anyOf": [
            {"type": "string", "pattern": "\\.\\.|^\\s*(\\+-|\u{b1})|^\\s*exact\\s*$"},
            {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 2, "maxItems": 2},
        ]},
    }) else {
        return root;
    };
    definitions.extend(common);
    root["$defs"] = definitions.into();
    root
}

/// The names that a group and the groups within it may have.
fn known_names(group: &Value) -> Value {
    let Value::Object(properties) = &group["properties"] else {
        // The members of a list have names of the user.
        return match &group["additionalProperties"] {
            member @ Value::Object(_) => json!({"additionalProperties": known_names(member)}),
            _ => json!({}),
        };
    };
    let groups = properties
        .iter()
        .filter(|(name, own)| own["properties"].is_object() && *name != "cycle");
    let groups: Map<_, _> = groups.map(|(name, own)| (name.clone(), known_names(own))).collect();
    let mut known = json!({"properties": groups});
    match &group["additionalProperties"] {
        Value::Bool(false) => known["propertyNames"] = json!({"enum": properties.keys().collect::<Vec<_>>()}),
        member => known["additionalProperties"] = known_names(member),
    }
    known
}

/// Allows further keys in a group of quantities and in the groups within it.
fn open(group: &mut Value, further: &Value) {
    let Value::Object(properties) = &mut group["properties"] else {
        return;
    };
    for (name, own) in properties {
        if own["properties"].is_object() && !["cycle", "study", "report"].contains(&name.as_str()) {
            open(own, further);
        }
    }
    if group["additionalProperties"] == json!(false) {
        group["additionalProperties"] = further.clone();
    }
}

/// Outcomes that a shot must have to count.
fn requirement(outcome: &Value) -> Value {
    json!({"description": "Outcomes of which a shot must have one to count: those of the tool.",
           "anyOf": [outcome, {"type": "array", "items": outcome}]})
}

/// A derived quantity that a study may draw.
fn derived(key: &str) -> Value {
    let description = Derived::find(key).map_or("", |derived| derived.description);
    let followers = SOLUTIONS.iter().filter(|own| own.key == key).map(|own| own.follower);
    let words: Vec<&str> = followers
        .flat_map(|name| [name, name.rsplit('.').next().unwrap_or(name)])
        .collect();
    json!({
        "description": format!("{description} It is computed; a study draws it from a range, and a primary quantity \
            follows."),
        "anyOf": [
            {"type": ["number", "string"]},
            {"type": "object", "additionalProperties": false, "properties": {
                "value": {"type": ["number", "string"]},
                "range": {"$ref": "#/$defs/range"},
                "distribution": {"enum": Distribution::ALL.map(Distribution::as_str)},
                "provenance": {"$ref": "#/$defs/provenance"},
                "note": {"type": "string"},
                "follows": {"enum": words},
            }},
        ],
    })
}

/// `[study]`, which contains no quantities of the design.
fn study() -> Value {
    let band = json!({"type": "string", "pattern": "^.*\\.\\..*dB\\s*$"});
    json!({
        "type": "object",
        "description": "Quantities that a study draws in addition to the ranges of the design, and shots that count.",
        "properties": {
            "require": requirement(&json!({"type": "string"})),
            "screening": {"type": "integer", "minimum": 0, "maximum": 8,
                          "description": "Draws of `nailnoise run` for a design without a study."},
            "default_range": {"type": "string", "pattern": "^\\s*(base|exact|(\\+-|\u{b1}).*%)\\s*$",
                              "description": "Range of values given without one, where a base states a range."},
            "draws": {"type": "string",
                      "description": "File with joint draws of keys, which `nailnoise calibrate` writes."},
            "alternatives": {"type": "object", "additionalProperties": {"type": ["object", "array"]},
                             "description": "Values of a key with weights, or a list of options of a group."},
            "model": {"type": "object", "properties": SOURCES.map(|source| (source.to_owned(), band.clone()))
                          .into_iter().collect::<Map<_, _>>(),
                      "additionalProperties": false,
                      "description": "Error of a source's method, in place of its own band."},
            "correlation": {"type": "array", "description": "Rank correlations between drawn quantities.",
                "items": {"type": "object", "additionalProperties": false, "required": ["keys", "rank"], "properties": {
                    "keys": {"type": "array", "items": {"type": "string"}, "minItems": 2},
                    "rank": {"type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 1},
                }}},
        },
        "additionalProperties": false,
    })
}

/// `[report]`, which contains no quantities of the design either.
fn head_of_report() -> Value {
    let text =
        |(key, description): (&str, &str)| (key.to_owned(), json!({"type": "string", "description": description}));
    json!({
        "type": "object",
        "description": "Texts in the head of the report in addition to the design. No result depends on them.",
        "properties": report::KEYS.into_iter().map(text).collect::<Map<_, _>>(),
        "additionalProperties": false,
    })
}

fn group(spec: &GroupSpec) -> Value {
    let keys = spec.keys().map(|spec| (spec.name.to_owned(), key(spec)));
    let groups = spec.groups.iter().map(|(name, spec)| ((*name).to_owned(), group(spec)));
    let lists = spec.lists.iter().map(|(name, spec)| {
        let members = json!({"type": "object", "description": spec.description(), "additionalProperties": group(spec)});
        ((*name).to_owned(), members)
    });
    let mut object = json!({
        "type": "object",
        "description": spec.description(),
        "properties": keys.chain(groups).chain(lists).collect::<Map<_, _>>(),
        "additionalProperties": false,
    });
    if spec.is_list {
        let count = spec.keys().count();
        let list = |items: Value| json!({"type": "array", "items": items, "minItems": count, "maxItems": count});
        let values = list(json!({"type": ["number", "string"]}));
        object["type"] = json!(["object", "array"]);
        for (name, value) in [("items", "items"), ("minItems", "minItems"), ("maxItems", "maxItems")] {
            object[name] = values[value].clone();
        }
        object["properties"]["value"] = values;
        object["properties"]["range"] =
            json!({"anyOf": [{"$ref": "#/$defs/range"}, list(json!({"$ref": "#/$defs/range"}))]});
        object["properties"]["provenance"] = json!({"$ref": "#/$defs/provenance"});
        object["properties"]["note"] = json!({"type": "string"});
    }
    object
}

fn key(spec: &KeySpec) -> Value {
    let mut plain = match spec.kind {
        Kind::Quantity { .. } => json!({"type": ["number", "string"]}),
        Kind::Count(_) => json!({"type": "integer"}),
        Kind::Switch => json!({"type": "boolean"}),
        Kind::Choice(words) => json!({"enum": words}),
        Kind::File | Kind::Name => json!({"type": "string"}),
    };
    // A number is in SI units; the limits do not apply to a text with a unit.
    if let Some([low, high]) = spec.kind.domain() {
        (plain["minimum"], plain["maximum"]) = (json!(low), json!(high));
    }
    let mut fields = json!({
        "value": plain,
        "provenance": {"$ref": "#/$defs/provenance"},
        "note": {"type": "string"},
    });
    if let Kind::Quantity { .. } | Kind::Count(_) = spec.kind {
        fields["range"] = json!({"$ref": "#/$defs/range"});
        fields["distribution"] = json!({"enum": Distribution::ALL.map(Distribution::as_str)});
    }
    let unit = match spec.kind {
        Kind::Quantity { .. } => format!(" ({})", spec.kind.allowed()),
        _ => String::new(),
    };
    json!({
        "description": format!("{}{unit}", spec.description()),
        "anyOf": [
            plain,
            {"type": "object", "properties": fields, "additionalProperties": false},
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_stands_in_the_schema() {
        let schema = json_schema();
        Values::SPEC.each_key("", &mut |path, spec| {
            let mut node = &schema;
            for name in path.split('.') {
                let inner = &node["properties"][name];
                node = if inner.is_null() {
                    &node["additionalProperties"]
                } else {
                    inner
                };
            }
            let text = node["description"].as_str().unwrap_or_default();
            assert!(text.starts_with(&spec.description()), "{path}");
        });
    }
}
