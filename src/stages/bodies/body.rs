//! A body in modal coordinates, with all the data that a shot needs.

use nailnoise_fem::vibration::supports::ContactGrid;
use nailnoise_fem::{LoadVector, ModalBasis, ShortestWave, wall_thicknesses};
use nailnoise_meshes::{Mesh, Surface};
use nalgebra::{DMatrix, DVector};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::attachment::Meshed;
use super::geometry::BodyKind;
use super::load_places::Model;
use super::modes::WholeModes;
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::BodyError;
use crate::stages::{Code, HasMatrix, Progress, Stage, Stored, WithMatrix, code, matrix};

/// Reduces the finite elements of a body to its modes.
#[derive(Serialize)]
pub struct ModalModel {
    /// The body.
    pub kind: BodyKind,
    /// Its finite elements.
    pub model: Stored<Model>,
    /// Its modes.
    pub modes: Stored<WholeModes>,
    /// Highest frequency at which the result includes its motion \[Hz\].
    pub top_hz: f64,
    /// Frequency below which the set of modes is complete \[Hz\].
    pub below_hz: f64,
}

/// Minimum number of sides of quadratic elements per shortest wavelength; with fewer, frequencies and levels near the
/// top are inaccurate.
pub const SIDES_PER_WAVE: f64 = 2.0;

/// Minimum ratio of the frequency below which modes are complete to the top frequency of the result; modes just above
/// the top contribute to the motion below it.
const MODE_MARGIN: f64 = 1.05;

/// Resolution of a body's motion up to its top frequency by elements and modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Longest element side relative to the shortest wavelength along it at the top frequency \[-\], for each part.
    pub sides: Vec<(String, f64)>,
    /// Ratio of the top frequency to the frequency below which modes are complete \[-\].
    pub top_over_modes: f64,
}

impl Resolution {
    fn new(meshed: &Meshed, top_hz: f64, below_hz: f64) -> Result<Self, Error> {
        let mesh = &meshed.imported.mesh;
        let parts = wall_thicknesses(mesh)?.into_iter().enumerate();
        let sides = parts.map(|(part, thickness)| {
            let waves = ShortestWave::of_part(mesh, part, &meshed.materials[part], top_hz, thickness);
            (mesh.part_names[part].clone(), waves.elements.recip())
        });
        Ok(Self {
            sides: sides.collect(),
            top_over_modes: top_hz / below_hz,
        })
    }

    fn checks(&self, body: &str) -> Vec<Check> {
        let sides = self.sides.iter().map(|(part, sides)| {
            let name = format!(
                "{body}: longest element side of the {part} over the shortest wavelength at the top frequency [-]"
            );
            Check::at_most(name, *sides, 1.0 / SIDES_PER_WAVE)
        });
        let margin = Check::at_most(
            format!("{body}: top frequency over the frequency up to which all modes are known [-]"),
            self.top_over_modes,
            1.0 / MODE_MARGIN,
        );
        sides.chain([margin]).collect()
    }
}

/// A body in modal coordinates, with its geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// `workpiece`, `worktable` or `tool`.
    #[serde(deserialize_with = "known_name")]
    pub name: Name,
    /// Its mesh.
    pub mesh: Mesh,
    /// Its outer faces.
    pub surface: Surface,
    /// Resolution of its elements and modes.
    pub resolution: Resolution,
    /// Its modes, verified to be complete up to their top frequency, and static corrections; "modes" means both below.
    pub basis: ModalBasis<()>,
    /// Displacement of the surface's points, x, y and z of each, in each mode: 3 points x modes \[kg^-1/2\]. In single
    /// precision, like radiation matrices and pictures.
    #[serde(skip)]
    pub skin: DMatrix<f32>,
    /// Angular frequencies of the modes \[rad/s\]; 0 for rigid-body modes.
    pub omega: Vec<f64>,
    /// Modal momentum of the body moving upwards at unit speed, Phi^T M (0, 0, 1) \[kg^1/2\].
    #[serde(with = "matrix")]
    pub lift: DVector<f64>,
    /// Generalised displacement of each load, downwards positive: modes x loads.
    #[serde(with = "matrix")]
    pub loads: DMatrix<f64>,
    /// Generalised displacement of each contact cell along the body's outward normal, then of the sand's cells at its
    /// sides, of springs to the ground and of the joint of two pieces: modes x supports.
    #[serde(with = "matrix")]
    pub contacts: DMatrix<f64>,
}

/// The moving surface of a body.
#[derive(Clone, Copy)]
pub struct MovingSurface<'a> {
    /// `workpiece`, `worktable` or `tool`.
    pub body: &'static str,
    /// Its outer faces.
    pub surface: &'a Surface,
    /// Displacement of the surface's points in each mode, (3 x points) x modes \[kg^-1/2\].
    pub modes: &'a DMatrix<f32>,
}

