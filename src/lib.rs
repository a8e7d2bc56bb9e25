//! nailnoise predicts how much sound power each source of a pneumatic nailer radiates, from its design.
//!
//! [`design`] reads the design file, and [`model`] turns it into a support and sources of sound, one file each.
//! [`chain`] assembles their stages, and [`run`] ranks the sources. [`output`] makes the files of a run, [`figures`]
//! and [`drawing`] draw its charts, and [`report`] makes a page of it; [`artifacts`] stores the results for the next
//! run. [`study`] and [`sensitivity`] quantify how the ranges of a design affect its shot, and [`comparison`] compares
//! results.
//!
//! [`measurement`] converts the recordings of a test to levels; [`virtual_test`] makes such recordings from a design
//! and compares it with measured levels. [`verification`] computes public benchmarks. [`penetration`] compares
//! penetration laws, [`scaling`] makes a design of another tool, and [`cost`] estimates the cost of a run before it
//! begins. [`units`] contains the units in which results are shown. [`watch`] serves the page of a design that is being
//! edited, and [`commands`] is the command line for all of this.
#![forbid(unsafe_code)]

pub mod artifacts;
pub mod atomic_write;
pub mod calibration;
pub mod chain;
pub mod commands;
pub mod comparison;
pub mod cost;
mod decibels;
pub mod declaration;
pub mod design;
pub mod drawing;
mod error;
pub mod figures;
pub mod graph;
pub mod headline;
mod interrupt;
pub mod model;
pub mod optimisation;
pub mod output;
pub mod penetration;
pub mod report;
pub mod result;
pub mod run;
pub mod scaling;
pub mod sensitivity;
pub mod shipped;
pub mod stages;
pub mod study;
mod tables;
pub mod units;
pub mod verification;
pub mod virtual_test;
pub mod watch;
mod wording;

pub use design::Design;
pub use error::Error;
pub use nailnoise_measurement as measurement;
pub use nailnoise_pipeline::store;
