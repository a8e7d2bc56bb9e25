//! Locations of the blocks of a fault, and the changes to them in files closer to the design.

use nailnoise_documents::Place;

use super::fault::{Change, Changes};
use super::formula::{Term, parse};
use super::layers::AssemblyText;
use super::named::NamedInTexts;
use super::names::CHANNELS;
use super::node::{Entry, Node, Removed, Spot, Tree};
use crate::network::assembly::{Assembly, Base, BlockRef, Face, Family, Opens, Space};
use crate::network::error::RunError;

/// Fields that determine where a body may move.
const STOP: &[&str] = &["on", "against", "stop", "at"];
/// Longest chain of names of `[cycle.let]` that is followed.
const DEEPEST: usize = 64;

/// A block that contributes to a fault.
pub(super) struct Part<'n> {
    family: Family,
    name: &'n str,
    /// The fields that matter; all if none is given.
    fields: &'static [&'static str],
}

impl<'n> Part<'n> {
    fn new(family: Family, name: &'n str, fields: &'static [&'static str]) -> Self {
        Self { family, name, fields }
    }

    /// The blocks that determine the smallest size of a volume: its faces, and the stops of their bodies.
    pub(super) fn of_volume(assembly: &'n Assembly, index: usize) -> Vec<Self> {
        let Some(volume) = assembly.volumes.get(index) else {
            return Vec::new();
        };
        let mut parts = vec![Self::new(Family::Volume, &volume.name, &["dead"])];
        for face in assembly.faces.iter().filter(|face| face.gas == Space::Volume(index)) {
            let fields = &["volume", "body", "against", "push", "area", "zero", "constant_volume"];
            parts.push(Self::new(Family::Face, &face.name, fields));
            if let Some(body) = assembly.bodies.get(face.body) {
                parts.push(Self::new(Family::Body, &body.name, &["parent", "start"]));
            }
            parts.extend(Self::stops(assembly, face.body, face.against));
        }
        parts
    }

    /// The blocks that determine the compression of a spring: itself and the stops of its bodies.
    pub(super) fn of_spring(assembly: &'n Assembly, index: usize) -> Vec<Self> {
        let Some(spring) = assembly.springs.get(index) else {
            return Vec::new();
        };
        let own = Self::new(Family::Spring, &spring.name, &[]);
        let stops = Self::stops(assembly, spring.on, spring.against);
        std::iter::once(own).chain(stops).collect()
    }

    /// The blocks that determine when passages are open: their seats and the stops of the bodies.
    pub(super) fn of_passages(assembly: &'n Assembly, passages: [usize; 2]) -> Vec<Self> {
        let mut parts = Vec::new();
        for passage in passages.into_iter().filter_map(|index| assembly.passages.get(index)) {
            let fields = &["between", "seat", "series", "one_way"];
            parts.push(Self::new(Family::Passage, &passage.name, fields));
            for restriction in &passage.restrictions {
                if let Opens::Seat { body, against, .. } = restriction.opens {
                    parts.extend(Self::stops(assembly, body, against));
                }
            }
        }
        parts
    }

    /// The blocks that determine the force on a body at rest: its faces with their gas, and its connections.
    pub(super) fn of_body(assembly: &'n Assembly, index: usize) -> Vec<Self> {
        let Some(body) = assembly.bodies.get(index) else {
            return Vec::new();
        };
        let mut parts = vec![Self::new(Family::Body, &body.name, &[])];
        let is_own = |face: &&Face| face.body == index || face.against == Base::Body(index);
        for face in assembly.faces.iter().filter(is_own) {
            let gas = face.gas.block();
            parts.push(Self::new(Family::Face, &face.name, &[]));
            parts.push(Self::new(
                gas.family,
                assembly.name_of(gas),
                &["pressure", "temperature"],
            ));
        }
        let connections = assembly.connections().filter(|own| own.acts_on(index));
        parts.extend(connections.map(|own| Self::new(own.block.family, assembly.name_of(own.block), &[])));
        parts
    }

    /// The blocks that determine where a body starts: itself and its stops.
    pub(super) fn of_start(assembly: &'n Assembly, index: usize) -> Vec<Self> {
        let Some(body) = assembly.bodies.get(index) else {
            return Vec::new();
        };
        let own = Self::new(Family::Body, &body.name, &["parent", "start"]);
        std::iter::once(own)
            .chain(Self::stops(assembly, index, body.parent))
            .collect()
    }

    /// The blocks that determine the areas where gas pushes a body.
    pub(super) fn of_faces(assembly: &'n Assembly, index: usize) -> Vec<Self> {
        let body = assembly.bodies.get(index);
        let body = body.map(|body| Self::new(Family::Body, &body.name, &["unbalanced"]));
        let faces = assembly.faces.iter().filter(|face| face.body == index);
        let faces = faces.map(|face| Self::new(Family::Face, &face.name, &["body", "push", "area"]));
        body.into_iter().chain(faces).collect()
    }

    /// The blocks of any family with a name, with all their fields.
    pub(super) fn of_any_block(name: &'n str) -> Vec<Self> {
        CHANNELS
            .iter()
            .map(|(_, family)| Self::new(*family, name, &[]))
            .collect()
    }

    /// A block with all its fields.
    pub(super) fn of_block(family: Family, name: &'n str) -> Vec<Self> {
        vec![Self::new(family, name, &[])]
    }

    fn stops(assembly: &'n Assembly, on: usize, against: Base) -> impl Iterator<Item = Self> {
        let contacts = assembly.contacts.iter();
        let stops = contacts.filter(move |contact| contact.stop_for(on, against).is_some());
        stops.map(|contact| Self::new(Family::Contact, &contact.name, STOP))
    }
}

/// The error of a run, with the block at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}{error}{}", location(block.as_ref()), ending(block.as_ref()))]
pub struct PlacedError {
    /// The error.
    pub error: RunError,
    /// The block; none if the error is not that of one block.
    pub block: Option<PlacedBlock>,
}

/// A block of an assembly in its file.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedBlock {
    /// Its full name.
    pub path: String,
    /// Location.
    pub at: Box<Place>,
    /// Changes, in files closer to the design, to blocks that contribute to the error.
    pub changes: Changes,
}

