//! Sound exposure levels around the exhaust of one shot, 1 m away and above a floor:
//! `cargo run --release --example 03_around_the_exhaust designs/n80cb.toml`.

use nailnoise::model::sources::exhaust;
use nailnoise::{Design, chain};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{Floor, Outlet};
use nailnoise_acoustics::signals::Weighting;

fn main() -> Result<(), nailnoise::Error> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let design = Design::load(path)?;
    let ambient = &design.ambient;
    let air = Air::at(ambient.temperature, ambient.pressure)?;
    let air = air.of_gas(ambient.gas_constant, ambient.heat_capacity_ratio)?;
    let openings = exhaust::noise_of_openings(&design, &chain::shot(&design)?)?;
    // No direction of the jets is published; here they blow to the front, 1.2 m above the floor.
    let outlet = Outlet {
        position: [0.0, 0.0, 1.2],
        directions: vec![[1.0, 0.0, 0.0]],
    };
    let floor = Floor {
        height: 0.0,
        coherence: 0.0,
    };
    let range = [design.analysis.range_low, design.analysis.range_high];
    println!("angle from the jets    L_AE dB, free    above a floor");
    for degrees in (0..=180).step_by(30) {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        let level = |floor: Option<&Floor>| {
            let mut exposure = 0.0;
            for opening in &openings {
                let received = opening.at(&outlet, [cos, sin, 1.2], floor, &air)?;
                exposure += received.exposure(range, Weighting::A);
            }
            Ok::<f64, nailnoise::Error>(10.0 * (exposure / 4e-10).log10())
        };
        println!(
            "{degrees:>19}    {:>13.1}    {:>13.1}",
            level(None)?,
            level(Some(&floor))?
        );
    }
    Ok(())
}
