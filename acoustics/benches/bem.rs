//! CPU time of one frequency against size: `cargo bench -p nailnoise-acoustics --bench bem`.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/bem_common/mod.rs"]
mod bem_common;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, Exterior};

/// User and system time of this process \[s\], from /proc; wall time where there is none.
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
    println!("panels  unknowns  close pairs  patterns  set up    solve   far field  (CPU s, one thread)");
    for (n, patterns) in [(9, 1), (12, 1), (17, 1), (17, 100)] {
        let t0 = cpu(start);
        let boundary = Boundary::new(bem_common::sphere(0.3, n, false), None).unwrap();
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
            "{:6} {:9} {:12} {patterns:9} {:7.2} {:8.2} {:11.2}",
            problem.boundary().mesh().panels.len(),
            problem.boundary().nodes(),
            problem.close_pairs(),
            t1 - t0,
            t2 - t1,
            t3 - t2
        );
    }
}
