//! Time spent in each stage of the modal solution, and its growth with the degrees of freedom.
//!
//! `cargo bench -p nailnoise-fem` runs the small meshes; `cargo bench -p nailnoise-fem -- --full` adds the free wood
//! block with 50 000 and 153 000 degrees of freedom. Times are CPU seconds of the process if /proc provides them, so
//! that other work on the machine does not count. Set RAYON_NUM_THREADS=1 for one core. `-- --only 34 13 8` runs the
//! free block with only these divisions, `-- --block 8` sets the size of a Lanczos block, `-- --whole` disables mirror
//! planes.

#[path = "../tests/common/bodies.rs"]
mod bodies;

use std::time::{Duration, Instant};

use nailnoise_fem::{Constraints, ModalSettings, System, assemble, modes};

/// CPU time of this process, with a resolution of 10 ms.
fn cpu_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Fields 14 and 15, counted after the command name, which may contain spaces.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: u64 = fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?;
    Some(Duration::from_millis(10 * ticks))
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let (start, cpu) = (Instant::now(), cpu_time());
    let result = work();
    let spent = cpu_time()
        .zip(cpu)
        .map_or(start.elapsed(), |(after, before)| after - before);
    (result, spent)
}

/// The `count` numbers that follow a flag.
fn numbers(flag: &str, count: usize) -> Option<Vec<usize>> {
    let mut arguments = std::env::args().skip_while(|a| a != flag).skip(1);
    (0..count).map(|_| arguments.next()?.parse().ok()).collect()
}

fn report(name: &str, mesh: Duration, assembly: (System, Duration), top_hz: f64) -> (f64, f64) {
    let (system, assembly) = assembly;
    let mut settings = ModalSettings::below(top_hz);
    if let Some(block) = numbers("--block", 1) {
        settings.block = block[0];
    }
    settings.mirrors = !std::env::args().any(|a| a == "--whole");
    let (basis, solution) = timed(|| modes(&system, &settings, &|_, _| ()).expect("modes of a sound model"));
    let total = (mesh + assembly + solution).as_secs_f64();
    let worst = basis.residuals.iter().fold(0.0, |a: f64, &b| a.max(b));
    println!(
        "{name:22} {:7} dofs {:4} modes  mesh {:4.1} %  assembly {:4.1} %  modes {:4.1} %  total {total:7.2} s  \
         residual {worst:.1e}  sectors {}  L {:.1} M  steps {}  solves {}",
        basis.dofs,
        basis.hz.len(),
        100.0 * mesh.as_secs_f64() / total,
        100.0 * assembly.as_secs_f64() / total,
        100.0 * solution.as_secs_f64() / total,
        basis.work.sectors,
        basis.work.factor_values as f64 / 1e6,
        basis.work.block_steps,
        basis.work.solves,
    );
    (basis.dofs as f64, total)
}

fn main() {
    let full = std::env::args().any(|a| a == "--full");
    let mut last: Option<(f64, f64)> = None;
    let only = numbers("--only", 3);
    for divisions in [[17, 6, 4], [22, 9, 6], [34, 13, 8], [50, 19, 12]] {
        match &only {
            Some(only) if only != &divisions => continue,
            None if divisions[0] > 22 && !full => continue,
            _ => {}
        }
        let (mesh, meshing) = timed(|| bodies::workpiece(divisions));
        let assembly = timed(|| assemble(&mesh, &[bodies::pine_block()], &Constraints::free()).expect("a sound model"));
        let point = report(&format!("block {divisions:?}"), meshing, assembly, 10e3);
        if let Some(last) = last.replace(point) {
            println!(
                "    cost grows as dofs^{:.2}",
                (point.1 / last.1).ln() / (point.0 / last.0).ln()
            );
        }
    }
    if only.is_some() {
        return;
    }
    let assembly = timed(|| bodies::clamped_table(if full { 0.030 } else { 0.045 }));
    report("worktable A to 6 kHz", Duration::ZERO, assembly, 6e3);
}
