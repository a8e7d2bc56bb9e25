//! What acts on the tool's body: where, and how strongly at every sample of the cycle.
//!
//! Gas pressures p are taken over the ambient one. The cycle's rod, piston and head valve leave no area over at uniform
//! pressure, A_1 = A_2 + A_r and A_h1 = A_h2 + A_h3, so that nothing is lost by it. Along the axis, down,
//!
//! ```text
//! roof within the valve   - p_1 A_i + F_st                                    A_i = pi/4 D_i^2
//! roof above the valve    - p_h A_h1 + F_hc - F_s + F_fh + thrust
//! cylinder's rim          p_1 (A_i + A_h3 - A_1) + p_ext A_h2 + F_seat
//! floor of the cylinder   p_2 A_2 + F_b
//! cylinder's bore         F_fp, evenly
//! nose                    - F_n - F_e + F_mag
//! handle                  F_hm, evenly
//! ```
//!
//! and weight: their sum is the force on the tool in the cycle's equation of motion. Beside them gas presses on walls
//! without moving the whole: p_1 and p_2 on the bore on both sides of the piston, p_ext within the handle and around the
//! cylinder above the check-ring holes, p_r around it below them, and the plenum's pressure in the cap.

use nailnoise_dynamics::{CycleRecord, Form, Geometry, Parameters, Volume};
use nailnoise_fem::LoadVector;
use nailnoise_meshes::{Mesh, MeshError, Surface};
use nalgebra::{DMatrix, Point3, Vector3};
use serde::Serialize;

use crate::error::Error;

/// Rings of the bore on which the pressure changes as the piston passes.
const RINGS: usize = 12;

/// Loads along the axis, unit forces \[N\]; their places in the list of all loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axial {
    Roof,
    Cap,
    Rim,
    Floor,
    Bore,
    Nose,
    Handle,
}

/// Number of loads along the axis.
pub(crate) const AXIAL: usize = 7;

/// Pressures on walls, in the order of their loads behind the axial ones.
const SUPPLY: usize = AXIAL + RINGS;
const RETURN: usize = SUPPLY + 1;
const PLENUM: usize = RETURN + 1;

/// Loads without weight.
pub(crate) const LOADS: usize = PLENUM + 1;

/// Dimensions on which the places of loads on the tool's body depend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToolPlaces {
    /// Inner and outer diameter of the head valve \[m\].
    pub valve: [f64; 2],
    /// Distance of the check-ring holes from the bore's top \[m\].
    pub check_holes: f64,
}

/// Load vectors of all loads on a tool body, in their order: downwards displacement for the axial ones \[1\], swept volume for
/// the pressures \[m2\].
///
/// # Errors
/// [`Error::NoLoadSurface`] where a surface is not there, or not where the design has the force.
pub(crate) fn load_vectors(places: &ToolPlaces, mesh: &Mesh) -> Result<Vec<LoadVector>, Error> {
    let surface = Surface::of(mesh);
    let [inner, outer] = places.valve.map(|diameter| 0.5 * diameter);
    let radius = |p: &Point3<f64>| p.x.hypot(p.y);
    let down =
        |group: &'static str, what: &'static str, inside: &dyn Fn(&Point3<f64>) -> bool| match LoadVector::traction(
            &surface,
            group,
            -Vector3::z(),
            inside,
        ) {
            Ok(Some(vector)) => Ok(vector),
            Ok(None) => Err(Error::NoLoadSurface {
                group,
                what,
                known: surface.patches.join(", "),
            }),
            Err(MeshError::UnknownGroup { known, .. }) => Err(Error::NoLoadSurface { group, what, known }),
            Err(error) => Err(error.into()),
        };
    let all = |_: &Point3<f64>| true;
    let mut vectors = vec![
        down("cap", "gas and stopper within the head valve", &|p| radius(p) < inner)?,
        down("cap", "gas and head valve", &|p| (inner..outer).contains(&radius(p)))?,
        down("seat", "gas and head valve", &all)?,
        down("bumper_seat", "gas and bumper", &all)?,
        down("gas_bore", "friction of the piston", &all)?,
        down("nose_tip", "nose and guard", &all)?,
        down("handle", "the hand", &all)?,
    ];
    let bore = Bore::of(mesh)?;
    let ring = |ring: usize| {
        let [low, high] = bore.ring(ring);
        move |p: &Point3<f64>| (low..high).contains(&p.z)
    };
    let rings: Vec<_> = (0..RINGS).map(ring).collect();
    vectors.extend(LoadVector::pressures(&surface, &["gas_bore"], &rings)?);
    let here = |names: &[&'static str]| -> Vec<&'static str> {
        let known = |name: &&str| surface.patches.iter().any(|patch| patch == name);
        names.iter().copied().filter(|name| known(name)).collect()
    };
    let (jacket, handle, plenum) = (
        here(&["sleeve_outside", "fit_master", "barrel_inside"]),
        here(&["supply"]),
        here(&["plenum"]),
    );
    let holes = bore.top - places.check_holes;
    let supply = LoadVector::pressure(&surface, &jacket, |p| p.z >= holes)?;
    vectors.push(supply.plus(&LoadVector::pressure(&surface, &handle, all)?));
    vectors.push(LoadVector::pressure(&surface, &jacket, |p| p.z < holes)?);
    vectors.push(LoadVector::pressure(&surface, &plenum, all)?);
    Ok(vectors)
}

/// Extent of the cylinder's bore along the axis \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bore {
    bottom: f64,
    top: f64,
}

