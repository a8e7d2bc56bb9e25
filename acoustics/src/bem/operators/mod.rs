//! The boundary operators: panels in blocks, quadrature rules for distant and close panels, and the resulting
//! equations.

pub(crate) mod blocks;
pub(crate) mod equations;
pub(crate) mod far;
pub(crate) mod kernel;
pub(crate) mod near;
pub(crate) mod tile;
pub(crate) mod wave;
