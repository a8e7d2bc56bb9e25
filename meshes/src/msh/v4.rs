//! Entities, nodes and elements of versions 4.0 and 4.1.
//!
//! Version 4.0 (gmsh 4.0 and 4.1) writes the number of an entity before its dimension, writes each node's number before
//! its coordinates, and stores node and element numbers as `int`.

use std::collections::HashMap;

use super::MshError;
use super::cursor::Cursor;
use super::raw::{Kind, Raw};

/// The two layouts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// Version 4.0.
    V40,
    /// Version 4.1.
    V41,
}

impl Layout {
    /// Reads the number of a node or an element.
    fn number(self, cursor: &mut Cursor<'_>) -> Result<u64, MshError> {
        match self {
            Self::V40 => Ok(u64::try_from(cursor.int()?).unwrap_or(u64::MAX)),
            Self::V41 => cursor.size(),
        }
    }

    /// Minimum size of such a number \[bytes\].
    fn number_bytes(self, cursor: &Cursor<'_>) -> usize {
        match self {
            Self::V40 => cursor.least(4),
            Self::V41 => cursor.size_bytes(),
        }
    }

    /// Dimension and number of the entity of a block.
    fn entity(self, cursor: &mut Cursor<'_>) -> Result<(i64, i64), MshError> {
        let [first, second] = [cursor.int()?, cursor.int()?];
        Ok(match self {
            Self::V40 => (second, first),
            Self::V41 => (first, second),
        })
    }

    /// Number of coordinates that locate an entity of a dimension: a point, or the corners of a box.
    fn coordinates(self, dimension: i64) -> usize {
        match (self, dimension) {
            (Self::V41, 0) => 3,
            _ => 6,
        }
    }
}

/// Physical groups of each geometric entity, by dimension and number.
#[derive(Debug, Default)]
pub(super) struct Entities(HashMap<(i64, i64), Vec<i64>>);

impl Entities {
    /// Reads `$Entities`.
    pub(super) fn read(&mut self, cursor: &mut Cursor<'_>, layout: Layout) -> Result<(), MshError> {
        self.of_all_dimensions(cursor, layout, |_, _| Ok(None))
    }

    /// Reads `$PartitionedEntities`: pieces of entities, each with its parent and its own groups. A piece without
    /// groups has those of its parent.
    pub(super) fn read_partitioned(&mut self, cursor: &mut Cursor<'_>, layout: Layout) -> Result<(), MshError> {
        cursor.size()?; // partitions
        let ghosts = cursor.size()?;
        let ghosts = cursor.count("ghost entities", ghosts, 2 * cursor.least(4))?;
        for _ in 0..2 * ghosts {
            cursor.int()?;
        }
        self.of_all_dimensions(cursor, layout, |cursor, _| {
            let parent = (cursor.int()?, cursor.int()?);
            list(cursor, "partitions")?;
            Ok(Some(parent))
        })
    }

    fn of_all_dimensions(
        &mut self,
        cursor: &mut Cursor<'_>,
        layout: Layout,
        parent: impl Fn(&mut Cursor<'_>, i64) -> Result<Option<(i64, i64)>, MshError>,
    ) -> Result<(), MshError> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = cursor.size()?;
        }
        for (dimension, count) in (0..).zip(counts) {
            let count = cursor.count("entities", count, 4 * cursor.size_bytes().min(cursor.least(4)))?;
            for _ in 0..count {
                let number = cursor.int()?;
                let parent = parent(cursor, dimension)?;
                for _ in 0..layout.coordinates(dimension) {
                    cursor.double()?;
                }
                let mut groups = list(cursor, "physical groups")?;
                if dimension > 0 {
                    list(cursor, "bounding entities")?;
                }
                // The interface of two volumes is a surface whose parent is a volume; it does not belong to the
                // volume's groups.
                if let Some(parent) = parent.filter(|(own, _)| groups.is_empty() && *own == dimension) {
                    groups = self.0.get(&parent).cloned().unwrap_or_default();
                }
                self.0.insert((dimension, number), groups);
            }
        }
        Ok(())
    }
}

fn list(cursor: &mut Cursor<'_>, what: &'static str) -> Result<Vec<i64>, MshError> {
    let count = cursor.size()?;
    let count = cursor.count(what, count, cursor.least(4))?;
    (0..count).map(|_| cursor.int()).collect()
}

/// Reads `$Nodes`.
pub(super) fn nodes(cursor: &mut Cursor<'_>, layout: Layout, raw: &mut Raw) -> Result<(), MshError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    if layout == Layout::V41 {
        let (_least, _most) = (cursor.size()?, cursor.size()?);
    }
    let blocks = cursor.count("blocks of nodes", blocks, 4 * cursor.least(4))?;
    let least = layout.number_bytes(cursor) + 3 * cursor.least(8);
    let total = cursor.count("nodes", total, least)?;
    raw.nodes.reserve(total);
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let (dimension, _) = layout.entity(cursor)?;
        let parametric = cursor.int()?;
        let count = cursor.size()?;
        let count = cursor.count("nodes", count, least)?;
        numbers.clear();
        if layout == Layout::V41 {
            for _ in 0..count {
                numbers.push(cursor.size()?);
            }
        }
        let parameters = if parametric == 0 { 0 } else { dimension.clamp(0, 3) };
        for place in 0..count {
            let number = match numbers.get(place) {
                Some(&number) => number,
                None => layout.number(cursor)?,
            };
            let position = [cursor.double()?, cursor.double()?, cursor.double()?];
            for _ in 0..parameters {
                cursor.double()?;
            }
            raw.node(number, position)?;
        }
    }
    Ok(())
}

/// Reads `$Elements`.
pub(super) fn elements(
    cursor: &mut Cursor<'_>,
    layout: Layout,
    entities: &Entities,
    raw: &mut Raw,
) -> Result<(), MshError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    if layout == Layout::V41 {
        let (_least, _most) = (cursor.size()?, cursor.size()?);
    }
    let blocks = cursor.count("blocks of elements", blocks, 4 * cursor.least(4))?;
    cursor.count("elements", total, 2 * layout.number_bytes(cursor))?;
    for _ in 0..blocks {
        let entity = layout.entity(cursor)?;
        let code = cursor.int()?;
        let kind = Kind::of(code, 0)?;
        let count = cursor.size()?;
        let count = cursor.count("elements", count, (1 + kind.nodes) * layout.number_bytes(cursor))?;
        let set = entities.0.get(&entity).map_or(&[][..], Vec::as_slice);
        let group = raw.group_set(set);
        raw.nodes_of.reserve(count * kind.nodes);
        for _ in 0..count {
            let number = layout.number(cursor)?;
            for _ in 0..kind.nodes {
                let node = layout.number(cursor)?;
                raw.nodes_of.push(node);
            }
            raw.element(number, kind, group, entity.1);
        }
    }
    Ok(())
}
