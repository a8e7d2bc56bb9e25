//! Radiation efficiency of each mode at its natural frequency.
//!
//! ```text
//! sigma_j = R_jj(omega_j)/R^ERP_jj        R^ERP_jj = rho0 c0 int phi_n^2 dS        R_jj(omega_j) = 2 omega_j zeta_j
//! ```
//!
//! A mode that moves alone radiates sigma_j times its equivalent radiated power. zeta_j is the damping ratio that
//! radiation adds to the mode ([`FluidLoads::damping`]), so that R_jj is interpolated over frequency as it is there.
//! Modes also radiate together, by the terms R_jk, which an efficiency of single modes does not contain.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::boundary_elements::ModalBem;
use nailnoise_acoustics::radiation::radiator::FluidLoads;
use nailnoise_acoustics::radiation::{Erp, ModalRadiation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

use super::bodies::{Body, BodyError};
use super::radiation::top_of;
use super::{Code, Postcard, Progress, Stage, Stored, all, code};
use crate::error::Error;

/// Radiation efficiencies of the modes of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodyEfficiencies {
    /// `workpiece`, `worktable` or `tool`.
    pub body: String,
    /// Method of the efficiencies, or why they are not computed.
    pub method: String,
    /// The modes in ascending order; empty if the efficiencies are not computed.
    pub modes: Vec<ModeEfficiency>,
}

/// Radiation efficiency of a mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModeEfficiency {
    /// Its number from 1.
    pub mode: usize,
    /// Its natural frequency \[Hz\]; 0 for a rigid mode.
    pub hz: f64,
    /// Power that it radiates alone at its natural frequency, relative to that of efficiency 1 \[dB\]; null for a rigid
    /// mode, which has no natural frequency, and for a mode that does not radiate.
    pub efficiency_db: Option<f64>,
}

impl BodyEfficiencies {
    /// The efficiency of a mode, counted from 0 \[dB\]; `None` if it is not known.
    pub fn of_mode(&self, index: usize) -> Option<f64> {
        self.modes.get(index)?.efficiency_db
    }
}

/// How the bodies of a source radiate.
#[derive(Serialize)]
pub enum EfficiencyMethod {
    /// By boundary elements.
    BoundaryElements {
        /// The radiation matrix, in standard or in the ambient air.
        matrix: Stored<ModalBem>,
        /// Radiation damping of the modes.
        loads: Stored<Vec<FluidLoads>>,
    },
    /// By Rayleigh's integral over the top of the first body.
    FlushTop {
        /// Radiation damping of the modes.
        loads: Stored<Vec<FluidLoads>>,
    },
    /// By a method without radiation of single modes.
    NotComputed {
        /// The method, in words.
        reason: &'static str,
    },
}

/// Finds the radiation efficiencies of the modes of the bodies of a source. Nothing is solved again.
#[derive(Serialize)]
pub struct ModalEfficiencies {
    /// The method.
    pub method: EfficiencyMethod,
    /// The bodies.
    pub bodies: Vec<Stored<Body>>,
    /// The ambient air.
    pub air: Air,
}

impl Stage for ModalEfficiencies {
    /// One for each body.
    type Output = Vec<BodyEfficiencies>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "radiation efficiencies of the modes";
    const CODE: Code = code!(
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_radiation,
        stages_modal_efficiency
    );

