//! A vessel that discharges adiabatically and at constant temperature, in closed form and by the procedure of ISO
//! 6358-2.

use nailnoise_dynamics::{CycleRecord, Geometry, Parameters, Settings, simulate};

use super::row::{Case, Row};
use crate::design::Design;
use crate::design::inputs::cycle::parameters;
use crate::error::Error;

const ISENTROPIC: Case = Case {
    name: "choked discharge of a vessel",
    source: "isentropic: P = P_0 (1 + (g - 1)/2 m'_0 t/m_0)^(-2g/(g - 1)), closed form",
};
const ISOTHERMAL: Case = Case {
    name: "choked discharge at constant temperature",
    source: "isothermal: P = P_0 exp(-m'_0 t/m_0), closed form",
};
const SUBSONIC: Case = Case {
    name: "subsonic discharge at constant temperature",
    source: "Saint-Venant and Wantzel: r^(1/g) (1 - r^((g - 1)/g))^(1/2) over its maximum, closed form",
};
const CONDUCTANCE: Case = Case {
    name: "ISO 6358-2, isothermal discharge",
    source: "C = A (g/R T_0)^(1/2) (2/(g + 1))^((g + 1)/(2g - 2))/rho_0 and b = (2/(g + 1))^(g/(g - 1)), closed form; \
             not compared with the printed standard",
};

/// Sampling interval \[s\].
const INTERVAL: f64 = 2e-5;

/// Standard reference atmosphere of ISO 8778: temperature \[K\] and density \[kg/m³\].
const REFERENCE_TEMPERATURE: f64 = 293.15;
const REFERENCE_DENSITY: f64 = 1.185;

/// Heat transfer coefficient \[W/(m² K)\] for a wall \[m²\], like that of a vessel filled with metal wool, which keeps
/// the temperature constant within a tenth of a kelvin.
const HEAT_TRANSFER: f64 = 1e5;
const WALL: f64 = 5.0;

/// The volume above a fixed head valve, used as a vessel of one litre that discharges through the trigger's vent, with
/// this heat transfer to its walls.
fn vessel(wall_heat_transfer: f64) -> Result<Parameters, Error> {
    let design = Design::parse("base = \"n80cb.toml\"\n", "verification.toml")?;
    let mut p = parameters(&design)?;
    p.head_valve.mass = 1e3;
    p.contacts.seat_stiffness = 1e12;
    p.chambers.above_valve = 1e-3;
    p.chambers.wall_heat_transfer = wall_heat_transfer;
    p.chambers.wall_above_valve = WALL;
    p.trigger.vent_area = 2e-4;
    Ok(p)
}

/// The discharge in closed form.
struct Discharge {
    /// Heat capacity ratio, gas constant \[J/(kg K)\].
    g: f64,
    gas_constant: f64,
    /// Volume \[m³\], effective area \[m²\].
    volume: f64,
    area: f64,
    /// Pressure \[Pa\] and temperature \[K\] at the start, pressure outside \[Pa\].
    pressure: f64,
    temperature: f64,
    outside: f64,
    /// Start of the discharge \[s\].
    start: f64,
}

impl Discharge {
    fn of(p: &Parameters) -> Self {
        let geometry = Geometry::new(p);
        Self {
            g: p.ambient.heat_capacity_ratio,
            gas_constant: p.ambient.gas_constant,
            volume: p.chambers.above_valve + geometry.valve_control_area * p.head_valve.lift,
            area: p.trigger.vent_area * geometry.attenuation_vent,
            pressure: p.supply.pressure,
            temperature: p.ambient.temperature,
            outside: p.ambient.pressure,
            start: geometry.channel_delay,
        }
    }

    /// Choked mass flow per area and pressure, multiplied by the square root of the temperature \[kg K^(1/2)/(s m²
    /// Pa)\].
    fn choked(&self) -> f64 {
        let g = self.g;
        (g / self.gas_constant * (2.0 / (g + 1.0)).powf((g + 1.0) / (g - 1.0))).sqrt()
    }

    /// Rate of the choked discharge at the start, m'_0/m_0 \[1/s\].
    fn rate(&self) -> f64 {
        let flow = self.area * self.choked() * self.pressure / self.temperature.sqrt();
        flow * self.gas_constant * self.temperature / (self.pressure * self.volume)
    }

    fn isentropic(&self, time: f64) -> f64 {
        let g = self.g;
        let base = 1.0 + 0.5 * (g - 1.0) * (time - self.start) * self.rate();
        self.pressure * base.powf(-2.0 * g / (g - 1.0))
    }

