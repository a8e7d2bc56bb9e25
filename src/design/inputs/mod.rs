//! The inputs of the stages, made from a design: the only place where a stage's fields and the design file meet.

pub(crate) mod bodies;
pub(crate) mod cycle;
pub(crate) mod exhaust;
pub(crate) mod microphones;
pub(crate) mod notes;
pub(crate) mod radiation;
pub(crate) mod response;
pub(crate) mod sensors;
