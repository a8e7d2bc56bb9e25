//! Values of documents with their locations, shared by several documents.

use std::ops::Range;

use nailnoise_documents::{Document, Place, found};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::formula::{Term, parse};

/// Place of a value: a document by index and a span of bytes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spot {
    pub(super) document: usize,
    pub(super) span: Range<usize>,
}

/// A value and its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) value: Tree,
    pub(super) spot: Spot,
}

/// An entry of a table, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    /// Place of the key.
    pub(super) spot: Spot,
    pub(super) node: Node,
}

/// An entry that a file closer to the design removes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Removed {
    /// Full name.
    pub(super) path: String,
    /// Its value before.
    pub(super) node: Node,
    /// Place of the `false` that removes it.
    pub(super) spot: Spot,
}

/// A value of TOML.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Tree {
    Table(Vec<Entry>),
    Array(Vec<Node>),
    Text(String),
    Number(f64),
    Flag(bool),
    /// A value that is not used here, described in words.
    Other(String),
}

/// A field of an assembly as its files give it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldText {
    /// Full name, `cycle.passage.vent.one_way`; entries of an array by their number, from 0.
    pub path: String,
    /// The value as text.
    pub text: String,
}

impl FieldText {
    /// Its number in SI, if the text is a number with or without a unit.
    pub fn number(&self) -> Option<f64> {
        match parse(&self.text).ok()? {
            Term::Number { si, .. } => Some(si),
            _ => None,
        }
    }
}

impl Node {
    fn new(document: usize, value: &Spanned<DeValue<'_>>) -> Self {
        let spot = Spot {
            document,
            span: value.span(),
        };
        let tree = match value.get_ref() {
            DeValue::String(text) => Tree::Text(text.clone().into_owned()),
            DeValue::Boolean(on) => Tree::Flag(*on),
            DeValue::Float(float) => float
                .as_str()
                .parse()
                .map_or_else(|_| Tree::Other(found(value.get_ref())), Tree::Number),
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).map_or_else(
                |_| Tree::Other(found(value.get_ref())),
                |integer| Tree::Number(integer as f64),
            ),
            DeValue::Array(items) => Tree::Array(items.iter().map(|item| Self::new(document, item)).collect()),
            DeValue::Table(table) => Tree::Table(entries(document, table)),
            DeValue::Datetime(_) => Tree::Other(found(value.get_ref())),
        };
        Self { value: tree, spot }
    }

    /// An empty table at a place.
    pub(super) fn empty(spot: Spot) -> Self {
        Self {
            value: Tree::Table(Vec::new()),
            spot,
        }
    }

    /// The entries of a table; none of another value.
    pub(super) fn entries(&self) -> &[Entry] {
        match &self.value {
            Tree::Table(entries) => entries,
            _ => &[],
        }
    }

    /// The value of a key of a table.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        self.entries()
            .iter()
            .find(|entry| entry.key == key)
            .map(|entry| &entry.node)
    }

    /// The text, if it is one.
    pub(super) fn text(&self) -> Option<&str> {
        match &self.value {
            Tree::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn is_table(&self) -> bool {
        matches!(self.value, Tree::Table(_))
    }

    /// Whether it is a quantity with its range or provenance.
    pub(super) fn is_literal_table(&self) -> bool {
        self.get("value").is_some()
    }

    /// Every value under `path`, with its own path.
    pub(super) fn fields(&self, path: &str, fields: &mut Vec<FieldText>) {
        let text = match &self.value {
            Tree::Table(entries) => {
                for entry in entries {
                    entry.node.fields(&format!("{path}.{}", entry.key), fields);
                }
                return;
            }
            Tree::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    item.fields(&format!("{path}.{index}"), fields);
                }
                return;
            }
            Tree::Text(text) => text.clone(),
            Tree::Number(number) => format!("{number:e}"),
            Tree::Flag(on) => on.to_string(),
            Tree::Other(words) => words.clone(),
        };
        fields.push(FieldText {
            path: path.to_owned(),
            text,
        });
    }

    /// The value in words, for messages.
    pub(super) fn found(&self) -> String {
        match &self.value {
            Tree::Table(_) => "a table".to_owned(),
            Tree::Array(_) => "an array".to_owned(),
            Tree::Text(text) => format!("the text \"{text}\""),
            Tree::Number(number) => format!("the number {number}"),
            Tree::Flag(on) => on.to_string(),
            Tree::Other(words) => words.clone(),
        }
    }

    /// Merges another table into this one: tables merge entry by entry, other values replace existing ones. `false`
    /// removes an entry that is not itself a flag, `replace = true` clears a table first, and a bare value retains the
    /// range and provenance of the value that it replaces. Returns the entries that `false` removes; `path` is the full
    /// name of this table.
    pub(super) fn merge(&mut self, over: Self, path: &str) -> Vec<Removed> {
        if self.is_literal_table() && !over.is_table() && over.is_value() {
            if let Tree::Table(entries) = &mut self.value
                && let Some(value) = entries.iter_mut().find(|entry| entry.key == "value")
            {
                value.node = over;
            }
            return Vec::new();
        }
        let mut removed = Vec::new();
        match (&mut self.value, over.value) {
            (Tree::Table(own), Tree::Table(others)) => {
                let replace = others
                    .iter()
                    .any(|entry| entry.key == "replace" && entry.node.value == Tree::Flag(true));
                if replace {
                    own.clear();
                }
                for entry in others.into_iter().filter(|entry| entry.key != "replace") {
                    removed.extend(merge_entry(own, entry, path));
                }
            }
            (value, other) => {
                *value = other;
                self.spot = over.spot;
            }
        }
        removed
    }

    /// Whether it is a quantity given as a bare value and not as a formula.
    fn is_value(&self) -> bool {
        match &self.value {
            Tree::Number(_) => true,
            Tree::Text(text) => !text.starts_with('='),
            _ => false,
        }
    }
}