fn location(block: Option<&PlacedBlock>) -> String {
    block.map_or_else(String::new, |PlacedBlock { path, at, .. }| {
        format!("{}, line {}: `{path}`: ", at.file(), at.line())
    })
}

fn ending(block: Option<&PlacedBlock>) -> String {
    block.map_or_else(String::new, |block| block.changes.to_string())
}

impl From<RunError> for PlacedError {
    fn from(error: RunError) -> Self {
        Self { error, block: None }
    }
}

impl AssemblyText {
    /// Adds the location of the block at fault to the error of a run of this assembly.
    pub fn placed(&self, assembly: &Assembly, error: RunError) -> PlacedError {
        let found = error.block().and_then(|name| find(assembly, name));
        let block = found.and_then(|(table, block)| {
            let name = assembly.name_of(block);
            let entry = self.entry(table, name)?;
            let parts = match error {
                RunError::Collapse { .. } => Part::of_volume(assembly, block.index),
                RunError::SpringLimit { .. } => Part::of_spring(assembly, block.index),
                RunError::NotSeated { ref body, .. } | RunError::NoEquilibrium { ref body, .. } => {
                    let index = assembly.bodies.iter().position(|own| own.name == *body);
                    index.map_or_else(Vec::new, |index| Part::of_body(assembly, index))
                }
                _ => Part::of_block(block.family, name),
            };
            Some(PlacedBlock {
                path: format!("cycle.{table}.{name}"),
                at: self.sources.place(&entry.spot),
                changes: self.changes(&entry.spot, &parts),
            })
        });
        PlacedError { error, block }
    }

