//! A finite-element model of a body, its modes, and what is kept of both from run to run.
//!
//! Modes are kept under all that they are computed from: mesh, materials, supports, loads. To tell that two designs share
//! them takes reading, checking and loading the mesh, which is half of what another shot costs. So what a mesh leaves
//! behind is kept as well, under the values of the design alone; with it and the modes on its surface another shot needs
//! neither mesh nor whole shapes, which are the most of all that is kept of a body.

use std::borrow::Cow;

use nailnoise_fem::{LoadVector, ModalBasis, ModalSettings, System, assemble_with, modes_telling};
use nailnoise_meshes::{Mesh, Surface};
use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

use super::Tell;
use super::bodies::Body;
use super::geometry::{BodyKind, Geometry};
use super::modes::Kept;
use crate::design::Design;
use crate::error::Error;
use crate::store::{Key, Store};

/// Beginnings of the keys whose values reach no mesh, no mode and no load vector; [`Body::weight`] is not kept.
pub(super) const BEYOND_BODIES: [&str; 4] = ["acoustics.", "ambient.", "exhaust.", "supply."];

/// A finite-element model before its modes are known.
pub(super) struct Model {
    pub(super) geometry: Geometry,
    /// See [`Body::loads`].
    pub(super) loads: Vec<LoadVector>,
    /// See [`Body::contacts`].
    pub(super) contacts: Vec<LoadVector>,
}

/// How a model of a body is made of a design.
pub(super) type Modelling = fn(&Design, BodyKind) -> Result<Model, Error>;

/// All of a body but the shapes of its modes.
#[derive(Serialize, Deserialize)]
struct Prepared {
    /// See [`Body::identity`].
    identity: [u8; 32],
    basis: ModalBasis<()>,
    mesh: Mesh,
    surface: Surface,
    loss_factor: f64,
    top_hz: f64,
    lift: Vec<f64>,
    /// Load by load, every mode's.
    loads: Vec<Vec<f64>>,
    /// The same of the contacts.
    contacts: Vec<Vec<f64>>,
}

/// A body of a design, from the cache where it is known; `drive` tells which of its models it is, `model` makes it.
///
/// # Errors
/// Those of `model` and of the modal solution.
pub(super) fn body(
    design: &Design,
    (kind, drive): (BodyKind, &str),
    cache: &Store,
    tell: Tell<'_>,
    model: Modelling,
) -> Result<Body, Error> {
    let stage = format!("mesh of the {}", kind.name());
    let reaches = |key: &str| !BEYOND_BODIES.iter().any(|beyond| key.starts_with(beyond));
    let key = Key::new().with(drive).with(&design.values_where(reaches));
    let prepared: Option<Prepared> = cache.get(&stage, &key);
    if let Some(prepared) = prepared {
        let skin = Kept::new(cache, kind, &prepared.identity).surface();
        if let Some(skin) = skin.filter(|skin| skin.ncols() == prepared.lift.len()) {
            return Ok(prepared.body(design, (kind, model), (skin, None)));
        }
    }
    let (prepared, shapes) = model(design, kind)?.solve(design, cache, tell)?;
    let skin = skin(&prepared.surface, &shapes);
    Kept::new(cache, kind, &prepared.identity).keep_surface(&skin);
    cache.put(&stage, &key, &prepared);
    Ok(prepared.body(design, (kind, model), (skin, Some(shapes))))
}

impl Prepared {
    fn body(
        self,
        design: &Design,
        (kind, model): (BodyKind, Modelling),
        (skin, shapes): (DMatrix<f32>, Option<DMatrix<f64>>),
    ) -> Body {
        let modes = skin.ncols();
        let columns =
            |columns: &[Vec<f64>]| DMatrix::from_iterator(modes, columns.len(), columns.iter().flatten().copied());
        let lift = DVector::from_vec(self.lift);
        Body {
            name: kind.name(),
            identity: self.identity,
            omega: self
                .basis
                .all_hz()
                .iter()
                .map(|hz| std::f64::consts::TAU * hz)
                .collect(),
            weight: &lift * -design.ambient.gravity,
            loads: columns(&self.loads),
            contacts: columns(&self.contacts),
            lift,
            mesh: self.mesh,
            surface: self.surface,
            loss_factor: self.loss_factor,
            top_hz: self.top_hz,
            basis: self.basis,
            skin,
            shapes,
            model: (kind, model),
        }
    }
}

/// Shapes on a surface's points, see [`Body::skin`].
fn skin(surface: &Surface, shapes: &DMatrix<f64>) -> DMatrix<f32> {
    let nodes = &surface.volume_nodes;
    DMatrix::from_fn(3 * nodes.len(), shapes.ncols(), |row, mode| {
        shapes[(3 * nodes[row / 3] + row % 3, mode)] as f32
    })
}

