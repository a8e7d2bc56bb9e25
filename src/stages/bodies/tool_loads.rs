//! Places of forces and pressures on the tool's body.

use nailnoise_fem::LoadVector;
use nailnoise_meshes::{Mesh, MeshError, Surface};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

use crate::error::Error;
use crate::stages::bodies::BodyError;

/// Maximum relative difference between the body's mass and that of the tool in the cycle.
pub(crate) const MASS_LIMIT: f64 = 1e-3;

/// Number of rings of the bore, in which the pressure changes as the piston passes.
pub(crate) const RINGS: usize = 12;

/// Names in a shot of the surfaces of the loads along the axis, which are unit forces \[N\], in the order of the list
/// of all loads.
pub(crate) const AXIAL_SURFACES: [&str; AXIAL] = ["roof", "cap", "rim", "floor", "bore", "nose", "handle"];

/// Place of the load on the handle.
pub(crate) const HANDLE: usize = AXIAL - 1;

/// The axial load of a surface of the housing by its name in a shot.
pub(crate) fn axial_index(surface: &str) -> Option<usize> {
    AXIAL_SURFACES.iter().position(|own| *own == surface)
}

/// Number of loads along the axis.
pub(crate) const AXIAL: usize = 7;

/// Indices of the pressures on walls, which follow the axial loads.
pub(crate) const SUPPLY: usize = AXIAL + RINGS;
pub(crate) const RETURN: usize = SUPPLY + 1;
pub(crate) const PLENUM: usize = RETURN + 1;

/// Number of loads without weight.
pub(crate) const LOADS: usize = PLENUM + 1;

/// Dimensions that determine where loads act on the tool's body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToolPlaces {
    /// Inner and outer diameter of the head valve \[m\].
    pub valve: [f64; 2],
    /// Distance of the check-ring holes from the top of the bore \[m\].
    pub check_holes: f64,
}

/// Surface of an axial load, name of the load, and the part of the surface under load.
type AxialLoad<'a> = (&'static str, &'static str, &'a dyn Fn(&Point3<f64>) -> bool);

/// Load vectors of all loads on a tool body, in their order: downward displacement for the axial loads \[1\], swept
/// volume for the pressures \[m2\].
///
/// # Errors
/// [`BodyError::NoLoadSurface`] for each missing surface. [`BodyError::NoneOfSurface`] for a surface that is not where
/// the design applies the force.
pub(crate) fn load_vectors(places: &ToolPlaces, mesh: &Mesh) -> Result<Vec<LoadVector>, Error> {
    let surface = Surface::of(mesh);
    let [inner, outer] = places.valve.map(|diameter| 0.5 * diameter);
    let radius = |p: &Point3<f64>| p.x.hypot(p.y);
    let down = |(group, what, inside): AxialLoad<'_>| {
        let known = || surface.patches.join(", ");
        match LoadVector::traction(&surface, group, -Vector3::z(), inside) {
            Ok(Some(vector)) => Ok(vector),
            Ok(None) => Err(BodyError::NoneOfSurface { group, what }.into()),
            Err(MeshError::UnknownGroup { .. }) => Err(BodyError::NoLoadSurface {
                group,
                what,
                known: known(),
            }
            .into()),
            Err(error) => Err(error.into()),
        }
    };
    let all = |_: &Point3<f64>| true;
    let axial: [AxialLoad<'_>; AXIAL] = [
        ("cap", "gas and stopper within the head valve", &|p| radius(p) < inner),
        ("cap", "gas and head valve", &|p| (inner..outer).contains(&radius(p))),
        ("seat", "gas and head valve", &all),
        ("bumper_seat", "gas and bumper", &all),
        ("gas_bore", "friction of the piston", &all),
        ("nose_tip", "nose and guard", &all),
        ("handle", "the hand", &all),
    ];
    let (mut vectors, mut problems) = (Vec::with_capacity(LOADS), Vec::<Error>::new());
    for load in axial {
        match down(load) {
            Ok(vector) => vectors.push(vector),
            // Two forces act on the cap; its absence is reported once.
            Err(Error::Body(BodyError::NoLoadSurface { group, .. }))
                if problems.iter().any(|other| other.lacks(group)) => {}
            Err(error) => problems.push(error),
        }
    }
    Error::of_body("tool", problems)?;
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
pub(crate) struct Bore {
    bottom: f64,
    top: f64,
}

impl Bore {
    /// The bore of a tool's mesh.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`] for a mesh without a bore.
    pub(crate) fn of(mesh: &Mesh) -> Result<Self, MeshError> {
        let heights = mesh.group_nodes("gas_bore")?.into_iter().map(|node| mesh.nodes[node].z);
        let ends = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
        Ok(Self {
            bottom: ends.0,
            top: ends.1,
        })
    }

    /// The ends of a ring; the outermost rings extend beyond the bore, whose end nodes have rounding errors.
    fn ring(&self, ring: usize) -> [f64; 2] {
        let at = |k: usize| self.bottom + (self.top - self.bottom) * k as f64 / RINGS as f64;
        let low = if ring == 0 { f64::NEG_INFINITY } else { at(ring) };
        let high = if ring + 1 == RINGS { f64::INFINITY } else { at(ring + 1) };
        [low, high]
    }

    /// Fraction of a ring above the piston after a travel \[m\] from the top of the bore.
    pub(crate) fn above(&self, ring: usize, travel: f64) -> f64 {
        let length = (self.top - self.bottom) / RINGS as f64;
        let high = self.bottom + length * (ring + 1) as f64;
        ((high - (self.top - travel)) / length).clamp(0.0, 1.0)
    }
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
