//! Solution at one frequency: pressures on the surface, around it and in the far field, and the resulting radiation
//! resistances.

pub(crate) mod around;
pub(crate) mod compressed;
pub(crate) mod cost;
pub(crate) mod cover;
mod covered;
pub(crate) mod far_field;
pub(crate) mod field;
pub(crate) mod impedance;
pub(crate) mod neumann;
pub(crate) mod plate;
pub(crate) mod problem;
pub(crate) mod sweep;
pub(crate) mod transfer;
