//! Full modes of a body: their shapes at every node, in double precision.

use nailnoise_fem::{ModalBasis, ModalSettings, System, assemble_in_order, assemble_with, modes};
use nalgebra::{DMatrix, Vector3};
use serde::{Deserialize, Serialize};

use super::geometry::BodyKind;
use super::load_places::Model;
use crate::error::Error;
use crate::stages::{Code, HasMatrix, Progress, Stage, Stored, WithMatrix, code};

/// The modes of a body below a frequency, with static corrections for its loads.
#[derive(Serialize)]
pub struct Modes {
    /// The body.
    pub kind: BodyKind,
    /// Its finite elements.
    pub model: Stored<Model>,
    /// An elimination order for its matrices; `None` if each sector of a body with mirror planes has its own.
    pub order: Stored<Option<Vec<u32>>>,
    /// All modes below this frequency are computed \[Hz\].
    pub below_hz: f64,
    /// Largest residual accepted for any mode.
    pub residual_limit: f64,
}

/// Modes and static corrections with their shapes at every node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WholeModes {
    /// Frequencies, and the proof that no mode is missing.
    pub basis: ModalBasis<()>,
    /// M (0, 0, 1), the momentum in every degree of freedom when the body moves upwards at unit speed \[kg\].
    pub momentum: Vec<f64>,
    /// Shapes of the modes, then of the static corrections: 3 nodes x modes, phi^T M phi = 1 \[kg^-1/2\].
    #[serde(skip)]
    pub shapes: DMatrix<f64>,
}

impl HasMatrix for WholeModes {
    type Entry = f64;

    fn matrix(&self) -> &DMatrix<f64> {
        &self.shapes
    }

    fn set_matrix(&mut self, matrix: DMatrix<f64>) {
        self.shapes = matrix;
    }
}

impl Stage for Modes {
    type Output = WholeModes;
    type Error = Error;
    type Codec = WithMatrix;
    const NAME: &'static str = "modes";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, progress: &Progress) -> Result<WholeModes, Error> {
        let model = self.model.get()?;
        let (meshed, mesh) = (&model.meshed, &model.meshed.imported.mesh);
        let settings = ModalSettings {
            residual_limit: self.residual_limit,
            ..ModalSettings::below(self.below_hz)
        };
        let dofs = 3 * mesh.nodes.len();
        let loads = model.loads.iter().chain(&model.contacts);
        let loads: Vec<_> = loads
            .filter(|load| !load.is_zero())
            .map(|load| load.dense(dofs))
            .collect();
        let settings = if loads.is_empty() {
            settings
        } else {
            settings.with_loads(DMatrix::from_columns(&loads))
        };
        let (constraints, attachments) = (&meshed.constraints, &meshed.attachments);
        let system = match &*self.order.get()? {
            Some(order) => assemble_in_order(mesh, &meshed.materials, constraints, attachments, order),
            None => assemble_with(mesh, &meshed.materials, constraints, attachments),
        }?;
        let basis = progress.count((self.kind.modes(), "modes"), |report| {
            modes(&system, &settings, &|found, of| report(found as u64, of as u64))
        })?;
        let (basis, shapes) = basis.swap_shapes(());
        Ok(WholeModes {
            basis,
            momentum: upward_momentum(&system),
            shapes,
        })
    }
}

/// M (0, 0, 1) in all degrees of freedom, to be multiplied by the shapes: the momentum of the complete body, including
/// tied and lumped parts, moving upwards at unit speed \[kg\].
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
    #![allow(clippy::unwrap_used)]

    use super::super::attachment::Meshed;
    use super::*;
    use nailnoise_fem::{Attachments, Constraints, LoadVector, Material, Tie};
    use nailnoise_meshes::msh::Imported;
    use nailnoise_meshes::{Block, FaceGroup, Mesh, Surface, SurfaceFace, block};
    use std::f64::consts::TAU;
    use std::sync::Arc;

    const E: f64 = 70e9;
    const NU: f64 = 0.33;

    /// Static swept volume of a free body under unit pressure on patches, from its modes and static corrections.
    fn swept(mesh: Mesh, attachments: Attachments, patches: &[&str]) -> f64 {
        let load = LoadVector::pressure(&Surface::of(&mesh), patches, |_| true).unwrap();
        let imported = Imported::built(mesh);
        let model = Model {
            meshed: Arc::new(Meshed {
                imported,
                materials: vec![Material::isotropic(E, NU, 2700.0).unwrap()],
                constraints: Constraints::free(),
                attachments,
                surfaces: Vec::new(),
                unplaced: Vec::new(),
            }),
            loads: vec![load.clone()],
            contacts: Vec::new(),
        };
        let modes = Modes {
            kind: BodyKind::Tool,
            model: Stored::ready([0; 32], model),
            order: Stored::ready([0; 32], None),
            below_hz: 3000.0,
            residual_limit: 1e-8,
        };
        let modes = modes.compute(&Progress::silent()).unwrap();
        let hz = modes.basis.all_hz();
        let omega = hz.iter().map(|hz| TAU * hz);
        let loads = load.participation(&modes.shapes);
        let elastic = omega.zip(&loads).filter(|(omega, _)| *omega > 0.0);
        elastic.map(|(omega, p)| (p / omega).powi(2)).sum()
    }

    /// Hydrostatic pressure reduces the volume of a block by V/K per unit pressure, K = E/(3 (1 - 2 nu)); the elements
    /// represent this linear field exactly.
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

    /// A cylinder with open ends under internal pressure p (Lame): u(a) = p a/E ((b^2 + a^2)/(b^2 - a^2) + nu).
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
            let on = |f: &SurfaceFace, s: &Surface| f.nodes.iter().all(|&n| (s.points[n][axis] - value).abs() < 1e-9);
            let surface = Surface::of(mesh);
            surface
                .faces
                .iter()
                .filter(|f| on(f, &surface))
                .map(|f| f.of)
                .collect::<Vec<_>>()
        };
        for (name, axis, value) in [("bore", 1, a), ("seam_slave", 0, 0.0), ("seam_master", 0, 1.0)] {
            groups.push(FaceGroup {
                name: name.to_owned(),
                faces: at(&mesh, axis, value),
            });
        }
        mesh.groups = groups;
        for p in &mut mesh.nodes {
            let (angle, r) = (TAU * p.x, p.y);
            // Clockwise, to preserve the orientation of the elements.
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