fn merge_entry(own: &mut Vec<Entry>, mut entry: Entry, path: &str) -> Vec<Removed> {
    let found = own.iter().position(|present| present.key == entry.key);
    let path = format!("{path}.{}", entry.key);
    match (found, &mut entry.node.value) {
        (Some(at), Tree::Flag(false)) if !matches!(own[at].node.value, Tree::Flag(_)) => vec![Removed {
            path,
            node: own.remove(at).node,
            spot: entry.spot,
        }],
        (Some(at), _) => own[at].node.merge(entry.node, &path),
        (None, value) => {
            // The flag `replace` has no effect in a new table.
            if let Tree::Table(entries) = value {
                entries.retain(|entry| entry.key != "replace");
            }
            own.push(entry);
            Vec::new()
        }
    }
}

/// The entries of a table of a document.
pub(super) fn entries(document: usize, table: &DeTable<'_>) -> Vec<Entry> {
    let entry = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<DeValue<'_>>)| Entry {
        key: key.get_ref().clone().into_owned(),
        spot: Spot {
            document,
            span: key.span(),
        },
        node: Node::new(document, value),
    };
    table.iter().map(entry).collect()
}

/// The documents that spots refer to.
#[derive(Debug, Clone, Default)]
pub(super) struct Sources {
    pub(super) documents: Vec<Document>,
    /// Indices of the documents in the order of the merge, the closest to the design last.
    pub(super) merged: Vec<usize>,
}

impl Sources {
    /// Rank of a spot: higher for documents that change those of lower rank.
    pub(super) fn rank(&self, spot: &Spot) -> usize {
        let place = self.merged.iter().position(|index| *index == spot.document);
        place.map_or(0, |place| place + 1)
    }

    /// The place of a spot.
    pub(super) fn place(&self, spot: &Spot) -> Box<Place> {
        self.documents[spot.document].place(spot.span.clone())
    }
}
