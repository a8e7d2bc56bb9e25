//! Pictures of triangles: an orthographic view, with hidden faces removed by a depth buffer, written as PNG.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{Matrix3, Vector3};

/// Each pixel is the mean of this number of samples in each direction.
const SAMPLES: usize = 2;

/// Margin around the content, as a fraction of the picture.
const MARGIN: f64 = 0.03;

/// Brightness of a face whose normal is perpendicular to the line of sight; a face that faces the viewer has 1.
const AMBIENT: f64 = 0.62;

/// The colour scale viridis (Smith and van der Walt 2015) at equal steps. Its lightness increases evenly, also for the
/// colour-blind, and no colour of it is grey, the colour of covered faces.
pub(super) const COLOURS: [[f64; 3]; 11] = [
    [68.0, 1.0, 84.0],
    [72.0, 36.0, 117.0],
    [65.0, 68.0, 135.0],
    [53.0, 95.0, 141.0],
    [42.0, 120.0, 142.0],
    [33.0, 145.0, 140.0],
    [34.0, 168.0, 132.0],
    [68.0, 191.0, 112.0],
    [122.0, 209.0, 81.0],
    [189.0, 223.0, 38.0],
    [253.0, 231.0, 37.0],
];

/// The colour scale as the stops of a gradient in CSS.
pub(super) fn css_gradient() -> String {
    let colour = |[r, g, b]: [f64; 3]| format!("rgb({r} {g} {b})");
    COLOURS.map(colour).join(", ")
}

/// A triangle in space with its colour.
pub(super) struct Triangle {
    pub(super) corners: [Vector3<f64>; 3],
    pub(super) colour: [f64; 3],
}

/// The colour of a value between 0 and 1.
pub(super) fn scale(value: f64) -> [f64; 3] {
    let at = value.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let first = (at as usize).min(COLOURS.len() - 2);
    [0, 1, 2].map(|c| {
        let (a, b) = (COLOURS[first][c], COLOURS[first + 1][c]);
        a + (b - a) * (at - first as f64)
    })
}

/// The axes of a view from the front, right and above, as rows: to the right, up, towards the viewer.
pub(super) fn view() -> Matrix3<f64> {
    let towards = Vector3::new(1.3, -1.7, 1.0).normalize();
    let right = Vector3::z().cross(&towards).normalize();
    Matrix3::from_rows(&[
        right.transpose(),
        towards.cross(&right).transpose(),
        towards.transpose(),
    ])
}

/// A picture of this size that shows all triangles, as a data URL.
pub(super) fn picture(triangles: &[Triangle], [width, height]: [usize; 2]) -> String {
    let pixels = draw(triangles, [SAMPLES * width, SAMPLES * height]);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let image = reduced(&pixels, [width, height]);
    // Writing to memory cannot fail.
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&image));
    debug_assert!(written.is_ok());
    format!("data:image/png;base64,{}", STANDARD.encode(&bytes))
}

