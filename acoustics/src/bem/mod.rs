//! Boundary elements for the sound around a closed surface, in free space or above a rigid floor.
//!
//! ```text
//! mesh -> Boundary   closed, normals into the air, above the floor; what was mended is counted
//!      -> Exterior   blocks of panels, close pairs and their rules; what it will cost
//!      -> solve      one frequency: operators, one factorisation, pressure of all velocity patterns
//!      -> R(f)       from the far field (symmetric, positive), and from the surface beside it
//! ```
//!
//! One frequency runs on one thread; frequencies run beside each other.

mod above;
mod around;
mod bands;
mod blend;
mod blocks;
mod boundary;
mod boxes;
mod coarse;
mod combination;
mod equations;
mod faces;
mod far;
mod far_field;
mod field;
mod independent;
mod modal;
mod near;
mod outline;
mod panel;
mod problem;
mod receivers;
mod resistance;
mod rules;
mod single;
mod solver;
mod symmetry;
mod tile;
mod transfer;
pub(crate) mod trig;

pub use bands::{Sounding, SurfaceBand, WholeSurface};
pub use blend::BlendedRadiation;
pub use boundary::{Boundary, Mended};
pub use boxes::{Side, SolidBox};
pub use modal::{Level, ModalBem, ModalErp, Summary};
pub use outline::ClosedOutline;
pub use panel::{BoundaryMesh, Panel, PanelPoint};
pub use problem::{Exterior, Patterns, SurfacePressure};
pub use receivers::Receivers;
pub use resistance::{Estimate, TwoEvaluations};
pub use symmetry::Parity;
pub use transfer::MovingPart;
