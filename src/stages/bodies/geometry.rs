//! Geometry and materials of a body, and the source of its mesh: built in, from gmsh, or from the user.

use nailnoise_fem::Material;
use nailnoise_meshes::msh::Imported;
use nailnoise_meshes::{
    Block, Mesh, Tool, Worktable, block, jointed_block, tool, tool_ships, tube_worktable, worktable,
};
use serde::Serialize;

use super::mesh_file::MeshFile;
use super::surfaces::Naming;
use crate::error::Error;
use crate::stages::bodies::BodyError;

/// A body of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum BodyKind {
    /// The block of wood, free.
    Workpiece,
    /// The table under it, clamped at the floor or on springs.
    Worktable,
    /// The tool's body, free.
    Tool,
}

impl BodyKind {
    /// Name of the computation of its modes.
    pub fn modes(self) -> &'static str {
        match self {
            Self::Workpiece => "modes of the workpiece",
            Self::Worktable => "modes of the worktable",
            Self::Tool => "modes of the tool",
        }
    }

    /// All bodies.
    pub const ALL: [Self; 3] = [Self::Workpiece, Self::Worktable, Self::Tool];

    /// Its name in commands and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Workpiece => "workpiece",
            Self::Worktable => "worktable",
            Self::Tool => "tool",
        }
    }
}

/// All data from which the finite elements of a body are made, except the places of loads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Geometry {
    /// The body.
    pub kind: BodyKind,
    /// Source of its mesh.
    pub mesh: MeshSource,
    /// Names of the surfaces of a mesh from a file.
    pub naming: Naming,
    /// Materials and attachments of the mesh.
    pub properties: Properties,
}

/// Materials of a mesh, and its attachments.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Properties {
    /// Materials of the mesh's parts.
    pub materials: PartMaterials,
    /// Face group whose nodes are fixed.
    pub clamped: Option<&'static str>,
    /// Sand that moves with its base.
    pub sand: Option<AddedSand>,
    /// Mass that the mesh omits.
    pub remainder: Option<Remainder>,
}

/// Source of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum MeshSource {
    /// A block on the plane z = 0.
    Block {
        /// Lengths along x, y and z \[m\].
        size: [f64; 3],
        /// Longest element side \[m\].
        element: f64,
        /// Height at which a board touches the block below it \[m\]; `None` for one piece.
        joint: Option<f64>,
    },
    /// A table with solid legs or, with a wall thickness \[m\], on square tubes.
    Worktable(Worktable, Option<f64>),
    /// The parametric tool body. With `true`, gmsh meshes it even if a mesh of these dimensions comes with the program.
    Tool(Box<Tool>, bool),
    /// The user's own file.
    File(MeshFile),
}

/// Materials of the parts of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum PartMaterials {
    /// One material for all parts.
    Same(Box<Material>),
    /// By the name of the part; the first is also used for a mesh with only one part, whatever its name.
    Named(Vec<(&'static str, Material)>),
}

/// Sand that moves with the base of a block, a thin layer below it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AddedSand {
    /// Its mass \[kg\].
    pub mass: f64,
    /// Lengths of the base along x and y \[m\].
    pub base: [f64; 2],
}

/// The difference between a body's mass and that of its mesh, lumped on face groups.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Remainder {
    /// Mass of the body \[kg\].
    pub total: f64,
    /// Face groups with their fractions of the difference and the squared radii of gyration about x, y and z \[m2\].
    pub shares: [(&'static str, f64, [f64; 3]); 3],
}

impl MeshSource {
    /// Whether gmsh makes the mesh.
    pub fn needs_gmsh(&self) -> bool {
        match self {
            Self::Block { .. } | Self::Worktable(..) => false,
            Self::Tool(dimensions, remesh) => *remesh || !tool_ships(dimensions),
            Self::File(file) => file.needs_gmsh(),
        }
    }

    /// Imports the mesh; damaged elements are rejected.
    pub(super) fn import(&self) -> Result<Imported, Error> {
        let built_in = Imported::built;
        let imported = match self {
            &Self::Block { size, element, joint } => {
                let origin = [-0.5 * size[0], -0.5 * size[1], 0.0];
                if let Some(height) = joint {
                    return Ok(built_in(jointed_block(size, element, origin, height)?));
                }
                return Ok(built_in(block(&Block::with_element_size(size, element, origin)?)?));
            }
            Self::Worktable(table, None) => return Ok(built_in(worktable(table)?)),
            Self::Worktable(table, Some(wall)) => return Ok(built_in(tube_worktable(table, *wall)?)),
            Self::Tool(dimensions, remesh) => tool(dimensions, *remesh)?,
            Self::File(file) => file.import()?,
        };
        imported.validate()?;
        Ok(imported)
    }

    /// Gap that ties have to bridge by design \[m\]: that between sleeve and barrel.
    pub(super) fn fit(&self) -> f64 {
        match self {
            Self::Tool(dimensions, _) => dimensions.sleeve_gap,
            _ => 0.0,
        }
    }
}

impl PartMaterials {
    /// One material for each part.
    pub(super) fn of(&self, mesh: &Mesh) -> Result<Vec<Material>, Error> {
        let named = match self {
            Self::Same(material) => return Ok(vec![(**material).clone(); mesh.part_names.len()]),
            Self::Named(named) => named,
        };
        let of_part = |name: &String| match named.iter().find(|(known, _)| known == name) {
            Some((_, material)) => Ok(material.clone()),
            None if mesh.part_names.len() == 1 => Ok(named[0].1.clone()),
            None => Err(BodyError::UnknownPart {
                part: name.clone(),
                known: named.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", "),
            }
            .into()),
        };
        mesh.part_names.iter().map(of_part).collect()
    }
}
