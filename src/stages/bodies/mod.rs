//! Finite-element bodies: geometry, mesh, modes, and the load vectors through which forces act on them.
//!
//! Workpiece and worktable meet in the plane z = 0, z up; the workpiece's centre is at x = y = 0, x along the grain.
//!
//! [`Discretisation`] makes the mesh with materials and load vectors, [`Modes`] solves for the whole shapes, [`ModalModel`]
//! reduces them to what a shot reads: a run whose bodies have not changed needs neither mesh nor whole shapes.

mod body;
mod geometry;
mod load_places;
mod modes;
mod nail_stations;
mod sensor_modes;
pub(crate) mod tool_loads;

pub use body::{Body, ModalModel, MovingSurface, Resolution, SIDES_PER_WAVE};
pub use geometry::{AddedSand, BodyKind, Geometry, MeshFile, MeshSource, Meshed, PartMaterials, Remainder};
pub use load_places::{ContactCells, Discretisation, LoadPlaces, Model, NailPlace, SideSand, SpringFoot};
pub use modes::{Modes, WholeModes};
pub(crate) use nail_stations::STATIONS;
pub use sensor_modes::{BodySensors, SensorModes, SensorPoint};
pub use tool_loads::ToolPlaces;
