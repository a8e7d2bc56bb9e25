//! The data with which the page draws the surfaces in space.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::surface::ColouredSurface;
use super::super::{picture, raster};
use super::triangles::{Part, Triangles, stacking_levels};
use super::view::{SHOWN, View};

/// Number of steps of the levels and of the coordinates in the data of the page.
const LEVEL_STEPS: f64 = 255.0;
const PLACE_STEPS: f64 = 30_000.0;

/// Number of steps of the largest displacement of a mode.
const MOTION_STEPS: f32 = 127.0;

/// Points in integer steps, corners of triangles, parts, levels of the free faces for each view, and displacements of
/// modes, as base64 of little-endian numbers.
pub(super) fn data(surfaces: &[Triangles<'_>], views: &[View], modes: &[(usize, usize)]) -> Value {
    let points = |surface: &Triangles<'_>| {
        let all = 0..surface.painted.body.surface.points.len();
        all.map(|point| surface.place(point).amax()).fold(0.0, f64::max)
    };
    let reach = surfaces.iter().map(points).fold(f64::MIN_POSITIVE, f64::max);
    let step = reach / PLACE_STEPS;
    let stack = stacking_levels(surfaces);
    let used: Vec<Vec<usize>> = surfaces.iter().map(Triangles::used).collect();
    let bodies: Vec<_> = surfaces
        .iter()
        .enumerate()
        .map(|(body, surface)| {
            let (painted, used) = (surface.painted, &used[body]);
            let places = used.iter().flat_map(|&point| {
                let at = surface.place(point);
                [at.x, at.y, at.z].map(|own| (own / step).round() as i16)
            });
            let corners = surface.corners.iter().flatten();
            let corners = corners.map(|point| used.partition_point(|own| own < point) as u32);
            let levels = |view: &View| {
                let free = surface.faces[..surface.free].iter();
                let levels = free.map(|&face| (LEVEL_STEPS * view.shade(body, face)).round() as u8);
                STANDARD.encode(levels.collect::<Vec<u8>>())
            };
            json!({
                "name": painted.body.name,
                "points": STANDARD.encode(places.flat_map(i16::to_le_bytes).collect::<Vec<u8>>()),
                "triangles": STANDARD.encode(corners.flat_map(u32::to_le_bytes).collect::<Vec<u8>>()),
                "parts": surface.parts.iter().zip(&stack[body]).map(part).collect::<Vec<_>>(),
                "levels": views.iter().map(levels).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "step": step, "shown": SHOWN, "bodies": bodies, "colours": raster::COLOURS,
        "axes": raster::view().transpose().as_slice(),
        "views": views.iter().map(|view| view.high).collect::<Vec<_>>(),
        "modes": modes.iter().map(|(body, mode)| motion(*body, surfaces[*body].painted, &used[*body], *mode, step))
            .collect::<Vec<_>>(),
    })
}

/// A part of a body: its free and covered triangles, and its level in the stack of bodies.
fn part((part, level): (&Part, &usize)) -> Value {
    let ends = |range: &std::ops::Range<usize>| [range.start, range.end];
    json!({ "name": part.name, "free": ends(&part.free), "covered": ends(&part.covered), "stack": level })
}

/// Displacement of a body's points in a mode: the largest in steps of the points, and each relative to it.
fn motion(body: usize, painted: &ColouredSurface<'_>, used: &[usize], mode: usize, step: f64) -> Value {
    let shape = painted.body.skin.column(mode);
    let moves: Vec<[f32; 3]> = used
        .iter()
        .map(|&point| [0, 1, 2].map(|axis| shape[3 * point + axis]))
        .collect();
    let size = |own: &[f32; 3]| own.iter().map(|value| value * value).sum::<f32>().sqrt();
    let largest = moves.iter().map(size).fold(f32::MIN_POSITIVE, f32::max);
    let share = |value: &f32| (MOTION_STEPS * value / largest).round() as i8;
    let shares = moves.iter().flatten().map(|value| share(value).cast_unsigned());
    let (low, high) = painted.body.mesh.bounds();
    json!({
        "body": body,
        "reach": picture::AMPLITUDE * (high - low).norm() / step,
        "shape": STANDARD.encode(shares.collect::<Vec<u8>>()),
    })
}
