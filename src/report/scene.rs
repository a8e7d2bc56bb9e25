//! The surfaces in space, coloured by the sound that they would radiate: a picture, and the data with which the page
//! rotates it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};
use nailnoise_acoustics::signals::octaves;
use serde_json::json;

use super::raster::{self, Triangle, scale};
use super::surface::{ColouredSurface, level};
use super::{modes, picture};

/// Range of levels shown below the highest \[dB\].
const SHOWN: f64 = 30.0;

/// Size of the picture \[px\].
const SIZE: [usize; 2] = [1400, 880];

/// Colour of covered faces.
const COVERED: [f64; 3] = [200.0, 200.0, 200.0];

/// Number of steps of the levels and of the coordinates in the data of the page.
const LEVEL_STEPS: f64 = 255.0;
const PLACE_STEPS: f64 = 30_000.0;

/// Number of steps of the largest displacement of a mode.
const MOTION_STEPS: f32 = 127.0;

/// A triangulated surface: corners of the triangles and the face of each, free faces first.
struct Triangles<'a> {
    painted: &'a ColouredSurface<'a>,
    corners: Vec<[usize; 3]>,
    faces: Vec<usize>,
    free: usize,
}

/// A choice of the frequency range that the colours show.
struct View {
    label: String,
    /// Level at the upper end of the colours \[dB re 1 pW s/m2\].
    high: f64,
    /// Energies of the faces of each body \[J/m2\].
    energies: Vec<Vec<f64>>,
}

/// A view of all bodies; `None` if there is no surface.
pub(super) fn figure(bodies: &[ColouredSurface<'_>]) -> Option<Markup> {
    let surfaces: Vec<Triangles<'_>> = bodies.iter().map(Triangles::new).collect();
    let whole = View::new(
        "all, A-weighted".to_owned(),
        &surfaces,
        bodies.iter().map(|painted| painted.whole.clone()).collect(),
    );
    if surfaces.iter().all(|surface| surface.faces.is_empty()) {
        return None;
    }
    let image = image(&surfaces, &whole);
    let in_octave = |(index, octave): (usize, &nailnoise_acoustics::signals::Band)| {
        bodies.iter().find(|painted| painted.octaves[index].is_some())?;
        // A body that is not analysed in this range does not radiate there either.
        let energies = |painted: &ColouredSurface<'_>| {
            let own = painted.octaves[index].clone();
            own.unwrap_or_else(|| vec![0.0; painted.whole.len()])
        };
        let label = format!("{} Hz octave", octave.nominal_hz());
        Some(View::new(label, &surfaces, bodies.iter().map(energies).collect()))
    };
    let octaves = octaves();
    let mut views = vec![whole];
    views.extend(octaves.iter().enumerate().filter_map(in_octave));
    let names: Vec<&str> = bodies.iter().map(|painted| painted.body.name).collect();
    let alternative = format!(
        "{} from the front, the right and above, coloured by the A-weighted energy per area that each face would \
         radiate",
        names.join(", ")
    );
    // The data contain only numbers, so nothing in them can end the enclosing element.
    let data = data(&surfaces, &views, &modes::drawn(bodies))
        .to_string()
        .replace('<', "\\u003c");
    Some(html! {
        figure.scene {
            div.choice {
                label { "Shown " select.view { @for (index, view)
                    in views.iter().enumerate() { option value=(index) { (view.label) } } } }
                " "
                label.in-space { "Mode " select.mode { option value="" { "none" } @for (index, (body, mode))
                    in modes::drawn(bodies).into_iter().enumerate() {
                        option value=(index) { (modes::title(&bodies[body], mode)) } } } }
                " " button.play type="button" hidden { "Play" }
            }
            div.stage { img src=(image) width=(SIZE[0]) height=(SIZE[1]) alt=(alternative); }
            div.scale { span.low { (format!("{:.0}", views[0].high - SHOWN)) } i {}
                span.high { (format!("{:.0}", views[0].high)) } " dB re 1 pW s/m\u{b2}" output {} }
            figcaption {
                "Where the surfaces move so that they can sound: A-weighted equivalent radiated energy per area at \
                 radiation \
                 efficiency 1, whatever the method of the ranking; how much of it leaves as sound is there. Taken over "
                (ranges(bodies)) "; octaves are cut at these ends. Grey faces are covered and do not radiate. "
                span.with-script { "Drag to turn (or the arrow keys), scroll with Ctrl or pinch to come closer. Modes \
                    move far more than in the shot." }
            }
            script type="application/json" { (PreEscaped(data)) }
        }
    })
}