/// The colour of each sample; `None` if it is empty.
fn draw(triangles: &[Triangle], [width, height]: [usize; 2]) -> Vec<Option<[f64; 3]>> {
    let view = view();
    let seen: Vec<[Vector3<f64>; 3]> = triangles
        .iter()
        .map(|triangle| triangle.corners.map(|corner| view * corner))
        .collect();
    let ends = |axis: usize| {
        seen.iter()
            .flatten()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
                [low.min(p[axis]), high.max(p[axis])]
            })
    };
    let [x, y] = [ends(0), ends(1)];
    let within = 1.0 - 2.0 * MARGIN;
    let size = (within * width as f64 / (x[1] - x[0])).min(within * height as f64 / (y[1] - y[0]));
    let place = |p: &Vector3<f64>| {
        [
            (p.x - 0.5 * (x[0] + x[1])) * size + 0.5 * width as f64,
            0.5 * height as f64 - (p.y - 0.5 * (y[0] + y[1])) * size,
            p.z,
        ]
    };
    let mut colours = vec![None; width * height];
    let mut depths = vec![f64::NEG_INFINITY; width * height];
    for (triangle, corners) in triangles.iter().zip(&seen) {
        let [a, b, c] = corners.each_ref().map(place);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice == 0.0 || !twice.is_finite() {
            continue;
        }
        let bright = AMBIENT + (1.0 - AMBIENT) * (normal.z / normal.norm()).abs();
        let colour = triangle.colour.map(|part| bright * part);
        let range = |axis: usize, most: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0) as usize;
            let high = a[axis].max(b[axis]).max(c[axis]).ceil().max(0.0) as usize;
            low..(high + 1).min(most)
        };
        for row in range(1, height) {
            for column in range(0, width) {
                let [px, py] = [column as f64 + 0.5, row as f64 + 0.5];
                let edge =
                    |p: [f64; 3], q: [f64; 3]| ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) / twice;
                let [of_c, of_a, of_b] = [edge(a, b), edge(b, c), edge(c, a)];
                let depth = of_a * a[2] + of_b * b[2] + of_c * c[2];
                let at = row * width + column;
                if of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 && depth > depths[at] {
                    depths[at] = depth;
                    colours[at] = Some(colour);
                }
            }
        }
    }
    colours
}

/// Means over the samples of each pixel: red, green, blue and opacity.
fn reduced(samples: &[Option<[f64; 3]>], [width, height]: [usize; 2]) -> Vec<u8> {
    let count = SAMPLES * SAMPLES;
    let mut image = Vec::with_capacity(4 * width * height);
    for row in 0..height {
        for column in 0..width {
            let own = (0..count).filter_map(|sample| {
                let [x, y] = [SAMPLES * column + sample % SAMPLES, SAMPLES * row + sample / SAMPLES];
                samples[y * SAMPLES * width + x]
            });
            let (sum, seen) = own.fold(([0.0; 3], 0), |(sum, seen), colour| {
                ([0, 1, 2].map(|c| sum[c] + colour[c]), seen + 1)
            });
            image.extend(sum.map(|part: f64| (part / seen.max(1) as f64).round() as u8));
            image.push((255 * seen / count) as u8);
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle perpendicular to the line of sight, at this distance towards the viewer.
    fn across(towards: f64, colour: [f64; 3]) -> Triangle {
        let view = view().transpose();
        let corner = |x: f64, y: f64| view * Vector3::new(x, y, towards);
        Triangle {
            corners: [corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
            colour,
        }
    }

    /// A mean of colours that is grey would look like a covered face, bright or shaded.
    #[test]
    fn no_colour_of_the_scale_is_grey() {
        for step in 0..=100 {
            let [most, least] = [f64::max, f64::min].map(|of| scale(f64::from(step) / 100.0).into_iter().reduce(of));
            let (most, least) = (most.unwrap(), least.unwrap());
            assert!((most - least) / most > 0.5, "{step} %: {least} to {most}");
        }
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        let [near, far] = [[200.0, 0.0, 0.0], [0.0, 200.0, 0.0]];
        for triangles in [
            [across(1.0, near), across(0.0, far)],
            [across(0.0, far), across(1.0, near)],
        ] {
            let image = reduced(&draw(&triangles, [80, 80]), [40, 40]);
            let middle = 4 * (20 * 40 + 20);
            assert_eq!(image[middle..middle + 4], [200, 0, 0, 255]);
            assert_eq!(image[3], 0, "nothing is seen in the corner");
        }
    }

    #[test]
    fn all_of_it_is_within_the_picture() {
        let image = reduced(&draw(&[across(0.0, [9.0; 3])], [240, 120]), [120, 60]);
        let edge = |at: usize| image[4 * at + 3] == 0;
        assert!((0..120).all(|column| edge(column) && edge(59 * 120 + column)));
        assert!((0..60).all(|row| edge(120 * row) && edge(120 * row + 119)));
    }
}
