#![doc = include_str!("../README.md")]

mod document;
mod keys;
mod memory;
mod nearest;
mod place;
mod regular;
pub mod tables;
pub mod text;
mod value;

pub use document::{Document, DocumentError};
pub use keys::{KeyError, Keys, Value};
pub use memory::{MemoryLimit, address_space, available};
pub use nearest::nearest;
pub use place::Place;
pub use regular::{open_regular, read_regular};
pub use value::{found, found_value};
