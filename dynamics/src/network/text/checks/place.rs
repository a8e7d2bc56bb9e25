//! Locations of blocks, and the stops of bodies.

use crate::network::assembly::{Assembly, Base, Contact, Stop};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Changes, Fault};
use crate::network::text::resolver::Resolver;

/// The error for a block, given by name.
pub(super) fn error(resolver: &Resolver<'_>, table: &str, name: &str, fault: Fault) -> AssemblyError {
    let path = format!("cycle.{table}.{name}");
    let spot = resolver
        .names
        .find(name)
        .map_or(&resolver.text.cycle.spot, |block| block.spot);
    resolver.error(&path, spot, fault)
}

/// The same with what files closer to the design change of the blocks that contribute to the fault.
pub(super) fn error_of(
    resolver: &Resolver<'_>,
    table: &str,
    name: &str,
    fault: Fault,
    parts: &[Part<'_>],
) -> AssemblyError {
    let found = resolver.names.find(name);
    let changes = found.map_or_else(Changes::default, |block| resolver.text.changes(block.spot, parts));
    AssemblyError {
        changes: Box::new(changes),
        ..error(resolver, table, name, fault)
    }
}

/// The stop that limits a body's travel relative to another on one side.
pub(super) fn stop(assembly: &Assembly, body: usize, against: Base, side: Stop) -> Option<&Contact> {
    let mut stops: Vec<&Contact> = assembly
        .contacts
        .iter()
        .filter(|contact| contact.on == body && contact.against == against && contact.stop == side)
        .collect();
    stops.sort_by(|a, b| a.at.total_cmp(&b.at));
    match side {
        Stop::Below => stops.first().copied(),
        Stop::Above => stops.last().copied(),
    }
}
