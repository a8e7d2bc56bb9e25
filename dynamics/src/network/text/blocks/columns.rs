//! Names of columns, and events of markers.

use nailnoise_quantities::dimension::{PRESSURE, TEMPERATURE};

use super::events::{Measured, dimensions, event_index, expression};
use super::list::entries;
use super::tables::outputs::{COLUMNS, MARKERS, OPENING};
use crate::network::assembly::{ColumnValue, Family, JetQuantity, Marker, NamedColumn};
use crate::network::text::fault::AssemblyError;
use crate::network::text::fields::Fields;
use crate::network::text::layers::dotted;
use crate::network::text::names::quantities;
use crate::network::text::resolver::Resolver;

/// Quantities of a jet by name.
const OF_JET: [(&str, JetQuantity); 3] = [
    ("pressure", JetQuantity::Pressure),
    ("back_pressure", JetQuantity::BackPressure),
    ("temperature", JetQuantity::Temperature),
];

/// The columns that an assembly names. If a later file removes a block or an opening, its columns in a base are removed
/// too.
pub(super) fn columns(resolver: &Resolver<'_>, sensors: &[Measured]) -> Result<Vec<NamedColumn>, AssemblyError> {
    let Some(node) = resolver.text.cycle.get("columns") else {
        return Ok(Vec::new());
    };
    let fields = Fields::new(resolver, "cycle.columns".to_owned(), node, &COLUMNS)?;
    let dimensions = dimensions(sensors);
    let openings: Vec<&str> = entries(resolver, "opening", &OPENING)?
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    let mut columns = Vec::new();
    for entry in node.entries() {
        resolver.check_name(&dotted("cycle.columns", &entry.key), &entry.key, &entry.spot)?;
        let name = entry.key.clone();
        let text = fields.text(&entry.key)?.unwrap_or_default().trim();
        let of_jet = text.split_once('.').and_then(|(block, word)| {
            let quantity = OF_JET.iter().find(|(own, _)| *own == word)?.1;
            Some((block, quantity))
        });
        if let Some((block, quantity)) = of_jet {
            if let Some(opening) = openings.iter().position(|own| *own == block) {
                let dimension = match quantity {
                    JetQuantity::Pressure | JetQuantity::BackPressure => PRESSURE,
                    JetQuantity::Temperature => TEMPERATURE,
                };
                columns.push(NamedColumn {
                    name,
                    channel: String::new(),
                    value: ColumnValue::Jet(opening, quantity),
                    unit: dimension.unit(),
                });
                continue;
            }
            if resolver.names.index(block, Family::Passage).is_some() {
                continue;
            }
        }
        let sources = &resolver.text.sources;
        let of_base = sources.rank(&entry.spot) < sources.merged.len();
        let scalar = match expression(&fields, &entry.key, &dimensions, true) {
            Ok(scalar) => scalar.ok_or_else(|| fields.missing(&entry.key))?,
            Err(_) if of_base => continue,
            Err(error) => return Err(error),
        };
        columns.push(NamedColumn {
            name,
            channel: channel(resolver, text),
            value: ColumnValue::Expression(scalar.value),
            unit: scalar.dimension.map_or_else(String::new, |dimension| dimension.unit()),
        });
    }
    Ok(columns)
}

/// The channel or sensor that a text names; empty for another expression.
fn channel(resolver: &Resolver<'_>, text: &str) -> String {
    let names = &resolver.names;
    let is_channel = text.split_once('.').is_some_and(|(block, word)| {
        let found = names.find(block);
        found.is_some_and(|found| quantities(found.block.family).iter().any(|(own, _)| *own == word))
    });
    match is_channel || names.sensors.contains(&text) {
        true => text.to_owned(),
        false => String::new(),
    }
}

/// The events of markers.
pub(super) fn markers(top: &Fields<'_, '_>) -> Result<Vec<Marker>, AssemblyError> {
    let Some(fields) = top.table("marker")? else {
        return Ok(Vec::new());
    };
    let mut markers = Vec::new();
    for name in MARKERS.names() {
        if let Some(index) = event_index(&fields, name, fields.resolver)? {
            markers.push(Marker {
                name: name.to_owned(),
                event: fields.resolver.names.events[index].to_owned(),
            });
        }
    }
    Ok(markers)
}
