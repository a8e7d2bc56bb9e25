//! Parts of the tool's outer surface: its cap, and the surfaces under a porous cover.

use nailnoise_acoustics::PorousLayer;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Panel, SurfaceCover};
use nalgebra::DMatrix;
use serde::Serialize;

use super::error::SurfaceError;
use crate::error::Error;

/// Maximum distance of a node from the cap to which it belongs, relative to the cap's radius.
const OFF_CAP: f64 = 1e-3;

/// Surfaces that stay bare under a cover of the housing: the operator's hand and the workpiece are on them.
const BARE: [&str; 2] = ["handle", "nose_tip"];

/// The outer side of the tool's cap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum CapSurface {
    /// All of the outer surface above a height, within a radius around the axis \[m\].
    Above {
        /// Height of the cap's underside in the tool's coordinates \[m\].
        height: f64,
        /// Radius of the cap \[m\].
        radius: f64,
    },
    /// The surface with this name.
    Named(&'static str),
}

impl CapSurface {
    /// For each panel of a boundary, whether it is part of the cap.
    ///
    /// # Errors
    /// [`SurfaceError::NoCapSurface`] if none or all are.
    pub(super) fn panels(&self, mesh: &BoundaryMesh) -> Result<Vec<bool>, Error> {
        let inside = |panel: &Panel| match *self {
            Self::Above { height, radius } => panel.corners().iter().all(|&node| {
                let (point, slack) = (mesh.points[node], OFF_CAP * radius);
                point.z >= height - slack && point.x.hypot(point.y) <= radius + slack
            }),
            Self::Named(name) => mesh.patches[panel.patch] == name,
        };
        let panels: Vec<bool> = mesh.panels.iter().map(inside).collect();
        let own = panels.iter().filter(|own| **own).count();
        if own == 0 || own == panels.len() {
            return Err(SurfaceError::NoCapSurface {
                surface: match self {
                    Self::Above { .. } => None,
                    Self::Named(name) => Some(name),
                },
                panels: [own, panels.len()],
            }
            .into());
        }
        Ok(panels)
    }
}

/// Surfaces of the tool under a porous layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum CoveredSurfaces {
    /// The housing without its cap, handle and tip of the nose.
    Housing(CapSurface),
    /// The cap.
    Cap(CapSurface),
    /// Both.
    Both,
}

/// A porous cover on the tool.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToolCover {
    /// The layer in standard air, see [`PorousLayer::in_standard_air`].
    pub layer: PorousLayer,
    /// The surfaces under it.
    pub surfaces: CoveredSurfaces,
}

impl ToolCover {
    /// For each panel of the tool's outline, whether it is covered.
    ///
    /// # Errors
    /// [`SurfaceError::NoCapSurface`] if the cap is needed and cannot be separated.
    pub(super) fn panels(&self, mesh: &BoundaryMesh) -> Result<Vec<bool>, Error> {
        let on_housing = |panel: &Panel| !BARE.contains(&mesh.patches[panel.patch].as_str());
        Ok(match &self.surfaces {
            CoveredSurfaces::Cap(cap) => cap.panels(mesh)?,
            CoveredSurfaces::Both => mesh.panels.iter().map(on_housing).collect(),
            CoveredSurfaces::Housing(cap) => {
                let cap = cap.panels(mesh)?;
                let panels = mesh.panels.iter().zip(cap);
                panels.map(|(panel, cap)| on_housing(panel) && !cap).collect()
            }
        })
    }

    /// The cover on a boundary, whose panels are covered or not.
    pub(super) fn on(&self, boundary: &Boundary, covered: &[bool]) -> SurfaceCover {
        let panels = boundary.mesh().panels.iter().zip(covered);
        let shares = panels.flat_map(|(panel, covered)| vec![f64::from(u8::from(*covered)); panel.corners().len()]);
        SurfaceCover {
            layer: self.layer,
            shares: shares.collect(),
        }
    }

    /// The cover of a boundary on another mesh of the same surface.
    ///
    /// # Errors
    /// Those of the projection.
    pub(super) fn carried(cover: &SurfaceCover, from: &Boundary, to: &Boundary) -> Result<SurfaceCover, Error> {
        let shares = DMatrix::from_column_slice(cover.shares.len(), 1, &cover.shares);
        let shares = to.project_from(from, &shares)?;
        Ok(SurfaceCover {
            layer: cover.layer,
            // A projection slightly exceeds the limits where a panel is partly covered.
            shares: shares.iter().map(|share| share.clamp(0.0, 1.0)).collect(),
        })
    }
}
