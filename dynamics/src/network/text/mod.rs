//! Assemblies as text: TOML files with formulas over keys, read into an [`Assembly`](super::Assembly).
//!
//! A file has three parts. `[cycle]` is the topology: blocks by family and name. `[keys.GROUP]` declares the assembly's
//! own keys. All other groups give values of keys. A number of a block is a formula over keys ("=disc(piston.bore)") or
//! a literal ("100 cm3", or a table with value, range and provenance). A literal is itself a key, named by its path
//! (`cycle.volume.gas.dead`).

mod blocks;
mod changes;
mod checks;
mod compile;
mod fault;
mod fields;
mod formula;
mod keys;
mod layers;
mod literal;
mod named;
mod names;
mod node;
mod resolve;
mod resolver;
mod table;
mod unused;

pub use blocks::CYCLE;
pub use changes::{PlacedBlock, PlacedError};
pub use fault::{AssemblyError, Change, Changes, Fault, Travels};
pub use keys::{KeyValue, Keys};
pub use layers::{AssemblyText, BUILT_IN, DeclaredKey, LAYOUT};
pub use literal::Literal;
pub use node::FieldText;
pub use resolve::Resolved;
pub use table::{FieldSpec, FieldType, TableSpec};
pub use unused::Unused;
