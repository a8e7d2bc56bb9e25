//! The `nailnoise` command.
fn main() {}
