//! The energy balance of a shot: it closes, and its parts equal integrals of the recorded forces.

use nailnoise_dynamics::{CycleRecord, Form, Geometry, Method, Settings, simulate};

use crate::common::n80cb;
use crate::{BASE, run};

/// Integral of the product of two columns by the trapezoidal rule.
fn work(r: &CycleRecord, force: &[f64], rate: impl Fn(usize) -> f64) -> f64 {
    let power = |i: usize| force[i] * rate(i);
    (1..r.len()).map(|i| 0.5 * (power(i - 1) + power(i))).sum::<f64>() * r.sample_interval()
}

#[test]
fn the_shot_closes_to_a_millionth_of_the_gas_energy_and_to_a_millijoule() {
    for method in [Method::Switching, Method::Bdf, Method::Esdirk34] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let r = simulate(&n80cb(), &settings).unwrap();
        let e = &r.figures.energy;
        assert!((e.gas_start - 2286.0).abs() < 1.0, "{}", e.gas_start);
        let worst = |name: &str| r.figures.checks.iter().find(|c| c.name.starts_with(name)).unwrap();
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
        r.figures
            .checks
            .iter()
            .find(|c| c.name.ends_with("balance [J]") && c.name.starts_with("whole"))
            .unwrap()
            .value
    };
    let (loose, tight) = (residual(1e-6), residual(1e-9));
    assert!(tight < 0.02 * loose, "{loose} J, {tight} J");
}

fn close(name: &str, value: f64, expected: f64, limit: f64) {
    assert!(
        (value - expected).abs() < limit,
        "{name}: {value} J, expected {expected} J"
    );
}

/// Velocity of the piston relative to the tool at a sample \[m/s\].
fn relative_velocity(i: usize) -> f64 {
    BASE.history("piston.velocity")[i] - BASE.history("tool.velocity")[i]
}

#[test]
fn work_terms_equal_the_integrals_of_the_recorded_forces() {
    let (r, e) = (&*BASE, &BASE.figures.energy);
    // The record ends up to one interval after its last sample.
    let piston = work(r, r.history("piston_gas_force"), relative_velocity);
    close("piston", e.piston_work + e.atmosphere, piston, 0.01);
    let penetration = work(r, r.history("nail.force"), |i| {
        r.history("piston.velocity")[i] - r.history("workpiece.velocity")[i]
    });
    close("penetration", e.penetration, penetration, 0.05);
    let friction = work(r, r.history("piston_friction.force"), relative_velocity);
    close("friction", e.piston_friction, friction, 1e-3);
}

#[test]
fn constant_forces_do_their_work_over_the_distance() {
    let (p, r, e) = (n80cb(), &*BASE, &BASE.figures.energy);
    let last = r.len() - 1;
    let rise = r.history("tool.position")[last] - r.history("tool.position")[0];
    close("hand", e.hand, p.hand.force * rise, 1e-3);
    let travel = r.history("piston.travel")[last] - r.history("piston.travel")[0];
    let atmosphere = -p.ambient.pressure * Geometry::new(&p).rod_area * travel;
    close("atmosphere", e.atmosphere, atmosphere, 1e-3);
}

#[test]
fn the_impact_on_the_nail_loses_the_energy_of_a_plastic_impact() {
    let (p, r) = (n80cb(), &*BASE);
    let nail = Geometry::new(&p).nail_mass;
    let reduced = p.piston.mass * nail / (p.piston.mass + nail);
    let speed = r.figures.summary.speed_before_impact.unwrap();
    close(
        "impact",
        r.figures.energy.nail_impact,
        0.5 * reduced * speed * speed,
        0.03,
    );
    assert!(r.figures.energy.nail_left.abs() < 1e-9);
}

#[test]
fn the_work_on_the_wood_exceeds_that_along_the_shank_by_the_work_of_the_head() {
    let penetration = BASE.figures.energy.penetration;
    assert!(penetration > 96.1 && penetration < 96.1 + 20.0, "{penetration}");
}

#[test]
fn the_supply_brings_the_enthalpy_of_its_mass() {
    let (p, r) = (n80cb(), &*BASE);
    let enthalpy = 3.5 * p.ambient.gas_constant * p.ambient.temperature;
    close(
        "supply",
        r.figures.energy.supply,
        r.figures.summary.supply_mass * enthalpy,
        1e-6,
    );
}

#[test]
fn an_open_contact_has_dissipated_all_the_work_done_on_it() {
    let contacts = &BASE.figures.energy.contacts;
    let bumper = work(&BASE, BASE.history("bumper.force"), relative_velocity);
    close("bumper", contacts.bumper, bumper, 2e-3);
    assert!(contacts.cap > 0.1 && contacts.stopper > 1.0);
}

#[test]
fn the_published_gas_law_does_not_conserve_energy_and_the_mechanics_do() {
    let mut p = n80cb();
    p.model.gas = Form::Published;
    let r = run(&p);
    assert!(r.figures.energy.gas_residual().abs() > 1.0);
    // The mechanics close whatever the gas does.
    assert!(
        r.figures.energy.mechanical_residual().abs() < 1e-3,
        "{}",
        r.figures.energy.mechanical_residual()
    );
}

#[test]
fn the_published_impact_adds_the_energy_of_the_nail() {
    let mut p = n80cb();
    p.model.impact = Form::Published;
    let r = run(&p);
    // The mass of the nail appears at the speed of the piston.
    assert!(r.figures.energy.nail_impact < -1.0, "{}", r.figures.energy.nail_impact);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
}
