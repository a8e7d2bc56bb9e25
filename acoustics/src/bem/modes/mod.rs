//! Modes of a body over frequency: radiation matrices, pressures at receivers, and fields band by band.

pub(crate) mod added_mass;
pub(crate) mod band_fields;
pub(crate) mod combination;
pub(crate) mod independent;
pub(crate) mod mean_ranges;
pub(crate) mod mesh_range;
pub(crate) mod modal;
pub(crate) mod packed_pressure;
pub(crate) mod range_solver;
pub(crate) mod receivers;
mod shared;
pub(crate) mod solution_id;
pub(crate) mod summary;
pub(crate) mod surface_fit;
pub(crate) mod surface_pressures;
