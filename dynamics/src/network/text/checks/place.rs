//! Locations of blocks, and the stops of bodies.

use crate::network::assembly::{Assembly, Base, Stop};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::resolver::Resolver;

/// The error for a block, given by name, with the changes in files closer to the design to the blocks that contribute
/// to it.
pub(super) fn error_of(
    resolver: &Resolver<'_>,
    table: &str,
    name: &str,
    fault: Fault,
    parts: &[Part<'_>],
) -> AssemblyError {
    let path = format!("cycle.{table}.{name}");
    let block = resolver.names.find(name);
    let spot = block.map_or(&resolver.text.cycle.spot, |block| block.spot);
    AssemblyError {
        changes: Box::new(resolver.text.changes(spot, parts)),
        ..resolver.error(&path, spot, fault)
    }
}

/// Position of the first stop on one side of a body's motion relative to another \[m\]; `None` without one.
pub(super) fn stop_position(assembly: &Assembly, body: usize, against: Base, side: Stop) -> Option<f64> {
    let stops = assembly
        .contacts
        .iter()
        .filter_map(|contact| contact.stop_for(body, against));
    let stops = stops.filter(|(own, _)| *own == side).map(|(_, at)| at);
    match side {
        Stop::Below => stops.min_by(f64::total_cmp),
        Stop::Above => stops.max_by(f64::total_cmp),
    }
}
