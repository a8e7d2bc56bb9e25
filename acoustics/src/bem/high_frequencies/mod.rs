//! Frequencies above those solved one by one: means of boundary elements, and the limit of short waves.

pub(crate) mod above;
pub(crate) mod blend;
pub(crate) mod faces;