impl<'a> Triangles<'a> {
    /// Splits the faces into triangles between their corners.
    fn new(painted: &'a ColouredSurface<'a>) -> Self {
        let faces = &painted.body.surface.faces;
        let mut found = Self {
            painted,
            corners: Vec::new(),
            faces: Vec::new(),
            free: 0,
        };
        for free in [true, false] {
            for (index, face) in faces
                .iter()
                .enumerate()
                .filter(|(index, _)| painted.free[*index] == free)
            {
                for last in 2..face.kind.corners() {
                    found.corners.push([0, last - 1, last].map(|corner| face.nodes[corner]));
                    found.faces.push(index);
                }
            }
            if free {
                found.free = found.faces.len();
            }
        }
        found
    }

    /// The points that the triangles use, in ascending order.
    fn used(&self) -> Vec<usize> {
        let mut used: Vec<usize> = self.corners.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        used
    }
}

impl View {
    fn new(label: String, surfaces: &[Triangles<'_>], energies: Vec<Vec<f64>>) -> Self {
        let free = surfaces
            .iter()
            .zip(&energies)
            .flat_map(|(surface, own)| surface.faces[..surface.free].iter().map(|&face| own[face]));
        let high = level(free.fold(0.0, f64::max)).unwrap_or(0.0).ceil();
        Self { label, high, energies }
    }

    /// The level of a face relative to the range of the colours, 0 to 1.
    fn shade(&self, body: usize, face: usize) -> f64 {
        let level = level(self.energies[body][face]).unwrap_or(f64::NEG_INFINITY);
        (1.0 - (self.high - level) / SHOWN).clamp(0.0, 1.0)
    }
}

fn image(surfaces: &[Triangles<'_>], view: &View) -> String {
    let mut triangles = Vec::new();
    for (body, surface) in surfaces.iter().enumerate() {
        let painted = surface.painted;
        let point = |index: usize| painted.body.surface.points[index].coords + painted.origin;
        let own = surface.corners.iter().zip(&surface.faces).enumerate();
        triangles.extend(own.map(|(index, (corners, &face))| Triangle {
            corners: corners.map(point),
            colour: if index < surface.free {
                scale(view.shade(body, face))
            } else {
                COVERED
            },
        }));
    }
    raster::picture(&triangles, SIZE)
}

/// Points in integer steps, corners of triangles, levels of the free faces for each view, and displacements of modes,
/// as base64 of little-endian numbers.
fn data(surfaces: &[Triangles<'_>], views: &[View], modes: &[(usize, usize)]) -> serde_json::Value {
    let reach = surfaces
        .iter()
        .flat_map(|surface| {
            let painted = surface.painted;
            painted
                .body
                .surface
                .points
                .iter()
                .map(|point| (point.coords + painted.origin).amax())
        })
        .fold(f64::MIN_POSITIVE, f64::max);
    let step = reach / PLACE_STEPS;
    let bodies: Vec<_> = surfaces
        .iter()
        .enumerate()
        .map(|(body, surface)| {
            let (painted, used) = (surface.painted, surface.used());
            let places = used.iter().flat_map(|&point| {
                let at = painted.body.surface.points[point].coords + painted.origin;
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
                "levels": views.iter().map(levels).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "step": step, "shown": SHOWN, "bodies": bodies, "colours": raster::COLOURS,
            "axes": raster::view().transpose().as_slice(),
        "views": views.iter().map(|view| view.high).collect::<Vec<_>>(),
        "modes": modes.iter().map(|(body, mode)| motion(*body, &surfaces[*body], *mode, step)).collect::<Vec<_>>(),
    })
}

/// Displacement of a body's points in a mode: the largest in steps of the points, and each relative to it.
fn motion(body: usize, surface: &Triangles<'_>, mode: usize, step: f64) -> serde_json::Value {
    let painted = surface.painted;
    let shape = painted.body.skin.column(mode);
    let used = surface.used();
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

/// Text with the range of each body.
fn ranges(bodies: &[ColouredSurface<'_>]) -> String {
    let range = |painted: &ColouredSurface<'_>| {
        let [from, to] = painted.range_hz;
        format!("{from:.0} to {to:.0} Hz ({})", painted.body.name)
    };
    bodies.iter().map(range).collect::<Vec<_>>().join(", ")
}
