//! Finite-element bodies of a design: mesh, modes, and the patterns through which forces reach them.
//!
//! Workpiece and worktable meet in the plane z = 0, z up; the workpiece's centre is at x = y = 0, x along the grain.

use nailnoise_fem::supports::{ContactGrid, GridRule};
use nailnoise_fem::{LoadVector, ModalBasis, Rectangle};
use nailnoise_meshes::{Mesh, Surface};
use nalgebra::{DMatrix, DVector, Point3, Vector3};

use super::geometry::{BodyKind, Geometry, added_mass};
use super::model::{Model, Modelling, body};
use super::{Tell, shank, sides, springs, tool_loads};
use crate::design::{Design, Sprung, SupportKind};
use crate::error::Error;
use crate::result::Check;
use crate::stages::radiation::MovingSurface;
use crate::store::Store;

/// A body in modal coordinates, with its geometry.
pub struct Body {
    /// `workpiece`, `worktable` or `tool`.
    pub name: &'static str,
    /// Digest of all that its modes are computed from: bodies of one identity move alike.
    pub(super) identity: [u8; 32],
    /// Its mesh.
    pub mesh: Mesh,
    /// Its outer faces.
    pub surface: Surface,
    /// Its modes, proven complete up to their top frequency, and static corrections: below, "modes" are both. Their shapes are
    /// apart, see [`Body::shapes`].
    pub basis: ModalBasis<()>,
    /// Displacement of the surface's points, x, y and z of each, in each mode: 3 points x modes \[kg^-1/2\]. In single
    /// precision, as radiation matrices and pictures are.
    pub skin: DMatrix<f32>,
    /// The shapes, where they have just been computed.
    pub(super) shapes: Option<DMatrix<f64>>,
    /// What makes its model.
    pub(super) model: (BodyKind, Modelling),
    /// Angular frequencies of the modes \[rad/s\]; 0 for rigid ones.
    pub omega: Vec<f64>,
    /// Loss factor of all modes \[-\].
    pub loss_factor: f64,
    /// Frequency up to which the body's motion is part of the result \[Hz\].
    pub top_hz: f64,
    /// Modal momentum of the body as it rises at unit speed, Phi^T M (0, 0, 1) \[kg^1/2\].
    pub lift: DVector<f64>,
    /// Modal force of gravity \[N kg^-1/2\].
    pub weight: DVector<f64>,
    /// Generalised displacement of each load, downwards positive: modes x loads.
    pub loads: DMatrix<f64>,
    /// Generalised displacement of each contact cell along the body's outward normal, then of the sand's cells at its sides
    /// and of springs to the ground: modes x supports.
    pub contacts: DMatrix<f64>,
}

/// The bodies of a design.
pub struct Structure {
    /// The wood block.
    pub workpiece: Body,
    /// The worktable, when the block stands on one.
    pub worktable: Option<Body>,
    /// Cells in which the block's underside touches what it stands on.
    pub grid: ContactGrid,
}

impl Structure {
    /// The bodies there are.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        std::iter::once(&self.workpiece).chain(&self.worktable)
    }
}

/// Where loads act on the workpiece, in the order of the columns of [`Body::loads`]: the nail's stations, then the nose.
pub(super) const WORKPIECE_LOADS: usize = shank::STATIONS + 1;

/// Which model of a body has the loads and contacts of a shot.
const DRIVEN: &str = "driven";

/// The contact cells of the workpiece's underside.
pub(super) fn contact_grid(design: &Design) -> ContactGrid {
    let (block, contact) = (&design.workpiece, &design.support.contact);
    let (along, across) = (contact.points_along as usize, contact.points_across as usize);
    ContactGrid::new(block.length, block.width, along, across, GridRule::CellCentred)
}

/// What is nailed, free.
///
/// # Errors
/// Those of mesh, material and modal solution.
pub fn workpiece(design: &Design, cache: &Store) -> Result<Body, Error> {
    workpiece_telling(design, cache, &|_, _| ())
}

