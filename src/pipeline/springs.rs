//! The user's own springs and dashpots between the bodies and the ground.

use nailnoise_fem::LoadVector;
use nailnoise_fem::transient::{Support, SupportLaw};
use nailnoise_meshes::{Mesh, MeshError, Surface};
use nalgebra::{Point3, Vector3};

use crate::design::{Design, Spring, Sprung};
use crate::error::Error;

/// How far off its body a spring may be \[m\], as a sensor: more than the chords of a mesh are off the cylinders that they
/// stand for.
const OFF: f64 = 1e-3;

/// The springs whose body the design has, by name: each with the axes along which it acts, stiffness and damping there.
fn acting(design: &Design) -> impl Iterator<Item = (&str, &Spring, Vec<Axis>)> {
    let present = design.springs.iter().filter(|(_, spring)| design.has(spring.body));
    present.map(|(name, spring)| (name.as_str(), spring, axes(spring)))
}

/// One axis of a spring.
struct Axis {
    /// Downwards for the vertical one: the support's force then carries the body.
    along: Vector3<f64>,
    stiffness: f64,
    damping: f64,
}

fn axes(spring: &Spring) -> Vec<Axis> {
    [
        (Vector3::x(), spring.stiffness_x, spring.damping_x),
        (Vector3::y(), spring.stiffness_y, spring.damping_y),
        (-Vector3::z(), spring.stiffness_z, spring.damping_z),
    ]
    .into_iter()
    .filter(|&(_, stiffness, damping)| stiffness > 0.0 || damping > 0.0)
    .map(|(along, stiffness, damping)| Axis {
        along,
        stiffness,
        damping,
    })
    .collect()
}

/// Displacements of a body that all springs resist; nothing for those on another body.
///
/// # Errors
/// [`DesignError::Spring`](crate::design::DesignError::Spring) for a spring that is not on its body.
pub(super) fn load_vectors(design: &Design, mesh: &Mesh, body: Sprung) -> Result<Vec<LoadVector>, Error> {
    let mut vectors = Vec::new();
    let surface = Surface::of(mesh);
    for (name, spring, axes) in acting(design) {
        let at = Point3::new(spring.x, spring.y, spring.z);
        for axis in axes {
            if spring.body != body {
                vectors.push(LoadVector::zero());
                continue;
            }
            let foot = LoadVector::disc(&surface, (at, spring.radius), axis.along)?;
            let vector = foot.map_or_else(|| LoadVector::point(mesh, at, axis.along, OFF), Ok);
            vectors.push(vector.map_err(|error| match error {
                MeshError::Outside { distance, .. } => design.refuse_spring(name, spring, distance).into(),
                other => Error::from(other),
            })?);
        }
    }
    Ok(vectors)
}

/// What resists these displacements.
pub(super) fn supports(design: &Design) -> impl Iterator<Item = Support> {
    acting(design).flat_map(|(_, _, axes)| axes).map(|axis| Support {
        stiffness: axis.stiffness,
        damping: axis.damping,
        gap: 0.0,
        law: SupportLaw::Bonded,
    })
}

/// Names of the springs whose body the design lacks.
pub(super) fn idle(design: &Design) -> Vec<&str> {
    let absent = design.springs.iter().filter(|(_, spring)| !design.has(spring.body));
    absent.map(|(name, _)| name.as_str()).collect()
}