/// Name of a body.
type Name = &'static str;

fn known_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Name, D::Error> {
    let name = String::deserialize(deserializer)?;
    let mut known = BodyKind::ALL.into_iter().map(BodyKind::name);
    known
        .find(|known| *known == name)
        .ok_or_else(|| D::Error::custom("no such body"))
}

impl HasMatrix for Body {
    type Entry = f32;

    fn matrix(&self) -> &DMatrix<f32> {
        &self.skin
    }

    fn set_matrix(&mut self, matrix: DMatrix<f32>) {
        self.skin = matrix;
    }
}

impl Stage for ModalModel {
    type Output = Body;
    type Error = Error;
    type Codec = WithMatrix;
    const NAME: &'static str = "body";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<Body, Error> {
        let (modes, model) = (self.modes.get()?, self.model.get()?);
        let (mesh, shapes) = (&model.meshed.imported.mesh, &modes.shapes);
        let on_surface = || {
            let surface = Surface::of(mesh);
            let skin = skin(&surface, shapes);
            (surface, skin)
        };
        let of_elements = || {
            let resolution = Resolution::new(&model.meshed, self.top_hz, self.below_hz);
            let lift = shapes.tr_mul(&DVector::from_column_slice(&modes.momentum));
            (resolution, lift, participation(&model.loads, shapes))
        };
        let ((surface, skin), (resolution, lift, loads)) = rayon::join(on_surface, of_elements);
        Ok(Body {
            name: self.kind.name(),
            resolution: resolution?,
            skin,
            omega: modes
                .basis
                .all_hz()
                .iter()
                .map(|hz| std::f64::consts::TAU * hz)
                .collect(),
            basis: modes.basis.clone(),
            lift,
            loads,
            contacts: participation(&model.contacts, shapes),
            mesh: mesh.clone(),
            surface,
        })
    }
}

/// Shapes on a surface's points, see [`Body::skin`].
fn skin(surface: &Surface, shapes: &DMatrix<f64>) -> DMatrix<f32> {
    let nodes = &surface.volume_nodes;
    DMatrix::from_fn(3 * nodes.len(), shapes.ncols(), |row, mode| {
        shapes[(3 * nodes[row / 3] + row % 3, mode)] as f32
    })
}

/// Displacement in each mode that load vectors measure: modes x load vectors.
pub(super) fn participation(vectors: &[LoadVector], shapes: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(shapes.ncols(), vectors.len());
    for (vector, mut column) in vectors.iter().zip(all.column_iter_mut()) {
        column.copy_from(&vector.participation(shapes));
    }
    all
}

impl Body {
    /// Shapes at every node of the full modes that belong to this body.
    ///
    /// # Errors
    /// [`BodyError::OtherModes`] if another machine stored the body. The sign of a mode is arbitrary, and modes of
    /// equal frequency may be any mixture of each other.
    pub fn shapes<'a>(&self, modes: &'a WholeModes) -> Result<&'a DMatrix<f64>, Error> {
        if skin(&self.surface, &modes.shapes) == self.skin {
            Ok(&modes.shapes)
        } else {
            Err(BodyError::OtherModes { body: self.name }.into())
        }
    }

    /// Modal force of gravity \[N kg^-1/2\] for an acceleration of gravity \[m/s2\].
    pub fn weight(&self, gravity: f64) -> DVector<f64> {
        &self.lift * -gravity
    }

    /// The same if a mass \[kg\] of sand that moves with the base rests in the sand: its weight is carried evenly by
    /// the contact cells.
    pub fn weight_in_sand(&self, gravity: f64, sand: f64, grid: &ContactGrid) -> DVector<f64> {
        let mut weight = self.weight(gravity);
        let area: f64 = grid.areas.iter().sum();
        for (cell, cell_area) in grid.areas.iter().enumerate() {
            weight -= self.contacts.column(cell) * (gravity * sand * cell_area / area);
        }
        weight
    }

    /// Its surface, with the motion in each mode.
    pub fn moving_surface(&self) -> MovingSurface<'_> {
        MovingSurface {
            body: self.name,
            surface: &self.surface,
            modes: &self.skin,
        }
    }

    /// Checks of elements and modal solution.
    pub fn checks(&self) -> Vec<Check> {
        let (basis, name) = (&self.basis, self.name);
        let worst = basis.residuals.iter().fold(0.0, |worst: f64, &r| worst.max(r));
        let missing = basis.sturm.count as f64 - basis.hz.len() as f64;
        let mut checks = vec![
            Check::at_most(format!("{name}: eigen residual"), worst, 1e-8),
            Check::at_most(format!("{name}: orthonormality"), basis.orthonormality, 1e-8),
            Check::at_most(format!("{name}: number of missing modes, by Sturm count"), missing, 0.0),
        ];
        checks.extend(self.resolution.checks(name));
        checks
    }
}
