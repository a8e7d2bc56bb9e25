//! References between blocks.

use serde::Serialize;

/// One side of a passage or a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Space {
    /// Index in [`Assembly::volumes`](super::Assembly::volumes).
    Volume(usize),
    /// Index in [`Assembly::reservoirs`](super::Assembly::reservoirs).
    Reservoir(usize),
}

impl Space {
    /// The block of the space.
    pub fn block(self) -> BlockRef {
        let (family, index) = match self {
            Self::Volume(index) => (Family::Volume, index),
            Self::Reservoir(index) => (Family::Reservoir, index),
        };
        BlockRef { family, index }
    }
}

/// Reference of a motion, or object of the reaction of a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Base {
    /// The body at rest.
    Ground,
    /// Index in [`Assembly::bodies`](super::Assembly::bodies).
    Body(usize),
}

/// Families of blocks that have channels or log words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Family {
    /// Reservoir: pressure, gauge, temperature.
    Reservoir,
    /// Body: travel, speed, position, velocity, acceleration, moving mass.
    Body,
    /// Volume: pressure, gauge, temperature, mass, volume.
    Volume,
    /// Face: force.
    Face,
    /// Passage: mass flow, plenum pressure, choked.
    Passage,
    /// Contact: overlap, force.
    Contact,
    /// Spring: force.
    Spring,
    /// Friction: force.
    Friction,
    /// Imposed force: force.
    Force,
    /// Motor: force.
    Motor,
    /// Latch: force.
    Hold,
    /// Fastener: depth, deepest, advance, force, guide force.
    Fastener,
    /// Trigger: on (1) or off (0).
    Trigger,
}

/// A block by family and index in that family's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct BlockRef {
    /// Family of the block.
    pub family: Family,
    /// Index in the family's list.
    pub index: usize,
}

/// A block that exerts a force between two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Connection {
    /// The block.
    pub block: BlockRef,
    /// Index of the body that it acts on.
    pub on: usize,
    /// The body that carries the reaction.
    pub against: Base,
}

impl Connection {
    /// Whether the force or its reaction acts on a body.
    pub fn acts_on(&self, body: usize) -> bool {
        self.on == body || self.against == Base::Body(body)
    }

    /// The connections of one family, whose blocks have these bodies.
    pub(super) fn of_family<T>(
        family: Family,
        blocks: &[T],
        bodies: fn(&T) -> (usize, Base),
    ) -> impl Iterator<Item = Self> {
        blocks.iter().enumerate().map(move |(index, block)| {
            let (on, against) = bodies(block);
            let block = BlockRef { family, index };
            Self { block, on, against }
        })
    }
}