    fn compute(&self, _: &Progress) -> Result<Vec<BodyEfficiencies>, Error> {
        let bodies = all(&self.bodies)?;
        let (method, loads, erp) = match &self.method {
            EfficiencyMethod::BoundaryElements { matrix, loads } => {
                let bem = matrix.get()?.in_air(&Air::default(), &self.air);
                let method = format!(
                    "boundary elements, above {:.0} Hz their high-frequency limit",
                    bem.transition_hz()[1]
                );
                (method, loads.get()?, diagonal(&bem.reference()))
            }
            EfficiencyMethod::FlushTop { loads } => {
                let top = top_of(&bodies[0].moving_surface())?;
                (
                    "Rayleigh's integral".to_owned(),
                    loads.get()?,
                    diagonal(&Erp::new(&top, &self.air)),
                )
            }
            EfficiencyMethod::NotComputed { reason } => {
                let without = |body: &Arc<Body>| BodyEfficiencies {
                    body: body.name.to_owned(),
                    method: format!("not computed: {reason}"),
                    modes: Vec::new(),
                };
                return Ok(bodies.iter().map(without).collect());
            }
        };
        let mut erp = &erp[..];
        let of_body = |(body, loads): (&Arc<Body>, &FluidLoads)| {
            let (own, others) = erp
                .split_at_checked(body.omega.len())
                .ok_or(BodyError::OtherModes { body: body.name })?;
            erp = others;
            let efficiencies = efficiencies_db(&body.omega, &loads.damping, own);
            // Static corrections follow the modes.
            let modes = efficiencies.zip(&body.omega).take(body.basis.hz.len()).enumerate();
            Ok::<_, Error>(BodyEfficiencies {
                body: body.name.to_owned(),
                method: method.clone(),
                modes: modes
                    .map(|(index, (efficiency_db, omega))| ModeEfficiency {
                        mode: index + 1,
                        hz: omega / TAU,
                        efficiency_db,
                    })
                    .collect(),
            })
        };
        bodies.iter().zip(loads.iter()).map(of_body).collect()
    }
}

/// R_jj of the equivalent radiated power, which does not depend on frequency \[kg/s for unit modal mass\].
fn diagonal(erp: &dyn ModalRadiation) -> Vec<f64> {
    erp.resistance(0.0).real.diagonal().iter().copied().collect()
}

