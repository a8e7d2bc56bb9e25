//! Effect of the supply pressure on the shot and on exhaust noise: `cargo run --release --example 02_pressure`.

use nailnoise::model::sources::exhaust;
use nailnoise::{Design, chain};
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let mut design = Design::load(file)?;
    println!("kPa  m/s  mm  g of air  dB(A) of the exhaust");
    for kilopascal in [650.0, 700.0, 750.0, 800.0, 850.0] {
        design.supply.pressure = 1e3 * kilopascal;
        let shot = chain::shot(&design)?;
        let openings = exhaust::noise_of_openings(&design, &shot)?;
        let parts: Vec<SourceSpectrum> = openings.into_iter().map(|opening| opening.spectrum).collect();
        let exhaust = SourceSpectrum::sum("exhaust", "all openings", &parts);
        let level = exhaust.level([50.0, 10_000.0], Weighting::A);
        let figure = |name: &str| shot.figures.get(name);
        println!(
            "{kilopascal:.0}  {}  {:.1}  {:.2}  {:.1}",
            // None where the nail is not driven to its length.
            figure("mean_drive_speed").map_or("-".to_owned(), |speed| format!("{speed:.1}")),
            1e3 * figure("penetration").unwrap_or(f64::NAN),
            1e3 * figure("exhaust_mass").unwrap_or(f64::NAN),
            level.unwrap_or(f64::NEG_INFINITY)
        );
    }
    Ok(())
}
