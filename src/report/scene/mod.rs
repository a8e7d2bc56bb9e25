//! The surfaces in space, coloured by the sound that they would radiate: a picture, and the data with which the page
//! rotates it.

mod controls;
mod data;
mod triangles;
mod view;

use maud::{Markup, PreEscaped, html};
use nailnoise_acoustics::signals::octaves;

use super::modes;
use super::raster::{self, Triangle, scale};
use super::surface::ColouredSurface;
use data::data;
use triangles::Triangles;
use view::{SHOWN, View};

/// Size of the picture \[px\].
const SIZE: [usize; 2] = [1400, 880];

/// Colour of covered faces.
const COVERED: [f64; 3] = [200.0, 200.0, 200.0];

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
    // The data contain numbers and names without the sign that could end the enclosing element.
    let data = data(&surfaces, &views, &modes::drawn(bodies))
        .to_string()
        .replace('<', "\\u003c");
    Some(html! {
        figure.scene {
            (controls::range_and_mode(&views, bodies))
            div.stage { img src=(image) width=(SIZE[0]) height=(SIZE[1]) alt=(alternative); }
            div.scale {
                span.low { (format!("{:.0}", views[0].high - SHOWN)) }
                i style={ "background: linear-gradient(to right, " (raster::css_gradient()) ")" } {}
                span.high { (format!("{:.0}", views[0].high)) }
                " " span.unit-of-scale { "dB re 1 pW s/m\u{b2}" }
                output {}
            }
            (controls::view_controls())
            (controls::parts(&surfaces))
            figcaption {
                "Where the surfaces move so that they can sound: A-weighted equivalent radiated energy per area at \
                 radiation \
                 efficiency 1, whatever the method of the ranking; how much of it leaves as sound is there. Taken over "
                (ranges(bodies)) "; octaves are cut at these ends. Grey faces are covered and do not radiate. "
                span.with-script.in-space { "Drag to turn, with Shift or the right button to move; scroll with Ctrl to \
                    zoom to the place under the pointer; two fingers move and zoom. Click a face for its \
                    level; double-click to show only its part. Keys: arrows turn, with Shift move, plus and minus \
                    change the size, Enter reads the face in the middle, Escape returns to the first view. Modes \
                    move far more than in the shot." }
            }
            script type="application/json" { (PreEscaped(data)) }
        }
    })
}

fn image(surfaces: &[Triangles<'_>], view: &View) -> String {
    let mut triangles = Vec::new();
    for (body, surface) in surfaces.iter().enumerate() {
        let own = surface.corners.iter().zip(&surface.faces).enumerate();
        triangles.extend(own.map(|(index, (corners, &face))| Triangle {
            corners: corners.map(|point| surface.place(point)),
            colour: if index < surface.free {
                scale(view.shade(body, face))
            } else {
                COVERED
            },
        }));
    }
    raster::picture(&triangles, SIZE)
}

/// Text with the range of each body.
fn ranges(bodies: &[ColouredSurface<'_>]) -> String {
    let range = |painted: &ColouredSurface<'_>| {
        let [from, to] = painted.range_hz;
        format!("{from:.0} to {to:.0} Hz ({})", painted.body.name)
    };
    bodies.iter().map(range).collect::<Vec<_>>().join(", ")
}
