//! `check` and `cycle` of a tool that a file describes as an assembly of blocks.

mod check;
mod cycle;
mod openings;

pub(super) use check::{draw, execute as check};
pub(super) use cycle::{Asked, execute as cycle};
