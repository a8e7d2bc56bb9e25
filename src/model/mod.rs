//! The model of a design: the support of its workpiece and its sources of sound.

pub mod sources;
pub(crate) mod supports;
