//! Pressure in a vessel that discharges adiabatically through a choked opening, compared with the closed form P = P_0
//! (1 + (g - 1)/2 m'_0 t/m_0)^(-2g/(g - 1)): `cargo run --release --example 09_choked_vessel`.

use nailnoise::Design;
use nailnoise::design::inputs::cycle::parameters;
use nailnoise_dynamics::{Geometry, Settings, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The volume above a fixed head valve, one litre, discharges through the trigger's vent.
    let mut p = parameters(&Design::load("designs/n80cb.toml")?)?;
    p.head_valve.mass = 1e3;
    p.contacts.seat_stiffness = 1e12;
    p.chambers.above_valve = 1e-3;
    p.chambers.wall_heat_transfer = 0.0;
    p.trigger.vent_area = 2e-4;
    let record = simulate(
        &p,
        &Settings {
            end: 0.01,
            ..Settings::default()
        },
    )?;
    let (geometry, g, gas) = (Geometry::new(&p), p.ambient.heat_capacity_ratio, p.ambient.gas_constant);
    let (p0, t0) = (p.supply.pressure, p.ambient.temperature);
    let volume = p.chambers.above_valve + geometry.valve_control_area * p.head_valve.lift;
    let choked = (g / gas * (2.0 / (g + 1.0)).powf((g + 1.0) / (g - 1.0))).sqrt();
    let flow = p.trigger.vent_area * geometry.attenuation_vent * choked * p0 / t0.sqrt();
    let sample = (5e-3 / record.sample_interval()).round() as usize;
    let time = record.time(sample) - geometry.channel_delay;
    let rate = flow * gas * t0 / (p0 * volume);
    let closed = p0 * (1.0 + 0.5 * (g - 1.0) * time * rate).powf(-2.0 * g / (g - 1.0));
    let found = record.history("above_valve.pressure")[sample];
    println!(
        "{:.3} kPa after 5 ms, closed form {:.3} kPa",
        1e-3 * found,
        1e-3 * closed
    );
    assert!((found / closed - 1.0).abs() < 1e-5);
    Ok(())
}
