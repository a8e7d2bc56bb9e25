//! Manifests of tests and their recordings: written files are read back, and each fault is refused with its file, its
//! channel, its value and a remedy.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

mod channels;
mod containers;
mod damaged;
mod manifest;
mod recordings;
mod written;
