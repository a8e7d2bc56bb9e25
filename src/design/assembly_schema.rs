//! JSON schema of `[cycle]` and `[keys]`, made from the tables by which an assembly is read.
//!
//! A design changes an assembly field by field, so no field is required, and `false` removes a field or block that a
//! base gives. Names, types and words are checked here; only the reader can check whether blocks exist, formulas have a
//! value and balances are satisfied.

use nailnoise_dynamics::network::{BUILT_IN, CYCLE, FieldSpec, FieldType, LAYOUT, TableSpec};
use nailnoise_quantities::{Kind, dimension::NUMBER};
use serde_json::{Map, Value, json};

use super::distribution::Distribution;

/// Name of a block.
const NAME: &str = "^[a-z][a-z0-9_]*$";

/// Schemas by the name under which others refer to them.
#[derive(Default)]
pub(super) struct Definitions(Map<String, Value>);

impl Definitions {
    /// The definitions.
    pub(super) fn into_map(self) -> Map<String, Value> {
        self.0
    }

    /// `[cycle]`.
    pub(super) fn cycle(&mut self) -> Value {
        let built_in = BUILT_IN.map(|(name, _)| name).join(", ");
        let mut fields = self.fields(&CYCLE);
        fields.insert(
            "assembly".to_owned(),
            json!({
                "description": format!("Name and schema of a new assembly; or the assembly that this one changes: a \
                    file relative to this one, or {built_in}."),
                "anyOf": [
                    {"type": "string"},
                    {"type": "object", "additionalProperties": false, "properties": {
                        "name": {"type": "string"}, "schema": {"const": 1},
                    }},
                ],
            }),
        );
        fields.insert(
            "schema".to_owned(),
            json!({"const": 1, "description": "Version of the format."}),
        );
        json!({
            "type": "object",
            "description": "The tool as a network of blocks, in place of the N80CB.",
            "properties": fields,
            "additionalProperties": false,
        })
    }

    /// `[keys]`, the declarations of an assembly's own keys.
    pub(super) fn keys(&mut self) -> Value {
        let text = |words: &str| json!({"type": "string", "description": words});
        self.0.insert(
            "declarations".to_owned(),
            json!({
                "type": "object",
                "properties": {
                    "domain": {"anyOf": [text("Lowest and highest value, as \"5 .. 100 mm\"."),
                        {"$ref": "#/$defs/declarations"}]},
                    "symbol": {"anyOf": [text("Symbol."), {"$ref": "#/$defs/declarations"}]},
                    "text": {"anyOf": [text("Description."), {"$ref": "#/$defs/declarations"}]},
                },
                "additionalProperties": {"$ref": "#/$defs/declarations"},
            }),
        );
        json!({
            "description": "Keys that the assembly declares for its formulas and its designs.",
            "$ref": "#/$defs/declarations",
        })
    }

    /// Values of keys that an assembly declares, by group.
    pub(super) fn own_values(&mut self) -> Value {
        self.0.insert(
            "own_values".to_owned(),
            json!({
                "description": "A value of a key that the assembly declares, or a group of them.",
                "anyOf": [
                    {"type": ["number", "string", "boolean"]},
                    {"type": "object", "additionalProperties": {"anyOf": [
                        {"$ref": "#/$defs/own_values"}, {"$ref": "#/$defs/range"},
                    ]}},
                ],
            }),
        );
        json!({"$ref": "#/$defs/own_values"})
    }

    fn fields(&mut self, table: &TableSpec) -> Map<String, Value> {
        let fields = table.fields.iter();
        fields.map(|own| (own.name.to_owned(), self.field(own))).collect()
    }

    fn field(&mut self, field: &FieldSpec) -> Value {
        let mut schema = removable(self.of(&field.of));
        schema["description"] = json!(description(field));
        schema
    }

    /// A table with its own fields only.
    fn table(&mut self, table: &TableSpec) -> Value {
        let fields = self.fields(table);
        let others = match table.others {
            Some(of) => removable(self.of(of)),
            None => Value::Bool(false),
        };
        let mut schema = json!({"type": "object", "properties": fields, "additionalProperties": others});
        schema["properties"]["if"] = condition();
        schema["properties"]["replace"] = replaces();
        schema
    }