/// Efficiencies \[dB\] of modes with these angular frequencies \[rad/s\], damping ratios of radiation \[-\] and
/// resistances at efficiency 1; none without a natural frequency or without radiation.
fn efficiencies_db<'a>(
    omega: &'a [f64],
    damping: &'a [f64],
    erp: &'a [f64],
) -> impl Iterator<Item = Option<f64>> + use<'a> {
    omega.iter().zip(damping).zip(erp).map(|((omega, zeta), erp)| {
        let resistance = 2.0 * omega * zeta;
        (resistance > 0.0 && *erp > 0.0).then(|| 10.0 * (resistance / erp).log10())
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel, Parity, Patterns};
    use nailnoise_acoustics::radiation::Sampling;
    use nailnoise_acoustics::radiation::boundary_elements::MeshRange;
    use nailnoise_acoustics::radiation::fluid_loading::DryModes;
    use nailnoise_acoustics::radiation::radiator::{Loading, Radiator};
    use nailnoise_meshes::FaceKind;
    use nalgebra::{Point3, Vector3};
    use std::collections::HashMap;

    /// Radius of the sphere \[m\].
    const RADIUS: f64 = 0.1;

    /// A sphere of curved triangles, `n`² on each face of an octahedron.
    fn sphere(n: usize) -> BoundaryMesh {
        let (mut points, mut index, mut panels) = (Vec::new(), HashMap::new(), Vec::new());
        let mut at = |p: Vector3<f64>| {
            let p = Point3::from(p.normalize() * RADIUS);
            let key = [p.x, p.y, p.z].map(|c| (c * 1e8).round() as i64);
            *index.entry(key).or_insert_with(|| {
                points.push(p);
                points.len() - 1
            })
        };
        for signs in 0..8 {
            let sign = |axis: usize| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let [x, mut y, mut z] = [0, 1, 2].map(|axis| Vector3::ith(axis, sign(axis)));
            if sign(0) * sign(1) * sign(2) < 0.0 {
                std::mem::swap(&mut y, &mut z);
            }
            // Even numbers of half steps are corners, odd ones mid-sides.
            let mut node = |[u, v]: [usize; 2]| {
                let [s, t] = [u, v].map(|steps| steps as f64 / (2 * n) as f64);
                at(x * (1.0 - s - t) + y * s + z * t)
            };
            let mut push = |corners: [[usize; 2]; 3]| {
                let middle = |i: usize| [0, 1].map(|c| (corners[i][c] + corners[(i + 1) % 3][c]) / 2);
                let nodes: Vec<usize> = corners
                    .into_iter()
                    .chain([0, 1, 2].map(middle))
                    .map(&mut node)
                    .collect();
                panels.push(Panel::new(FaceKind::Tri6, &nodes, 0).unwrap());
            };
            for u in 0..n {
                for v in 0..n - u {
                    let [a, b] = [2 * u, 2 * v];
                    push([[a, b], [a + 2, b], [a, b + 2]]);
                    if u + v + 1 < n {
                        push([[a + 2, b], [a + 2, b + 2], [a, b + 2]]);
                    }
                }
            }
        }
        BoundaryMesh {
            points,
            panels,
            patches: vec!["surface".to_owned()],
        }
    }

    /// Efficiencies \[-\] of a breathing and an oscillating sphere as modes with natural frequencies at each k a, in
    /// air of another state than that of the computation.
    fn efficiencies(ka: &[f64]) -> Vec<[f64; 2]> {
        let (computed, air) = (Air::default(), Air::at(308.15, 9e4).unwrap());
        let boundary = Boundary::new(sphere(6), None).unwrap();
        let velocities = boundary.project(2 * ka.len(), |_, _, point, v| {
            let normal = point.area_vector().normalize();
            for own in v.chunks_mut(2) {
                own.copy_from_slice(&[1.0, normal.z]);
            }
        });
        let range = MeshRange {
            problem: Exterior::new(boundary, &computed),
            top_hz: 1400.0,
            patterns: vec![Patterns {
                parity: Parity::default(),
                velocities,
            }],
        };
        let sampling = Sampling {
            range_hz: [40.0, 1400.0],
            tolerance: 1e-3,
            ..Sampling::default()
        };
        let bem = ModalBem::new(vec![range], &sampling, &|| ()).unwrap();
        let bem = bem.in_air(&computed, &air);
        let omega: Vec<f64> = ka.iter().flat_map(|ka| [ka * air.sound_speed / RADIUS; 2]).collect();
        let modes = DryModes::new(omega.clone(), vec![0.0; omega.len()]).unwrap();
        let loads = bem.loads(&[modes], Loading::Damping).unwrap();
        let found: Vec<f64> = efficiencies_db(&omega, &loads[0].damping, &diagonal(&bem.reference()))
            .map(|db| 10f64.powf(0.1 * db.unwrap()))
            .collect();
        found.chunks(2).map(|own| [own[0], own[1]]).collect()
    }

    #[test]
    fn spheres_have_their_efficiencies_in_closed_form() {
        let ka = [0.2, 0.5, 1.0, 1.5, 2.0];
        for (x, [breathing, oscillating]) in ka.iter().zip(efficiencies(&ka)) {
            let squared = x * x;
            let exact = [squared / (1.0 + squared), squared * squared / (4.0 + squared * squared)];
            println!("k a {x}: {breathing} {oscillating}, exact {exact:?}");
            assert!((breathing / exact[0] - 1.0).abs() < 1e-3, "{x}: {breathing}");
            assert!((oscillating / exact[1] - 1.0).abs() < 1e-3, "{x}: {oscillating}");
        }
    }

    #[test]
    fn a_rigid_mode_and_a_silent_mode_have_no_efficiency() {
        let omega = [0.0, 1e3, 1e3, 1e3];
        let found: Vec<Option<f64>> = efficiencies_db(&omega, &[0.0, 0.0, 0.1, 0.1], &[1.0, 1.0, 0.0, 2e3]).collect();
        assert_eq!(found[..3], [None; 3]);
        assert!((found[3].unwrap() + 10.0).abs() < 1e-9);
    }
}
