//! Literals: quantities given as values, which are themselves keys.

use nailnoise_documents::Place;
use nailnoise_quantities::dimension::NUMBER;
use nailnoise_quantities::{Dimension, Kind, Measured, QuantityError, quantity, range};

use super::fault::Fault;
use super::node::{Node, Tree};

/// A number that an assembly gives instead of a formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Literal {
    /// Full name, `cycle.volume.gas.dead`.
    pub path: String,
    /// Dimension and domain.
    pub kind: Kind,
    /// Value in SI.
    pub si: f64,
    /// Plausible range in SI.
    pub range: Option<[f64; 2]>,
    /// Provenance; empty if there is none.
    pub provenance: String,
    /// Note; empty if there is none.
    pub note: String,
    /// Where.
    pub at: Place,
}

/// Range and provenance of a literal.
#[derive(Debug, Clone, Default)]
pub(super) struct Details {
    pub(super) range: Option<[Measured; 2]>,
    pub(super) provenance: String,
    pub(super) note: String,
}

const FIELDS: [&str; 6] = ["value", "range", "provenance", "note", "distribution", "follows"];

/// The dimension of a kind.
pub(super) fn dimension(kind: Kind) -> Dimension {
    match kind {
        Kind::Quantity { dimension, .. } => dimension,
        _ => NUMBER,
    }
}

/// Whether a gauge pressure may be given.
fn is_gauge(kind: Kind) -> bool {
    matches!(kind, Kind::Quantity { gauge: true, .. })
}

/// Reads a quantity of this kind.
pub(super) fn read(node: &Node, kind: Kind) -> Result<Measured, Fault> {
    let dimension = dimension(kind);
    let gauge = is_gauge(kind);
    match &node.value {
        Tree::Text(text) => quantity(text, dimension, gauge).map_err(|error| refused(text, error, kind)),
        Tree::Number(number) if dimension == NUMBER || *number == 0.0 => Ok(Measured {
            si: *number,
            gauge: false,
        }),
        Tree::Number(number) => Err(refused(&number.to_string(), QuantityError::NoUnit, kind)),
        Tree::Table(_) => match node.get("value") {
            Some(value) if !value.is_table() => read(value, kind),
            _ => Err(Fault::Missing {
                field: "value".to_owned(),
                example: "{ value = \"100 cm3\", range = \"60 .. 150 cm3\", provenance = \"estimated\" }".to_owned(),
            }),
        },
        _ => Err(Fault::Kind {
            found: node.found(),
            expected: format!("{dimension}"),
        }),
    }
}

fn refused(text: &str, error: QuantityError, kind: Kind) -> Fault {
    let dimension = dimension(kind);
    let gauge = if is_gauge(kind) { ", barg, psig" } else { "" };
    let units = format!("{}{gauge}", dimension.examples());
    match error {
        QuantityError::Dimension { found, .. } => Fault::Dimension {
            found: found.to_string(),
            expected: dimension.to_string(),
            units,
        },
        error => Fault::Literal {
            text: text.to_owned(),
            problem: error.to_string(),
            units,
        },
    }
}

/// Range, provenance and note of a literal given as a table.
pub(super) fn details(node: &Node, kind: Kind) -> Result<Details, Fault> {
    let mut details = Details::default();
    for entry in node.entries() {
        let text = || {
            entry.node.text().map(str::to_owned).ok_or_else(|| Fault::Kind {
                found: entry.node.found(),
                expected: "a text".to_owned(),
            })
        };
        match entry.key.as_str() {
            "range" => {
                let text = text()?;
                let read = range(&text, dimension(kind), is_gauge(kind));
                details.range = Some(read.map_err(|error| refused(&text, error, kind))?);
            }
            "provenance" => details.provenance = text()?,
            "note" => details.note = text()?,
            other if FIELDS.contains(&other) => {}
            other => {
                return Err(Fault::UnknownField {
                    owner: "quantity".to_owned(),
                    name: other.to_owned(),
                    known: FIELDS.map(str::to_owned).to_vec(),
                });
            }
        }
    }
    Ok(details)
}
