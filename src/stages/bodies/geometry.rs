//! Geometry and materials of a body, and the mesh made of them: built in, by gmsh, or the user's own.

use std::path::{Path, PathBuf};

use nailnoise_fem::{Attachments, Constraints, Coupling, LumpedMass, Material, Tie};
use nailnoise_meshes::msh::{self, Imported};
use nailnoise_meshes::{
    Block, Mesh, MeshError, Surface, Tool, Worktable, block, gmsh, read_regular, tool, tool_ships, tube_worktable,
    worktable,
};
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::error::Error;
use crate::stages::Digest;

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
    },
    /// A table with solid legs or, given the thickness of their wall \[m\], on square tubes.
    Worktable(Worktable, Option<f64>),
    /// The parametric tool body; `true` has gmsh mesh it even if a mesh of these dimensions ships.
    Tool(Box<Tool>, bool),
    /// The user's own file.
    File(MeshFile),
}

/// A mesh or solid geometry in a file, identified by its content.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshFile {
    #[serde(skip)]
    path: PathBuf,
    content: Digest,
    /// Length of one unit of the file \[m\].
    unit: f64,
    /// Longest element side of a solid geometry \[m\]; none for a mesh.
    element: Option<f64>,
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

impl MeshFile {
    /// A file whose unit is `unit` \[m\]; a solid geometry is meshed with elements no longer than `element` \[m\].
    ///
    /// # Errors
    /// [`MeshError::UnknownKind`] for another kind of file, [`MeshError::Read`], [`Error::NoSize`] for a solid geometry
    /// without an element size.
    pub fn new(path: &Path, unit: f64, element: Option<f64>) -> Result<Self, Error> {
        let element = if is_solid(path)? {
            Some(element.ok_or(Error::NoSize)?)
        } else {
            None
        };
        let bytes = read_regular(path, msh::LARGEST).map_err(|source| MeshError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            content: Sha256::digest(bytes).into(),
            unit,
            element,
        })
    }

    /// Reads a mesh, or has gmsh mesh a solid geometry.
    ///
    /// # Errors
    /// Those of reading and meshing.
    pub fn import(&self) -> Result<Imported, MeshError> {
        let Some(element) = self.element else {
            return msh::read(&self.path, self.unit);
        };
        // gmsh gives lengths in millimetres of whatever unit the file has; a unit of 1 mm leaves them.
        let scale = self.unit / 1e-3;
        let mut imported = gmsh::solid(&self.path, element / scale)?;
        imported.mesh.nodes.iter_mut().for_each(|p| *p *= scale);
        Ok(imported)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Longest element side of a solid geometry \[m\]; none for a mesh.
    pub fn element_size(&self) -> Option<f64> {
        self.element
    }
}

/// Whether a file is a solid geometry rather than a mesh, by the end of its name.
fn is_solid(path: &Path) -> Result<bool, MeshError> {
    let name = path.to_string_lossy().to_lowercase();
    let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
    if ends(&[".msh", ".msh.gz"]) {
        Ok(false)
    } else if ends(&[".step", ".stp", ".brep", ".igs", ".iges"]) {
        Ok(true)
    } else {
        Err(MeshError::UnknownKind { path: path.to_owned() })
    }
}

impl MeshSource {
    /// Whether gmsh makes the mesh.
    pub fn needs_gmsh(&self) -> bool {
        match self {
            Self::Block { .. } | Self::Worktable(..) => false,
            Self::Tool(dimensions, remesh) => *remesh || !tool_ships(dimensions),
            Self::File(file) => file.element.is_some(),
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
            &Self::Block { size, element } => {
                let origin = [-0.5 * size[0], -0.5 * size[1], 0.0];
                return Ok(built_in(block(&Block::with_element_size(size, element, origin)?)?));
            }
            Self::Worktable(table, None) => return Ok(built_in(worktable(table)?)),
            Self::Worktable(table, Some(wall)) => return Ok(built_in(tube_worktable(table, *wall)?)),
            Self::Tool(t, remesh) => {
                let (sleeve, barrel) = (t.sleeve_radius + t.sleeve_wall, t.barrel_radius - t.barrel_wall);
                if sleeve >= barrel {
                    return Err(Error::NoRoom { sleeve, barrel });
                }
                tool(t, *remesh)?
            }
            Self::File(file) => file.import()?,
        };
        imported.mesh.validate(|element| imported.element_numbers[element])?;
        Ok(imported)
    }

    /// Gap that ties bridge by design \[m\]: that between sleeve and barrel.
    fn fit(&self) -> f64 {
        match self {
            Self::Tool(t, _) => t.barrel_radius - t.barrel_wall - t.sleeve_wall - t.sleeve_radius,
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
}

impl Geometry {
    /// Makes the mesh.
    ///
    /// # Errors
    /// Those of mesh, gmsh and parts; [`Error::TooHeavy`] and [`Error::NoSeat`] for lumped masses.
    pub fn mesh(&self) -> Result<Meshed, Error> {
        let mut imported = self.mesh.import()?;
        let mesh = &mut imported.mesh;
        // The lowest surface of a table without names stands on the floor.
        if self.kind == BodyKind::Worktable && mesh.group("floor").is_err() {
            for group in mesh.groups.iter_mut().filter(|group| group.name == "bottom") {
                "floor".clone_into(&mut group.name);
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
        if let Some(remainder) = &self.remainder {
            attachments.masses.extend(remainder.lumped(mesh, &materials)?);
        }
        Ok(Meshed {
            imported,
            materials,
            constraints,
            attachments,
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
    fn lumped(&self, mesh: &Mesh, materials: &[Material]) -> Result<Vec<LumpedMass>, Error> {
        let meshed = meshed_mass(mesh, materials)?;
        let rest = self.total - meshed;
        if rest < 0.0 {
            return Err(Error::TooHeavy {
                meshed,
                tool: self.total,
            });
        }
        let surface = Surface::of(mesh);
        let of_group = |&(group, share, gyration): &(&'static str, f64, [f64; 3])| {
            let mass = share * rest;
            if let Err(MeshError::UnknownGroup { known, .. }) = mesh.group(group) {
                return Err(Error::NoSeat { group, mass, known });
            }
            Ok(LumpedMass {
                group: group.to_owned(),
                mass,
                inertia: Matrix3::from_diagonal(&Vector3::from(gyration)) * mass,
                centre: centroid(&surface, group)?,
                coupling: Coupling::Distributed,
            })
        };
        let present = self.shares.iter().filter(|(_, share, _)| share * rest > 0.0);
        present.map(of_group).collect()
    }
}

/// Centroid of a patch of a surface.
fn centroid(surface: &Surface, group: &str) -> Result<Point3<f64>, MeshError> {
    let patch = surface.patch(group)?;
    let (mut area, mut moment) = (0.0, Vector3::zeros());
    for point in surface.quadrature(2)? {
        if surface.faces[point.face].patch == patch {
            area += point.weight;
            moment += point.weight * point.position.coords;
        }
    }
    Ok(Point3::from(moment / area))
}
