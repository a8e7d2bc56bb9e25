//! Universal files (SDRC-UFF) for modal-test software: nodes (datasets 15 and 2411), elements (2412), mode shapes (55),
//! time histories (58).
//!
//! Formats: Structural Dynamics Research Laboratory, University of Cincinnati, *Universal File Formats for Modal Analysis
//! Testing*. Lengths are in m, shapes in the unit of the caller. The skin is written, not the volume: it is what test
//! software draws and what can be measured.

mod dataset;
mod function;
mod history;
mod read;
mod write;

pub use dataset::UffError;
pub use function::{Function, functions, is_universal};
pub use history::{History, Ordinate};
pub use read::{MeasuredMode, Measurement, parse, read};
pub use write::{Mode, text};
