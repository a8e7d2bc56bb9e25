//! The energy flow of a shot: it closes, and its parts are what other records say they are.

#![allow(clippy::unwrap_used)]

mod common;

use nailnoise_dynamics::{CycleRecord, Form, Geometry, Method, Parameters, Settings, simulate};

use common::n80cb;

fn run(p: &Parameters) -> CycleRecord {
    simulate(p, &Settings::default()).unwrap()
}

/// Integral of the product of two columns by the trapezoidal rule.
fn work(r: &CycleRecord, force: &[f64], rate: impl Fn(usize) -> f64) -> f64 {
    let power = |i: usize| force[i] * rate(i);
    (1..r.len()).map(|i| 0.5 * (power(i - 1) + power(i))).sum::<f64>() * r.sample_interval
}

#[test]
fn the_shot_closes_to_a_millionth_of_the_gas_energy_and_to_a_millijoule() {
    for method in [Method::Bdf, Method::Esdirk34] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let r = simulate(&n80cb(), &settings).unwrap();
        let e = &r.energy;
        assert!((e.gas_start - 2286.0).abs() < 1.0, "{}", e.gas_start);
        let worst = |name: &str| r.checks.iter().find(|c| c.name.starts_with(name)).unwrap();
        let (joule, part) = (
            worst("whole-shot energy balance [J]"),
            worst("whole-shot energy balance, part"),
        );
        assert!(joule.ok && joule.limit == 1e-3, "{method:?}: {joule:?}");
        assert!(part.ok && part.limit == 1e-6, "{method:?}: {part:?}");
        assert!((part.value * e.gas_start / joule.value - 1.0).abs() < 1e-12);
        assert!(e.residual().abs() <= joule.value * (1.0 + 1e-12));
        assert!(e.gas_residual().abs() < 1e-9, "{}", e.gas_residual());
    }
}

#[test]
fn the_residual_falls_with_the_tolerance() {
    let residual = |relative_tolerance: f64| {
        let settings = Settings {
            relative_tolerance,
            ..Settings::default()
        };
        let r = simulate(&n80cb(), &settings).unwrap();
        r.checks
            .iter()
            .find(|c| c.name.ends_with("balance [J]") && c.name.starts_with("whole"))
            .unwrap()
            .value
    };
    let (loose, tight) = (residual(1e-6), residual(1e-9));
    assert!(tight < 0.02 * loose, "{loose} J, {tight} J");
}

#[test]
fn the_parts_equal_the_integrals_of_the_recorded_forces() {
    let (p, r) = (n80cb(), run(&n80cb()));
    let (e, f, g) = (&r.energy, &r.forces, Geometry::new(&p));
    let relative = |i: usize| r.piston.velocity[i] - r.tool.velocity[i];
    let close = |name: &str, value: f64, expected: f64, limit: f64| {
        assert!(
            (value - expected).abs() < limit,
            "{name}: {value} J, by samples {expected} J"
        );
    };
    // The record ends up to one interval after its last sample.
    let last = r.len() - 1;
    let piston = work(&r, &f.piston_gas, relative);
    close("piston", e.piston_work + e.atmosphere, piston, 0.01);
    let penetration = work(&r, &f.penetration, |i| r.piston.velocity[i] - r.workpiece.velocity[i]);
    close("penetration", e.penetration, penetration, 0.05);
    close(
        "friction",
        e.piston_friction,
        work(&r, &f.piston_friction, relative),
        1e-3,
    );
    close(
        "hand",
        e.hand,
        p.hand.force * (r.tool.position[last] - r.tool.position[0]),
        1e-3,
    );
    let travel = r.motion.piston_travel[last] - r.motion.piston_travel[0];
    close(
        "atmosphere",
        e.atmosphere,
        -p.ambient.pressure * g.rod_area * travel,
        1e-3,
    );
    // Plastic impact of a mass at rest.
    let (before, reduced) = (
        r.summary.speed_before_impact.unwrap(),
        p.piston.mass * g.nail_mass / (p.piston.mass + g.nail_mass),
    );
    close("impact", e.nail_impact, 0.5 * reduced * before * before, 0.03);
    assert!((e.nail_left).abs() < 1e-9);
    // The work on the wood exceeds that over the nail's length by what the head does.
    assert!(e.penetration > 96.1 && e.penetration < 96.1 + 20.0, "{}", e.penetration);
    let temperature = p.ambient.temperature;
    close(
        "supply",
        e.supply,
        r.summary.supply_mass * 3.5 * p.ambient.gas_constant * temperature,
        1e-6,
    );
    // An open contact has nothing stored: all the work on it is dissipated.
    close(
        "stopper and bumper",
        e.contacts.bumper,
        work(&r, &f.bumper, relative),
        2e-3,
    );
    assert!(e.contacts.cap > 0.1 && e.contacts.stopper > 1.0);
}

#[test]
fn published_forms_state_what_they_lose() {
    let mut p = n80cb();
    p.model.gas = Form::Published;
    let r = run(&p);
    assert!(r.energy.gas_residual().abs() > 1.0);
    // The mechanics close whatever the gas does.
    assert!(
        r.energy.mechanical_residual().abs() < 1e-3,
        "{}",
        r.energy.mechanical_residual()
    );
    let mut p = n80cb();
    p.model.impact = Form::Published;
    let r = run(&p);
    // Mass that appears at speed brings its energy along.
    assert!(r.energy.nail_impact < -1.0, "{}", r.energy.nail_impact);
    assert!(r.is_certified(), "{:?}", r.checks);
}
