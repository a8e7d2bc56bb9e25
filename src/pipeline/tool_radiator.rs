//! Radiation of the tool's body by boundary elements: the faces of its housing in the open air, above a rigid floor.
//!
//! What is nailed is no part of the problem: it neither reflects the tool's sound nor shades it, except in sand, where its
//! top is flush with the plane that reflects. It closes the nose everywhere. The body is taken where it stands before the
//! shot.
//!
//! A plane that is farther below than the tool is high is no part of the equations either. It changes the power of a
//! small source at the height h by sin(2 k h)/(2 k h), ripples of 170 Hz below a table that would ask for three times as
//! many frequencies and cancel in every band that is wider; what it reflects to a microphone is that of the microphone's
//! image.

use std::io::Read;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, ClosedOutline, Exterior, Level, ModalBem, Parity, Patterns, Receivers};
use nailnoise_acoustics::radiation::{Archive, Sampling};
use nalgebra::{Point3, Vector3};

use super::bodies::Body;
use super::microphones::{positions, reflecting_plane, tool_height};
use super::radiator::{FLOOR, LOWEST_SAMPLE, MOST_SAMPLES};
use crate::design::{Design, RadiationMethod};
use crate::error::Error;
use crate::stages::Progress;
use crate::store::{Key, Store};

/// Name of the stage in the cache.
const STAGE: &str = "radiation of the tool";

/// Panels of a coarser mesh over those of the finest up to which it is worth its while.
const WORTH_WHILE: f64 = 0.6;

/// Frequencies at which a piece of a range is sampled, at least.
const SAMPLES: f64 = 8.0;

/// Where the coarser mesh ceases to be enough by itself, over the top of all.
const ALONE: f64 = 0.4;

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
    cache: &Store,
    progress: &Progress,
) -> Result<Option<ModalBem>, Error> {
    if design.acoustics.body_method == RadiationMethod::Erp {
        return Ok(None);
    }
    let receivers = receivers(design);
    // Once for every air: the matrix depends on the wavelength.
    let computed = Air::default();
    let key = key(design, body, &receivers, &computed);
    let read = |from: &mut dyn Read, length| Ok::<_, Error>(ModalBem::from_reader(from, length)?);
    let bem = cache.decoded_or(STAGE, &key, read, || {
        let levels = levels(design, body, &computed)?;
        let top_hz = levels.iter().map(|level| level.top_hz).fold(0.0, f64::max);
        tell(&levels, body.omega.len(), progress);
        let sampling = Sampling {
            range_hz: [LOWEST_SAMPLE.min(0.1 * top_hz), top_hz],
            tolerance: design.acoustics.bem_tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let expected: f64 = expected(&levels).iter().sum();
        let task = ("boundary elements of the tool", "frequencies");
        let bem = progress.count_each(task, expected as u64, |one_more| {
            ModalBem::with_receivers_telling(levels, &sampling, &receivers, one_more)
        })?;
        Ok::<_, Error>(bem.to_bytes())
    })?;
    Ok(Some(bem.in_air(&computed, air)))
}

/// Tells what will be computed before any time is spent, and what was mended.
fn tell(levels: &[Level], modes: usize, progress: &Progress) {
    let Some(finest) = levels.last() else { return };
    let of_level = |(level, frequencies): (&Level, f64)| {
        let estimate = level.problem.estimate();
        // Only where many frequencies are solved something is kept for all of them.
        let kept = if levels.len() == 1 || frequencies > SAMPLES {
            estimate.seconds_kept
        } else {
            0.0
        };
        kept + frequencies * estimate.seconds_with(modes)
    };
    let seconds: f64 = levels.iter().zip(expected(levels)).map(of_level).sum();
    progress.note(&format!(
        "tool: boundary elements up to {:.0} Hz, computed once for this body, about {seconds:.0} s of processor time in all; \
         finest mesh: {}",
        finest.top_hz,
        finest.problem.estimate()
    ));
    let mended = finest.problem.boundary().mended();
    if mended.flipped > 0 {
        progress.note(&format!("tool: {mended}; look at its mesh"));
    }
}

/// Frequencies at which each mesh is asked, about: alone on three pieces of the range, beside a coarser one at half as many
/// on the last piece and in the middles of the means.
fn expected(levels: &[Level]) -> Vec<f64> {
    match levels {
        [_, _] => vec![
            4.0 * SAMPLES + ModalBem::IN_MEAN as f64,
            0.5 * SAMPLES + ModalBem::MEANS as f64,
        ],
        _ => vec![3.0 * SAMPLES + ModalBem::IN_MEAN as f64; levels.len()],
    }
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

/// The housing's own mesh, its nose closed, up to the frequency that it resolves.
pub(super) fn level(design: &Design, body: &Body, air: &Air) -> Result<Level, Error> {
    let a = &design.acoustics;
    let outline = ClosedOutline::new(&body.surface, floor(design))?;
    let motion = outline.motion(&body.surface, &body.skin);
    let boundary = Boundary::new(outline.mesh, floor(design))?;
    let patterns = Patterns {
        parity: Parity::default(),
        velocities: boundary.project_displacements(&motion)?,
    };
    let top_hz = boundary.highest_hz(air.sound_speed, a.bem_panels).min(a.bem_top);
    let problem = Exterior::new(boundary, air).with_panels_per_wavelength(a.bem_panels)?;
    Ok(Level {
        problem,
        top_hz,
        patterns: vec![patterns],
    })
}

/// The housing's mesh, below it where that saves much a coarser one of the same surface, which resolves the same waves:
/// alone in the lower part of the range, in the upper part to show how the matrix runs between the few frequencies of the
/// finer.
pub(super) fn levels(design: &Design, body: &Body, air: &Air) -> Result<Vec<Level>, Error> {
    let fine = level(design, body, air)?;
    let boundary = fine.problem.boundary();
    let edge = air.sound_speed / (design.acoustics.bem_panels * fine.top_hz);
    let worth_while = WORTH_WHILE * boundary.mesh().panels.len() as f64;
    // A surface that cannot be coarsened is solved as it is.
    let coarse = match boundary.coarsened(edge) {
        Ok(coarse) if coarse.mesh().panels.len() as f64 <= worth_while => coarse,
        _ => return Ok(vec![fine]),
    };
    let carried = |p: &Patterns| {
        let velocities = coarse.carried(boundary, &p.velocities)?;
        Ok::<_, Error>(Patterns {
            parity: p.parity,
            velocities,
        })
    };
    let patterns: Vec<Patterns> = fine.patterns.iter().map(carried).collect::<Result<_, _>>()?;
    let problem = Exterior::new(coarse, air).with_panels_per_wavelength(design.acoustics.bem_panels)?;
    let below = Level {
        problem,
        top_hz: ALONE * fine.top_hz,
        patterns,
    };
    Ok(vec![below, fine])
}

/// All that the radiation matrix depends on.
fn key(design: &Design, body: &Body, receivers: &Receivers, air: &Air) -> Key {
    let a = &design.acoustics;
    Key::new()
        .with("closed nose; coarser mesh, corrected")
        .with(&format!("{air:?} {receivers:?} {:?}", floor(design)))
        .with(&[a.bem_top, a.bem_panels, a.bem_tolerance])
        .with(&body.identity)
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
