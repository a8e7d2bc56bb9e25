//! A vessel that discharges without heat, in closed form.

use nailnoise_dynamics::{CycleRecord, Geometry, Parameters, Settings, simulate};

use super::row::{Case, Row};
use crate::design::Design;
use crate::design::inputs::cycle::parameters;
use crate::error::Error;

const CASE: Case = Case {
    name: "choked discharge of a vessel",
    source: "isentropic: P = P_0 (1 + (g - 1)/2 m'_0 t/m_0)^(-2g/(g - 1)), closed form",
};

/// The volume above a head valve that cannot move, as a vessel of one litre that discharges through the trigger's vent.
fn vessel() -> Result<Parameters, Error> {
    let design = Design::parse("base = \"n80cb.toml\"\n", "verification.toml")?;
    let mut p = parameters(&design)?;
    p.head_valve.mass = 1e3;
    p.contacts.seat_stiffness = 1e12;
    p.chambers.above_valve = 1e-3;
    p.chambers.wall_heat_transfer = 0.0;
    p.trigger.vent_area = 2e-4;
    Ok(p)
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let p = vessel()?;
    let settings = Settings {
        sample_interval: 2e-5,
        end: 0.03,
        ..Settings::default()
    };
    let record: CycleRecord = simulate(&p, &settings)?;
    let geometry = Geometry::new(&p);
    let g = p.ambient.heat_capacity_ratio;
    let base = 2.0 / (g + 1.0);
    let choked = (g / p.ambient.gas_constant * base.powf((g + 1.0) / (g - 1.0))).sqrt();
    let volume = p.chambers.above_valve + geometry.valve_control_area * p.head_valve.lift;
    let (p0, t0) = (p.supply.pressure, p.ambient.temperature);
    let mass = p0 * volume / (p.ambient.gas_constant * t0);
    let flow = p.trigger.vent_area * geometry.attenuation_vent * choked * p0 / t0.sqrt();
    let exact = |t: f64| p0 * (1.0 + 0.5 * (g - 1.0) * t * flow / mass).powf(-2.0 * g / (g - 1.0));
    let row = |milliseconds: usize| {
        let sample = milliseconds * 50;
        let reference = exact(record.time(sample) - geometry.channel_delay);
        let computed = record.above_valve.pressure[sample];
        let quantity = format!("pressure after {milliseconds} ms, kPa");
        let row = CASE.row(quantity, 1e-3 * reference, 1e-3 * computed);
        row.within_part(1e-5).decimals(3)
    };
    Ok([2, 5, 8].map(row).into())
}
