//! The chain from design to sound power, through the library.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

#[path = "../common/mod.rs"]
mod common;

mod assemblies;
mod cached_body;
mod convention;
mod coupling;
mod cover;
mod cycle;
mod figures;
mod fluid_loading;
mod joint;
mod laws;
mod layering;
mod modules;
mod radiation;
mod requirements;
mod rigid_housing;
mod sensitivity;
mod sound_files;
mod sources;
mod study;
mod tool;
mod transducers;
mod worktables;
