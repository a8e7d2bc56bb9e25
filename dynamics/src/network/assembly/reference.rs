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

/// What a motion is relative to, or a force reacts on.
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
