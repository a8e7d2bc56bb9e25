//! The elastic blow: Saint-Venant's two rods, reflections, balances, the rigid limit and convergence.
#![allow(clippy::unwrap_used)]

mod assemblies;
#[path = "../common/mod.rs"]
mod common;
mod ensemble;
#[path = "../common/n80cb_assembly.rs"]
mod n80cb_assembly;
#[path = "../common/random_assembly.rs"]
mod random_assembly;

use std::f64::consts::PI;
use std::sync::LazyLock;

use nailnoise_dynamics::blow::{Bar, Blow, BlowInput, Course, EndContact, advance, elastic_blow};
use nailnoise_dynamics::network::assembly::Rod;
use nailnoise_dynamics::{BlowModel, CycleRecord, Parameters, Settings, blow_input, simulate};

use common::n80cb;

const STEEL: Rod = Rod {
    length: 0.2,
    area: 7.85e-5,
    modulus: 207e9,
    density: 7850.0,
};

static BASE: LazyLock<CycleRecord> = LazyLock::new(|| simulate(&n80cb(), &Settings::default()).unwrap());

/// The N80CB with an elastic blow.
fn elastic_n80cb() -> Parameters {
    let mut parameters = n80cb();
    parameters.model.blow = BlowModel::Elastic;
    parameters
}

/// The bars of the base design.
fn base_input() -> BlowInput {
    blow_input(&elastic_n80cb()).unwrap().unwrap()
}

/// The cycle around the blow of the base design.
fn course() -> Course<'static> {
    Course::of_record(&base_input(), &BASE.record).unwrap()
}

/// The blow of the base design with some bars.
fn blow_of(input: &BlowInput) -> Blow {
    elastic_blow(input, &course()).unwrap()
}

/// The same bars, a thousand times as stiff.
fn stiffened(input: &BlowInput) -> BlowInput {
    let mut stiff = input.clone();
    stiff.bars.rod.modulus *= 1e3;
    stiff.bars.shank.modulus *= 1e3;
    stiff
}

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
    let force = 0.5 * STEEL.density * STEEL.wave_speed() * STEEL.area * speed;
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
fn a_rigid_blow_has_no_bars() {
    assert_eq!(blow_input(&n80cb()).unwrap(), None);
}

/// The equation of motion of the piston gives the sum of the forces of gas, stops, friction and guide.
#[test]
fn the_push_on_the_driver_is_the_sum_of_its_forces() {
    let names = [
        "piston_gas_force",
        "bumper.force",
        "stopper.force",
        "piston_friction.force",
        "nail.guide_force",
    ];
    let [gas, bumper, stopper, friction, magazine] = names.map(|name| BASE.history(name));
    for (n, push) in course().push(base_input().gravity).into_iter().enumerate() {
        let sum = gas[n] - bumper[n] - stopper[n] - friction[n] - magazine[n];
        assert!((push - sum).abs() < 1e-7, "{push} N for {sum} N at sample {n}");
    }
}

#[test]
fn the_nail_stops_at_the_event_of_the_cycle() {
    let (course, tip_at) = (course(), base_input().fastener.tip_at);
    let t9 = BASE.figures.events.t9.unwrap();
    let stop = course.stop(tip_at).unwrap();
    assert!((stop - t9).abs() < 1e-11, "{stop} s for {t9} s");
    let interpolated = Course {
        unloads: None,
        ..course
    };
    let stop = interpolated.stop(tip_at).unwrap();
    assert!((stop - t9).abs() < 0.1 * course.interval, "{stop} s for {t9} s");
}

#[test]
fn momentum_and_energy_of_a_blow_balance() {
    let blow = blow_of(&base_input());
    assert_eq!(blow.checks.len(), 2);
    for check in &blow.checks {
        assert!(check.ok, "{check:?}");
    }
    assert!((1..50).contains(&blow.contacts), "{}", blow.contacts);
}

/// Ratio of the impulse of bars a thousand times as stiff as steel to that of the cycle.
fn rigid(elements: usize) -> f64 {
    let bars = BlowInput {
        elements,
        ..stiffened(&base_input())
    };
    let [elastic, cycle] = blow_of(&bars).impulses;
    elastic / cycle
}

