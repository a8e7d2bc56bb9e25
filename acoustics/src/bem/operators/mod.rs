//! The boundary operators: panels in blocks, the rule for distant panels, rules for close ones, and the equations they
//! form.

pub(crate) mod blocks;
pub(crate) mod equations;
pub(crate) mod far;
pub(crate) mod kernel;
pub(crate) mod near;
pub(crate) mod tile;
pub(crate) mod wave;