    /// Changes to these parts in files closer to the design than the file of `of`: new blocks, fields, keys that the
    /// closest file gives, and removed blocks that refer to a part.
    pub(super) fn changes(&self, of: &Spot, parts: &[Part<'_>]) -> Changes {
        let mut search = Search {
            text: self,
            above: self.sources.rank(of),
            found: Vec::new(),
        };
        for part in parts {
            let table = CHANNELS.iter().find(|(_, family)| *family == part.family);
            let Some((table, entry)) = table.and_then(|(table, _)| Some((table, self.entry(table, part.name)?))) else {
                continue;
            };
            let path = format!("cycle.{table}.{}", part.name);
            if search.is_nearer(&entry.spot) {
                search.add(path, &entry.spot);
                continue;
            }
            let fields = entry.node.entries().iter();
            for field in fields.filter(|field| part.fields.is_empty() || part.fields.contains(&field.key.as_str())) {
                search.field(&format!("{path}.{}", field.key), &field.node);
            }
        }
        for removed in &self.removed {
            let mut names = NamedInTexts::default();
            names.add(&removed.node);
            let own = removed.path.split('.').nth(2).unwrap_or_default();
            let concerns = parts.iter().any(|part| part.name == own || names.has_block(part.name));
            if search.is_nearer(&removed.spot) && concerns {
                search.add(removed.path.clone(), &removed.spot);
            }
        }
        Changes(search.found)
    }

    /// The change by which a file removes the block or name of `[cycle.let]` that a channel or word begins with.
    pub(super) fn removal(&self, name: &str) -> Option<Change> {
        let own = name.split(['.', ' ']).next()?;
        let is_own = |removed: &&Removed| {
            let mut words = removed.path.split('.').skip(2);
            words.next() == Some(own) && words.next().is_none()
        };
        let removed = self.removed.iter().find(is_own)?;
        Some(Change {
            path: removed.path.clone(),
            at: self.sources.place(&removed.spot),
        })
    }

    fn entry(&self, table: &str, name: &str) -> Option<&Entry> {
        let mut entries = self.cycle.get(table)?.entries().iter();
        entries.find(|entry| entry.key == name)
    }
}

/// The block of a name and the table of its family. A block that is switched off may have the same name.
fn find(assembly: &Assembly, name: &str) -> Option<(&'static str, BlockRef)> {
    CHANNELS.iter().find_map(|(table, family)| {
        let blocks = (0..).map(|index| BlockRef { family: *family, index });
        let mut blocks = blocks.take_while(|block| !assembly.name_of(*block).is_empty());
        let found = blocks.find(|block| assembly.name_of(*block) == name)?;
        Some((*table, found))
    })
}

/// A search for what nearer files give.
struct Search<'a> {
    text: &'a AssemblyText,
    /// Rank of the file that they change.
    above: usize,
    found: Vec<Change>,
}

impl Search<'_> {
    fn is_nearer(&self, spot: &Spot) -> bool {
        self.text.sources.rank(spot) > self.above
    }

    fn add(&mut self, path: String, spot: &Spot) {
        if !self.found.iter().any(|change| change.path == path) {
            let at = self.text.sources.place(spot);
            self.found.push(Change { path, at });
        }
    }

    /// Adds a value if a nearer file gives it, else the parts and keys of it that one gives.
    fn field(&mut self, path: &str, node: &Node) {
        match &node.value {
            Tree::Table(entries) => {
                for entry in entries {
                    self.field(&format!("{path}.{}", entry.key), &entry.node);
                }
            }
            _ if self.is_nearer(&node.spot) => self.add(path.to_owned(), &node.spot),
            Tree::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    self.field(&format!("{path}.{index}"), item);
                }
            }
            _ => self.formula(node, 0),
        }
    }

    /// Adds the names in a formula that nearer files give.
    fn formula(&mut self, node: &Node, depth: usize) {
        let formula = node.text().and_then(|text| text.strip_prefix('='));
        let Some(Ok(term)) = formula.map(parse).filter(|_| depth < DEEPEST) else {
            return;
        };
        let mut names = Vec::new();
        each_name(&term, &mut |name| names.push(name.to_owned()));
        for name in names {
            self.name(name.strip_prefix("key.").unwrap_or(&name), depth);
        }
    }

    fn name(&mut self, name: &str, depth: usize) {
        let text = self.text;
        if let Some(node) = text.cycle.get("let").and_then(|lets| lets.get(name)) {
            if self.is_nearer(&node.spot) {
                self.add(format!("cycle.let.{name}"), &node.spot);
            } else {
                self.formula(node, depth + 1);
            }
        } else if let Some(node) = text.values.get(name) {
            let node = node.get("value").unwrap_or(node);
            // Most keys are given by the base of a design, and the user does not change the base.
            let nearest = text.sources.merged.last() == Some(&node.spot.document);
            if nearest && self.is_nearer(&node.spot) {
                self.add(name.to_owned(), &node.spot);
            }
        }
    }
}

fn each_name(term: &Term, f: &mut dyn FnMut(&str)) {
    match term {
        Term::Name(name) => f(name),
        Term::Number { .. } | Term::Word(_) => {}
        Term::Negative(inner) | Term::Disc(inner) | Term::Not(inner) => each_name(inner, f),
        Term::Binary(_, left, right)
        | Term::Compare(_, left, right)
        | Term::And(left, right)
        | Term::Or(left, right) => {
            each_name(left, f);
            each_name(right, f);
        }
        Term::Function(_, arguments) => arguments.iter().for_each(|argument| each_name(argument, f)),
        Term::Either(terms) => terms.iter().for_each(|term| each_name(term, f)),
    }
}
