//! The Radiatterer, a benchmark case of the European Acoustics Association: a box with slots and cavities whose entire
//! surface moves at 1 mm/s. `cargo run --release -p nailnoise-acoustics --example radiatterer -- [--divide N] [HZ
//! ...]`.
//!
//! Panels are 0.1 m / N wide. Without frequencies, all those of the reference are computed. Each row has
//! comma-separated values: the power, the levels at three points, and their differences from the reference if it has
//! the frequency.
//!
//! Reference: finite and infinite elements of order 4 on bricks of 50 mm (P. Fiala and P. Rucz, NiHu, public
//! repository), an independent computation whose dispersion shifts frequencies by 0.15 % at 200 Hz and 0.4 % at 300 Hz.
//! At the maxima of 20.5, 53, 78.5 and 109 Hz, compare frequencies instead of levels.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel};
use nailnoise_meshes::FaceKind;
use nalgebra::Point3;
use std::collections::HashMap;

/// Side of a cell of the lattice \[m\]. All dimensions are multiples of it.
const SIDE: f64 = 0.1;

/// Number of cells of the brick along x, y and z.
const BRICK: [usize; 3] = [25, 20, 17];

/// Boxes cut out of it: start and end along x, y and z.
#[rustfmt::skip]
const CUT: [[[usize; 2]; 3]; 21] = [
    [[2, 14], [0, 12], [4, 12]],
    [[23, 25], [2, 4], [5, 7]],
    [[23, 25], [7, 8], [10, 11]],
    [[16, 23], [1, 12], [2, 15]],
    [[2, 10], [14, 18], [0, 17]],
    [[12, 14], [14, 20], [16, 17]],
    [[12, 14], [14, 20], [12, 14]],
    [[12, 14], [14, 20], [6, 10]],
    [[12, 14], [14, 20], [0, 4]],
    [[16, 18], [14, 20], [16, 17]],
    [[16, 18], [14, 20], [12, 14]],
    [[16, 18], [14, 20], [6, 10]],
    [[16, 18], [14, 20], [0, 4]],
    [[20, 22], [14, 20], [16, 17]],
    [[20, 22], [14, 20], [12, 14]],
    [[20, 22], [14, 20], [6, 10]],
    [[20, 22], [14, 20], [0, 4]],
    [[24, 25], [14, 20], [16, 17]],
    [[24, 25], [14, 20], [12, 14]],
    [[24, 25], [14, 20], [6, 10]],
    [[24, 25], [14, 20], [0, 4]],
];

/// Velocity amplitude \[m/s\].
const VELOCITY: f64 = 1e-3;

/// Receiver points \[m\].
const POINTS: [[f64; 3]; 3] = [[-0.3, 0.3, 0.0], [0.2, -0.3, 0.4], [0.0, 0.0, -0.3]];

/// Frequency \[Hz\], power \[W\] and levels of the pressure amplitudes at the three points \[dB re 20 uPa\].
const REFERENCE: [[f64; 5]; 29] = [
    [0.5, 3.1139e-06, 51.22, 53.74, 51.14],
    [2.0, 4.9876e-05, 63.27, 65.78, 63.18],
    [10.0, 0.001313, 77.28, 79.86, 77.25],
    [18.0, 0.0079931, 83.61, 86.37, 83.93],
    [20.0, 0.063561, 90.0, 92.63, 90.84],
    [21.0, 0.030219, 84.29, 85.22, 84.47],
    [25.0, 0.0025461, 83.14, 86.09, 82.62],
    [35.0, 0.0081193, 86.97, 90.87, 86.93],
    [45.0, 0.018657, 91.19, 97.19, 91.68],
    [52.0, 0.06785, 97.2, 106.11, 98.57],
    [54.0, 0.066183, 96.45, 106.53, 98.23],
    [60.0, 0.020149, 84.78, 98.88, 88.21],
    [70.0, 0.025795, 83.46, 93.2, 84.48],
    [78.0, 0.061728, 91.45, 92.59, 91.57],
    [79.0, 0.061298, 92.09, 91.73, 92.06],
    [85.0, 0.015425, 87.0, 70.89, 84.92],
    [95.0, 0.02264, 84.76, 82.2, 76.99],
    [105.0, 0.03957, 87.07, 86.08, 79.49],
    [109.0, 0.042837, 87.43, 86.59, 80.59],
    [115.0, 0.033437, 86.04, 85.21, 80.68],
    [125.0, 0.029384, 74.71, 80.26, 77.94],
    [140.0, 0.01019, 78.42, 72.18, 77.94],
    [160.0, 0.0090329, 85.21, 75.82, 83.82],
    [180.0, 0.010128, 85.99, 73.4, 86.53],
    [200.0, 0.01044, 83.76, 79.06, 85.02],
    [220.0, 0.0098007, 79.59, 83.52, 81.85],
    [240.0, 0.007817, 77.25, 83.1, 76.34],
    [260.0, 0.0065004, 83.0, 83.25, 81.23],
    [300.0, 0.0063813, 84.57, 87.44, 75.94],
];

