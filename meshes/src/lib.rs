//! Finite-element meshes: structured meshers, surfaces, quality checks and file formats.
//!
//! A [`Mesh`] contains nodes, elements that each belong to a part, and named groups of element faces. [`block()`],
//! [`worktable()`] and [`tool()`] build second-order meshes; [`SolidGeometry`] meshes STEP files. [`Surface`] contains
//! the outer faces with their normals; [`Mesh::locate`] finds the nodes and weights that interpolate a value at any
//! point. [`msh`], [`vtu`], [`vtkhdf`] and [`uff`] exchange files with gmsh, ParaView and modal-test software. All
//! lengths are in metres.
#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod block;
pub mod child;
pub mod digits;
mod element;
mod error;
mod gauss;
pub mod gmsh;
mod grid;
pub mod locate;
mod mesh;
pub mod msh;
mod open_surface;
mod points;
mod quality;
mod reflection;
mod size;
mod smooth;
mod solid;
mod straighten;
mod surface;
pub mod temporary;
mod tool;
mod tubes;
pub mod uff;
pub mod vtkhdf;
pub mod vtu;
mod worktable;

pub use block::{Block, JOINT, block, jointed_block};
pub use element::{ElementKind, FaceKind, FaceNodes};
pub use error::MeshError;
pub use gauss::gauss_legendre;
pub use grid::Grid;
pub use locate::Location;
pub use mesh::{ElementRef, FaceGroup, FaceRef, Mesh};
pub use msh::MshError;
pub use nailnoise_documents::read_regular;
pub use open_surface::open_faces;
pub use quality::{Jacobian, POOR, Quality};
pub use size::{element_size, subdivide};
pub use smooth::SmoothFace;
pub use solid::{SolidGeometry, allow_memory};
pub use surface::{QuadraturePoint, Surface, SurfaceFace};
pub use tool::{Tool, ToolDimensions, tool, tool_ships};
pub use tubes::tube_worktable;
pub use worktable::{Worktable, worktable};
