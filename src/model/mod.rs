//! A design turned into things: the support of its workpiece.

pub(crate) mod supports;
