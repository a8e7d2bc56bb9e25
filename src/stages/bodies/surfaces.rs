//! Names of the surfaces of a user's body: from its file, from places that the design gives, or recognised.
//!
//! A face has the same meaning as in a drawing: element faces that meet at smooth edges. So a point names an entire
//! bore or the end of a tube, whether the file is a mesh or a solid geometry.

use std::f64::consts::PI;

use nailnoise_meshes::{FaceGroup, FaceRef, Mesh, Surface, gmsh};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::tool_surfaces::ToolShape;
use crate::error::Error;
use crate::stages::bodies::BodyError;

/// Angle between the normals at an edge above which a smooth face ends.
pub(super) const EDGE: f64 = PI / 6.0;

/// Largest angle between the direction that the design gives and the normal of the face.
const ASIDE: f64 = PI / 3.0;

/// Maximum distance from the body for a place without a radius \[m\]; it is larger than the deviation of a mesh from a
/// cylinder.
const REACH: f64 = 1e-3;

/// A place on a body's skin that identifies a named surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfacePlace {
    /// Its name in the design.
    pub entry: String,
    /// Name of the surface.
    pub surface: &'static str,
    /// A point on it \[m\].
    pub at: [f64; 3],
    /// Distance from the point within which the face belongs to it \[m\]; 0 for the entire face.
    pub radius: f64,
    /// Outward direction of the face at that point; `None` for either side of a wall.
    pub outward: Option<[f64; 3]>,
}

/// How the surfaces of a body from a file are named.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Naming {
    /// Places that the design gives.
    pub places: Vec<SurfacePlace>,
    /// Dimensions by which the surfaces of a tool are recognised; `None` for other bodies.
    pub tool: Option<ToolShape>,
}

/// Origin of the name of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// The design gives its place.
    Design,
    /// The program recognised it.
    Guess,
}

/// A surface that the file of a body does not name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundSurface {
    /// Its name.
    pub name: String,
    /// Origin of the name.
    pub origin: Origin,
    /// Its centroid \[m\].
    pub centre: [f64; 3],
    /// Its area \[m2\].
    pub area: f64,
}

impl FoundSurface {
    /// Name, centre and area.
    pub fn in_words(&self) -> String {
        let [x, y, z] = self.centre.map(|c| 1e3 * c);
        format!(
            "{} at ({x:.1}, {y:.1}, {z:.1}) mm, {:.1} cm2",
            self.name,
            1e4 * self.area
        )
    }
}

impl Naming {
    /// Names the surfaces of a mesh: those whose places the design gives; for a mesh without any names, those
    /// identified by the heights of its planes; and the surfaces of a tool, unless its file names one of them. A face
    /// has one name.
    ///
    /// # Errors
    /// [`BodyError::SurfaceOutside`] for a place that is not on the body.
    pub(super) fn apply(&self, mesh: &mut Mesh) -> Result<Vec<FoundSurface>, Error> {
        let mut found = Vec::new();
        if mesh.groups.is_empty() && self.tool.is_none() {
            gmsh::name_by_height(mesh);
            let surface = Surface::of(mesh);
            for group in &mesh.groups {
                let patch = surface.patch(&group.name)?;
                let faces = (0..surface.faces.len()).filter(|&face| surface.faces[face].patch == patch);
                found.push(measured(
                    &surface,
                    &group.name,
                    Origin::Guess,
                    &faces.collect::<Vec<_>>(),
                )?);
            }
        }
        let guesses = self
            .tool
            .filter(|_| !mesh.groups.iter().any(|group| ToolShape::NAMES.contains(&&*group.name)));
        if self.places.is_empty() && guesses.is_none() {
            return Ok(found);
        }
        let surface = Surface::of(mesh);
        let smooth = surface.smooth_faces(EDGE)?;
        let mut named: Vec<(&'static str, Origin, Vec<usize>)> = Vec::new();
        for place in &self.places {
            let nearest = place.nearest(&surface)?;
            let whole = smooth.iter().find(|face| face.faces.binary_search(&nearest).is_ok());
            let whole = whole.map_or(&[][..], |face| &face.faces);
            let faces = whole
                .iter()
                .copied()
                .filter(|&face| face == nearest || place.holds(&surface, face));
            match named.iter_mut().find(|(name, ..)| *name == place.surface) {
                Some((.., own)) => own.extend(faces),
                None => named.push((place.surface, Origin::Design, faces.collect())),
            }
        }
        if let Some(shape) = guesses {
            for (name, faces) in shape.guesses(&surface, &smooth)? {
                if !named.iter().any(|(own, ..)| *own == name) {
                    named.push((name, Origin::Guess, faces));
                }
            }
        }
        let mut taken = std::collections::HashSet::new();
        for (name, origin, mut faces) in named {
            faces.retain(|&face| taken.insert(face));
            found.retain(|other: &FoundSurface| other.name != name);
            found.push(measured(&surface, name, origin, &faces)?);
            let faces: Vec<FaceRef> = faces.into_iter().map(|face| surface.faces[face].of).collect();
            rename(mesh, name, faces);
        }
        Ok(found)
    }
}

impl SurfacePlace {
    /// The nearest element face with the given orientation.
    fn nearest(&self, surface: &Surface) -> Result<usize, Error> {
        let at = Point3::from(self.at);
        let outward = self.outward.map(|outward| Vector3::from(outward).normalize());
        let looks = |face: usize| {
            let centre = surface.point_at(face, surface.faces[face].kind.centre());
            outward.is_none_or(|outward| outward.dot(&centre.normal) > ASIDE.cos())
        };
        let nearest = surface.nearest_face(at, looks);
        match nearest {
            Some((face, distance)) if distance <= self.radius.max(REACH) => Ok(face),
            _ => Err(BodyError::SurfaceOutside {
                entry: self.entry.clone(),
                distance: nearest.map(|(_, distance)| distance),
            }
            .into()),
        }
    }

    /// Whether an element face is within the radius.
    fn holds(&self, surface: &Surface, face: usize) -> bool {
        let centre = surface.point_at(face, surface.faces[face].kind.centre()).position;
        self.radius == 0.0 || (centre - Point3::from(self.at)).norm() <= self.radius
    }
}

/// Centroid and area of a surface.
fn measured(surface: &Surface, name: &str, origin: Origin, faces: &[usize]) -> Result<FoundSurface, Error> {
    let own: std::collections::HashSet<usize> = faces.iter().copied().collect();
    let (mut area, mut moment) = (0.0, Vector3::zeros());
    for point in surface.quadrature(3)?.iter().filter(|point| own.contains(&point.face)) {
        area += point.weight;
        moment += point.weight * point.position.coords;
    }
    Ok(FoundSurface {
        name: name.to_owned(),
        origin,
        centre: (moment / area).into(),
        area,
    })
}

/// Assigns only these faces to the group, replacing its previous ones.
fn rename(mesh: &mut Mesh, name: &str, faces: Vec<FaceRef>) {
    mesh.groups.retain(|group| group.name != name);
    for group in &mut mesh.groups {
        group.faces.retain(|face| !faces.contains(face));
    }
    mesh.groups.retain(|group| !group.faces.is_empty());
    mesh.groups.push(FaceGroup {
        name: name.to_owned(),
        faces,
    });
}
