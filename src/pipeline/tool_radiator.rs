//! Radiation of the tool's body by boundary elements: the faces of its housing in the open air, above a rigid floor.
//!
//! What is nailed is no part of the problem: it neither reflects the tool's sound nor shades it, except in sand, where its
//! top is flush with the plane that reflects and closes the nose. The body is taken where it stands before the shot.
//!
//! A plane that is farther below than the tool is high is no part of the equations either. It changes the power of a
//! small source at the height h by sin(2 k h)/(2 k h), ripples of 170 Hz below a table that would ask for three times as
//! many frequencies and cancel in every band that is wider; what it reflects to a microphone is that of the microphone's
//! image.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Level, ModalBem, Parity, Patterns, Receivers};
use nailnoise_acoustics::radiation::{Archive, Sampling};
use nalgebra::{Point3, Vector3};

use super::Watched;
use super::bodies::Body;
use super::microphones::{positions, reflecting_plane, tool_height};
use super::outside::open_air_above;
use super::radiator::{FLOOR, LOWEST_SAMPLE, MOST_SAMPLES, with_skin};
use crate::cache::{Cache, Key};
use crate::design::{Design, RadiationMethod};
use crate::error::Error;

/// Name of the stage in the cache.
const STAGE: &str = "radiation of the tool";

/// Where the tool's nose stands, in the coordinates of the workpiece.
pub(super) fn nose(design: &Design) -> Vector3<f64> {
    let nail = &design.nail;
    Vector3::new(nail.offset_along, nail.offset_across, design.workpiece.thickness)
}

/// Boundary elements on the tool's housing, from the cache where they are known; none where the design asks for none.
///
/// # Errors
/// Those of mesh and radiation.
pub(super) fn tool_radiator(
    design: &Design,
    body: &Body,
    air: &Air,
    cache: &Cache,
    watched: &Watched<'_>,
) -> Result<Option<ModalBem>, Error> {
    if design.acoustics.body_method == RadiationMethod::Erp {
        return Ok(None);
    }
    let open = open_air_above(&body.surface, floor(design))?;
    let receivers = receivers(design);
    // Once for every air: the matrix depends on the wavelength.
    let computed = Air::default();
    let key = key(design, body, &open, &receivers, &computed);
    let read = |bytes: &[u8]| Ok::<_, Error>(ModalBem::from_bytes(bytes)?);
    let bem = cache.decoded_or(STAGE, &key, read, || {
        let level = level(design, body, &computed)?;
        watched.note(&format!(
            "tool: boundary elements up to {:.0} Hz, computed once for this body; {}",
            level.top_hz,
            level.problem.estimate()
        ));
        let mended = level.problem.boundary().mended();
        if mended.flipped > 0 {
            watched.note(&format!("tool: {mended}; look at its mesh"));
        }
        let sampling = Sampling {
            range_hz: [LOWEST_SAMPLE.min(0.1 * level.top_hz), level.top_hz],
            tolerance: design.acoustics.bem_tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let task = ("boundary elements of the tool", "frequencies");
        let bem = watched.counting_each(task, 0, |one_more| {
            ModalBem::with_receivers_telling(vec![level], &sampling, &receivers, one_more)
        })?;
        Ok::<_, Error>(bem.to_bytes())
    })?;
    Ok(Some(bem.in_air(&computed, air)))
}

/// The microphones in the tool's coordinates; where the plane that reflects is no part of the equations, their images in it
/// behind them.
fn receivers(design: &Design) -> Receivers {
    let nose = nose(design);
    let mut points: Vec<Point3<f64>> = positions(design).into_iter().map(|point| point - nose).collect();
    if floor(design).is_none() {
        let image = |p: &Point3<f64>| Point3::new(p.x, p.y, 2.0 * plane(design) - p.z);
        points.extend(points.iter().map(image).collect::<Vec<_>>());
    }
    Receivers {
        points,
        origin: Point3::new(0.0, 0.0, 0.5 * tool_height(design)),
    }
}

/// Height of the reflecting plane in the tool's coordinates: not above the tip of its nose.
fn plane(design: &Design) -> f64 {
    reflecting_plane(design) - design.workpiece.thickness
}

/// The same where it is part of the equations.
fn floor(design: &Design) -> Option<f64> {
    let plane = plane(design);
    (-plane < tool_height(design)).then_some(plane)
}

/// The housing's own mesh, up to the frequency that it resolves.
pub(super) fn level(design: &Design, body: &Body, air: &Air) -> Result<Level, Error> {
    let a = &design.acoustics;
    let open = open_air_above(&body.surface, floor(design))?;
    let mut mesh = BoundaryMesh::of_skin(&body.surface);
    let mut face = 0;
    mesh.panels.retain(|_| {
        face += 1;
        open[face - 1]
    });
    let boundary = Boundary::new(mesh, floor(design))?;
    let patterns = Patterns {
        parity: Parity::default(),
        velocities: boundary.project_modes(&body.surface, &body.shapes)?,
    };
    let top_hz = boundary.highest_hz(air.sound_speed, a.bem_panels).min(a.bem_top);
    let problem = Exterior::new(boundary, air).with_panels_per_wavelength(a.bem_panels)?;
    Ok(Level {
        problem,
        top_hz,
        patterns: vec![patterns],
    })
}

/// All that the radiation matrix depends on.
fn key(design: &Design, body: &Body, open: &[bool], receivers: &Receivers, air: &Air) -> Key {
    let a = &design.acoustics;
    let key = Key::new()
        .with(&format!("{air:?} {receivers:?} {:?}", floor(design)))
        .with(&[a.bem_top, a.bem_panels, a.bem_tolerance])
        .with(&open.iter().map(|o| usize::from(*o)).collect::<Vec<usize>>());
    with_skin(key, body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_plane_is_in_the_equations_a_far_one_at_the_microphones() {
        let design = |name: &str| Design::load(format!("{}/designs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let sand = design("n80cb-sandbox.toml");
        assert_eq!(floor(&sand), Some(0.0));
        assert_eq!(receivers(&sand).points.len(), 9);
        let table = design("n80cb.toml");
        assert_eq!(floor(&table), None);
        let points = receivers(&table).points;
        assert_eq!(points.len(), 18);
        for (point, image) in points[..9].iter().zip(&points[9..]) {
            assert!(point.z > plane(&table) && image.z < plane(&table));
            assert!((point.z + image.z - 2.0 * plane(&table)).abs() < 1e-12);
        }
    }
}
