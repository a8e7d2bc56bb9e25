//! nailnoise predicts how much sound power each source of a pneumatic nailer radiates, from its design.
//!
//! [`design`] reads the design file, [`chain`] assembles its stages, [`run`] ranks its sources, [`output`] makes files
//! of them, [`figures`] draws them, [`drawing`] shows the tool, and [`report`] makes a page of them. [`artifacts`] stores
//! all of it for the next run, [`comparison`] lays results side by side, [`watch`] serves the page of a design that is
//! being changed, and [`commands`] is the command line over all of it. [`measurement`] takes the recordings of a test
//! to levels, [`virtual_test`] makes such recordings from a design and compares it with measured levels,
//! [`penetration`] compares penetration laws, [`scaling`] makes a design of another tool, [`cost`] estimates the cost
//! of a run before it begins; [`sensitivity`] and [`study`] quantify how the ranges of a design affect its shot.
#![forbid(unsafe_code)]

pub mod artifacts;
pub mod chain;
pub mod commands;
pub mod comparison;
pub mod cost;
pub mod declaration;
pub mod design;
pub mod drawing;
mod error;
pub mod figures;
pub mod graph;
pub mod headline;
mod interrupt;
pub mod output;
pub mod penetration;
pub mod report;
pub mod result;
pub mod run;
pub mod scaling;
pub mod sensitivity;
pub mod shipped;
pub mod stages;
pub mod staging;
pub mod store;
pub mod study;
mod table;
mod threads;
pub mod virtual_test;
pub mod watch;
mod wording;

pub use design::Design;
pub use error::Error;
pub use nailnoise_measurement as measurement;
