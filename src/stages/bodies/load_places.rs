//! Places where forces act on a body, and its finite elements with the load vectors of these places.

use std::sync::Arc;

use nailnoise_fem::vibration::supports::{RectangularBase, Sand};
use nailnoise_fem::vibration::{Support, SupportLaw};
use nailnoise_fem::{LoadVector, Rectangle};
use nailnoise_meshes::{Mesh, MeshError, Surface};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::attachment::Meshed;
use super::contact_cells::ContactFace;
use super::geometry::BodyKind;
use super::joint::Joint;
use super::nail_stations::NailPlace;
use super::tool_loads::{self, ToolPlaces};
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::{Code, Progress, Stage, Stored, Uncached, code};

/// The mesh of a body with its materials and load vectors.
#[derive(Serialize)]
pub struct Discretisation {
    /// The body.
    pub kind: BodyKind,
    /// The meshed body.
    pub meshed: Stored<Meshed>,
    /// Places of forces on it.
    pub places: LoadPlaces,
}

/// Finite elements of a body before its modes are known.
#[derive(Debug, Clone)]
pub struct Model {
    /// Mesh, materials, supports and attachments.
    pub meshed: Arc<Meshed>,
    /// Load vectors of the shot's forces, see [`Body::loads`](super::Body::loads).
    pub loads: Vec<LoadVector>,
    /// Load vectors of contacts and supports, see [`Body::contacts`](super::Body::contacts).
    pub contacts: Vec<LoadVector>,
}

impl Stage for Discretisation {
    type Output = Model;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "load vectors";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<Model, Error> {
        let meshed = self.meshed.get()?;
        let mesh = &meshed.imported.mesh;
        let mut problems = Vec::new();
        for &(group, mass) in &meshed.unplaced {
            let known = known_groups(mesh);
            problems.push(BodyError::NoSeat { group, mass, known }.into());
        }
        let loads = collected(self.places.loads(mesh), &mut problems);
        let contacts = collected(self.places.contacts(mesh), &mut problems);
        Error::of_body(self.kind.name(), problems)?;
        Ok(Model {
            meshed,
            loads,
            contacts,
        })
    }
}

/// Places where forces act on a body; empty by default.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct LoadPlaces {
    /// Nail and nose on the workpiece.
    pub nail: Option<NailPlace>,
    /// Forces and pressures on the tool's body.
    pub tool: Option<ToolPlaces>,
    /// Contact cells on its faces.
    pub contacts: Vec<ContactFace>,
    /// Sand at the sides.
    pub side_sand: Option<SideSand>,
    /// Springs to the ground.
    pub springs: Vec<SpringFoot>,
    /// Joint of a workpiece with two pieces.
    pub joint: Option<Joint>,
    /// Number of further supports that act only on another body, numbered after these.
    pub elsewhere: usize,
}

/// Sand at the sides of a block: cells in which the sand supports the sides, each in three directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SideSand {
    /// Lengths of the block along x, y and z \[m\].
    pub block: [f64; 3],
}

/// A cell of a side.
struct SideCell {
    group: &'static str,
    place: Rectangle,
    /// Outward normal, up, and along the side.
    directions: [Vector3<f64>; 3],
}

impl SideSand {
    /// Number of cells along a side, and up it; the waves that the sand carries at the sides are longer than the
    /// thickness of the block.
    const ALONG: usize = 5;
    const UP: usize = 2;

    fn cells(&self) -> impl Iterator<Item = SideCell> {
        let [x, y, z] = self.block;
        let (wide, tall) = (move |length: f64| length / Self::ALONG as f64, z / Self::UP as f64);
        let faces = [
            ("x_min", -Vector3::x(), Vector3::y(), 0.5 * x, y),
            ("x_max", Vector3::x(), Vector3::y(), 0.5 * x, y),
            ("y_min", -Vector3::y(), Vector3::x(), 0.5 * y, x),
            ("y_max", Vector3::y(), Vector3::x(), 0.5 * y, x),
        ];
        faces
            .into_iter()
            .flat_map(move |(group, normal, along, distance, length)| {
                let places = (0..Self::UP).flat_map(|row| (0..Self::ALONG).map(move |column| (row, column)));
                places.map(move |(row, column)| {
                    let across = (column as f64 + 0.5) * wide(length) - 0.5 * length;
                    let up = (row as f64 + 0.5) * tall;
                    SideCell {
                        group,
                        place: Rectangle {
                            centre: Point3::from(normal * distance + along * across + Vector3::z() * up),
                            sides: [along * wide(length), Vector3::z() * tall],
                        },
                        directions: [normal, Vector3::z(), along],
                    }
                })
            })
    }

