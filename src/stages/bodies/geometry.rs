//! Geometry and materials of a body, and the mesh made of them: built in, by gmsh, or the user's own.

use nailnoise_fem::{Attachments, Constraints, Coupling, LumpedMass, Material, Tie};
use nailnoise_meshes::msh::Imported;
use nailnoise_meshes::{
    Block, Mesh, MeshError, Surface, Tool, Worktable, block, jointed_block, tool, tool_ships, tube_worktable, worktable,
};
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;

use super::mesh_file::MeshFile;
use super::surfaces::{FoundSurface, Naming};
use crate::error::Error;
use crate::stages::{Code, NotKept, Progress, Stage, code};

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

/// All that the finite elements of a body are made of, but for the places of loads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Geometry {
    /// Which body it is.
    pub kind: BodyKind,
    /// Source of its mesh.
    pub mesh: MeshSource,
    /// Names of the surfaces of a mesh from a file.
    pub naming: Naming,
    /// Materials of the mesh's parts.
    pub materials: PartMaterials,
    /// Face group whose nodes are held.
    pub clamped: Option<&'static str>,
    /// Sand that moves with its base.
    pub sand: Option<AddedSand>,
    /// Mass that the mesh lacks.
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
        /// Height at which a board touches the block below it \[m\]; none for one piece.
        joint: Option<f64>,
    },
    /// A table with solid legs or, given the thickness of their wall \[m\], on square tubes.
    Worktable(Worktable, Option<f64>),
    /// The parametric tool body; `true` has gmsh mesh it even if a mesh of these dimensions ships.
    Tool(Box<Tool>, bool),
    /// The user's own file.
    File(MeshFile),
}

/// Materials of the parts of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum PartMaterials {
    /// One material for all parts.
    Same(Box<Material>),
    /// By the name of the part; the first also for the part of a mesh that has only one, whatever its name.
    Named(Vec<(&'static str, Material)>),
}

/// Sand that moves with the base of a block, a thin layer under it.
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
    /// Face groups with their shares of the difference and the squared radii of gyration about x, y and z \[m2\].
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

    /// The mesh; damaged elements are refused.
    fn import(&self) -> Result<Imported, Error> {
        let built_in = |mesh| Imported {
            mesh,
            element_numbers: Vec::new(),
            node_numbers: Vec::new(),
            unused_nodes: 0,
            comment: String::new(),
        };
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
        imported.mesh.validate(|element| imported.element_numbers[element])?;
        Ok(imported)
    }

    /// Gap that ties bridge by design \[m\]: that between sleeve and barrel.
    fn fit(&self) -> f64 {
        match self {
            Self::Tool(dimensions, _) => dimensions.sleeve_gap,
            _ => 0.0,
        }
    }
}

impl PartMaterials {
    /// One material a part.
    fn of(&self, mesh: &Mesh) -> Result<Vec<Material>, Error> {
        let named = match self {
            Self::Same(material) => return Ok(vec![(**material).clone(); mesh.part_names.len()]),
            Self::Named(named) => named,
        };
        let of_part = |name: &String| match named.iter().find(|(known, _)| known == name) {
            Some((_, material)) => Ok(material.clone()),
            None if mesh.part_names.len() == 1 => Ok(named[0].1.clone()),
            None => Err(Error::UnknownPart {
                part: name.clone(),
                known: named.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", "),
            }),
        };
        mesh.part_names.iter().map(of_part).collect()
    }
}

/// A meshed body with its materials, supports and attachments.
#[derive(Debug, Clone)]
pub struct Meshed {
    /// Its mesh, with the numbers of the file it comes from.
    pub imported: Imported,
    /// One material a part.
    pub materials: Vec<Material>,
    /// Degrees of freedom that are held.
    pub constraints: Constraints,
    /// Ties and lumped masses.
    pub attachments: Attachments,
    /// Surfaces that its file does not name.
    pub surfaces: Vec<FoundSurface>,
    /// Lumped masses \[kg\] whose surfaces it lacks.
    pub unplaced: Vec<(&'static str, f64)>,
}

impl Stage for Geometry {
    type Output = Meshed;
    type Codec = NotKept;
    const NAME: &'static str = "mesh";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<Meshed, Error> {
        self.mesh()
    }
}

impl Geometry {
    /// Makes the mesh.
    ///
    /// # Errors
    /// Those of mesh, gmsh and parts; [`Error::TooHeavy`] for lumped masses.
    pub fn mesh(&self) -> Result<Meshed, Error> {
        let mut imported = self.mesh.import()?;
        let mesh = &mut imported.mesh;
        let mut surfaces = match self.mesh {
            MeshSource::File(_) => self.naming.apply(mesh)?,
            _ => Vec::new(),
        };
        // The lowest surface of a table without names stands on the floor.
        if self.kind == BodyKind::Worktable && mesh.group("floor").is_err() {
            for group in mesh.groups.iter_mut().filter(|group| group.name == "bottom") {
                "floor".clone_into(&mut group.name);
            }
            for found in surfaces.iter_mut().filter(|found| found.name == "bottom") {
                "floor".clone_into(&mut found.name);
            }
        }
        let materials = self.materials.of(mesh)?;
        let constraints = match self.clamped {
            Some(group) => {
                mesh.group(group)?; // a fault of the mesh, not of the solution
                Constraints::clamped(mesh, group)?
            }
            None => Constraints::free(),
        };
        let mut attachments = Attachments {
            ties: ties(mesh, self.mesh.fit()),
            ..Attachments::default()
        };
        attachments.masses.extend(self.sand.map(AddedSand::lumped));
        let mut unplaced = Vec::new();
        if let Some(remainder) = &self.remainder {
            for (group, mass) in remainder.masses(mesh, &materials)? {
                if mesh.group(group).is_ok() {
                    attachments.masses.push(remainder.lumped(mesh, group, mass)?);
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

impl Meshed {
    /// Mass of everything, lumped masses included \[kg\].
    ///
    /// # Errors
    /// Those of the quadrature, never for a valid mesh.
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

/// Interfaces between bodies meshed apart: the nodes of every group `NAME_slave` follow the faces of `NAME_master`, across a
/// gap of `fit` \[m\] and the chords of both meshes.
fn ties(mesh: &Mesh, fit: f64) -> Vec<Tie> {
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

/// Largest gap of a tied interface as a share of the longest element side: chords of two curved meshes may stand apart.
const TIED_WITHIN: f64 = 0.1;

impl AddedSand {
    fn lumped(self) -> LumpedMass {
        let (l2, b2) = (self.base[0].powi(2), self.base[1].powi(2));
        LumpedMass {
            group: "bottom".to_owned(),
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
            return Err(Error::TooHeavy {
                meshed,
                tool: self.total,
            });
        }
        let masses = self.shares.iter().map(|&(group, share, _)| (group, share * rest));
        Ok(masses.filter(|(_, mass)| *mass > 0.0).collect())
    }

    /// A mass \[kg\] on a face group.
    fn lumped(&self, mesh: &Mesh, group: &'static str, mass: f64) -> Result<LumpedMass, Error> {
        let own = self.shares.iter().find(|(name, ..)| *name == group);
        let surface = Surface::of(mesh);
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
