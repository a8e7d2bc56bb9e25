//! Radiation of the bodies per unit of modal motion, independent of the actual motion.
//!
//! The costly part depends only on the wavelength. It is computed in standard air and stored ([`RadiationMatrix`],
//! [`PressureOnSurface`], [`FlushMatrix`]). For boundary elements, it is that of the modes of reference bodies of the
//! same shape ([`ProjectedMatrix`]). [`WorkpieceRadiator`] and [`ToolRadiator`] take it over to the ambient air.

mod boundary_elements;
mod covered;
mod error;
mod flush_with_sand;
mod matrices;
mod radiators;
mod reference;
mod surface_modes;
mod tool;
mod tool_parts;
mod workpiece;

pub(crate) use boundary_elements::describe_gap;
pub use boundary_elements::{Places, Resolution, Solution};
pub use covered::{CoveredFaces, OpenFaces};
pub use error::SurfaceError;
pub use flush_with_sand::{FlushTop, top_of};
pub use matrices::{
    FlushMatrix, MatrixWithMicrophones, PressureAtMicrophones, PressureOnSurface, RadiationMatrix, ToolCapSolution,
    ToolSolution, WorkpieceSolution,
};
pub use radiators::{FluidLoadings, ToolRadiator, WorkpieceMethod, WorkpieceRadiator};
pub use reference::{
    ProjectedMatrix, ProjectedPressures, Projection, RadiatingShape, ReferenceProjection, ReferenceResult,
};
pub use surface_modes::SurfaceModes;
pub use tool::ToolRadiation;
pub use tool_parts::{CapSurface, CoveredSurfaces, ToolCover};
pub use workpiece::{WorkpieceBoundaryElements, WorkpieceRadiation};

use super::{Code, code};

/// Code that the stages of this module call.
const CODE: Code = code!(meshes, fem, acoustics, stages_bodies, stages_radiation);
