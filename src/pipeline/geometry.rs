//! Mesh and materials of a body of a design: built in, meshed by gmsh, or the user's own.

use std::path::{Path, PathBuf};

use nailnoise_fem::supports::RectangularBase;
use nailnoise_fem::{Attachments, Constraints, Coupling, LumpedMass, Material, Tie};
use nailnoise_meshes::msh::{self, Imported};
use nailnoise_meshes::{Block, Mesh, MeshError, Surface, Tool, block, gmsh, tool, tube_worktable, worktable};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::design::{self, Design, SupportKind, TableFoot, WorktablePreset};
use crate::error::Error;

/// A body of a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyKind {
    /// What is nailed, free.
    Workpiece,
    /// What it stands on, clamped at the floor.
    Worktable,
    /// The tool's body, free.
    Tool,
}

impl BodyKind {
    /// Its name in commands and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Workpiece => "workpiece",
            Self::Worktable => "worktable",
            Self::Tool => "tool",
        }
    }
}

/// Where the mesh of a body comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The built-in mesher.
    BuiltIn,
    /// The parametric tool body.
    Parametric,
    /// The user's own file, a mesh or a geometry.
    File(PathBuf),
}

/// A body before its modes are known.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Which body it is.
    pub kind: BodyKind,
    /// Its mesh, in the coordinates of the body.
    pub mesh: Mesh,
    /// Numbers of the elements in the file they come from; empty for a built-in mesh.
    pub element_numbers: Vec<u64>,
    /// Nodes of the file that no element uses.
    pub unused_nodes: usize,
    /// One material a part.
    pub materials: Vec<Material>,
    /// Where it is held.
    pub constraints: Constraints,
    /// What is fixed to it.
    pub attachments: Attachments,
    /// Loss factor of all its modes \[-\].
    pub loss_factor: f64,
    /// Frequency up to which its motion is part of the result \[Hz\].
    pub top_hz: f64,
    /// Where the mesh comes from.
    pub origin: Origin,
}

impl Geometry {
    /// Mesh and materials of a body; `anew` has gmsh mesh the tool body even if a mesh for its dimensions ships.
    ///
    /// # Errors
    /// [`Error::NoSuchBody`] for the worktable of a sandbox; those of mesh and material.
    pub fn of(design: &Design, kind: BodyKind, anew: bool) -> Result<Self, Error> {
        match kind {
            BodyKind::Workpiece => workpiece(design),
            BodyKind::Worktable => table(design),
            BodyKind::Tool => tool_body(design, anew),
        }
    }

    /// Mass of the elements of each part \[kg\].
    ///
    /// # Errors
    /// Those of the quadrature, never for a valid mesh.
    pub fn part_masses(&self) -> Result<Vec<f64>, MeshError> {
        let volumes = self.mesh.part_volumes()?;
        let masses = volumes.iter().zip(&self.materials);
        Ok(masses.map(|(volume, material)| volume * material.density()).collect())
    }

    /// Mass of everything, lumped masses included \[kg\].
    ///
    /// # Errors
    /// As [`Self::part_masses`].
    pub fn mass(&self) -> Result<f64, MeshError> {
        let lumped: f64 = self.attachments.masses.iter().map(|mass| mass.mass).sum();
        Ok(self.part_masses()?.iter().sum::<f64>() + lumped)
    }

    /// Number of an element in its file, or its index.
    pub fn number(&self, element: usize) -> u64 {
        self.element_numbers.get(element).copied().unwrap_or(element as u64)
    }

    /// Takes a mesh; damaged elements are refused.
    fn new(kind: BodyKind, imported: Imported, origin: Origin, top_hz: f64, loss_factor: f64) -> Self {
        let attachments = Attachments {
            ties: ties(&imported.mesh),
            ..Attachments::default()
        };
        Self {
            kind,
            mesh: imported.mesh,
            element_numbers: imported.element_numbers,
            unused_nodes: imported.unused_nodes,
            materials: Vec::new(),
            constraints: Constraints::free(),
            attachments,
            loss_factor,
            top_hz,
            origin,
        }
    }
}

/// Interfaces between bodies meshed apart: the nodes of every group `NAME_slave` follow the faces of `NAME_master`.
fn ties(mesh: &Mesh) -> Vec<Tie> {
    let longest = mesh.longest_edges().into_iter().fold(0.0, f64::max);
    mesh.groups
        .iter()
        .filter_map(|group| {
            let master = format!("{}_master", group.name.strip_suffix("_slave")?);
            Some(Tie {
                slave: group.name.clone(),
                master: mesh.group(&master).ok()?.name.clone(),
                tolerance: TIED_WITHIN * longest,
            })
        })
        .collect()
}

/// Largest gap of a tied interface as a share of the longest element side: chords of two curved meshes may stand apart.
const TIED_WITHIN: f64 = 0.1;

