//! Radiators, their energy and their sound.
#![allow(clippy::unwrap_used)]

#[path = "../common/boundary_meshes.rs"]
mod boundary_meshes;
#[path = "../common/radiating_surfaces.rs"]
mod radiating_surfaces;

mod air;
mod compact;
mod energy;
mod intervals;
mod parts;
mod pipe;
mod receivers;
mod sampling;
mod skin;

mod boundary_elements {
    mod means;
    mod modal;
}
mod fluid_loading {
    mod plates;
    mod shell;
}
mod flush_with_sand {
    mod rayleigh;
    mod sand;
}