impl Body {
    /// Shapes of the modes, then of the static corrections, on every node: 3 x nodes rows, one column a shape, phi^T M phi =
    /// 1 \[kg^-1/2\]. They are read when they are wanted: a shot has enough of [`Body::skin`].
    ///
    /// # Errors
    /// Those of the modal solution, where the cache no longer has them; [`Error::OtherModes`] where they then are not those
    /// that the body moves in.
    pub fn shapes(&self, design: &Design, cache: &Store) -> Result<Cow<'_, DMatrix<f64>>, Error> {
        if let Some(shapes) = &self.shapes {
            return Ok(Cow::Borrowed(shapes));
        }
        let (kind, model) = self.model;
        let shapes = match Kept::new(cache, kind, &self.identity).modes() {
            Some((basis, _)) => basis.shapes,
            None => model(design, kind)?.solve(design, cache, &|_, _| ())?.1,
        };
        // The sign of a mode is open, and modes of one frequency may be any mixture of each other.
        if skin(&self.surface, &shapes) != self.skin {
            return Err(Error::OtherModes { body: self.name });
        }
        Ok(Cow::Owned(shapes))
    }

    /// What patterns are in each mode: modes x patterns; kept, as it needs the whole shapes.
    ///
    /// # Errors
    /// As [`Body::shapes`].
    pub(super) fn participation(
        &self,
        design: &Design,
        cache: &Store,
        patterns: &[LoadVector],
    ) -> Result<DMatrix<f64>, Error> {
        let modes = self.omega.len();
        if patterns.is_empty() {
            return Ok(DMatrix::zeros(modes, 0));
        }
        let key = Key::new().with(&self.identity).with(patterns);
        let stage = format!("modes under the sensors of the {}", self.name);
        let found: Vec<Vec<f64>> = cache.get_or(&stage, key, || {
            let shapes = self.shapes(design, cache)?;
            Ok::<_, Error>(participation(patterns, &shapes))
        })?;
        let known = found.iter().flatten().copied();
        Ok(DMatrix::from_iterator(modes, patterns.len(), known))
    }
}

/// What patterns are in each mode, pattern by pattern.
fn participation(patterns: &[LoadVector], shapes: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let of_modes = |vector: &LoadVector| vector.participation(shapes).as_slice().to_vec();
    patterns.iter().map(of_modes).collect()
}

impl Model {
    fn settings(&self, design: &Design) -> ModalSettings {
        let analysis = &design.analysis;
        ModalSettings {
            residual_limit: analysis.mode_tolerance,
            ..ModalSettings::below(analysis.mode_margin * self.geometry.top_hz)
        }
    }

    /// Digest of the model, for tests of what it depends on.
    #[cfg(test)]
    pub(super) fn digest(&self, design: &Design) -> [u8; 32] {
        let Geometry {
            loss_factor, top_hz, ..
        } = self.geometry;
        let identity = self.identity(&self.settings(design));
        Key::new().with(&(identity, loss_factor, top_hz)).digest()
    }

    /// Digest of all that the modes are computed from.
    fn identity(&self, settings: &ModalSettings) -> [u8; 32] {
        let Geometry {
            mesh,
            materials,
            constraints,
            attachments,
            ..
        } = &self.geometry;
        // The debug form names every field, its numbers with all their digits: no input can be forgotten.
        let key = Key::new()
            .with(mesh)
            .with(&format!("{materials:?} {constraints:?} {attachments:?} {settings:?}"))
            .with(&self.loads)
            .with(&self.contacts);
        key.digest()
    }

    /// The modes' shapes, and what else is known of the body then.
    fn solve(self, design: &Design, cache: &Store, tell: Tell<'_>) -> Result<(Prepared, DMatrix<f64>), Error> {
        let settings = self.settings(design);
        let identity = self.identity(&settings);
        let Geometry {
            kind,
            mesh,
            materials,
            constraints,
            attachments,
            top_hz,
            loss_factor,
            ..
        } = self.geometry;
        let kept = Kept::new(cache, kind, &identity);
        let (basis, momentum) = match kept.modes() {
            Some(modes) => modes,
            None => {
                let dofs = 3 * mesh.nodes.len();
                let patterns: Vec<_> = self
                    .loads
                    .iter()
                    .chain(&self.contacts)
                    .filter(|pattern| !pattern.is_zero())
                    .map(|pattern| pattern.dense(dofs))
                    .collect();
                let settings = if patterns.is_empty() {
                    settings
                } else {
                    settings.with_loads(DMatrix::from_columns(&patterns))
                };
                let system = assemble_with(&mesh, &materials, &constraints, &attachments)?;
                let tell = |found: usize, of: usize| tell(found as u64, of as u64);
                kept.keep_modes((modes_telling(&system, &settings, &tell)?, upward_momentum(&system)))
            }
        };
        let (basis, shapes) = basis.swap_shapes(());
        let prepared = Prepared {
            identity,
            basis,
            surface: Surface::of(&mesh),
            mesh,
            loss_factor,
            top_hz,
            lift: shapes.tr_mul(&DVector::from_vec(momentum)).as_slice().to_vec(),
            loads: participation(&self.loads, &shapes),
            contacts: participation(&self.contacts, &shapes),
        };
        Ok((prepared, shapes))
    }
}