/// A built-in mesh as if it had been read.
fn built_in(mesh: Mesh) -> Imported {
    Imported {
        mesh,
        element_numbers: Vec::new(),
        node_numbers: Vec::new(),
        unused_nodes: 0,
        comment: String::new(),
    }
}

/// What a file is, by the end of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FileKind {
    Mesh,
    Solid,
}

fn kind_of(path: &Path) -> Result<FileKind, MeshError> {
    let name = path.to_string_lossy().to_lowercase();
    let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
    if ends(&[".msh", ".msh.gz"]) {
        Ok(FileKind::Mesh)
    } else if ends(&[".step", ".stp", ".brep", ".igs", ".iges"]) {
        Ok(FileKind::Solid)
    } else {
        Err(MeshError::UnknownKind { path: path.to_owned() })
    }
}

/// Reads a mesh, or has gmsh mesh a geometry with elements no longer than `size` \[m\].
///
/// # Errors
/// [`Error::NoSize`] for a geometry without a size; those of reading and meshing.
pub fn import(path: &Path, unit: f64, size: Option<f64>) -> Result<Imported, Error> {
    match kind_of(path)? {
        FileKind::Mesh => Ok(msh::read(path, unit)?),
        // gmsh gives lengths in millimetres of whatever unit the file has; a unit of 1 mm leaves them.
        FileKind::Solid => {
            let scale = unit / 1e-3;
            let mut imported = gmsh::solid(path, size.ok_or(Error::NoSize)? / scale)?;
            imported.mesh.nodes.iter_mut().for_each(|p| *p *= scale);
            Ok(imported)
        }
    }
}

/// Whether gmsh is needed for the mesh of a body.
pub fn needs_gmsh(design: &Design, kind: BodyKind) -> bool {
    let file = match kind {
        BodyKind::Workpiece => design.workpiece.mesh,
        BodyKind::Worktable => design.support.worktable.mesh,
        BodyKind::Tool => design.body.mesh,
    };
    if file.is_empty() {
        kind == BodyKind::Tool && !nailnoise_meshes::tool_ships(&tool_dimensions(design))
    } else {
        matches!(kind_of(Path::new(file)), Ok(FileKind::Solid))
    }
}

/// The user's own file in place of a body: its mesh with the file as origin, or none.
fn own(
    design: &Design,
    (file, unit): (&str, f64),
    slowest: f64,
    top_hz: f64,
    largest: f64,
) -> Result<Option<(Imported, Origin)>, Error> {
    if file.is_empty() {
        return Ok(None);
    }
    let path = Path::new(file);
    let analysis = &design.analysis;
    let size = nailnoise_meshes::element_size(analysis.mode_margin * top_hz, slowest, analysis.elements_per_wave)?;
    let imported = import(path, unit, Some(size.min(largest)))?;
    imported.mesh.validate(|element| imported.element_numbers[element])?;
    Ok(Some((imported, Origin::File(path.to_owned()))))
}

fn workpiece(design: &Design) -> Result<Geometry, Error> {
    let (block_, wood, analysis) = (&design.workpiece, &design.wood, &design.analysis);
    let size = [block_.length, block_.width, block_.thickness];
    let material = Material::orthotropic(&constants(&wood.block_axes()), &Matrix3::identity(), wood.density)?;
    let (top_hz, largest) = (analysis.workpiece_top, analysis.workpiece_element);
    let file = (block_.mesh, block_.mesh_unit);
    let (imported, origin) = match own(design, file, material.slowest_speed(), top_hz, largest)? {
        Some(own) => own,
        None => {
            let origin = [-0.5 * size[0], -0.5 * size[1], 0.0];
            let mesh = block(&Block::with_element_size(size, largest, origin)?)?;
            (built_in(mesh), Origin::BuiltIn)
        }
    };
    let mut geometry = Geometry::new(BodyKind::Workpiece, imported, origin, top_hz, wood.loss_factor);
    geometry.materials = vec![material; geometry.mesh.part_names.len()];
    match design.support.kind {
        SupportKind::Clamped => geometry.constraints = Constraints::clamped(&geometry.mesh, "bottom")?,
        SupportKind::Sandbox => geometry.attachments.masses.extend(added_sand(design)?),
        SupportKind::Worktable | SupportKind::Floor | SupportKind::Springs => {}
    }
    Ok(geometry)
}

/// Sand that moves with the base of a block, a thin layer under it.
fn added_sand(design: &Design) -> Result<Option<LumpedMass>, Error> {
    let (block, mass) = (&design.workpiece, added_mass(design)?);
    if mass == 0.0 {
        return Ok(None);
    }
    let (l2, b2) = (block.length.powi(2), block.width.powi(2));
    Ok(Some(LumpedMass {
        group: "bottom".to_owned(),
        mass,
        inertia: Matrix3::from_diagonal(&Vector3::new(b2, l2, l2 + b2)) * (mass / 12.0),
        centre: Point3::origin(),
        coupling: Coupling::Distributed,
    }))
}

