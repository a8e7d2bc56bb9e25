//! Boundary element method for the sound around a closed surface, in free space or above a rigid floor.
//!
//! ```text
//! mesh -> Boundary   closed, normals into the air, above the floor; repairs are counted
//!      -> Exterior   blocks of panels, close pairs and their rules; cost estimate
//!      -> solve      one frequency: operators, one factorisation, pressure of all velocity patterns
//!      -> R(f)       from the far field (symmetric, positive), and for comparison from the surface
//! ```
//!
//! Each frequency is solved on one thread; different frequencies run in parallel.

pub(crate) mod error;
pub(crate) mod mesh;
pub(crate) mod operators;
pub(crate) mod solve;

pub use error::BemError;
pub use mesh::boundary::{Boundary, Repairs};
pub use mesh::boxes::{Side, SolidBox};
pub use mesh::gaps::{Gap, Gaps, Rim};
pub use mesh::outline::ClosedOutline;
pub use mesh::panel::{BoundaryMesh, Panel, PanelPoint};
pub use mesh::subdivision::Subdivision;
pub use mesh::symmetric_part::SymmetricPart;
pub use mesh::symmetry::Parity;
pub use solve::cost::{FrequencyCost, SurfaceSize};
pub use solve::cover::SurfaceCover;
pub use solve::neumann::Patterns;
pub use solve::plate::{Plate, WetSides};
pub use solve::problem::{EquationSolver, Exterior, SurfacePressure};
pub use solve::transfer::MovingPart;
