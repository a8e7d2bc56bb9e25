//! The mesh of a body with named surfaces.

use nailnoise_meshes::msh::Imported;
use serde::Serialize;

use super::geometry::{BodyKind, Geometry, MeshSource};
use super::surfaces::{FoundSurface, Naming};
use crate::error::Error;
use crate::stages::{Code, Progress, Stage, Uncached, code};

/// Makes the mesh of a body and names its surfaces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Meshing {
    /// The body.
    pub kind: BodyKind,
    /// Origin of the mesh.
    pub source: MeshSource,
    /// Names of the surfaces of a mesh from a file.
    pub naming: Naming,
}

/// A mesh with named surfaces.
#[derive(Debug, Clone)]
pub struct NamedMesh {
    /// The mesh, with the numbers of the source file.
    pub imported: Imported,
    /// Surfaces that its file does not name.
    pub surfaces: Vec<FoundSurface>,
}

impl Stage for Meshing {
    type Output = NamedMesh;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "mesh";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, progress: &Progress) -> Result<NamedMesh, Error> {
        let mut imported = self.source.import()?;
        imported.notes.iter().for_each(|note| progress.note(note));
        let mesh = &mut imported.mesh;
        let mut surfaces = match self.source {
            MeshSource::File(_) => self.naming.apply(mesh)?,
            _ => Vec::new(),
        };
        // The lowest surface of a table without named surfaces stands on the floor.
        if self.kind == BodyKind::Worktable && mesh.group("floor").is_err() {
            for group in mesh.groups.iter_mut().filter(|group| group.name == "bottom") {
                "floor".clone_into(&mut group.name);
            }
            for found in surfaces.iter_mut().filter(|found| found.name == "bottom") {
                "floor".clone_into(&mut found.name);
            }
        }
        Ok(NamedMesh { imported, surfaces })
    }
}

impl Geometry {
    /// The stage that makes the mesh.
    pub fn meshing(&self) -> Meshing {
        Meshing {
            kind: self.kind,
            source: self.mesh.clone(),
            naming: self.naming.clone(),
        }
    }
}