/// Mass of the sand that moves with a block's base, as a part of rho r_0 A \[kg\].
pub(super) fn added_mass(design: &Design) -> Result<f64, Error> {
    let (block, sand) = (&design.workpiece, &design.support.sand);
    let base = RectangularBase::new(block.length, block.width)?;
    Ok(sand.added_mass * sand.density * base.equivalent_radius() * base.area())
}

fn table(design: &Design) -> Result<Geometry, Error> {
    let support = &design.support;
    if support.kind != SupportKind::Worktable {
        return Err(Error::NoSuchBody {
            design: design.name().to_owned(),
            body: "worktable",
            support: support.kind.as_str(),
        });
    }
    let (t, analysis) = (&support.worktable, &design.analysis);
    let steel = &t.steel;
    let thickness = match t.preset {
        WorktablePreset::A => t.top_thickness,
        WorktablePreset::B => steel.top_thickness_b,
        WorktablePreset::C => steel.top_thickness_c,
    };
    let wooden = t.preset == WorktablePreset::A;
    let (top, legs, loss_factor) = if wooden {
        let top = Material::orthotropic(&constants(&t.top), &Matrix3::identity(), t.top_density)?;
        // Legs: grain (axis 1) vertical, radial axis 2 along y, tangential axis 3 along x.
        let upright = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
        let legs = Material::orthotropic(&constants(&t.legs), &upright, t.leg_density)?;
        (top, legs, t.loss_factor)
    } else {
        let material = isotropic(&steel.material)?;
        (material.clone(), material, steel.loss_factor)
    };
    let slowest = top.slowest_speed().min(legs.slowest_speed());
    let (top_hz, largest) = (analysis.worktable_top, analysis.worktable_element);
    let (imported, origin) = match own(design, (t.mesh, t.mesh_unit), slowest, top_hz, largest)? {
        Some(own) => own,
        None => {
            let spec = nailnoise_meshes::Worktable {
                top: [t.length, t.width],
                thickness,
                leg: [if wooden { t.leg_width } else { steel.tube_width }; 2],
                height: t.height,
                element_size: largest,
                leg_element_size: if wooden {
                    analysis.worktable_leg_element
                } else {
                    analysis.worktable_tube_element
                },
                top_layers: analysis.worktable_top_layers as usize,
                origin: [-0.5 * t.length, -0.5 * t.width, -t.height],
            };
            let mesh = if wooden {
                worktable(&spec)?
            } else {
                tube_worktable(&spec, steel.tube_wall)?
            };
            (built_in(mesh), Origin::BuiltIn)
        }
    };
    let mut geometry = Geometry::new(BodyKind::Worktable, imported, origin, top_hz, loss_factor);
    // What stands lowest in a geometry without names stands on the floor.
    if geometry.mesh.group("floor").is_err() {
        for group in geometry.mesh.groups.iter_mut().filter(|group| group.name == "bottom") {
            "floor".clone_into(&mut group.name);
        }
    }
    let of_part = |name: &str| match name {
        "top" => Some(top.clone()),
        "leg" | "legs" => Some(legs.clone()),
        _ => None,
    };
    geometry.materials = materials(&geometry.mesh, "top, leg", &top, of_part)?;
    if t.foot == TableFoot::Clamped {
        geometry.mesh.group("floor")?; // a fault of the mesh, not of the solution
        geometry.constraints = Constraints::clamped(&geometry.mesh, "floor")?;
    }
    Ok(geometry)
}

/// The tool body's dimensions and element size.
pub fn tool_dimensions(design: &Design) -> Tool {
    let b = &design.body;
    Tool {
        barrel_radius: b.barrel_radius,
        barrel_wall: b.barrel_wall,
        barrel_height: b.barrel_height,
        cap_radius: b.cap_radius,
        cap_wall: b.cap_wall,
        cap_height: b.cap_height,
        handle_radius: b.handle_radius,
        handle_wall: b.handle_wall,
        handle_length: b.handle_length,
        handle_level: b.handle_level,
        magazine_radius: b.magazine_radius,
        magazine_wall: b.magazine_wall,
        magazine_height: b.magazine_height,
        magazine_offset: b.magazine_offset,
        magazine_level: b.magazine_level,
        arm_depth: b.arm_depth,
        arm_height: b.arm_height,
        arm_reach: b.arm_reach,
        nose_width: b.nose_width,
        nose_depth: b.nose_depth,
        nose_wall: b.nose_wall,
        nose_height: b.nose_height,
        nose_overlap: b.nose_overlap,
        sleeve_radius: design.piston.bore / 2.0,
        sleeve_wall: b.sleeve_wall,
        sleeve_height: b.sleeve_height,
        sleeve_fit: b.sleeve_fit,
        size: design.analysis.body_element,
    }
}

