//! Nodes and elements of versions 1 and 2.

use super::MshError;
use super::cursor::{Cursor, Encoding};
use super::raw::{Kind, Raw};

/// Largest number of tags per element; gmsh writes 2, and a few more for partitions.
const MOST_TAGS: i64 = 64;

pub(super) fn nodes(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    each_node(cursor, raw, |_| Ok(()))
}

/// Reads nodes that gmsh saved with `Mesh.SaveParametric`. Their coordinates are followed by the dimension and number
/// of the entity they lie on, and by their parameters on it: one on a curve, two on a surface.
pub(super) fn parametric_nodes(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    each_node(cursor, raw, |cursor| {
        let (dimension, _entity) = (cursor.int()?, cursor.int()?);
        for _ in 0..if matches!(dimension, 1 | 2) { dimension } else { 0 } {
            cursor.double()?;
        }
        Ok(())
    })
}

/// Reads the number and coordinates of every node, and calls `pass` to skip any values after them.
fn each_node(
    cursor: &mut Cursor<'_>,
    raw: &mut Raw,
    pass: impl Fn(&mut Cursor<'_>) -> Result<(), MshError>,
) -> Result<(), MshError> {
    let count = announced(cursor)?;
    let count = cursor.count("nodes", count, 4 * cursor.least(7))?;
    raw.nodes.reserve(count);
    for _ in 0..count {
        let number = number(cursor)?;
        let position = [cursor.double()?, cursor.double()?, cursor.double()?];
        pass(cursor)?;
        raw.node(number, position)?;
    }
    Ok(())
}

/// Elements of version 1: number, type, physical group, entity, number of nodes, nodes.
pub(super) fn elements_of_version_1(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    let count = announced(cursor)?;
    let count = cursor.count("elements", count, 2 * cursor.least(4))?;
    for _ in 0..count {
        let (element, code) = (number(cursor)?, cursor.int()?);
        let kind = Kind::of(code, element)?;
        let (physical, entity, nodes) = (cursor.int()?, cursor.int()?, cursor.int()?);
        if usize::try_from(nodes) != Ok(kind.nodes) {
            return Err(MshError::Header {
                what: "of an element that the number of its nodes is",
                found: nodes.to_string(),
                expected: "it must be that of its type",
            });
        }
        with_nodes(cursor, raw, (element, kind), (physical, entity))?;
    }
    Ok(())
}

pub(super) fn elements(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    let count = announced(cursor)?;
    let count = cursor.count("elements", count, 2 * cursor.least(4))?;
    match cursor.encoding {
        Encoding::Text => {
            for _ in 0..count {
                let (element, code, tags) = (number(cursor)?, cursor.int()?, cursor.int()?);
                let kind = Kind::of(code, element)?;
                one(cursor, raw, element, kind, tags)?;
            }
        }
        Encoding::Binary { .. } => {
            let mut read = 0;
            while read < count {
                let (code, block, tags) = (cursor.int()?, cursor.int()?, cursor.int()?);
                let kind = Kind::of(code, 0)?;
                let block = cursor.count("elements", u64::try_from(block).unwrap_or(u64::MAX), 8)?;
                // With an empty block, a damaged file could cause an infinite loop.
                for _ in 0..block.max(1).min(count - read) {
                    let element = number(cursor)?;
                    one(cursor, raw, element, kind, tags)?;
                }
                read += block.max(1);
            }
        }
    }
    Ok(())
}

fn one(cursor: &mut Cursor<'_>, raw: &mut Raw, element: u64, kind: &'static Kind, tags: i64) -> Result<(), MshError> {
    if !(0..=MOST_TAGS).contains(&tags) {
        return Err(MshError::Header {
            what: "of an element that the number of its tags is",
            found: tags.to_string(),
            expected: "gmsh writes two",
        });
    }
    let (mut physical, mut entity) = (0, 0);
    for tag in 0..tags {
        let value = cursor.int()?;
        match tag {
            0 => physical = value,
            1 => entity = value,
            _ => {}
        }
    }
    with_nodes(cursor, raw, (element, kind), (physical, entity))
}

/// Adds an element, whose nodes follow.
fn with_nodes(
    cursor: &mut Cursor<'_>,
    raw: &mut Raw,
    (element, kind): (u64, &'static Kind),
    (physical, entity): (i64, i64),
) -> Result<(), MshError> {
    let set: &[i64] = if physical == 0 { &[] } else { &[physical] };
    let group = raw.group_set(set);
    for _ in 0..kind.nodes {
        let node = number(cursor)?;
        raw.nodes_of.push(node);
    }
    raw.element(element, kind, group, entity);
    Ok(())
}

fn announced(cursor: &mut Cursor<'_>) -> Result<u64, MshError> {
    let count = cursor.text_integer()?;
    cursor.end_of_line();
    Ok(u64::try_from(count).unwrap_or(u64::MAX))
}

/// Reads the number of a node or element. A negative number is mapped to one that no node or element has.
fn number(cursor: &mut Cursor<'_>) -> Result<u64, MshError> {
    Ok(u64::try_from(cursor.int()?).unwrap_or(u64::MAX))
}