impl Bore {
    fn of(mesh: &Mesh) -> Result<Self, MeshError> {
        let heights = mesh.group_nodes("gas_bore")?.into_iter().map(|node| mesh.nodes[node].z);
        let ends = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
        Ok(Self {
            bottom: ends.0,
            top: ends.1,
        })
    }

    /// The ends of a ring; the outermost reach beyond the bore, whose nodes lie on its ends up to rounding.
    fn ring(&self, ring: usize) -> [f64; 2] {
        let at = |k: usize| self.bottom + (self.top - self.bottom) * k as f64 / RINGS as f64;
        let low = if ring == 0 { f64::NEG_INFINITY } else { at(ring) };
        let high = if ring + 1 == RINGS { f64::INFINITY } else { at(ring + 1) };
        [low, high]
    }

    /// Share of a ring above the piston after a travel \[m\] from the bore's top.
    fn above(&self, ring: usize, travel: f64) -> f64 {
        let length = (self.top - self.bottom) / RINGS as f64;
        let high = self.bottom + length * (ring + 1) as f64;
        ((high - (self.top - travel)) / length).clamp(0.0, 1.0)
    }
}

/// Forces \[N\] and pressures \[Pa\] of all loads: loads x samples.
///
/// # Errors
/// [`MeshError::UnknownGroup`] for a mesh without a bore.
pub(crate) fn histories(parameters: &Parameters, mesh: &Mesh, record: &CycleRecord) -> Result<DMatrix<f64>, MeshError> {
    let (p, g) = (parameters, Geometry::new(parameters));
    let bore = Bore::of(mesh)?;
    let within = 0.25 * std::f64::consts::PI * p.head_valve.inner_diameter.powi(2);
    // As published, nothing acts on the valve's underside: the ambient pressure on it is not balanced.
    let underside = match p.model.valve_underside {
        Form::Corrected => g.valve_cylinder_area,
        Form::Published => 0.0,
    };
    let ambient = p.ambient.pressure;
    let unbalanced = ambient * (g.valve_control_area - g.valve_supply_area - underside);
    let f = &record.forces;
    let mut histories = DMatrix::zeros(LOADS, record.len());
    for (n, mut column) in histories.column_iter_mut().enumerate() {
        let over = |volume: &Volume| volume.pressure[n] - ambient;
        let (above, below) = (over(&record.above_piston), over(&record.below_piston));
        let (control, supply) = (over(&record.above_valve), over(&record.supply));
        let mut axial = |place: Axial, force: f64| column[place as usize] = force;
        axial(Axial::Roof, f.stopper[n] - above * within);
        axial(
            Axial::Cap,
            f.cap[n] - f.spring[n] + f.valve_friction[n] + f.thrust[n] - control * g.valve_control_area - unbalanced,
        );
        axial(
            Axial::Rim,
            f.seat[n] + above * (within + underside - g.piston_area) + supply * g.valve_supply_area,
        );
        axial(Axial::Floor, f.bumper[n] + below * g.ring_area);
        axial(Axial::Bore, f.piston_friction[n]);
        axial(Axial::Nose, f.magazine[n] - f.nose[n] - f.guard[n]);
        axial(Axial::Handle, f.hand[n]);
        for ring in 0..RINGS {
            let share = bore.above(ring, record.motion.piston_travel[n]);
            column[AXIAL + ring] = share * above + (1.0 - share) * below;
        }
        column[SUPPLY] = supply;
        column[RETURN] = over(&record.return_volume);
        column[PLENUM] = record.exhaust.plenum_pressure[n] - ambient;
    }
    Ok(histories)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_share_the_bore_and_the_piston_passes_them_one_after_the_other() {
        let bore = Bore { bottom: 1.0, top: 2.2 };
        let total = |travel: f64| (0..RINGS).map(|k| bore.above(k, travel)).sum::<f64>();
        for travel in [-0.1, 0.0, 0.03, 0.55, 1.2, 1.3] {
            let expected = (travel / 1.2 * RINGS as f64).clamp(0.0, RINGS as f64);
            assert!((total(travel) - expected).abs() < 1e-12);
        }
        assert_eq!(bore.ring(0)[1], bore.ring(1)[0]);
        assert!((bore.ring(3)[1] - 1.4).abs() < 1e-12);
    }
}