/// [`workpiece`], and tells how many modes are found.
pub(super) fn workpiece_telling(design: &Design, cache: &Store, tell: Tell<'_>) -> Result<Body, Error> {
    let mut block = body(design, (BodyKind::Workpiece, DRIVEN), cache, tell, workpiece_model)?;
    if design.support.kind == SupportKind::Sandbox {
        // Sand that moves with the base rests in the sand: its weight is not the block's.
        let weight = design.ambient.gravity * added_mass(design)?;
        let cells = contact_grid(design).areas;
        let area: f64 = cells.iter().sum();
        for (cell, cell_area) in cells.iter().enumerate() {
            let share = block.contacts.column(cell) * (weight * cell_area / area);
            block.weight -= share;
        }
    }
    Ok(block)
}

fn workpiece_model(design: &Design, kind: BodyKind) -> Result<Model, Error> {
    let geometry = Geometry::of(design, kind, false)?;
    let (mesh, thickness) = (&geometry.mesh, design.workpiece.thickness);
    let mut loads = Vec::with_capacity(WORKPIECE_LOADS);
    let nail = [design.nail.offset_along, design.nail.offset_across];
    for depth in shank::depths(design.nail.length) {
        let station = Point3::new(nail[0], nail[1], thickness - depth);
        loads.push(LoadVector::point(mesh, station, -Vector3::z(), 0.0)?);
    }
    let nose = Rectangle::horizontal(
        Point3::new(nail[0], nail[1], thickness),
        [design.body.nose_width, design.body.nose_depth],
    );
    loads.push(LoadVector::rectangle(mesh, "top", &nose, -Vector3::z())?);
    let mut contacts = match design.support.kind {
        SupportKind::Clamped | SupportKind::Springs => Vec::new(),
        SupportKind::Worktable | SupportKind::Sandbox | SupportKind::Floor => {
            let mut contacts = contact_vectors(design, mesh, "bottom", -Vector3::z())?;
            contacts.extend(sides::load_vectors(design, mesh)?);
            contacts
        }
    };
    contacts.extend(springs::load_vectors(design, mesh, Sprung::Workpiece)?);
    Ok(Model {
        geometry,
        loads,
        contacts,
    })
}

/// The worktable, clamped at the floor or on springs.
///
/// # Errors
/// [`Error::NoSuchBody`] when the support is a sandbox; those of mesh, material and modal solution.
pub fn table(design: &Design, cache: &Store) -> Result<Body, Error> {
    table_telling(design, cache, &|_, _| ())
}

/// [`table`], and tells how many modes are found.
pub(super) fn table_telling(design: &Design, cache: &Store, tell: Tell<'_>) -> Result<Body, Error> {
    body(design, (BodyKind::Worktable, DRIVEN), cache, tell, table_model)
}

fn table_model(design: &Design, kind: BodyKind) -> Result<Model, Error> {
    let geometry = Geometry::of(design, kind, false)?;
    let mut contacts = contact_vectors(design, &geometry.mesh, "top", Vector3::z())?;
    contacts.extend(springs::load_vectors(design, &geometry.mesh, Sprung::Worktable)?);
    Ok(Model {
        geometry,
        loads: Vec::new(),
        contacts,
    })
}

/// The tool's body, free, with what drives it: forces along the axis, then pressures on walls.
///
/// # Errors
/// As [`Geometry::of`], [`Error::NoLoadSurface`], and those of the modal solution.
pub fn tool_body(design: &Design, cache: &Store) -> Result<Body, Error> {
    tool_body_telling(design, cache, &|_, _| ())
}

/// [`tool_body`], and tells how many modes are found.
pub(super) fn tool_body_telling(design: &Design, cache: &Store, tell: Tell<'_>) -> Result<Body, Error> {
    body(design, (BodyKind::Tool, DRIVEN), cache, tell, tool_model)
}

