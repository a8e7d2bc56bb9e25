//! Ranks the sources of a design: `cargo run --release --example rank designs/n80cb.toml`.

use nailnoise::chain::Options;
use nailnoise::run::run;
use nailnoise::{Design, graph::Graph};

fn main() -> Result<(), nailnoise::Error> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let design = Design::load(path)?;
    let run = run(&Graph::default(), &design, Options::default())?;
    for source in &run.result.ranking {
        match source.lwa_db {
            Some(level) => println!("{:<10} {level:6.1} dB(A)  {}", source.source, source.method),
            None => println!("{:<10} silent", source.source),
        }
    }
    Ok(())
}
