//! A design turned into things: the support of its workpiece and its sources of sound.

pub mod sources;
pub(crate) mod supports;
