//! The level of a housing without forces on its surfaces: a rigid sphere of its mass.

use std::f64::consts::{PI, TAU};

use nailnoise::Design;

use crate::common::{design, run, small};

/// Half of the width of a triangular pulse \[s\], its peak \[N\], and its middle \[s\].
const HALF: f64 = 0.2e-3;
const PEAK: f64 = 500.0;
const MIDDLE: f64 = 2e-3;

/// A body that only a triangular pulse of force moves: no gas, no contact, no workpiece.
fn shaker(mass: f64) -> Design {
    let at = |offset: f64| format!("{} us", (1e6 * (MIDDLE + offset)).round());
    let [begin, middle, end] = [-HALF, 0.0, HALF].map(at);
    small(&format!(
        "[cycle]\nassembly = {{ name = \"shaker\", schema = 1 }}\n\
         gas = {{ constant = \"287.05 J/(kg K)\", ratio = 1.4 }}\nend = \"10 ms\"\n\
         [cycle.reservoir.atmosphere]\npressure = \"=ambient.pressure\"\ntemperature = \"=ambient.temperature\"\n\
         [cycle.body.tool]\nmass = \"{mass} kg\"\n\
         [cycle.force.pulse]\non = \"tool\"\n\
         table = [[\"0 s\", \"0 N\"], [\"{begin}\", \"0 N\"], [\"{middle}\", \"{PEAK} N\"], [\"{end}\", \"0 N\"]]\n\
         [cycle.event]\nstruck = {{ at = \"{begin}\" }}\n[cycle.outcome]\nshakes = \"struck\"\n\
         [study]\nrequire = \"shakes\""
    ))
}

/// A-weighting of a power (IEC 61672-1:2013, formula E.6, rounded constants of its table).
fn a_weighting(f: f64) -> f64 {
    let [f1, f2, f3, f4] = [20.6, 107.7, 737.9, 12194.0].map(|f: f64| f * f);
    let square = f * f;
    let response = f4 * square * square / ((square + f1) * (square + f4) * ((square + f2) * (square + f3)).sqrt());
    (response * 10f64.powf(2.0 / 20.0)).powi(2)
}

/// Level of the energy that a sphere of radius a radiates with the velocity V(f) = F(f)/(2 pi f m)
/// \[dB re 1 pW s\] (Morse and Ingard 1968, Theoretical Acoustics, sec. 7.1):
///
/// ```text
/// E = 2 int R |V|^2 df,   R = 4/3 pi a^2 rho c (k a)^4/(4 + (k a)^4),   |F| = F_0 T sinc^2(f T)
/// ```
fn closed_form(mass: f64, radius: f64, [density, speed]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
    let power = |f: f64| {
        let ka4 = (TAU * f / speed * radius).powi(4);
        let resistance = 4.0 / 3.0 * PI * radius * radius * density * speed * ka4 / (4.0 + ka4);
        let sinc = (PI * f * HALF).sin() / (PI * f * HALF);
        let velocity = PEAK * HALF * sinc * sinc / (TAU * f * mass);
        2.0 * resistance * velocity * velocity * a_weighting(f)
    };
    let count = 20_000;
    let step = (high - low) / f64::from(count);
    let energy: f64 = (0..count)
        .map(|n| step * power(low + step * (f64::from(n) + 0.5)))
        .sum();
    10.0 * (energy / 1e-12).log10()
}

#[test]
fn a_housing_in_rigid_motion_radiates_as_an_oscillating_sphere_of_its_mass() {
    let reference = design("designs/n80cb.toml");
    let mean_density = reference.tool.mass / reference.body.volume(reference.piston.bore);
    for mass in [0.5, 3.0] {
        let own = shaker(mass);
        let run = run(&own);
        let [body] = run.result.ranking.as_slice() else {
            panic!("{:?}", run.result.ranking.len());
        };
        assert_eq!(body.source, "body");
        let radius = (3.0 * mass / mean_density / (4.0 * PI)).cbrt();
        let ambient = &own.ambient;
        let gas = ambient.gas_constant * ambient.temperature;
        let air = [ambient.pressure / gas, (ambient.heat_capacity_ratio * gas).sqrt()];
        let range = [own.analysis.range_low, own.analysis.range_high];
        let (found, exact) = (body.lwa_db.unwrap(), closed_form(mass, radius, air, range));
        assert!((found - exact).abs() < 0.05, "{mass} kg: {found} dB against {exact} dB");
    }
}

/// Far below ka = 1, R is proportional to a^6 and so to m^2, and V^2 to 1/m^2.
#[test]
fn small_housings_of_any_mass_radiate_the_same_energy_for_the_same_force() {
    let level = |mass: f64| run(&shaker(mass)).result.total.lwa_db.unwrap();
    let gap = level(0.008) - level(0.002);
    assert!(gap.abs() < 0.05, "{gap} dB");
}
