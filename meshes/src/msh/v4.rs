//! Entities, nodes and elements of version 4.1.

use std::collections::HashMap;

use super::MshError;
use super::cursor::Cursor;
use super::raw::{Kind, Raw};

/// Physical groups of each geometric entity, by dimension and number.
#[derive(Debug, Default)]
pub(super) struct Entities(HashMap<(i64, i64), Vec<i64>>);

impl Entities {
    pub(super) fn read(cursor: &mut Cursor<'_>) -> Result<Self, MshError> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = cursor.size()?;
        }
        let mut physical = HashMap::new();
        for (dimension, count) in (0..).zip(counts) {
            let count = cursor.count("entities", count, 4 * cursor.size_bytes().min(cursor.least(4)))?;
            for _ in 0..count {
                let number = cursor.int()?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    cursor.double()?;
                }
                let groups = list(cursor, "physical groups")?;
                if dimension > 0 {
                    list(cursor, "bounding entities")?;
                }
                physical.insert((dimension, number), groups);
            }
        }
        Ok(Self(physical))
    }
}

fn list(cursor: &mut Cursor<'_>, what: &'static str) -> Result<Vec<i64>, MshError> {
    let count = cursor.size()?;
    let count = cursor.count(what, count, cursor.least(4))?;
    (0..count).map(|_| cursor.int()).collect()
}

pub(super) fn nodes(cursor: &mut Cursor<'_>, raw: &mut Raw) -> Result<(), MshError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    let (_least, _most) = (cursor.size()?, cursor.size()?);
    let blocks = cursor.count("blocks of nodes", blocks, 4 * cursor.least(4))?;
    let total = cursor.count("nodes", total, cursor.size_bytes() + 3 * cursor.least(8))?;
    raw.nodes.reserve(total);
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let (dimension, _entity, parametric) = (cursor.int()?, cursor.int()?, cursor.int()?);
        let count = cursor.size()?;
        let count = cursor.count("nodes", count, cursor.size_bytes() + 3 * cursor.least(8))?;
        numbers.clear();
        for _ in 0..count {
            numbers.push(cursor.size()?);
        }
        let parameters = if parametric == 1 { dimension.clamp(0, 3) } else { 0 };
        for &number in &numbers {
            let position = [cursor.double()?, cursor.double()?, cursor.double()?];
            for _ in 0..parameters {
                cursor.double()?;
            }
            raw.node(number, position)?;
        }
    }
    Ok(())
}

pub(super) fn elements(cursor: &mut Cursor<'_>, entities: &Entities, raw: &mut Raw) -> Result<(), MshError> {
    let (blocks, total) = (cursor.size()?, cursor.size()?);
    let (_least, _most) = (cursor.size()?, cursor.size()?);
    let blocks = cursor.count("blocks of elements", blocks, 4 * cursor.least(4))?;
    cursor.count("elements", total, 2 * cursor.size_bytes())?;
    for _ in 0..blocks {
        let (dimension, entity, code) = (cursor.int()?, cursor.int()?, cursor.int()?);
        let kind = Kind::of(code, 0)?;
        let count = cursor.size()?;
        let count = cursor.count("elements", count, (1 + kind.nodes) * cursor.size_bytes())?;
        let set = entities.0.get(&(dimension, entity)).map_or(&[][..], Vec::as_slice);
        let group = raw.group_set(set);
        raw.nodes_of.reserve(count * kind.nodes);
        for _ in 0..count {
            let number = cursor.size()?;
            for _ in 0..kind.nodes {
                let node = cursor.size()?;
                raw.nodes_of.push(node);
            }
            raw.element(number, kind, group);
        }
    }
    Ok(())
}
