//! Laws that an assembly must satisfy before it runs.

mod faces;
mod loads;
mod passages;
mod place;
mod springs;
mod starts;
mod volumes;

use super::fault::AssemblyError;
use super::resolver::Resolver;
use crate::network::assembly::Assembly;

/// Checks all laws; the first that is violated is the error.
pub(super) fn run(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    faces::balance(resolver, assembly)?;
    starts::check(resolver, assembly)?;
    volumes::are_reachable(resolver, assembly)?;
    volumes::do_not_collapse(resolver, assembly)?;
    passages::are_heard(resolver, assembly)?;
    passages::shut_in_turn(resolver, assembly)?;
    springs::check_range(resolver, assembly)?;
    loads::add_up(resolver, assembly)
}