    /// Springs and dashpots of the cells: those of the base per area, times the fraction `held` of the sides that is
    /// supported.
    ///
    /// They act in both directions, because the sand's own weight presses it against the sides, and a small motion
    /// removes as much of this pressure as it adds on its way back.
    pub fn supports(&self, base: &RectangularBase, sand: &Sand, held: f64) -> Vec<Support> {
        let (along, across) = base.shear_bedding(sand);
        let shear = 0.5 * (along + across);
        let of_cell = |cell: SideCell| {
            let [side, height] = cell.place.sides.map(|side| side.norm());
            let area = held * (side * height);
            let support = |stiffness: f64, dashpot: f64| Support {
                stiffness: stiffness * area,
                damping: dashpot * area,
                gap: 0.0,
                law: SupportLaw::Bonded,
            };
            let tangential = support(shear, sand.shear_dashpot());
            [
                support(base.normal_bedding(sand), sand.normal_dashpot()),
                tangential,
                tangential,
            ]
        };
        self.cells().flat_map(of_cell).collect()
    }

    /// Displacements that the sand resists: outwards, upwards and along the side, cell by cell.
    fn load_vectors(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, MeshError> {
        let of_cell = |cell: SideCell| {
            let along = |direction| LoadVector::rectangle(mesh, cell.group, &cell.place, direction);
            cell.directions.map(along)
        };
        self.cells().flat_map(of_cell).collect()
    }
}

/// Maximum distance of a spring from its body \[m\], the same as for sensors; it is larger than the deviation of a mesh
/// from a cylinder.
const REACH: f64 = 1e-3;

/// Place of a spring to the ground.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpringFoot {
    /// Its name in the design.
    pub name: String,
    /// Position and radius of its foot \[m\]; `None` for a spring on another body.
    pub place: Option<([f64; 3], f64)>,
    /// Axes along which it acts; the vertical one points down, so that the spring's force carries the body.
    pub axes: Vec<[f64; 3]>,
}

impl SpringFoot {
    /// Displacements that it resists, one per axis; zero vectors for a spring on another body.
    fn load_vectors(&self, mesh: &Mesh, surface: &Surface) -> Result<Vec<LoadVector>, Error> {
        let along = |&axis: &[f64; 3]| {
            let Some((at, radius)) = self.place else {
                return Ok(LoadVector::zero());
            };
            let (at, axis) = (Point3::from(at), Vector3::from(axis));
            let disc = LoadVector::disc(surface, (at, radius), axis)?;
            let vector = disc.map_or_else(|| LoadVector::point(mesh, at, axis, REACH), Ok);
            vector.map_err(|error| match error {
                MeshError::Outside { distance, .. } => BodyError::SpringOutside {
                    spring: self.name.clone(),
                    distance,
                }
                .into(),
                other => other.into(),
            })
        };
        self.axes.iter().map(along).collect()
    }
}

/// The load vectors; if they cannot be computed, none, and the problem is added.
fn collected(vectors: Result<Vec<LoadVector>, Error>, problems: &mut Vec<Error>) -> Vec<LoadVector> {
    match vectors {
        Ok(vectors) => vectors,
        Err(error) => {
            problems.extend(error.parts());
            Vec::new()
        }
    }
}

/// Names of the face groups of a mesh, in one line.
pub(super) fn known_groups(mesh: &Mesh) -> String {
    let names: Vec<&str> = mesh.groups.iter().map(|group| &*group.name).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

impl LoadPlaces {
    /// Load vectors of the shot's forces.
    fn loads(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, Error> {
        let mut loads = Vec::new();
        if let Some(nail) = &self.nail {
            loads.extend(nail.load_vectors(mesh)?);
        }
        if let Some(tool) = &self.tool {
            loads.extend(tool_loads::load_vectors(tool, mesh)?);
        }
        Ok(loads)
    }

    /// Load vectors of contacts and supports.
    fn contacts(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, Error> {
        let mut contacts = Vec::new();
        for face in &self.contacts {
            contacts.extend(face.load_vectors(mesh)?);
        }
        if let Some(side_sand) = &self.side_sand {
            contacts.extend(side_sand.load_vectors(mesh)?);
        }
        if !self.springs.is_empty() {
            let surface = Surface::of(mesh);
            for spring in &self.springs {
                contacts.extend(spring.load_vectors(mesh, &surface)?);
            }
        }
        if let Some(joint) = &self.joint {
            contacts.extend(joint.load_vectors(mesh)?);
        }
        contacts.extend((0..self.elsewhere).map(|_| LoadVector::zero()));
        Ok(contacts)
    }
}
