//! nailnoise predicts how much sound power each source of a pneumatic nailer radiates, from its design.

pub mod design;