fn tool_model(design: &Design, kind: BodyKind) -> Result<Model, Error> {
    let geometry = Geometry::of(design, kind, false)?;
    let loads = tool_loads::load_vectors(design, &geometry.mesh)?;
    Ok(Model {
        geometry,
        loads,
        contacts: Vec::new(),
    })
}

/// The modes of any body alone, without what drives it.
///
/// # Errors
/// As [`Geometry::of`], and those of the modal solution.
pub fn modes_of(design: &Design, kind: BodyKind, cache: &Store) -> Result<Body, Error> {
    modes_of_telling(design, kind, cache, &|_, _| ())
}

/// [`modes_of`], and tells how many modes are found.
pub(crate) fn modes_of_telling(design: &Design, kind: BodyKind, cache: &Store, tell: Tell<'_>) -> Result<Body, Error> {
    body(design, (kind, "alone"), cache, tell, model_alone)
}

fn model_alone(design: &Design, kind: BodyKind) -> Result<Model, Error> {
    Ok(Model {
        geometry: Geometry::of(design, kind, false)?,
        loads: Vec::new(),
        contacts: Vec::new(),
    })
}

/// Mean displacement along a direction of each contact cell on a face group in the plane z = 0.
fn contact_vectors(
    design: &Design,
    mesh: &Mesh,
    group: &str,
    direction: Vector3<f64>,
) -> Result<Vec<LoadVector>, Error> {
    let (block, contact) = (&design.workpiece, &design.support.contact);
    let size = [
        block.length / f64::from(contact.points_along),
        block.width / f64::from(contact.points_across),
    ];
    let cells = contact_grid(design);
    let cell = |&[x, y]: &[f64; 2]| {
        let cell = Rectangle::horizontal(Point3::new(x, y, 0.0), size);
        LoadVector::rectangle(mesh, group, &cell, direction)
    };
    Ok(cells.points.iter().map(cell).collect::<Result<_, _>>()?)
}

impl Body {
    /// Its surface and how that moves.
    pub(crate) fn moving_surface(&self) -> MovingSurface<'_> {
        MovingSurface {
            body: self.name,
            surface: &self.surface,
            modes: &self.skin,
        }
    }

    /// Checks of the modal solution.
    pub fn checks(&self) -> Vec<Check> {
        let worst = self.basis.residuals.iter().fold(0.0, |worst: f64, &r| worst.max(r));
        let missing = self.basis.sturm.count as f64 - self.basis.hz.len() as f64;
        vec![
            Check::at_most(format!("{}: eigen residual", self.name), worst, 1e-8),
            Check::at_most(
                format!("{}: orthonormality", self.name),
                self.basis.orthonormality,
                1e-8,
            ),
            Check::at_most(format!("{}: Sturm count less modes found", self.name), missing, 0.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::pipeline::model::BEYOND_BODIES;

    /// What the cache leaves out of a body's key does not reach the body.
    #[test]
    fn keys_beyond_the_bodies_change_no_mesh_no_mode_and_no_pattern() {
        let base = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let mut other = base.clone();
        let mut moved = 0;
        for (key, kind, value) in base.keys() {
            if BEYOND_BODIES.iter().any(|beyond| key.starts_with(beyond)) {
                let value = value.another(kind).unwrap_or_else(|| panic!("{key} has one value"));
                other.set(&[(key.as_str(), value)]).unwrap();
                moved += 1;
            }
        }
        assert!(moved > 30, "{moved} keys moved");
        let models: [(BodyKind, Modelling); 3] = [
            (BodyKind::Workpiece, workpiece_model),
            (BodyKind::Worktable, table_model),
            (BodyKind::Tool, tool_model),
        ];
        for (kind, model) in models {
            let [a, b] = [&base, &other].map(|design| model(design, kind).unwrap().digest(design));
            assert_eq!(a, b);
        }
    }
}
