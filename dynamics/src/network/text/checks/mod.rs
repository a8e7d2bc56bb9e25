//! Laws that an assembly must satisfy before it runs.

mod faces;
mod loads;
mod passages;
mod springs;
mod volumes;

use super::fault::{AssemblyError, Fault};
use super::resolver::Resolver;
use crate::network::assembly::{Assembly, Base, Contact, Stop};

/// Checks all laws; the first that is violated is the error.
pub(super) fn run(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    faces::balance(resolver, assembly)?;
    volumes::are_reachable(resolver, assembly)?;
    volumes::do_not_collapse(resolver, assembly)?;
    passages::are_heard(resolver, assembly)?;
    passages::shut_in_turn(resolver, assembly)?;
    springs::stay_within_their_law(resolver, assembly)?;
    loads::add_up(resolver, assembly)
}

/// The error of a block by its name.
fn error(resolver: &Resolver<'_>, table: &str, name: &str, fault: Fault) -> AssemblyError {
    let path = format!("cycle.{table}.{name}");
    let spot = resolver
        .names
        .find(name)
        .map_or(&resolver.text.cycle.spot, |block| block.spot);
    resolver.error(&path, spot, fault)
}

/// The stop that limits the travel of a body from another on one side.
fn stop(assembly: &Assembly, body: usize, against: Base, side: Stop) -> Option<&Contact> {
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
