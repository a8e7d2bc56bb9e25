//! A mode as a picture: the surface in its deflection, painted from the back to the front.

use std::fmt::Write as _;

use nalgebra::Vector3;

use crate::stages::bodies::Body;

/// Size of a picture \[px\].
const WIDTH: f64 = 260.0;
const HEIGHT: f64 = 180.0;

/// Largest displacement as a share of the body's diagonal: seen, and not yet folded.
const AMPLITUDE: f64 = 0.06;

/// From rest to the largest displacement: Cividis (Nuñez, Anderton and Renslow 2018) at five places.
const COLOURS: [[f64; 3]; 5] = [
    [0.0, 34.0, 78.0],
    [65.0, 77.0, 107.0],
    [124.0, 123.0, 120.0],
    [188.0, 175.0, 111.0],
    [254.0, 232.0, 56.0],
];

/// The picture as SVG; the colour is the size of the displacement at a face's centre over the largest.
pub(super) fn mode(body: &Body, mode: usize) -> String {
    let surface = &body.surface;
    let shape = body.skin.column(mode);
    let moves: Vec<Vector3<f64>> = (0..surface.points.len())
        .map(|point| shape.fixed_rows::<3>(3 * point).map(f64::from))
        .collect();
    let largest = moves.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = body.mesh.bounds();
    let scale = AMPLITUDE * (high - low).norm() / largest;
    // Seen from the front, the right and above, as the turning view begins.
    let towards = Vector3::new(0.5, -0.75, 0.42).normalize();
    let right = Vector3::z().cross(&towards).normalize();
    let up = towards.cross(&right);
    let moved: Vec<Vector3<f64>> = surface
        .points
        .iter()
        .zip(&moves)
        .map(|(p, u)| p.coords + scale * u)
        .collect();
    let flat: Vec<[f64; 2]> = moved.iter().map(|p| [right.dot(p), -up.dot(p)]).collect();
    let bounds = |axis: usize| {
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        flat.iter()
            .fold(ends, |[low, high], p| [low.min(p[axis]), high.max(p[axis])])
    };
    let [x, y] = [bounds(0), bounds(1)];
    let size = (0.94 * WIDTH / (x[1] - x[0])).min(0.94 * HEIGHT / (y[1] - y[0]));
    let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
    let place = |p: usize| {
        let at = |axis: usize, full: f64| (flat[p][axis] - middle[axis]) * size + 0.5 * full;
        [at(0, WIDTH), at(1, HEIGHT)]
    };
    let mut faces: Vec<(f64, String)> = Vec::new();
    for face in &surface.faces {
        let corners: Vec<usize> = (0..face.kind.corners()).map(|corner| face.nodes[corner]).collect();
        let normal = (moved[corners[1]] - moved[corners[0]]).cross(&(moved[corners[2]] - moved[corners[0]]));
        if normal.dot(&towards) <= 0.0 {
            continue;
        }
        let count = corners.len() as f64;
        let depth = corners.iter().map(|&p| towards.dot(&moved[p])).sum::<f64>() / count;
        let size = corners.iter().map(|&p| moves[p]).sum::<Vector3<f64>>().norm() / (count * largest);
        let fill = colour(size);
        let mut path = String::new();
        for (index, [x, y]) in corners.iter().map(|&p| place(p)).enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
        // A hair of the same colour closes the seams between faces.
        faces.push((
            depth,
            format!("<path d=\"{path}z\" fill=\"{fill}\" stroke=\"{fill}\"/>"),
        ));
    }
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let faces: String = faces.into_iter().map(|(_, path)| path).collect();
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" xmlns=\"http://www.w3.org/2000/svg\" stroke-width=\"0.4\" role=\"img\">{faces}</svg>"
    )
}

fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let first = (at as usize).min(COLOURS.len() - 2);
    let mixed = [0, 1, 2].map(|c| {
        let (a, b) = (COLOURS[first][c], COLOURS[first + 1][c]);
        (a + (b - a) * (at - first as f64)).round() as u8
    });
    format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
}
