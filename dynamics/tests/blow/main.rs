//! The elastic blow: Saint-Venant's two rods, reflections, balances, the rigid limit and convergence.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

use std::sync::LazyLock;

use nailnoise_dynamics::blow::{Bar, Bars, EndContact, Rod, advance, elastic_blow, with_bars};
use nailnoise_dynamics::{CycleRecord, Settings, simulate};

use common::n80cb;

const STEEL: Rod = Rod {
    length: 0.2,
    diameter: 0.01,
    modulus: 207e9,
    density: 7850.0,
};

static BASE: LazyLock<CycleRecord> = LazyLock::new(|| simulate(&n80cb(), &Settings::default()).unwrap());

/// Time of one element at the wave speed.
fn exact_step(elements: usize) -> f64 {
    STEEL.length / elements as f64 / STEEL.wave_speed()
}

/// A contact that never closes.
const APART: EndContact = EndContact {
    gap: 1.0,
    force: 0.0,
    loss: 0.0,
};

#[test]
fn two_equal_rods_exchange_their_speeds_as_saint_venant_found() {
    let (elements, speed) = (2000, 4.0);
    let dt = exact_step(elements);
    let mut first = Bar::new(&STEEL, elements, speed);
    let mut second = Bar::new(&STEEL, elements, 0.0);
    let (energy, momentum) = (first.energy(dt), first.momentum());
    let mut contact = EndContact::default();
    let (mut duration, mut impulse) = (0.0, 0.0);
    for _ in 0..3 * elements {
        advance(&mut first, &mut second, &mut contact, dt);
        if contact.force > 0.0 {
            duration += dt;
            impulse += contact.force * dt;
        }
    }
    let expected = 2.0 * STEEL.length / STEEL.wave_speed();
    assert!(
        (duration / expected - 1.0).abs() < 1e-3,
        "{duration} s for {expected} s"
    );
    let force = 0.5 * STEEL.density * STEEL.wave_speed() * STEEL.area() * speed;
    assert!(
        (impulse / duration / force - 1.0).abs() < 1e-3,
        "{} N for {force} N",
        impulse / duration
    );
    assert!((second.momentum() / momentum - 1.0).abs() < 1e-3);
    assert!((first.momentum() + second.momentum() - momentum).abs() < 1e-9 * momentum);
    let balance = first.energy(dt) + second.energy(dt) + contact.loss - energy;
    assert!(balance.abs() < 1e-9 * energy, "{balance} J of {energy} J");
    assert!(contact.loss < 1e-3 * energy);
}

#[test]
fn the_loss_of_the_end_masses_vanishes_with_the_elements() {
    let loss = |elements: usize| {
        let dt = exact_step(elements);
        let mut first = Bar::new(&STEEL, elements, 4.0);
        let mut second = Bar::new(&STEEL, elements, 0.0);
        let energy = first.energy(dt);
        let mut contact = EndContact::default();
        for _ in 0..3 * elements {
            advance(&mut first, &mut second, &mut contact, dt);
        }
        contact.loss / energy
    };
    let [coarse, fine] = [50, 200].map(loss);
    let order = (coarse / fine).log2() / 2.0;
    assert!((order - 1.0).abs() < 0.1, "order {order}");
}

#[test]
fn a_pulse_returns_upright_from_a_free_end_and_inverted_from_a_fixed_one() {
    let elements = 400;
    let dt = exact_step(elements);
    let pulse = |x: f64| (-((x - 150.0) / 20.0).powi(2)).exp() * 1e-6;
    for (end_mass, sign) in [(None, 1.0), (Some(1e9), -1.0)] {
        let mut bar = Bar::new(&STEEL, elements, 0.0);
        if let Some(mass) = end_mass {
            bar.mass[elements] = mass;
        }
        for i in 0..=elements {
            let x = i as f64;
            bar.displacement[i] = pulse(x);
            bar.velocity[i] = (pulse(x) - pulse(x + 1.0)) / dt;
        }
        let mut other = Bar::new(&STEEL, 1, 0.0);
        let mut contact = APART;
        // To the end at 400 and back to 150.
        for _ in 0..500 {
            advance(&mut bar, &mut other, &mut contact, dt);
        }
        for i in 100..200 {
            let expected = sign * pulse(i as f64);
            assert!((bar.displacement[i] - expected).abs() < 1e-9, "{sign} at {i}");
        }
    }
}

#[test]
fn momentum_and_energy_of_a_blow_balance() {
    let blow = elastic_blow(&n80cb(), &BASE).unwrap();
    assert_eq!(blow.checks.len(), 2);
    for check in &blow.checks {
        assert!(check.ok, "{check:?}");
    }
    assert!((1..50).contains(&blow.contacts), "{}", blow.contacts);
}

#[test]
fn rigid_bars_give_the_impulse_of_the_cycle() {
    let p = n80cb();
    let bars = Bars::new(&p);
    let rigid = Bars {
        rod: Rod {
            modulus: 1e3 * bars.rod.modulus,
            ..bars.rod
        },
        nail: Rod {
            modulus: 1e3 * bars.nail.modulus,
            ..bars.nail
        },
        elements: 4,
        ..bars
    };
    let [elastic, cycle] = with_bars(&rigid, &p, &BASE).unwrap().impulses;
    assert!((elastic / cycle - 1.0).abs() < 0.01, "{elastic} N s for {cycle} N s");
}

#[test]
fn elastic_bars_keep_the_impulse_on_the_wood() {
    let [elastic, cycle] = elastic_blow(&n80cb(), &BASE).unwrap().impulses;
    assert!((elastic / cycle - 1.0).abs() < 0.02, "{elastic} N s for {cycle} N s");
}

/// Energy of the force above 2 kHz, as the integral of the square of its rate.
fn roughness(force: &[f64]) -> f64 {
    force
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[test]
fn the_force_on_the_wood_converges_with_the_elements() {
    let p = n80cb();
    let bars = Bars::new(&p);
    let force = |elements: usize| with_bars(&Bars { elements, ..bars }, &p, &BASE).unwrap().on_wood;
    let [coarse, shipped, fine] = [16, 32, 128].map(force);
    let distance = |a: &[f64], b: &[f64]| {
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        difference.iter().map(|d| d * d).sum::<f64>().sqrt() / b.iter().map(|d| d * d).sum::<f64>().sqrt()
    };
    let [far, near] = [distance(&coarse, &fine), distance(&shipped, &fine)];
    assert!(near < 0.05 && near < far, "{far} {near}");
    assert!((roughness(&shipped) / roughness(&fine) - 1.0).abs() < 0.2);
}

#[test]
fn an_elastic_blow_is_rougher_than_a_rigid_one() {
    let blow = elastic_blow(&n80cb(), &BASE).unwrap();
    assert!(roughness(&blow.on_wood) > roughness(&BASE.forces.penetration));
}
