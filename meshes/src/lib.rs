//! Finite-element meshes: built-in mesher, skin, quality and VTK output.
//!
//! A [`Mesh`] holds nodes, elements with a part each, and named groups of element faces. [`block()`] and
//! [`worktable()`] build structured quadratic meshes of the two wooden bodies; [`Surface`] is the skin through which a
//! body radiates; [`locate`] finds the nodes and weights that carry a value to any point; [`vtu`] writes what a
//! post-processor reads. Lengths are in metres throughout.
#![forbid(unsafe_code)]

mod block;
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
mod size;
mod straighten;
mod surface;
mod tool;
mod tubes;
pub mod uff;
pub mod vtu;
mod worktable;

pub use block::{Block, block};
pub use element::{ElementKind, FaceKind, FaceNodes};
pub use error::MeshError;
pub use gauss::gauss_legendre;
pub use grid::Grid;
pub use locate::Location;
pub use mesh::{ElementRef, FaceGroup, FaceRef, Mesh};
pub use msh::MshError;
pub use open_surface::open_faces;
pub use quality::{Jacobian, POOR, Quality};
pub use size::{element_size, subdivide};
pub use surface::{QuadraturePoint, Surface, SurfaceFace};
pub use tool::{Tool, tool, tool_ships};
pub use tubes::tube_worktable;
pub use worktable::{Worktable, worktable};
