//! Transmission loss of an expansion chamber compared with its closed form, 10 lg(1 + (m - 1/m)^2/4 sin^2 kl), where m
//! is the area ratio: `cargo run --release --example 07_expansion_chamber`.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::muffler::{MufflerChain, MufflerElement};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (air, length, wide, narrow) = (Air::default(), 0.1, 0.03, 0.01);
    let pipe = MufflerElement {
        length,
        diameter: wide,
        lining: None,
    };
    let chamber = MufflerChain {
        elements: vec![pipe],
        outlet_diameter: narrow,
        outlet_mach: 0.0,
    };
    // A quarter wavelength in the chamber: sin kl = 1.
    let hz = air.sound_speed / (4.0 * length);
    let ratio: f64 = (wide / narrow).powi(2);
    let closed = 10.0 * (1.0 + 0.25 * (ratio - 1.0 / ratio).powi(2)).log10();
    let found = chamber.transmission_loss(hz, narrow, &air)?;
    println!("{found:.3} dB at {hz:.0} Hz, closed form {closed:.3} dB");
    assert!((found - closed).abs() < 1e-9);
    Ok(())
}
