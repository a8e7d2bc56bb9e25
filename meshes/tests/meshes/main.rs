//! Meshes and their files.
#![allow(clippy::unwrap_used)]

#[path = "../../../tests/common/base_design.rs"]
mod base_design;
mod common;

mod block;
mod locate;
mod mesh;
mod msh;
mod surface;
mod tool;
mod tubes;
mod uff;
mod vtkhdf;
mod vtu;
mod worktable;
