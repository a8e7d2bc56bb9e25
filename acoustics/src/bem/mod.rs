//! Boundary elements for the sound around a closed surface, in free space or above a rigid floor.
//!
//! ```text
//! mesh -> Boundary   closed, normals into the air, above the floor; repairs are counted
//!      -> Exterior   blocks of panels, close pairs and their rules; cost estimate
//!      -> solve      one frequency: operators, one factorisation, pressure of all velocity patterns
//!      -> R(f)       from the far field (symmetric, positive), and from the surface beside it
//! ```
//!
//! One frequency runs on one thread; different frequencies run in parallel.

mod compressed;
pub(crate) mod error;
mod high_frequencies;
mod mesh;
mod modes;
mod operators;
mod solver;

pub use error::BemError;
pub use high_frequencies::mean_bands::{MeanBand, MeanBands};
pub use mesh::boundary::{Boundary, Repairs};
pub use mesh::boxes::{Side, SolidBox};
pub use mesh::gaps::{Gap, Gaps, Rim};
pub use mesh::outline::ClosedOutline;
pub use mesh::panel::{BoundaryMesh, Panel, PanelPoint};
pub use mesh::subdivision::Subdivision;
pub use mesh::symmetric_part::SymmetricPart;
pub use mesh::symmetry::Parity;
pub use modes::band_fields::{BandFields, SurfaceBand, WholeSurface};
pub use modes::mean_ranges::MeanRanges;
pub use modes::mesh_range::MeshRange;
pub use modes::modal::{ModalBem, ModalErp};
pub use modes::receivers::{ModalPressures, Receivers};
pub use modes::summary::Summary;
pub use modes::surface_fit::SurfaceFit;
pub use modes::surface_pressures::SurfacePressures;
pub use solver::cost::{FrequencyCost, SurfaceSize};
pub use solver::neumann::Patterns;
pub use solver::plate::{Plate, WetSides};
pub use solver::problem::{EquationSolver, Exterior, SurfacePressure};
pub use solver::resistance::{Estimate, TwoEvaluations};
pub use solver::transfer::MovingPart;
