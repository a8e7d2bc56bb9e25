//! The program as a user runs it: tables, JSON, files, exit status, messages.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

#[path = "../common/mod.rs"]
mod common;

mod assembly;
mod cache;
mod calibrate;
mod compare;
mod cycle;
mod declare;
mod documented_designs;
mod drawing;
mod examples;
mod faults;
mod installed;
mod measure;
mod mesh;
mod migrate;
mod optimise;
mod outcomes;
mod own_assembly;
mod penetration;
mod penetration_fit;
mod penetration_tables;
mod report;
mod run;
mod scene;
mod structures;
mod study;
mod surface_records;
mod sweep;
mod units;
mod verify;
mod watch;
