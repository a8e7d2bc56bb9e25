//! Sound power of a control valve compared with IEC 60534-8-3:2010, table A.1, example 1: `cargo run --release
//! --example 08_valve_noise`.

use nailnoise_acoustics::jets::{ValveFlow, ValveNoise};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let valve = ValveNoise {
        efficiency_exponent: -3.8,
        peak_strouhal: 0.2,
        recovery: 0.792 / 0.984,
    };
    let flow = ValveFlow {
        mass_flow: 2.22,
        inlet_pressure: 1e6,
        outlet_pressure: 720e3,
        inlet_density: 5.3,
        heat_ratio: 1.22,
    };
    let power = valve.sound(&flow)?.map_or(0.0, |sound| sound.power());
    println!("{power:.1} W, printed 22.3 W");
    assert!((power / 22.3 - 1.0).abs() < 5e-3);
    Ok(())
}