    fn isothermal(&self, time: f64) -> f64 {
        self.pressure * (-(time - self.start) * self.rate()).exp()
    }

    /// Critical pressure ratio.
    fn critical(&self) -> f64 {
        (2.0 / (self.g + 1.0)).powf(self.g / (self.g - 1.0))
    }

    /// Flow at a pressure ratio relative to the choked flow.
    fn relative_flow(&self, ratio: f64) -> f64 {
        let psi = |r: f64| r.powf(1.0 / self.g) * (1.0 - r.powf((self.g - 1.0) / self.g)).sqrt();
        psi(ratio.max(self.critical())) / psi(self.critical())
    }
}

/// The discharge computed by the cycle; pressures in the vessel \[Pa\].
fn pressures(p: &Parameters, end: f64) -> Result<CycleRecord, Error> {
    let settings = Settings {
        sample_interval: INTERVAL,
        end,
        ..Settings::default()
    };
    Ok(simulate(p, &settings)?)
}

/// Pressures after some milliseconds, while the flow is choked.
fn choked(case: Case, record: &CycleRecord, exact: impl Fn(f64) -> f64, part: f64) -> Vec<Row> {
    let row = |milliseconds: usize| {
        let sample = milliseconds * 50;
        let (reference, computed) = (
            exact(record.time(sample)),
            record.history("above_valve.pressure")[sample],
        );
        let quantity = format!("pressure after {milliseconds} ms, kPa");
        let row = case.row(quantity, 1e-3 * reference, 1e-3 * computed);
        row.within_part(part).decimals(3)
    };
    [2, 5, 8].map(row).into()
}

/// Mass flow out of a vessel at constant temperature, from the slope of its pressure, divided by the pressure \[kg/(s
/// Pa)\].
fn flow_per_pressure(of: &Discharge, record: &CycleRecord, sample: usize) -> f64 {
    let p = record.history("above_valve.pressure");
    let slope = (p[sample + 1] - p[sample - 1]) / (2.0 * INTERVAL);
    -slope * of.volume / (of.gas_constant * of.temperature) / p[sample]
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let p = vessel(0.0)?;
    let of = Discharge::of(&p);
    let mut rows = choked(ISENTROPIC, &pressures(&p, 0.03)?, |t| of.isentropic(t), 1e-5);
    let p = vessel(HEAT_TRANSFER)?;
    let record = pressures(&p, 0.06)?;
    rows.extend(choked(ISOTHERMAL, &record, |t| of.isothermal(t), 1e-3));

    // ISO 6358-2: the conductance follows from the choked flow, the critical ratio from the flow that is not choked.
    let choked = flow_per_pressure(&of, &record, 250);
    let scale = 1e8 * (of.temperature / REFERENCE_TEMPERATURE).sqrt() / REFERENCE_DENSITY;
    let exact = of.area * of.choked() / of.temperature.sqrt();
    rows.push(
        CONDUCTANCE
            .row("sonic conductance C, dm³/(s bar)", scale * exact, scale * choked)
            .within_part(1e-3)
            .decimals(3),
    );
    let mut critical = Vec::new();
    for ratio in [0.6, 0.7, 0.8, 0.9] {
        let at = record
            .history("above_valve.pressure")
            .iter()
            .position(|p| of.outside / p > ratio);
        let Some(sample) = at.filter(|&at| at > 0 && at + 1 < record.history("above_valve.pressure").len()) else {
            rows.push(SUBSONIC.row(format!("flow at the ratio {ratio} over choked flow"), 1.0, f64::NAN));
            continue;
        };
        let found = of.outside / record.history("above_valve.pressure")[sample];
        let flow = flow_per_pressure(&of, &record, sample) / choked;
        let quantity = format!("flow at the ratio {ratio} over choked flow");
        rows.push(
            SUBSONIC
                .row(quantity, of.relative_flow(found), flow)
                .within_part(1e-3)
                .decimals(5),
        );
        critical.push(1.0 - (1.0 - found) / (1.0 - (1.0 - flow * flow).sqrt()));
    }
    let mean = critical.iter().sum::<f64>() / critical.len() as f64;
    rows.push(
        CONDUCTANCE
            .row(
                "critical back-pressure ratio b, mean of four ratios",
                of.critical(),
                mean,
            )
            .within(0.02)
            .decimals(4),
    );
    rows.sort_by_key(|row| {
        [ISENTROPIC, ISOTHERMAL, SUBSONIC, CONDUCTANCE]
            .iter()
            .position(|case| *case == row.case)
    });
    Ok(rows)
}