    /// Blocks of a family by their names. Fields may be in layout tables.
    fn blocks(&mut self, table: &TableSpec) -> Value {
        let fields = self.fields(table);
        let names: Vec<String> = fields.keys().cloned().collect();
        let (of_fields, of_layout) = (
            format!("fields of a {}", table.name),
            format!("layout of a {}", table.name),
        );
        let own = reference(&of_fields);
        self.0.insert(of_fields, json!({"properties": fields}));
        let mut layout = own.clone();
        layout["type"] = json!("object");
        let mut block = layout.clone();
        match table.others {
            Some(of) => block["additionalProperties"] = removable(self.of(of)),
            None => {
                layout["propertyNames"] = json!({"enum": names});
                let all = names.iter().map(String::as_str).chain(["if", "replace"]).chain(LAYOUT);
                block["propertyNames"] = json!({"enum": all.collect::<Vec<_>>()});
            }
        }
        let mut special = Map::from_iter([("if".to_owned(), condition()), ("replace".to_owned(), replaces())]);
        if table.others.is_none() {
            let layout_tables = LAYOUT.map(|name| (name.to_owned(), reference(&of_layout)));
            special.extend(layout_tables);
            self.0.insert(of_layout, layout);
        }
        block["properties"] = special.into();
        json!({"type": "object", "propertyNames": {"pattern": NAME}, "additionalProperties": removable(block)})
    }

    fn of(&mut self, of: &FieldType) -> Value {
        match of {
            FieldType::Quantity(kind) => self.quantity(*kind),
            FieldType::Number => json!({"type": "number"}),
            FieldType::Value => self.own_values(),
            FieldType::Flag => json!({"anyOf": [{"type": "boolean"}, {"type": "string", "pattern": "^\\s*="}]}),
            FieldType::Name(_) => json!({"type": "string", "pattern": NAME}),
            FieldType::Text(_) => json!({"type": "string"}),
            FieldType::Words(words) => json!({"anyOf": [{"enum": words}, {"type": "string", "pattern": "^\\s*="}]}),
            FieldType::Table(table) => self.table(table),
            FieldType::Blocks(table) => self.blocks(table),
            FieldType::List(of) => json!({"type": "array", "items": self.of(of)}),
            FieldType::Pair(of) => {
                let items: Vec<Value> = of.iter().map(|of| self.of(of)).collect();
                json!({"type": "array", "prefixItems": items, "minItems": 2, "maxItems": 2})
            }
            FieldType::Either(types) => {
                let types: Vec<Value> = types.iter().map(|of| self.of(of)).collect();
                json!({"anyOf": types})
            }
        }
    }

    /// A quantity: a formula, a text with a unit, a plain number if it has no unit, or a table with its range.
    fn quantity(&mut self, kind: Kind) -> Value {
        let name = match kind {
            Kind::Count(_) => "plain number",
            Kind::Quantity { dimension, .. } if dimension == NUMBER => "plain number",
            _ => "quantity",
        };
        if !self.0.contains_key(name) {
            let number = match name {
                "quantity" => json!({"const": 0}),
                _ => json!({"type": "number"}),
            };
            let value = json!({"anyOf": [number, {"type": "string", "pattern": "^\\s*[=+\\-.0-9]"}]});
            let table = json!({"type": "object", "additionalProperties": false, "properties": {
                "value": value,
                "range": {"$ref": "#/$defs/range"},
                "distribution": {"enum": Distribution::ALL.map(Distribution::as_str)},
                "provenance": {"$ref": "#/$defs/provenance"},
                "note": {"type": "string"},
                "follows": {"type": "string"},
            }});
            self.0.insert(name.to_owned(), json!({"anyOf": [value, table]}));
        }
        reference(name)
    }
}

/// A reference to a definition.
fn reference(name: &str) -> Value {
    json!({"$ref": format!("#/$defs/{}", name.replace(' ', "%20"))})
}

/// A value, or `false`, which removes that of a base.
fn removable(value: Value) -> Value {
    json!({"anyOf": [value, {"const": false}]})
}

fn condition() -> Value {
    json!({"type": ["string", "boolean"], "description": "Condition over keys under which it exists."})
}

fn replaces() -> Value {
    json!({"type": "boolean", "description": "Whether the fields that a base gives are dropped."})
}

/// Description with the allowed values and their unit.
fn description(field: &FieldSpec) -> String {
    let allowed = field.of.quantity().map(|kind| format!(" ({})", kind.allowed()));
    let example = match field.example {
        "" => String::new(),
        example => format!("; as {example}"),
    };
    format!("{}{}{example}", field.text, allowed.unwrap_or_default())
}
