//! Elimination order of the unknowns of a body.

use nailnoise_fem::{Attachments, Coupling, LumpedMass, elimination_order};
use nalgebra::{Matrix3, Point3};
use serde::Serialize;

use super::attachment::{constraints, ties};
use super::geometry::{AddedSand, Geometry, Properties};
use super::meshing::NamedMesh;
use crate::error::Error;
use crate::stages::{Code, Postcard, Progress, Stage, Stored, code};

/// Finds an elimination order for the matrices of a body. The order is stored because it does not depend on masses and
/// materials, and designs with the same shape differ only in these.
#[derive(Serialize)]
pub struct Elimination {
    /// The mesh.
    pub mesh: Stored<NamedMesh>,
    /// Gap that ties have to bridge by design \[m\].
    pub fit: f64,
    /// Face group whose nodes are fixed.
    pub clamped: Option<&'static str>,
    /// Face groups with a lumped mass.
    pub lumped: Vec<&'static str>,
}

impl Stage for Elimination {
    type Output = Option<Vec<u32>>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "order of elimination";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<Option<Vec<u32>>, Error> {
        let named = self.mesh.get()?;
        let mesh = &named.imported.mesh;
        let of_group = |&group: &&'static str| LumpedMass {
            group: group.to_owned(),
            mass: 1.0,
            inertia: Matrix3::zeros(),
            centre: Point3::origin(),
            coupling: Coupling::Distributed,
        };
        let lumped = self.lumped.iter().filter(|group| mesh.group(group).is_ok());
        let attachments = Attachments {
            ties: ties(mesh, self.fit),
            masses: lumped.map(of_group).collect(),
            ..Attachments::default()
        };
        Ok(elimination_order(
            mesh,
            &constraints(mesh, self.clamped)?,
            &attachments,
        )?)
    }
}

impl Geometry {
    /// The stage that finds the elimination order.
    pub fn elimination(&self, mesh: Stored<NamedMesh>) -> Elimination {
        let Properties {
            clamped,
            sand,
            remainder,
            ..
        } = &self.properties;
        let shares = remainder.iter().flat_map(|remainder| &remainder.shares);
        let remaining = shares.filter(|(_, share, _)| *share > 0.0).map(|(group, ..)| *group);
        Elimination {
            mesh,
            fit: self.mesh.fit(),
            clamped: *clamped,
            lumped: sand.map(|_| AddedSand::GROUP).into_iter().chain(remaining).collect(),
        }
    }
}
