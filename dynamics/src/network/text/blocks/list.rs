//! Blocks of a family by name, and small queries about them.

use crate::network::assembly::{Base, Family, Space};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::names::family_name;
use crate::network::text::node::Node;
use crate::network::text::resolver::Resolver;
use crate::network::text::table::TableSpec;

/// The blocks of a family that are switched on.
pub(super) fn each<'r, 'a>(
    resolver: &'r Resolver<'a>,
    family: Family,
    spec: &'static TableSpec,
) -> Result<Vec<(&'a str, Fields<'r, 'a>)>, AssemblyError> {
    let table = family_name(family);
    let of = resolver
        .names
        .blocks
        .iter()
        .filter(|block| block.block.family == family);
    of.map(|block| {
        let path = format!("cycle.{table}.{}", block.name);
        Ok((block.name, Fields::new(resolver, path, block.node, spec)?))
    })
    .collect()
}

/// The entries of a table without channels that are switched on.
pub(super) fn entries<'r, 'a>(
    resolver: &'r Resolver<'a>,
    table: &str,
    spec: &'static TableSpec,
) -> Result<Vec<(&'a str, Fields<'r, 'a>)>, AssemblyError> {
    let mut found = Vec::new();
    for entry in resolver.text.cycle.get(table).map_or(&[][..], Node::entries) {
        let path = format!("cycle.{table}.{}", entry.key);
        if resolver.is_on(&path, &entry.node)? {
            found.push((entry.key.as_str(), Fields::new(resolver, path, &entry.node, spec)?));
        }
    }
    Ok(found)
}

/// The entries of a table whose names are those of blocks of a family, as `[cycle.load.tool]`, with the indices of the
/// blocks.
pub(super) fn of_named<'r, 'a>(
    resolver: &'r Resolver<'a>,
    table: &str,
    (family, wanted): (Family, &str),
    spec: &'static TableSpec,
) -> Result<Vec<(usize, Fields<'r, 'a>)>, AssemblyError> {
    let mut found = Vec::new();
    for entry in resolver.text.cycle.get(table).map_or(&[][..], Node::entries) {
        let path = format!("cycle.{table}.{}", entry.key);
        let fields = Fields::new(resolver, path.clone(), &entry.node, spec)?;
        if !resolver.is_on(&path, &entry.node)? {
            continue;
        }
        let name = entry.key.clone();
        let fault = match resolver.names.index(&name, family) {
            Some(block) => {
                found.push((block, fields));
                continue;
            }
            None if resolver.names.off.contains(&name.as_str()) => Fault::SwitchedOff { name },
            None => Fault::UnknownName {
                name,
                wanted: wanted.to_owned(),
                known: resolver.names.of(&[family]),
            },
        };
        return Err(resolver.error(&path, &entry.spot, fault));
    }
    Ok(found)
}

/// The parent of a body.
pub(super) fn parent(parents: &[Base], body: usize) -> Base {
    parents.get(body).copied().unwrap_or(Base::Ground)
}

/// Whether a space is the atmosphere.
pub(in crate::network::text) fn is_atmosphere(resolver: &Resolver<'_>, space: Space) -> bool {
    let atmosphere = resolver.names.index("atmosphere", Family::Reservoir);
    matches!(space, Space::Reservoir(index) if Some(index) == atmosphere)
}
