//! The boundary as panels: checks, mirror planes, quadrature rules, boxes, and coarser and finer meshes of the same
//! surface.

pub(crate) mod boundary;
pub(crate) mod boxes;
pub(crate) mod coarse;
pub(crate) mod gaps;
pub(crate) mod outline;
pub(crate) mod panel;
pub(crate) mod rules;
pub(crate) mod subdivision;
pub(crate) mod symmetric_part;
pub(crate) mod symmetry;
