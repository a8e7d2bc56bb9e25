//! A design turned into things: its sources.

pub mod sources;
