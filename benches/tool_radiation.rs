//! Radiation of the tool at one frequency far above the resolution of its mesh, with the dense and the compressed
//! matrix: `cargo bench -p nailnoise --bench tool_radiation -- [HZ ...]`, 8 kHz by default.
//!
//! The body of the N80CB moves in all its modes. Times are processor time of the entire process, with the modes in the
//! cache.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use nailnoise::Design;
use nailnoise::chain::BodyStages;
use nailnoise::graph::Graph;
use nailnoise::stages::Silent;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::stages::radiation::{Resolution, ToolRadiation};
use nailnoise::store::Store;
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{BemError, EquationSolver, SurfacePressure};
use nalgebra::DMatrix;

fn main() -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let mut frequencies: Vec<f64> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    if frequencies.is_empty() {
        frequencies.push(8000.0);
    }
    let design = Design::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/n80cb.toml"))?;
    let graph = Graph::new(Arc::new(Store::of_user()?), Arc::new(Silent));
    let body = BodyStages::add(&graph, &design, BodyKind::Tool, true)?.body.get()?;
    let elements = ToolRadiation {
        resolution: Resolution {
            top_hz: design.acoustics.bem_max_frequency,
            mean_top_hz: None,
            panels: design.acoustics.bem_panels,
            equations: EquationSolver::Auto,
            tolerance: design.acoustics.bem_tolerance,
        },
        floor: None,
        cover: None,
    };
    println!("    Hz  panels  unknowns  modes  set up  matrix       CPU s  peak GB");
    for hz in frequencies {
        let before = cpu(start);
        let range = elements.resolving(&body.moving_surface(), hz, &Air::default())?;
        let (patterns, boundary) = (&range.patterns, range.problem.boundary());
        print!(
            "{hz:6.0} {:7} {:9} {:6} {:7.2}",
            boundary.mesh().panels.len(),
            boundary.nodes(),
            patterns[0].velocities.ncols(),
            cpu(start) - before
        );
        let mut problem = range.problem;
        let mut found: Vec<Vec<SurfacePressure>> = Vec::new();
        for (solver, name) in [
            (EquationSolver::Compressed, "compressed"),
            (EquationSolver::Dense, "dense"),
        ] {
            problem = problem.with_equation_solver(solver);
            let before = cpu(start);
            found.push(problem.solve_parities(hz, patterns)?);
            let indent = if found.len() > 1 { 38 } else { 0 };
            println!("{:indent$}  {name:<10} {:7.2} {:8.2}", "", cpu(start) - before, peak());
        }
        let powers = |solutions: &[SurfacePressure]| {
            let of_parities = patterns.iter().zip(solutions);
            let each = of_parities.map(|(patterns, p)| problem.far_field_resistance(&patterns.velocities, p));
            each.sum::<Result<DMatrix<f64>, BemError>>()
        };
        let [a, b] = [powers(&found[0])?, powers(&found[1])?];
        let pressure = |solutions: &[SurfacePressure]| solutions.iter().map(|p| p.pressure.norm_squared()).sum::<f64>();
        let apart = found[0]
            .iter()
            .zip(&found[1])
            .map(|(a, b)| (&a.pressure - &b.pressure).norm_squared());
        let loudest = b.diagonal().max();
        let off = (0..b.nrows()).filter(|&m| b[(m, m)] > 1e-3 * loudest);
        println!(
            "        power of modes within 30 dB of the loudest: {:.4} dB apart; pressure: {:.1e} apart",
            off.map(|m| (10.0 * (a[(m, m)] / b[(m, m)]).log10()).abs())
                .fold(0.0, f64::max),
            (apart.sum::<f64>() / pressure(&found[1])).sqrt()
        );
    }
    Ok(())
}

/// User and system time of this process \[s\], from /proc; wall time without it.
fn cpu(start: Instant) -> f64 {
    let ticks = |stat: String| -> Option<f64> {
        let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
        Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
    };
    let stat = std::fs::read_to_string("/proc/self/stat").ok();
    stat.and_then(ticks).unwrap_or_else(|| start.elapsed().as_secs_f64())
}

/// Peak memory of this process \[GB\].
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |kilobytes| 1.024e-6 * kilobytes)
}
