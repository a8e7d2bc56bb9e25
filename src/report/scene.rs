//! The surfaces in space, coloured by what they would radiate.

use nailnoise_acoustics::levels::octaves;
use serde_json::{Value, json};

use super::chart::Plot;
use super::surface::{Painted, level};

/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 30.0;

/// A triangulated part of a surface: the triangles' corners, and the face of each.
struct Triangles {
    corners: [Vec<usize>; 3],
    faces: Vec<usize>,
}

/// A view of all bodies that turns with the mouse; none where there is no surface.
pub(super) fn chart(bodies: &[Painted<'_>]) -> Option<Plot> {
    let mut data = Vec::new();
    let mut coloured: Vec<(&Painted<'_>, Triangles)> = Vec::new();
    for painted in bodies {
        let free = triangles(painted, true);
        let mut trace = mesh(painted, &free);
        trace["name"] = json!(painted.body.name);
        trace["coloraxis"] = json!("coloraxis");
        trace["intensitymode"] = json!("cell");
        trace["intensity"] = values(&painted.whole, &free);
        trace["hovertemplate"] = json!(format!("{}: %{{intensity:.0f}} dB<extra></extra>", painted.body.name));
        data.push(trace);
        coloured.push((painted, free));
    }
    let count = data.len();
    for painted in bodies {
        let covered = triangles(painted, false);
        if !covered.faces.is_empty() {
            let mut trace = mesh(painted, &covered);
            trace["name"] = json!(format!("{}, covered", painted.body.name));
            trace["color"] = json!("#c8c8c8");
            trace["hovertemplate"] = json!(format!(
                "{}, covered: does not radiate<extra></extra>",
                painted.body.name
            ));
            data.push(trace);
        }
    }
    if data.is_empty() {
        return None;
    }
    let top = |energies: &dyn Fn(&Painted<'_>) -> Vec<f64>| {
        let highest = coloured.iter().flat_map(|(painted, own)| {
            let energies = energies(painted);
            own.faces.iter().map(|&face| energies[face]).collect::<Vec<_>>()
        });
        level(highest.fold(0.0, f64::max)).unwrap_or(0.0).ceil()
    };
    let button = |label: String, energies: &dyn Fn(&Painted<'_>) -> Vec<f64>| {
        let high = top(energies);
        let each: Vec<Value> = coloured
            .iter()
            .map(|(painted, own)| values(&energies(painted), own))
            .collect();
        json!({
            "label": label, "method": "update",
            "args": [
                { "intensity": each },
                { "coloraxis.cmin": high - SHOWN, "coloraxis.cmax": high },
                (0..count).collect::<Vec<_>>(),
            ],
        })
    };
    let mut buttons = vec![button("all, A-weighted".to_owned(), &|painted| painted.whole.clone())];
    for (index, octave) in octaves().iter().enumerate() {
        if coloured.iter().any(|(painted, _)| painted.octaves[index].is_some()) {
            // A body that is not analysed there does not radiate there either.
            let energies = |painted: &Painted<'_>| {
                let own = painted.octaves[index].clone();
                own.unwrap_or_else(|| vec![0.0; painted.whole.len()])
            };
            buttons.push(button(format!("{} Hz octave", octave.nominal_hz()), &energies));
        }
    }
    let high = top(&|painted| painted.whole.clone());
    let hidden = json!({ "visible": false });
    Some(Plot {
        id: "surfaces".to_owned(),
        description: format!(
            "Where the surfaces move so that they can sound: A-weighted equivalent radiated energy per area, dB re 1 pW s/m\u{b2}, \
             at radiation efficiency 1 whatever the method of the ranking; how much of it leaves as sound is there. Taken \
             over {}; octaves are cut at these ends. Drag to turn, scroll to come closer, choose an octave on the left. \
             Grey faces are covered and do not radiate.",
            ranges(bodies)
        ),
        data,
        layout: json!({
            "scene": {
                "aspectmode": "data", "xaxis": hidden, "yaxis": hidden, "zaxis": hidden,
                "camera": { "eye": { "x": 1.3, "y": -1.7, "z": 1.0 }, "center": { "x": 0, "y": 0, "z": -0.1 } }, "dragmode": "turntable",
            },
            "coloraxis": {
                "colorscale": "Cividis", "cmin": high - SHOWN, "cmax": high,
                "colorbar": { "title": { "text": "dB re 1 pW s/m\u{b2}", "side": "right" }, "thickness": 14, "len": 0.8 },
            },
            "margin": { "l": 0, "r": 0, "t": 36, "b": 0 },
            "updatemenus": [{ "type": "dropdown", "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "bottom", "buttons": buttons }],
        }),
        height: 560,
        group: "",
    })
}

/// The range of each body in words.
fn ranges(bodies: &[Painted<'_>]) -> String {
    let range = |painted: &Painted<'_>| {
        let [from, to] = painted.range_hz;
        format!("{from:.0} to {to:.0} Hz ({})", painted.body.name)
    };
    bodies.iter().map(range).collect::<Vec<_>>().join(", ")
}

/// The faces that are free, or those that are not, as triangles between their corners.
fn triangles(painted: &Painted<'_>, free: bool) -> Triangles {
    let mut found = Triangles {
        corners: Default::default(),
        faces: Vec::new(),
    };
    for (index, face) in painted.body.surface.faces.iter().enumerate() {
        if painted.free[index] != free {
            continue;
        }
        for last in 2..face.kind.corners() {
            for (list, corner) in found.corners.iter_mut().zip([0, last - 1, last]) {
                list.push(face.nodes[corner]);
            }
            found.faces.push(index);
        }
    }
    found
}

/// The triangles with the points that they use, in millimetres.
fn mesh(painted: &Painted<'_>, triangles: &Triangles) -> Value {
    let points = &painted.body.surface.points;
    let mut used: Vec<usize> = triangles.corners.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let place = |point: &usize| used.partition_point(|own| own < point);
    let axis = |axis: usize| -> Vec<f64> {
        let at = |&p: &usize| (1e4 * (points[p][axis] + painted.origin[axis])).round() / 10.0;
        used.iter().map(at).collect()
    };
    let corners = triangles
        .corners
        .each_ref()
        .map(|list| list.iter().map(place).collect::<Vec<_>>());
    json!({
        "type": "mesh3d", "x": axis(0), "y": axis(1), "z": axis(2),
        "i": corners[0], "j": corners[1], "k": corners[2], "flatshading": true,
        "lighting": { "ambient": 0.75, "diffuse": 0.4, "specular": 0.05 },
    })
}

/// Levels of the triangles, to a tenth of a decibel.
fn values(energies: &[f64], triangles: &Triangles) -> Value {
    let level = |&face: &usize| {
        let level = level(energies[face]).unwrap_or(-100.0);
        (10.0 * level).round() / 10.0
    };
    json!(triangles.faces.iter().map(level).collect::<Vec<f64>>())
}
