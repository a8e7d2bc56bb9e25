//! The modes of the wood block, proven complete: `cargo run --release --example 04_block`.

use nailnoise::Design;
use nailnoise::chain::BodyStages;
use nailnoise::graph::Graph;
use nailnoise::stages::bodies::BodyKind;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let design = Design::load(file)?;
    let block = BodyStages::add(&Graph::default(), &design, BodyKind::Workpiece, true)?
        .body
        .get()?;
    let basis = &block.basis;
    let elastic = basis.hz.iter().zip(&basis.rigid).filter(|(_, rigid)| !**rigid);
    for (hz, _) in elastic.take(5) {
        println!("{hz:.0} Hz");
    }
    println!(
        "{} modes found, {} by the Sturm count",
        basis.hz.len(),
        basis.sturm.count
    );
    assert_eq!(basis.hz.len(), basis.sturm.count);
    Ok(())
}
