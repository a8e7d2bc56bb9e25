//! A tool as a network of blocks: gas volumes, passages, bodies, contacts, springs, friction, a fastener, triggers.
//!
//! An [`Assembly`] is the topology with every number in SI. It is compiled once into a plan, which is integrated into a
//! record of named channels.

pub mod assembly;
mod text;

pub use assembly::Assembly;
pub use text::{AssemblyError, AssemblyText, BUILT_IN, DeclaredKey, Fault, KeyValue, Keys, Literal, Resolved};