/// A nail of one element hardly rebounds from the rod, as in the plastic impact of the cycle.
#[test]
fn a_rigid_nail_of_one_element_has_the_impulse_of_the_cycle() {
    let ratio = rigid(1);
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

/// Rods of any stiffness rebound like Saint-Venant's: the nail loses less energy to the impact and drives for longer,
/// and the gas pushes for longer. The more elements, the less do the impacts of the end masses lose.
#[test]
fn rigid_bars_give_the_impulse_of_the_cycle_within_a_hundredth() {
    for elements in [4, 16, 32] {
        let ratio = rigid(elements);
        assert!((ratio - 1.0).abs() < 0.01, "{elements} elements: {ratio}");
    }
}

#[test]
fn elastic_bars_keep_the_impulse_on_the_wood() {
    let [elastic, cycle] = blow_of(&base_input()).impulses;
    assert!((elastic / cycle - 1.0).abs() < 0.03, "{elastic} N s for {cycle} N s");
}

#[test]
fn the_first_strike_converges_with_the_elements() {
    let input = base_input();
    let force = |elements: usize| {
        let blow = blow_of(&BlowInput {
            elements,
            ..input.clone()
        });
        let first = blow.samples[0];
        blow.on_wood[first..first + 200].to_vec()
    };
    let [coarse, shipped, fine] = [16, 64, 128].map(force);
    let distance = |a: &[f64]| {
        let square = |x: f64, y: f64| (x - y).powi(2);
        let apart: f64 = a.iter().zip(&fine).map(|(x, y)| square(*x, *y)).sum();
        (apart / fine.iter().map(|y| y * y).sum::<f64>()).sqrt()
    };
    let [far, near] = [distance(&coarse), distance(&shipped)];
    assert!(near < 0.02 && near < far, "{far} {near}");
}

/// Energy of a force in the third octave around `centre` \[Hz\], by its Fourier integral every 10 Hz.
fn third_octave(force: &[f64], interval: f64, centre: f64) -> f64 {
    let [low, high] = [-1.0, 1.0].map(|side| centre * 2f64.powf(side / 6.0));
    let lines = (low / 10.0).ceil() as usize..(high / 10.0) as usize;
    let square = |line: usize| {
        let step = 2.0 * PI * 10.0 * line as f64 * interval;
        let parts = force.iter().enumerate().fold([0.0; 2], |[a, b], (k, f)| {
            let (sin, cos) = (step * k as f64).sin_cos();
            [a + f * cos, b + f * sin]
        });
        parts[0].powi(2) + parts[1].powi(2)
    };
    lines.map(square).sum()
}

/// Changes of the force on the wood \[dB\] between these numbers of elements, in third octaves from 1 kHz on.
fn level_change(elements: [usize; 2], bands: &[f64]) -> Vec<f64> {
    let input = base_input();
    let [one, other] = elements.map(|elements| {
        let input = BlowInput {
            elements,
            ..input.clone()
        };
        blow_of(&input).on_wood
    });
    let level = |force: &[f64], band: f64| 10.0 * third_octave(force, BASE.sample_interval(), band).log10();
    bands
        .iter()
        .map(|band| level(&one, *band) - level(&other, *band))
        .collect()
}

/// Above, the times of single strikes decide: between 128 and 256 elements, bands from 8 kHz on change by 10 dB.
#[test]
fn third_octaves_of_the_force_on_the_wood_converge_up_to_3_khz() {
    let bands = [1000.0, 1250.0, 1600.0, 2000.0, 2500.0, 3150.0];
    for elements in [[64, 128], [128, 256]] {
        let changes = level_change(elements, &bands);
        assert!(
            changes.iter().all(|change| change.abs() < 1.0),
            "{elements:?}: {changes:.1?} dB in {bands:?} Hz"
        );
    }
}

#[test]
fn strikes_add_high_frequencies_to_the_force_on_the_wood() {
    let blow = blow_of(&base_input());
    let [first, last] = blow.samples;
    // The square of the second difference weighs the highest frequencies.
    let roughness = |force: &[f64]| {
        force[first..last]
            .windows(3)
            .map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2))
            .sum::<f64>()
    };
    assert!(roughness(&blow.on_wood) > 2.0 * roughness(BASE.history("nail.force")));
}
