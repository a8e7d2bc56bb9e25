//! A meshed body with its materials, supports and attachments.

use nailnoise_fem::{Attachments, Constraints, Coupling, LumpedMass, Material, Tie};
use nailnoise_meshes::msh::Imported;
use nailnoise_meshes::{Mesh, MeshError, Surface};
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;

use super::geometry::{AddedSand, Geometry, Properties, Remainder};
use super::meshing::NamedMesh;
use super::surfaces::FoundSurface;
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::{Code, Progress, Stage, Stored, Uncached, code};

/// A meshed body with its materials, supports and attachments.
#[derive(Debug, Clone)]
pub struct Meshed {
    /// Its mesh, with the numbers of the source file.
    pub imported: Imported,
    /// One material for each part.
    pub materials: Vec<Material>,
    /// Constrained degrees of freedom.
    pub constraints: Constraints,
    /// Ties and lumped masses.
    pub attachments: Attachments,
    /// Surfaces that its file does not name.
    pub surfaces: Vec<FoundSurface>,
    /// Lumped masses \[kg\] whose surfaces the mesh does not have.
    pub unplaced: Vec<(&'static str, f64)>,
}

/// Adds materials, supports and attachments to a mesh.
#[derive(Serialize)]
pub struct Attachment {
    /// The mesh.
    pub mesh: Stored<NamedMesh>,
    /// Materials and attachments of the mesh.
    pub properties: Properties,
    /// Gap that ties have to bridge by design \[m\].
    pub fit: f64,
}

impl Stage for Attachment {
    type Output = Meshed;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "materials and attachments";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<Meshed, Error> {
        self.properties.attached(NamedMesh::clone(&*self.mesh.get()?), self.fit)
    }
}

impl Geometry {
    /// The stage that adds materials, supports and attachments to a mesh.
    pub fn attachment(&self, mesh: Stored<NamedMesh>) -> Attachment {
        Attachment {
            mesh,
            properties: self.properties.clone(),
            fit: self.mesh.fit(),
        }
    }

    /// Makes the mesh with its materials, supports and attachments.
    ///
    /// # Errors
    /// Those of mesh, gmsh and parts; [`BodyError::TooHeavy`] for lumped masses.
    pub fn mesh(&self) -> Result<Meshed, Error> {
        let named = self.meshing().compute(&Progress::silent())?;
        self.properties.attached(named, self.mesh.fit())
    }
}

impl Properties {
    /// Adds materials, supports and attachments to a mesh; `fit` is the gap that ties have to bridge by design \[m\].
    fn attached(&self, named: NamedMesh, fit: f64) -> Result<Meshed, Error> {
        let NamedMesh { imported, surfaces } = named;
        let mesh = &imported.mesh;
        let materials = self.materials.of(mesh)?;
        let constraints = constraints(mesh, self.clamped)?;
        let mut attachments = Attachments {
            ties: ties(mesh, fit),
            ..Attachments::default()
        };
        attachments.masses.extend(self.sand.map(AddedSand::lumped));
        let mut unplaced = Vec::new();
        if let Some(remainder) = &self.remainder {
            let surface = Surface::of(mesh);
            for (group, mass) in remainder.masses(mesh, &materials)? {
                if mesh.group(group).is_ok() {
                    attachments.masses.push(remainder.lumped(&surface, group, mass)?);
                } else {
                    unplaced.push((group, mass));
                }
            }
        }
        Ok(Meshed {
            imported,
            materials,
            constraints,
            attachments,
            surfaces,
            unplaced,
        })
    }
}

/// Constraints that fix the nodes of a face group. A missing group is a fault of the mesh, not of the solution.
pub(super) fn constraints(mesh: &Mesh, clamped: Option<&'static str>) -> Result<Constraints, Error> {
    let Some(group) = clamped else {
        return Ok(Constraints::free());
    };
    mesh.group(group)?;
    Ok(Constraints::clamped(mesh, group)?)
}

impl Meshed {
    /// Total mass including lumped masses \[kg\].
    ///
    /// # Errors
    /// The errors of the quadrature, which do not occur for a valid mesh.
    pub fn mass(&self) -> Result<f64, MeshError> {
        let lumped: f64 = self.attachments.masses.iter().map(|mass| mass.mass).sum();
        Ok(meshed_mass(&self.imported.mesh, &self.materials)? + lumped)
    }
}

/// Mass of the elements \[kg\].
fn meshed_mass(mesh: &Mesh, materials: &[Material]) -> Result<f64, MeshError> {
    let volumes = mesh.part_volumes()?;
    let masses = volumes.iter().zip(materials);
    Ok(masses.map(|(volume, material)| volume * material.density()).sum())
}

/// Interfaces between bodies that are meshed separately: the nodes of every group `NAME_slave` follow the faces of
/// `NAME_master`, across a gap of `fit` \[m\] and the deviation of both meshes from curved surfaces.
pub(super) fn ties(mesh: &Mesh, fit: f64) -> Vec<Tie> {
    let longest = mesh.longest_edges().into_iter().fold(0.0, f64::max);
    let of_group = |group: &nailnoise_meshes::FaceGroup| {
        let master = format!("{}_master", group.name.strip_suffix("_slave")?);
        Some(Tie {
            slave: group.name.clone(),
            master: mesh.group(&master).ok()?.name.clone(),
            tolerance: TIED_WITHIN * longest + fit,
        })
    };
    mesh.groups.iter().filter_map(of_group).collect()
}

/// Largest gap of a tied interface as a fraction of the longest element side; two meshes of a curved surface may be
/// this far apart.
const TIED_WITHIN: f64 = 0.1;

impl AddedSand {
    /// The face group with which it moves.
    pub(super) const GROUP: &'static str = "bottom";

    fn lumped(self) -> LumpedMass {
        let (l2, b2) = (self.base[0].powi(2), self.base[1].powi(2));
        LumpedMass {
            group: Self::GROUP.to_owned(),
            mass: self.mass,
            inertia: Matrix3::from_diagonal(&Vector3::new(b2, l2, l2 + b2)) * (self.mass / 12.0),
            centre: Point3::origin(),
            coupling: Coupling::Distributed,
        }
    }
}

impl Remainder {
    /// The masses \[kg\] that belong on face groups.
    fn masses(&self, mesh: &Mesh, materials: &[Material]) -> Result<Vec<(&'static str, f64)>, Error> {
        let meshed = meshed_mass(mesh, materials)?;
        let rest = self.total - meshed;
        if rest < 0.0 {
            return Err(BodyError::TooHeavy {
                meshed,
                tool: self.total,
            }
            .into());
        }
        let masses = self.shares.iter().map(|&(group, share, _)| (group, share * rest));
        Ok(masses.filter(|(_, mass)| *mass > 0.0).collect())
    }

    /// A mass \[kg\] on a face group.
    fn lumped(&self, surface: &Surface, group: &'static str, mass: f64) -> Result<LumpedMass, Error> {
        let own = self.shares.iter().find(|(name, ..)| *name == group);
        let centre = surface.patch_centre(surface.patch(group)?).unwrap_or_default();
        let gyration = own.map_or([0.0; 3], |&(.., gyration)| gyration);
        Ok(LumpedMass {
            group: group.to_owned(),
            mass,
            inertia: Matrix3::from_diagonal(&Vector3::from(gyration)) * mass,
            centre,
            coupling: Coupling::Distributed,
        })
    }
}