/// M (0, 0, 1) on the free degrees of freedom, to be multiplied by the shapes: the momentum of everything, what is tied
/// and lumped included, when it moves upwards at unit speed \[kg\].
fn upward_momentum(system: &System) -> Vec<f64> {
    let velocity = system.equations.translation(Vector3::z());
    let mut momentum = vec![0.0; velocity.nrows()];
    for (row, column, &value) in system.mass.triplet_iter() {
        momentum[row] += value * velocity[column];
        if row != column {
            momentum[column] += value * velocity[row]; // only the lower triangle is stored
        }
    }
    let of_dof = |dof: usize| system.equations.equation(dof / 3, dof % 3).map_or(0.0, |e| momentum[e]);
    (0..system.equations.dofs()).map(of_dof).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_fem::{Attachments, Constraints, Material, Tie};
    use nailnoise_meshes::{Block, block};
    use std::f64::consts::TAU;

    use super::super::geometry::Origin;

    const E: f64 = 70e9;
    const NU: f64 = 0.33;

    /// Static swept volume of a free body under a unit of pressure on patches, from its modes and static corrections.
    fn swept(mesh: Mesh, attachments: Attachments, patches: &[&str]) -> f64 {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");
        let mut design = Design::load(path).unwrap();
        design.analysis.mode_margin = 1.0;
        let loads = vec![LoadVector::pressure(&Surface::of(&mesh), patches, |_| true).unwrap()];
        let geometry = Geometry {
            kind: BodyKind::Tool,
            mesh,
            element_numbers: Vec::new(),
            unused_nodes: 0,
            materials: vec![Material::isotropic(E, NU, 2700.0).unwrap()],
            constraints: Constraints::free(),
            attachments,
            loss_factor: 0.0,
            top_hz: 3000.0,
            origin: Origin::BuiltIn,
        };
        let model = Model {
            geometry,
            loads,
            contacts: Vec::new(),
        };
        let (prepared, _) = model.solve(&design, &Store::none(), &|_, _| ()).unwrap();
        let hz = prepared.basis.all_hz();
        let omega = hz.iter().map(|hz| TAU * hz);
        let elastic = omega.zip(&prepared.loads[0]).filter(|(omega, _)| *omega > 0.0);
        elastic.map(|(omega, p)| (p / omega).powi(2)).sum()
    }

    /// Pressure from all sides shrinks a block by V/K, K = E/(3 (1 - 2 nu)): a linear field, which the elements hold.
    #[test]
    fn modes_and_corrections_give_the_static_shrinking_of_a_block_exactly() {
        let size = [0.3, 0.2, 0.1];
        let mesh = block(&Block {
            size,
            divisions: [3, 2, 1],
            origin: [0.0; 3],
        })
        .unwrap();
        let every: Vec<String> = mesh.groups.iter().map(|g| g.name.clone()).collect();
        let every: Vec<&str> = every.iter().map(String::as_str).collect();
        let exact = size.iter().product::<f64>() * 3.0 * (1.0 - 2.0 * NU) / E;
        let found = swept(mesh, Attachments::default(), &every);
        assert!((found / exact - 1.0).abs() < 1e-6, "{found:e} {exact:e}");
    }

    /// A cylinder open at its ends under inner pressure p (Lame): u(a) = p a/E ((b^2 + a^2)/(b^2 - a^2) + nu).
    #[test]
    fn a_cylinder_widens_under_pressure_as_lames_formula_says() {
        let (a, b, height) = (0.030, 0.034, 0.02);
        let mut mesh = block(&Block {
            size: [1.0, b - a, height],
            divisions: [24, 1, 2],
            origin: [0.0, a, 0.0],
        })
        .unwrap();
        // The strip's lower side along y becomes the bore; its two ends meet and are tied.
        let mut groups = Vec::new();
        let at = |mesh: &Mesh, axis: usize, value: f64| {
            let on = |f: &nailnoise_meshes::SurfaceFace, s: &Surface| {
                f.nodes.iter().all(|&n| (s.points[n][axis] - value).abs() < 1e-9)
            };
            let surface = Surface::of(mesh);
            surface
                .faces
                .iter()
                .filter(|f| on(f, &surface))
                .map(|f| f.of)
                .collect::<Vec<_>>()
        };
        for (name, axis, value) in [("bore", 1, a), ("seam_slave", 0, 0.0), ("seam_master", 0, 1.0)] {
            groups.push(nailnoise_meshes::FaceGroup {
                name: name.to_owned(),
                faces: at(&mesh, axis, value),
            });
        }
        mesh.groups = groups;
        for p in &mut mesh.nodes {
            let (angle, r) = (TAU * p.x, p.y);
            // Clockwise, so that elements keep their orientation.
            (p.x, p.y) = (r * angle.sin(), r * angle.cos());
        }
        let tie = Tie {
            slave: "seam_slave".to_owned(),
            master: "seam_master".to_owned(),
            tolerance: 1e-6,
        };
        let attachments = Attachments {
            ties: vec![tie],
            ..Attachments::default()
        };
        let widening = a / E * ((b * b + a * a) / (b * b - a * a) + NU);
        let exact = TAU * a * height * widening;
        let found = swept(mesh, attachments, &["bore"]);
        assert!((found / exact - 1.0).abs() < 5e-3, "{found:e} {exact:e}");
    }
}
