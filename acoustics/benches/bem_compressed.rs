//! CPU time and memory of one frequency with the compressed matrix, as a function of size: `cargo bench -p
//! nailnoise-acoustics --bench bem_compressed -- [PATTERNS [UNKNOWNS ...]]`.
//!
//! A box of 1 x 0.8 x 0.6 m above the floor, with six panels per wavelength at every size. Options: `quads` uses
//! quadrilaterals; `sphere` a sphere of triangles in free space without congruent pairs; `low` a tenth of the
//! frequency; `dense` the dense matrix for comparison, at about 6 000 unknowns. The exponent is the slope of the
//! logarithms of time and size.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/common/boundary_meshes.rs"]
mod boundary_meshes;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, EquationSolver, Exterior};
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// User and system time of this process \[s\], from /proc; wall time if that is unavailable.
fn cpu(start: std::time::Instant) -> f64 {
    let ticks = |stat: String| -> Option<f64> {
        let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
        Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
    };
    std::fs::read_to_string("/proc/self/stat")
        .ok()
        .and_then(ticks)
        .unwrap_or_else(|| start.elapsed().as_secs_f64())
}

/// A line of /proc/self/status \[GiB\].
fn memory(line: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kilobytes = status.lines().find_map(|l| l.strip_prefix(line)).and_then(|l| {
        let digits: String = l.chars().filter(char::is_ascii_digit).collect();
        digits.parse::<f64>().ok()
    });
    kilobytes.map_or(f64::NAN, |k| k / 1048576.0)
}

struct Case {
    problem: Exterior,
    velocities: DMatrix<f64>,
    hz: f64,
}

/// A sphere with an uneven mesh, like that of a mesh generator.
fn sphere(unknowns: f64) -> Boundary {
    let n = (unknowns / 10.0).sqrt().round() as usize;
    let mut mesh = boundary_meshes::sphere(0.4, n, false);
    for (i, p) in mesh.points.iter_mut().enumerate() {
        let shift = [12.9, 78.2, 37.7].map(|s| (s * (i + 1) as f64).sin() * 0.05 / n as f64);
        p.coords = (p.coords + nalgebra::Vector3::from(shift)).normalize() * 0.4;
    }
    Boundary::new(mesh, None).unwrap()
}

/// A box above the floor.
fn cuboid(unknowns: f64, quads: bool) -> Boundary {
    let sides = [1.0, 0.8, 0.6];
    let area = 2.0 * (sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0]);
    let edge = (area / unknowns).sqrt();
    let mesh = boundary_meshes::cuboid([0.0, 0.0, 0.3], [sides[0], sides[1], 0.3 + sides[2]], edge, quads);
    Boundary::new(mesh, Some(0.0)).unwrap()
}

/// A case with about this many unknowns.
fn case(unknowns: f64, patterns: usize) -> Case {
    let is = |word: &str| std::env::args().any(|a| a == word);
    let air = Air::default();
    let boundary = if is("sphere") {
        sphere(unknowns)
    } else {
        cuboid(unknowns, is("quads"))
    };
    let problem = Exterior::new(boundary, &air);
    let hz = problem.estimate().highest_hz * if is("low") { 0.1 } else { 1.0 };
    let k = 2.0 * PI * hz / air.sound_speed;
    // Bending waves, supersonic and subsonic.
    let velocities = problem.boundary().project(patterns, |_, _, point, v| {
        let [x, y, z] = point.position.into();
        for (m, v) in v.iter_mut().enumerate() {
            let (sine, cosine) = (2.4 * m as f64).sin_cos();
            let k = k * (0.2 + 1.6 * m as f64 / patterns as f64);
            *v = (k * (x * cosine + y * sine + z * (cosine - sine))).cos();
        }
    });
    Case {
        problem,
        velocities,
        hz,
    }
}

fn main() {
    let start = std::time::Instant::now();
    let numbers: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let patterns = numbers.first().map_or(100, |&n| n as usize);
    let sizes = match numbers.get(1..) {
        Some(given @ [_, ..]) => given.to_vec(),
        _ => vec![1500.0, 3000.0, 6000.0, 12_000.0, 20_500.0],
    };
    println!("panels  unknowns  patterns      Hz  set up   solve  peak GiB  exponent  (CPU s)");
    let mut before: Option<(f64, f64)> = None;
    for unknowns in sizes {
        let t0 = cpu(start);
        let Case {
            problem,
            velocities,
            hz,
        } = case(unknowns, patterns);
        let problem = problem.with_equation_solver(EquationSolver::Compressed);
        let t1 = cpu(start);
        let found = problem.solve(hz, &velocities).unwrap();
        let t2 = cpu(start);
        let (n, time) = (problem.boundary().nodes() as f64, t2 - t1);
        let exponent = before.map_or(String::new(), |(m, t)| format!("{:.2}", (time / t).ln() / (n / m).ln()));
        before = Some((n, time));
        println!(
            "{:6} {n:9} {patterns:9} {hz:7.0} {:7.2} {time:7.2} {:9.2} {exponent:>9}",
            problem.boundary().mesh().panels.len(),
            t1 - t0,
            memory("VmHWM:"),
        );
        println!("        estimated: {}", problem.estimate());
        if (5000.0..7000.0).contains(&unknowns) && std::env::args().any(|a| a == "dense") {
            let dense = problem.with_equation_solver(EquationSolver::Dense);
            let t3 = cpu(start);
            let exact = dense.solve(hz, &velocities).unwrap();
            let t4 = cpu(start);
            let [a, b] = [&found, &exact].map(|p| dense.far_field_resistance(&velocities, p).unwrap());
            let off = (0..patterns).map(|m| (10.0 * (a[(m, m)] / b[(m, m)]).log10()).abs());
            println!(
                "       dense: {:.2} s; power within {:.4} dB, pressure {:.1e}",
                t4 - t3,
                off.fold(0.0, f64::max),
                (&found.pressure - &exact.pressure).norm() / exact.pressure.norm()
            );
        }
    }
}