fn tool_body(design: &Design, anew: bool) -> Result<Geometry, Error> {
    let (b, analysis) = (&design.body, &design.analysis);
    let (housing, nose, sleeve) = (isotropic(&b.housing)?, isotropic(&b.nose)?, isotropic(&b.sleeve)?);
    let (top_hz, largest) = (analysis.body_top, analysis.body_element);
    let (imported, origin) = match own(design, (b.mesh, b.mesh_unit), housing.slowest_speed(), top_hz, largest)? {
        Some(own) => own,
        None => {
            let (sleeve, barrel) = (
                design.piston.bore / 2.0 + b.sleeve_wall,
                b.barrel_radius - b.barrel_wall,
            );
            if sleeve >= barrel {
                return Err(Error::NoRoom { sleeve, barrel });
            }
            (tool(&tool_dimensions(design), anew)?, Origin::Parametric)
        }
    };
    imported.mesh.validate(|element| imported.element_numbers[element])?;
    let mut geometry = Geometry::new(BodyKind::Tool, imported, origin, top_hz, b.loss_factor);
    let of_part = |name: &str| match name {
        "housing" => Some(housing.clone()),
        "nose" => Some(nose.clone()),
        "sleeve" => Some(sleeve.clone()),
        _ => None,
    };
    geometry.materials = materials(&geometry.mesh, "housing, nose, sleeve", &housing, of_part)?;
    if geometry.origin == Origin::Parametric {
        // The fit bridges the room between sleeve and barrel, however wide.
        let room = b.barrel_radius - b.barrel_wall - b.sleeve_wall - design.piston.bore / 2.0;
        geometry
            .attachments
            .ties
            .iter_mut()
            .for_each(|tie| tie.tolerance += room);
    }
    if b.lumped {
        geometry.attachments.masses = lumped(design, &geometry)?;
    }
    Ok(geometry)
}

/// What the mesh lacks of the tool's mass, on nose, seat and magazine.
fn lumped(design: &Design, geometry: &Geometry) -> Result<Vec<LumpedMass>, Error> {
    let b = &design.body;
    let meshed: f64 = geometry.part_masses()?.iter().sum();
    let rest = design.tool.mass - meshed;
    if rest < 0.0 {
        return Err(Error::TooHeavy {
            meshed,
            tool: design.tool.mass,
        });
    }
    let surface = Surface::of(&geometry.mesh);
    // A coil of nails as a solid cylinder with its axis along y.
    let (r, h) = (b.magazine_radius, b.magazine_height);
    let (along, across) = (r * r / 2.0, (3.0 * r * r + h * h) / 12.0);
    let coil = Matrix3::from_diagonal(&Vector3::new(across, along, across));
    [
        ("nose_tip", b.lumped_nose, Matrix3::zeros()),
        ("magazine", b.lumped_magazine, coil),
        ("seat", 1.0 - b.lumped_nose - b.lumped_magazine, Matrix3::zeros()),
    ]
    .into_iter()
    .filter(|(_, share, _)| share * rest > 0.0)
    .map(|(group, share, gyration)| {
        let mass = share * rest;
        if let Err(MeshError::UnknownGroup { known, .. }) = geometry.mesh.group(group) {
            return Err(Error::NoSeat { group, mass, known });
        }
        Ok(LumpedMass {
            group: group.to_owned(),
            mass,
            inertia: gyration * mass,
            centre: centroid(&surface, group)?,
            coupling: Coupling::Distributed,
        })
    })
    .collect()
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

/// One material a part: by name, or `alone` for a mesh of one part.
fn materials(
    mesh: &Mesh,
    known: &'static str,
    alone: &Material,
    of_part: impl Fn(&str) -> Option<Material>,
) -> Result<Vec<Material>, Error> {
    mesh.part_names
        .iter()
        .map(|name| match of_part(name) {
            Some(material) => Ok(material),
            None if mesh.part_names.len() == 1 => Ok(alone.clone()),
            None => Err(Error::UnknownPart {
                part: name.clone(),
                known,
            }),
        })
        .collect()
}

fn isotropic(c: &design::Isotropic) -> Result<Material, Error> {
    Ok(Material::isotropic(c.young_modulus, c.poisson_ratio, c.density)?)
}

fn constants(c: &design::Orthotropic) -> nailnoise_fem::Orthotropic {
    nailnoise_fem::Orthotropic {
        e_1: c.e1,
        e_2: c.e2,
        e_3: c.e3,
        g_12: c.g12,
        g_13: c.g13,
        g_23: c.g23,
        nu_12: c.nu12,
        nu_13: c.nu13,
        nu_23: c.nu23,
    }
}
