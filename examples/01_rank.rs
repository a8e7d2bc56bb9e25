//! Ranks the sources of a design: `cargo run --release --example 01_rank designs/n80cb.toml`.

use nailnoise::chain::Options;
use nailnoise::run::run;
use nailnoise::{Design, graph::Graph};

fn main() -> Result<(), nailnoise::Error> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let design = Design::load(path)?;
    let run = run(&Graph::default(), &design, Options::default())?;
    let energy = |level: Option<f64>| level.map_or(0.0, |level| 10f64.powf(0.1 * level));
    let sum: f64 = run.result.ranking.iter().map(|source| energy(source.lwa_db)).sum();
    // The energies of the sources add up to that of the total.
    assert!((sum / energy(run.result.total.lwa_db) - 1.0).abs() < 1e-6);
    for source in &run.result.ranking {
        match source.lwa_db {
            Some(level) => println!("{:<10} {level:6.1} dB(A)  {}", source.source, source.method),
            None => println!("{:<10} silent", source.source),
        }
    }
    Ok(())
}
