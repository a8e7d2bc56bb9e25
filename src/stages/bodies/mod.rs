//! Finite-element bodies: geometry, mesh, modes, and the load vectors through which forces act on them.
//!
//! Workpiece and worktable meet in the plane z = 0, with z up; the workpiece's centre is at x = y = 0, with x along the
//! grain.
//!
//! [`Meshing`] makes the mesh, [`Attachment`] adds materials, supports and masses, [`Discretisation`] load vectors.
//! [`Modes`] solves for the full shapes in the elimination order found by [`Elimination`]. [`ModalModel`] reduces them
//! to the values that a shot reads, so a run whose bodies have not changed needs neither mesh nor full shapes.

mod attachment;
mod body;
mod contact_cells;
mod elimination;
mod error;
mod geometry;
mod joint;
mod load_places;
mod mesh_file;
mod meshing;
mod modes;
mod nail_stations;
mod pieces;
mod sensor_modes;
mod surfaces;
pub(crate) mod tool_loads;
mod tool_surfaces;

pub use attachment::{Attachment, Meshed};
pub use body::{Body, ModalModel, MovingSurface, Resolution, SIDES_PER_WAVE};
pub use contact_cells::{ContactCells, ContactFace};
pub use elimination::Elimination;
pub use error::BodyError;
pub use geometry::{AddedSand, BodyKind, Geometry, MeshSource, PartMaterials, Properties, Remainder};
pub use joint::{Joint, JointSpring};
pub use load_places::{Discretisation, LoadPlaces, Model, SideSand, SpringFoot};
pub use mesh_file::{Extent, FileUnit, MeshFile, states_unit};
pub use meshing::{Meshing, NamedMesh};
pub use modes::{Modes, WholeModes};
pub use nail_stations::NailPlace;
pub(crate) use nail_stations::STATIONS;
pub use sensor_modes::{BodySensors, SensorModes, SensorPoint};
pub use surfaces::{FoundSurface, Naming, Origin, SurfacePlace};
pub use tool_loads::ToolPlaces;
pub use tool_surfaces::ToolShape;
