//! The blocks of a tool after resolution: formulas are evaluated, numbers are in SI, and names are indices.
//!
//! Coordinates: +y points down the tool's axis, towards the workpiece; t = 0 is the start of the record. Blocks that a
//! design switches off are omitted. Each list is in the order of the file.

use nailnoise_penetration::ForceTable;
use nailnoise_penetration::fit::FittedLaw;
use serde::Serialize;

mod blow;
mod event;
mod expression;
mod gas;
mod mechanics;
mod output;
mod reference;

pub use blow::{ElasticBlow, Rod};
pub use event::{Action, Condition, Edge, Event, Outcome, OutcomeTest, Pick, Trigger, Word};
pub use expression::{Binary, Channel, Comparison, Expression, Function, Quantity, Sensor};
pub use gas::{
    Coefficient, Cone, Face, Gate, Opens, Passage, PassageLaw, Pipe, Polytropic, Reservoir, Restriction, Volume, Wall,
};
pub use mechanics::{
    Body, Contact, ContactDamping, Fastener, FastenerLaw, Force, ForceLaw, Friction, Hold, Motor, Push, Seated, Spring,
    SpringLaw, Start, Stop, Weights, WoodLaw,
};
pub use output::{ColumnValue, JetQuantity, Load, Marker, NamedColumn, Opening, PressurePatch, PressureSurface};
pub use reference::{Base, BlockRef, Connection, Family, Space};

/// A tool as a network of blocks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Assembly {
    /// Name of the assembly.
    pub name: String,
    /// Gas constant R \[J/(kg K)\].
    pub gas_constant: f64,
    /// Ratio of specific heats.
    pub heat_capacity_ratio: f64,
    /// Polytropic law instead of the balance of energy; none for an ideal gas.
    pub polytropic: Option<Polytropic>,
    /// Acceleration of gravity, along +y \[m/s2\].
    pub gravity: f64,
    /// Pressure ratio 1 - r below which a passage's flow is linear in the pressure difference.
    pub linear_ratio: f64,
    /// End of the record \[s\].
    pub end: f64,
    /// Event after which the record may end before [`end`](Self::end).
    pub finish: Option<Finish>,
    /// Balances to integrate.
    pub ledger: Ledger,
    /// Whether a uniform pressure on the faces of a body may have a resultant.
    pub unbalanced: bool,
    /// Infinite reservoirs. `atmosphere` is always one of them.
    pub reservoirs: Vec<Reservoir>,
    /// Moving bodies.
    pub bodies: Vec<Body>,
    /// Gas volumes.
    pub volumes: Vec<Volume>,
    /// Faces where gas acts on a body.
    pub faces: Vec<Face>,
    /// Passages between volumes and reservoirs.
    pub passages: Vec<Passage>,
    /// One-sided contacts.
    pub contacts: Vec<Contact>,
    /// Springs.
    pub springs: Vec<Spring>,
    /// Friction.
    pub frictions: Vec<Friction>,
    /// Imposed forces and jet thrusts.
    pub forces: Vec<Force>,
    /// Motors.
    pub motors: Vec<Motor>,
    /// Latches.
    pub holds: Vec<Hold>,
    /// Fasteners, at most one per driver.
    pub fasteners: Vec<Fastener>,
    /// Elastic blows on fasteners, at most one per fastener. They do not affect the cycle. They affect the force on the
    /// work at frequencies above those of the cycle.
    pub blows: Vec<ElasticBlow>,
    /// Boolean signals that passages, motors and latches follow.
    pub triggers: Vec<Trigger>,
    /// Named expressions.
    pub sensors: Vec<Sensor>,
    /// Named events.
    pub events: Vec<Event>,
    /// Outcomes of the shot, in order; the first whose test is satisfied applies.
    pub outcomes: Vec<Outcome>,
    /// Openings to the atmosphere that make noise.
    pub openings: Vec<Opening>,
    /// Forces on named surfaces of bodies.
    pub loads: Vec<Load>,
    /// Pressures on walls that exert no net force.
    pub pressures: Vec<PressureSurface>,
    /// Columns with names given by the assembly.
    pub columns: Vec<NamedColumn>,
    /// Markers of a measurement whose events have other names.
    pub markers: Vec<Marker>,
}

impl Assembly {
    /// Name of a block; empty if its index is out of range.
    pub fn name_of(&self, block: BlockRef) -> &str {
        let i = block.index;
        let name = match block.family {
            Family::Reservoir => self.reservoirs.get(i).map(|b| &b.name),
            Family::Body => self.bodies.get(i).map(|b| &b.name),
            Family::Volume => self.volumes.get(i).map(|b| &b.name),
            Family::Face => self.faces.get(i).map(|b| &b.name),
            Family::Passage => self.passages.get(i).map(|b| &b.name),
            Family::Contact => self.contacts.get(i).map(|b| &b.name),
            Family::Spring => self.springs.get(i).map(|b| &b.name),
            Family::Friction => self.frictions.get(i).map(|b| &b.name),
            Family::Force => self.forces.get(i).map(|b| &b.name),
            Family::Motor => self.motors.get(i).map(|b| &b.name),
            Family::Hold => self.holds.get(i).map(|b| &b.name),
            Family::Fastener => self.fasteners.get(i).map(|b| &b.name),
            Family::Trigger => self.triggers.get(i).map(|b| &b.name),
        };
        name.map_or("", |name| name)
    }

    /// All contacts, springs, forces, latches and motors.
    pub fn connections(&self) -> impl Iterator<Item = Connection> {
        let contacts = Connection::of_family(Family::Contact, &self.contacts, |own| (own.on, own.against));
        let springs = Connection::of_family(Family::Spring, &self.springs, |own| (own.on, own.against));
        let forces = Connection::of_family(Family::Force, &self.forces, |own| (own.on, own.against));
        let holds = Connection::of_family(Family::Hold, &self.holds, |own| (own.on, own.against));
        let motors = Connection::of_family(Family::Motor, &self.motors, |own| (own.on, own.against));
        contacts.chain(springs).chain(forces).chain(holds).chain(motors)
    }
}

impl Assembly {
    /// Assigns the table and the fitted law of a design to the fasteners in a wood. A formula cannot give these.
    pub fn set_resistance(&mut self, table: Option<&ForceTable>, fit: Option<&FittedLaw>) {
        for fastener in &mut self.fasteners {
            if let FastenerLaw::Wood(law) = &mut fastener.law {
                law.table = table.cloned();
                law.fit = fit.cloned();
            }
        }
    }
}

/// Early end of the record: `tail` after `event`, but not past another event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finish {
    /// Index of the event in [`Assembly::events`].
    pub event: usize,
    /// Time after the event \[s\].
    pub tail: f64,
    /// Index of an event at which the record ends at the latest.
    pub never_past: Option<usize>,
}

/// Balances that are integrated with the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Ledger {
    /// Flows across the boundary, heat, work and losses.
    Lean,
    /// Also every passage, wall and face, so that the balance of each volume can be checked.
    Full,
}
