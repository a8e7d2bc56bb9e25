//! Positions of integrals, switches and memories, and the indices of places.

use super::mechanics::Pair;
use crate::network::assembly::{Assembly, Base, Space};

/// Name and unit of an integral.
#[derive(Debug, Clone)]
pub(crate) struct LedgerItem {
    pub(crate) name: String,
    pub(crate) unit: &'static str,
}

/// Allocates positions of integrals, switches and memories.
pub(super) struct Compiler<'a> {
    pub(super) assembly: &'a Assembly,
    /// Body that an external structure replaces.
    pub(super) driven: Option<usize>,
    pub(super) states: usize,
    pub(super) ledger: Vec<LedgerItem>,
    pub(super) switches: usize,
    pub(super) memories: usize,
}

impl Compiler<'_> {
    pub(super) fn integral(&mut self, name: String, unit: &'static str) -> usize {
        self.ledger.push(LedgerItem { name, unit });
        self.states + self.ledger.len() - 1
    }

    pub(super) fn switch(&mut self) -> usize {
        self.switches += 1;
        self.switches - 1
    }

    pub(super) fn memory(&mut self, count: usize) -> usize {
        self.memories += count;
        self.memories - count
    }

    pub(super) fn body(&self, base: Base) -> usize {
        match base {
            Base::Ground => self.assembly.bodies.len(),
            Base::Body(i) => i,
        }
    }

    pub(super) fn pair(&self, on: usize, against: Base) -> Pair {
        Pair {
            on,
            against: self.body(against),
        }
    }

    /// Whether a block between two bodies carries the driven body.
    pub(super) fn carries(&self, on: usize, against: Base) -> bool {
        self.driven == Some(on) && against == Base::Ground
    }

    pub(super) fn gas(&self, space: Space) -> usize {
        match space {
            Space::Volume(i) => i,
            Space::Reservoir(i) => self.assembly.volumes.len() + i,
        }
    }
}
