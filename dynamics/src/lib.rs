#![doc = include_str!("../README.md")]

pub mod blow;
mod coupling;
mod energy;
mod error;
mod geometry;
mod log;
pub mod machine;
mod nailer;
pub mod network;
mod parameters;
mod penetration;
mod presets;
mod record;
mod settings;
mod workpiece;

pub use energy::{ContactEnergy, EnergyFlow};
pub use error::CycleError;
pub use geometry::{Geometry, critical_ratio};
pub use log::{Crossing, Direction, LogEntry, LogState};
pub use nailer::{blow_input, simulate, simulate_figures, simulate_loads, simulate_on};
pub use nailnoise_penetration::{NailedWood, Wood};
pub use parameters::{
    Ambient, Block, BlowModel, Chambers, Contacts, Exhaust, Form, Friction, Hand, HeadValve, Model, Nail, Parameters,
    Piston, Supply, Support, SupportDamping, Tool, Trigger,
};
pub use record::{CycleRecord, Events, NailerFigures, Outcome, Summary};
pub use settings::{Method, Settings};
pub use workpiece::{Compliance, CouplingWork, WoodForces, WoodMotion, Workpiece};
