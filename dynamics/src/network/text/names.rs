//! Names of blocks, quantities of their channels, and the words that they log.

use nailnoise_quantities::Dimension;
use nailnoise_quantities::dimension::{
    ACCELERATION, FORCE, LENGTH, MASS, MASS_FLOW, NUMBER, PRESSURE, TEMPERATURE, VELOCITY, VOLUME,
};

use super::node::{Node, Spot};
use crate::network::assembly::{Action, Assembly, BlockRef, Family, Quantity};

/// Families whose blocks have channels, by the name of their table.
pub(super) const CHANNELS: [(&str, Family); 13] = [
    ("reservoir", Family::Reservoir),
    ("body", Family::Body),
    ("volume", Family::Volume),
    ("face", Family::Face),
    ("passage", Family::Passage),
    ("contact", Family::Contact),
    ("spring", Family::Spring),
    ("friction", Family::Friction),
    ("force", Family::Force),
    ("motor", Family::Motor),
    ("hold", Family::Hold),
    ("fastener", Family::Fastener),
    ("trigger", Family::Trigger),
];

/// Name of a family's table.
pub(super) fn family_name(family: Family) -> &'static str {
    CHANNELS
        .iter()
        .find(|(_, own)| *own == family)
        .map_or("block", |(name, _)| name)
}

/// A block by name.
#[derive(Debug)]
pub(super) struct Block<'a> {
    pub(super) name: &'a str,
    pub(super) block: BlockRef,
    pub(super) node: &'a Node,
    pub(super) spot: &'a Spot,
}

/// All blocks with channels.
#[derive(Debug, Default)]
pub(super) struct Names<'a> {
    pub(super) blocks: Vec<Block<'a>>,
    /// Names switched off by an `if`.
    pub(super) off: Vec<&'a str>,
    /// Sensors in order.
    pub(super) sensors: Vec<&'a str>,
    /// Events in order.
    pub(super) events: Vec<&'a str>,
}

impl<'a> Names<'a> {
    /// The block of a name.
    pub(super) fn find(&self, name: &str) -> Option<&Block<'a>> {
        self.blocks.iter().find(|block| block.name == name)
    }

    /// The index of a block of a family.
    pub(super) fn index(&self, name: &str, family: Family) -> Option<usize> {
        self.find(name)
            .filter(|block| block.block.family == family)
            .map(|block| block.block.index)
    }

    /// Names of the other blocks of the family of a table.
    pub(super) fn others_of(&self, table: &str, name: &str) -> Vec<String> {
        let of_table = self.blocks.iter().filter(|own| family_name(own.block.family) == table);
        let names = of_table.map(|own| own.name.to_owned());
        names.filter(|own| own != name).collect()
    }

    /// Names of the blocks of some families.
    pub(super) fn of(&self, families: &[Family]) -> Vec<String> {
        let of = self
            .blocks
            .iter()
            .filter(|block| families.contains(&block.block.family));
        of.map(|block| block.name.to_owned()).collect()
    }
}

/// Quantities of a family, with their names in expressions.
pub(super) fn quantities(family: Family) -> &'static [(&'static str, Quantity)] {
    use Quantity as Q;
    match family {
        Family::Reservoir => &[
            ("pressure", Q::Pressure),
            ("gauge", Q::Gauge),
            ("temperature", Q::Temperature),
        ],
        Family::Body => &[
            ("travel", Q::Travel),
            ("speed", Q::Speed),
            ("position", Q::Position),
            ("velocity", Q::Velocity),
            ("acceleration", Q::Acceleration),
            ("moving_mass", Q::MovingMass),
        ],
        Family::Volume => &[
            ("pressure", Q::Pressure),
            ("gauge", Q::Gauge),
            ("temperature", Q::Temperature),
            ("mass", Q::Mass),
            ("volume", Q::Volume),
        ],
        Family::Passage => &[("mass_flow", Q::MassFlow), ("plenum", Q::Plenum), ("choked", Q::Choked)],
        Family::Contact => &[("overlap", Q::Overlap), ("force", Q::Force)],
        Family::Face | Family::Spring | Family::Friction | Family::Force | Family::Motor | Family::Hold => {
            &[("force", Q::Force)]
        }
        Family::Fastener => &[
            ("depth", Q::Depth),
            ("tip", Q::Tip),
            ("deepest", Q::Deepest),
            ("advance", Q::Advance),
            ("force", Q::Force),
            ("guide_force", Q::GuideForce),
        ],
        Family::Trigger => &[("on", Q::On)],
    }
}

impl Assembly {
    /// The quantities of all blocks by their names in expressions, as `piston.travel`, with their dimensions.
    pub fn quantities(&self) -> Vec<(String, Dimension)> {
        let mut all = Vec::new();
        for (_, family) in CHANNELS {
            let named = (0..).map(|index| self.name_of(BlockRef { family, index }));
            for block in named.take_while(|name| !name.is_empty()) {
                let own = quantities(family).iter();
                all.extend(own.map(|(name, quantity)| (format!("{block}.{name}"), dimension(*quantity))));
            }
        }
        all
    }
}

/// Dimension of a quantity.
pub(super) fn dimension(quantity: Quantity) -> Dimension {
    match quantity {
        Quantity::Travel | Quantity::Position | Quantity::Overlap | Quantity::Depth => LENGTH,
        Quantity::Tip | Quantity::Deepest => LENGTH,
        Quantity::Speed | Quantity::Velocity | Quantity::Advance => VELOCITY,
        Quantity::Acceleration => ACCELERATION,
        Quantity::MovingMass | Quantity::Mass => MASS,
        Quantity::Pressure | Quantity::Gauge | Quantity::Plenum => PRESSURE,
        Quantity::Temperature => TEMPERATURE,
        Quantity::Volume => VOLUME,
        Quantity::MassFlow => MASS_FLOW,
        Quantity::Force | Quantity::GuideForce => FORCE,
        Quantity::Choked | Quantity::On => NUMBER,
    }
}

/// Words that the blocks of a family log.
pub(super) fn words(family: Family) -> &'static [(&'static str, Action)] {
    use Action as A;
    match family {
        Family::Contact => &[("closes", A::Closes), ("opens", A::Opens)],
        Family::Passage => &[
            ("opens", A::Opens),
            ("shuts", A::Shuts),
            ("uncovered", A::Uncovered),
            ("covered", A::Covered),
            ("choked", A::Choked),
            ("unchoked", A::Unchoked),
            ("reverses", A::Reverses),
            ("gate opens", A::GateOpens),
            ("gate shuts", A::GateShuts),
        ],
        Family::Body => &[("reverses", A::Reverses)],
        Family::Fastener => &[
            ("struck", A::Struck),
            ("left", A::Left),
            ("enters", A::Enters),
            ("seats", A::Seats),
            ("unloads", A::Unloads),
            ("reloads", A::Reloads),
        ],
        Family::Friction => &[("sticks", A::Sticks), ("slips", A::Slips)],
        Family::Hold => &[("catches", A::Catches), ("releases", A::Releases)],
        Family::Motor => &[("runs", A::Runs), ("stops", A::Stops)],
        Family::Trigger => &[("switches on", A::SwitchesOn), ("switches off", A::SwitchesOff)],
        Family::Reservoir | Family::Volume | Family::Face | Family::Spring | Family::Force => &[],
    }
}
