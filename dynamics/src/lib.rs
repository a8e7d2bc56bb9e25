//! The nailing cycle of a pneumatic nailer: gas, motion, contacts and events.
//!
//! [`simulate`] turns [`Parameters`] (primary quantities only, SI) into a [`CycleRecord`]: every pressure, motion,
//! force and flow of one shot on a uniform time grid, the events t0..t18, and the checks that certify it.
//!
//! The model is that of Nili Ahmadabadi, "Noise source identification and dynamic modeling of a pneumatic nailing
//! device" (ETS Montreal, 2016), ch. 4, in a corrected form: mass and energy balances for five gas volumes, the
//! contacts only push, the nail is an elasto-plastic element and the rod meets it in a plastic impact.

#![warn(missing_docs)]

mod cycle;
mod energy;
mod error;
mod geometry;
mod log;
mod parameters;
mod presets;
pub mod prf;
mod record;
mod settings;
mod workpiece;

pub use cycle::{simulate, simulate_on};
pub use energy::{ContactEnergy, EnergyFlow};
pub use error::CycleError;
pub use geometry::Geometry;
pub use log::{Crossing, Direction, LogEntry, LogState};
pub use parameters::{
    Ambient, Block, Chambers, Contacts, Exhaust, Form, Friction, Hand, HeadValve, Model, Nail, Parameters, Piston,
    Supply, Support, SupportDamping, Tool, Trigger, Wood,
};
pub use record::{
    Body, Check, CycleRecord, Events, ExhaustFlow, Forces, Motion, Outcome, Summary, VentFlow, Volume, Work,
};
pub use settings::{Method, Settings};
pub use workpiece::{Compliance, CouplingWork, WoodForces, WoodMotion, Workpiece};