/// Whether a cell of the lattice, with `divide` subdivisions along each axis, belongs to the body.
fn is_solid(cell: [i64; 3], divide: i64) -> bool {
    let cell = cell.map(|c| c.div_euclid(divide));
    let inside = |c: usize| (0..BRICK[c] as i64).contains(&cell[c]);
    let in_cut = |cut: &[[usize; 2]; 3]| (0..3).all(|c| (cut[c][0] as i64..cut[c][1] as i64).contains(&cell[c]));
    (0..3).all(inside) && !CUT.iter().any(in_cut)
}

/// One panel on every side of a solid cell that is exposed to the air.
fn surface(divide: i64) -> BoundaryMesh {
    let (mut points, mut index) = (Vec::new(), HashMap::new());
    let mut panels = Vec::new();
    let mut at = |p: [i64; 3]| {
        *index.entry(p).or_insert_with(|| {
            points.push(Point3::from(p.map(|c| SIDE * c as f64 / divide as f64)));
            points.len() - 1
        })
    };
    let [nx, ny, nz] = BRICK.map(|n| n as i64 * divide);
    let cells = (0..nx).flat_map(|x| (0..ny).flat_map(move |y| (0..nz).map(move |z| [x, y, z])));
    for cell in cells.filter(|&cell| is_solid(cell, divide)) {
        for axis in 0..3 {
            for upper in [0, 1] {
                let mut beyond = cell;
                beyond[axis] += 2 * upper - 1;
                if is_solid(beyond, divide) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |[i, j]: [i64; 2]| {
                    let mut p = cell;
                    p[axis] += upper;
                    p[u] += i;
                    p[v] += j;
                    p
                };
                let mut nodes = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|ij| at(corner(ij)));
                if upper == 0 {
                    nodes.reverse();
                }
                panels.extend(Panel::new(FaceKind::Quad4, &nodes, 0));
            }
        }
    }
    BoundaryMesh {
        points,
        panels,
        patches: vec!["surface".to_owned()],
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let divide: i64 = match arguments.iter().position(|argument| argument == "--divide") {
        Some(at) => {
            let given = arguments.splice(at..(at + 2).min(arguments.len()), []).nth(1);
            given.ok_or("--divide needs a number")?.parse()?
        }
        None => 1,
    };
    let mut wanted: Vec<f64> = arguments.iter().map(|hz| hz.parse()).collect::<Result<_, _>>()?;
    if wanted.is_empty() {
        wanted = REFERENCE.map(|[hz, ..]| hz).into();
    }
    let air = Air {
        density: 1.3,
        sound_speed: 340.0,
        ..Air::default()
    };
    let boundary = Boundary::new(surface(divide), None)?;
    eprintln!("{} panels, {} unknowns", boundary.mesh().panels.len(), boundary.nodes());
    let velocities = boundary.project(1, |_, _, _, v| v[0] = VELOCITY);
    let exterior = Exterior::new(boundary, &air);
    println!("Hz,power [W],L_1 [dB],L_2 [dB],L_3 [dB],power - reference [dB],L_1,L_2,L_3");
    for hz in wanted {
        let solution = exterior.solve(hz, &velocities)?;
        let power = 0.5 * exterior.impedance(&velocities, &solution)?[0][(0, 0)].re;
        let [pressure, _] = exterior.pressure_at(&POINTS.map(Point3::from), &velocities, &solution)?;
        let levels = [0, 1, 2].map(|i| 20.0 * (pressure[(i, 0)].norm() / 2e-5).log10());
        let mut row = format!("{hz},{power:.5e}");
        levels.iter().for_each(|level| row.push_str(&format!(",{level:.3}")));
        if let Some([_, watts, reference @ ..]) = REFERENCE.iter().find(|row| row[0] == hz) {
            row.push_str(&format!(",{:.3}", 10.0 * (power / watts).log10()));
            for (level, reference) in levels.iter().zip(reference) {
                row.push_str(&format!(",{:.3}", level - reference));
            }
        } else {
            row.push_str(",,,,");
        }
        println!("{row}");
    }
    Ok(())
}
