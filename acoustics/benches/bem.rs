//! CPU time of one frequency as a function of size: `cargo bench -p nailnoise-acoustics --bench bem`, or `... -- table`
//! for the last rows only.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/common/boundary_meshes.rs"]
mod boundary_meshes;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Parity, Patterns, SolidBox};

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

fn main() {
    let start = std::time::Instant::now();
    println!("panels  unknowns  close pairs  shapes  patterns  set up    solve   far field  (CPU s, one thread)");
    let spheres = if std::env::args().any(|a| a == "table") { 0 } else { 4 };
    let cases = [(9, 1, true), (12, 1, true), (17, 1, true), (17, 100, false)];
    for (n, patterns, uneven) in cases.into_iter().take(spheres) {
        let mut mesh = boundary_meshes::sphere(0.3, n, false);
        if uneven {
            // No two pairs of panels are congruent, as on a surface from a mesh generator.
            for (i, p) in mesh.points.iter_mut().enumerate() {
                let shift = [12.9, 78.2, 37.7].map(|s| (s * (i + 1) as f64).sin() * 0.01 / n as f64);
                p.coords += nalgebra::Vector3::from(shift);
            }
        }
        let t0 = cpu(start);
        let boundary = Boundary::new(mesh, None).unwrap();
        let v = boundary.project(patterns, |_, _, point, v| {
            for (m, v) in v.iter_mut().enumerate() {
                *v = (point.position.z * m as f64 * 10.0).cos();
            }
        });
        let problem = Exterior::new(boundary, &Air::default())
            .with_panels_per_wavelength(1.0)
            .unwrap();
        let t1 = cpu(start);
        let solution = problem.solve(1000.0, &v).unwrap();
        let t2 = cpu(start);
        problem.far_field_resistance(&v, &solution).unwrap();
        let t3 = cpu(start);
        println!(
            "{:6} {:9} {:12} {:7} {patterns:9} {:7.2} {:8.2} {:11.2}",
            problem.boundary().mesh().panels.len(),
            problem.boundary().nodes(),
            problem.close_pairs(),
            problem.close_shapes(),
            t1 - t0,
            t2 - t1,
            t3 - t2
        );
    }
    table(start);
}

/// Block on a table above the floor: a quarter of it, all four parities with a hundred patterns each.
fn table(start: std::time::Instant) {
    let boxes = [
        ([-0.2032, -0.0762, 0.0], [0.2032, 0.0762, 0.09525]),
        ([-0.225, -0.2, -0.038], [0.225, 0.2, 0.0]),
        ([-0.225, -0.2, -0.67], [-0.136, -0.111, -0.038]),
        ([0.136, -0.2, -0.67], [0.225, -0.111, -0.038]),
        ([-0.225, 0.111, -0.67], [-0.136, 0.2, -0.038]),
        ([0.136, 0.111, -0.67], [0.225, 0.2, -0.038]),
    ];
    let boxes: Vec<SolidBox> = boxes
        .into_iter()
        .enumerate()
        .map(|(part, (low, high))| SolidBox { low, high, part })
        .collect();
    let (mirrors, floor) = ([Some(0.0); 2], -0.67);
    let air = Air::default();
    println!("\nblock on table, six panels a wavelength, a quarter, four parities of 100 patterns");
    println!(
        "    Hz  panels  unknowns  close pairs  shapes  set up     kept    solve   both powers  (CPU s, one thread)"
    );
    for hz in [1280.0, 3200.0] {
        let t0 = cpu(start);
        let planes = [mirrors[0], mirrors[1], Some(floor)];
        let edge = (air.sound_speed / (6.0 * hz)).min(1.0 / 16.0);
        let mesh = BoundaryMesh::of_boxes(&boxes, planes, edge, vec!["all".to_owned()], |_| 0).unwrap();
        let boundary = Boundary::symmetric(mesh, mirrors, Some(floor)).unwrap();
        let pattern = |parity: Parity| {
            let velocities = boundary.project(100, |_, _, point, v| {
                let [x, y, z] = point.position.into();
                let odd = if parity.odd_x { x } else { 1.0 } * if parity.odd_y { y } else { 1.0 };
                for (m, v) in v.iter_mut().enumerate() {
                    *v = odd * (z * m as f64 + 0.3 * x * x * m as f64 + y * y).cos();
                }
            });
            Patterns { parity, velocities }
        };
        let patterns: Vec<Patterns> = Parity::all([true; 2]).into_iter().map(pattern).collect();
        let problem = Exterior::new(boundary, &air);
        let t1 = cpu(start);
        let problem = problem.with_near_field_cache(hz);
        let t2 = cpu(start);
        problem.solve_parities(0.9 * hz, &patterns).unwrap();
        let t3 = cpu(start);
        problem.resistance_parities(0.9 * hz, &patterns).unwrap();
        let t4 = cpu(start);
        println!(
            "{hz:6} {:7} {:9} {:12} {:7} {:7.2} {:8.2} {:8.2} {:13.2}",
            problem.boundary().mesh().panels.len(),
            problem.boundary().nodes(),
            problem.close_pairs(),
            problem.close_shapes(),
            t1 - t0,
            t2 - t1,
            t3 - t2,
            t4 - t3 - (t3 - t2)
        );
        println!("        estimated: {}", problem.estimate());
    }
}
