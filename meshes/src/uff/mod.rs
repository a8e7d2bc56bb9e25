//! Universal files (SDRC-UFF) for modal-test software. Nodes (datasets 15 and 2411), elements (2412), mode shapes (55)
//! and time histories (58) are read and written; coordinate systems of nodes (18 and 2420) and the unit of length (164)
//! are read.
//!
//! Formats: Structural Dynamics Research Laboratory, University of Cincinnati, *Universal File Formats for Modal
//! Analysis Testing*. Lengths are in m, mode shapes in the unit of the caller. The skin is written instead of the
//! volume, because test software draws the skin, and only the skin can be measured.

mod dataset;
mod function;
mod history;
mod read;
mod systems;
mod write;

pub use dataset::UffError;
pub use function::{Function, functions, is_universal};
pub use history::{History, Ordinate};
pub use read::{MeasuredMode, Measurement, parse, read, units};
pub use systems::Axes;
pub use write::{Mode, text};
