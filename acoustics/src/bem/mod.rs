//! Exterior boundary elements.
mod blocks;
mod boundary;
mod far_field;
mod near;
mod panel;
mod problem;
mod resistance;
mod rules;
mod tile;
mod trig;
pub use boundary::{Boundary, Mended};
pub use panel::{BoundaryMesh, Panel, PanelKind, PanelPoint};
pub use problem::{Exterior, SurfacePressure};
pub use resistance::{BlendedRadiation, Estimate, TwoEvaluations};
