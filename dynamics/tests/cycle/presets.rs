//! The published forms of the model, each with its known consequence.

use nailnoise_dynamics::{CycleRecord, Form, Geometry, Model, Outcome, Parameters, Settings, simulate};

use crate::common::n80cb;

fn run(p: &Parameters) -> CycleRecord {
    simulate(
        p,
        &Settings {
            tail: 1.0,
            ..Settings::default()
        },
    )
    .unwrap()
}

fn with(change: impl Fn(&mut Model)) -> Parameters {
    let mut p = n80cb();
    change(&mut p.model);
    p
}

/// Whether every balance of the run closes.
fn balanced(r: &CycleRecord) -> bool {
    r.figures.checks.iter().all(|c| c.ok || !c.name.contains("balance"))
}

fn speed(r: &CycleRecord) -> f64 {
    r.figures.summary.mean_drive_speed.unwrap()
}

fn close(value: f64, expected: f64, limit: f64) {
    assert!((value - expected).abs() < limit, "{value}, expected {expected}");
}

#[test]
fn b12_the_published_presets_strike_the_bumper_before_the_piston_stops() {
    for p in [n80cb().published_nail_only(), n80cb().published_all()] {
        let r = run(&p);
        assert_eq!(r.figures.outcome, Outcome::StrikesBumper);
        assert!(r.is_certified(), "{:?}", r.figures.checks);
    }
}

/// Share of the air through the trigger channel that flows back out of the volume above the valve, after the release.
fn returned(r: &CycleRecord) -> f64 {
    let from = ((r.figures.events.t12.unwrap() + 1e-3) / r.sample_interval()) as usize;
    let changes = r.history("above_valve.mass")[from..].windows(2).map(|w| w[1] - w[0]);
    let (out, into) = changes.fold((0.0, 0.0), |(out, into), change: f64| {
        (out + (-change).max(0.0), into + change.max(0.0))
    });
    out / into
}

#[test]
fn the_published_channel_fills_one_way() {
    let mut p = n80cb().published_all();
    let one_way = returned(&run(&p));
    p.model.intake = Form::Corrected;
    let both_ways = returned(&run(&p));
    assert!(one_way < 1e-4 && both_ways > 0.1, "{one_way} {both_ways}");
}

#[test]
fn published_all_opens_early_and_never_reaches_the_cap() {
    let r = run(&n80cb().published_all());
    let base = run(&n80cb());
    assert_eq!(r.figures.summary.cap_contacts, 0);
    assert!(r.figures.events.t2 < r.figures.events.t1);
    close(
        base.figures.events.t1.unwrap() - r.figures.events.t1.unwrap(),
        2e-3,
        0.5e-3,
    );
}

/// The gas volumes.
const GAS: [&str; 5] = ["above_piston", "below_piston", "return_volume", "above_valve", "supply"];

/// Gas mass by P V/(R T_a) less the mass by bookkeeping, at the end \[kg\].
fn excess(p: &Parameters, r: &CycleRecord) -> f64 {
    let (g, c, last) = (Geometry::new(p), &p.chambers, r.len() - 1);
    let travel = r.history("piston.travel")[last];
    let lift = r.history("valve_lift")[last];
    let swept = if p.model.valve_underside == Form::Corrected {
        1.0
    } else {
        0.0
    };
    let volumes = [
        c.above_piston + g.piston_area * travel + swept * g.valve_cylinder_area * lift,
        c.below_piston + g.ring_area * (p.piston.stroke - travel),
        c.return_volume,
        c.above_valve + g.valve_control_area * (p.head_valve.lift - lift),
        c.supply_volume + swept * g.valve_supply_area * lift,
    ];
    let rt = p.ambient.gas_constant * p.ambient.temperature;
    let of = |gas: &str, quantity: &str| r.history(&format!("{gas}.{quantity}"))[last];
    let gas = GAS.iter().zip(volumes);
    gas.map(|(gas, v)| of(gas, "pressure") * v / rt - of(gas, "mass")).sum()
}

#[test]
fn c02_the_published_gas_law_does_not_conserve_mass() {
    let p = with(|m| m.gas = Form::Published);
    let r = run(&p);
    close(speed(&r), 24.95, 0.01);
    close(excess(&p, &r), 0.32e-3, 0.01e-3);
    // The energy of the gas is not a quantity of this law; mass flow, energy of the bodies and momentum are.
    let names: Vec<&str> = r.figures.checks.iter().map(|c| &*c.name).collect();
    let balances = names.iter().filter(|name| name.contains("balance"));
    let expected = [
        "mass balance [kg]",
        "mechanical energy balance [J]",
        "mechanical energy balance, part of the energy of gas and bodies [-]",
        "momentum balance [N s]",
    ];
    assert!(balances.eq(&expected));
    assert!(balanced(&r));
}

#[test]
fn c05_without_a_hose_the_supply_pressure_falls() {
    let r = run(&with(|m| m.refill = Form::Published));
    close(speed(&r), 21.72, 0.01);
    close(r.history("supply.pressure")[r.len() - 1], 487e3, 2e3);
    assert_eq!(r.figures.summary.supply_mass, 0.0);
}

#[test]
fn c06_without_pressure_under_the_valve_it_stays_shut() {
    assert_eq!(
        run(&with(|m| m.valve_underside = Form::Published)).figures.outcome,
        Outcome::DoesNotOpen
    );
}

#[test]
fn c08_the_mass_jump_keeps_the_speed_of_the_piston() {
    let r = run(&with(|m| m.impact = Form::Published));
    assert_eq!(
        r.figures.summary.speed_before_impact,
        r.figures.summary.speed_after_impact
    );
    close(speed(&r), 22.8, 0.05);
}

#[test]
fn c09_the_published_nail_has_no_resistance_after_the_first_reversal() {
    let r = run(&with(|m| m.nail = Form::Published));
    let t9 = r.figures.events.t9.unwrap();
    let after = (t9 / r.sample_interval()) as usize + 250;
    assert!(r.history("nail.force")[after..].iter().all(|f| *f == 0.0));
    let full = (r.figures.summary.full_penetration.unwrap() / r.sample_interval()) as usize;
    let drop = r.history("nail.force")[full - 1] - r.history("nail.force")[full + 2];
    close(drop, 1.8e3, 0.1e3);
}

#[test]
fn c13_published_contacts_pull() {
    let r = run(&with(|m| m.contacts = Form::Published));
    assert!(r.history("bumper.force").iter().any(|f| *f < -1.0));
    assert!(run(&n80cb()).history("bumper.force").iter().all(|f| *f >= 0.0));
    assert!(r.is_certified(), "{:?}", r.figures.checks);
}

#[test]
fn c03_the_published_delay_vents_the_flow_of_one_delay_ago() {
    let delayed = run(&with(|m| m.delay = Form::Published));
    assert!(delayed.is_certified(), "{:?}", delayed.figures.checks);
    // The vented flow of one delay ago, against the flow the state then gives.
    let p = n80cb();
    let g = Geometry::new(&p);
    let lag = g.channel_delay;
    let h = delayed.sample_interval();
    let gamma: f64 = 1.4;
    let k = (gamma / p.ambient.gas_constant * (2.0 / (gamma + 1.0)).powf((gamma + 1.0) / (gamma - 1.0))).sqrt();
    for t in [1e-3, 3e-3, 8e-3] {
        let i = (t / h).round() as usize;
        let past = i as f64 - lag / h;
        let (j, w) = (past.floor() as usize, past.fract());
        let at = |column: &[f64]| (1.0 - w) * column[j] + w * column[j + 1];
        let (pressure, temperature) = (
            at(delayed.history("vent_pressure")),
            at(delayed.history("vent_temperature")),
        );
        let choked = p.trigger.vent_area * g.attenuation_vent * k * pressure / temperature.sqrt();
        assert!(
            (delayed.history("vent.mass_flow")[i] / choked - 1.0).abs() < 1e-5,
            "{t}: {} {choked}",
            delayed.history("vent.mass_flow")[i]
        );
    }
}

/// Mass of gas at the start that is neither in a volume nor counted as flow at the end \[kg\].
fn lost_mass(r: &CycleRecord) -> f64 {
    let total = |i: usize| GAS.iter().map(|gas| r.history(&format!("{gas}.mass"))[i]).sum::<f64>();
    let s = &r.figures.summary;
    total(0) - total(r.len() - 1) - s.exhaust_mass - s.vent_mass - s.leak_mass + s.supply_mass
}

#[test]
fn c03_the_published_delay_conserves_mass() {
    close(lost_mass(&run(&with(|m| m.delay = Form::Published))), 0.0, 1e-12);
}

#[test]
fn c04_the_published_channel_loses_mass() {
    let r = run(&with(|m| m.channel = Form::Published));
    assert!(!r.figures.checks.iter().any(|c| c.name.starts_with("mass")) && balanced(&r));
    // The filling flow of one delay, about 8 g/s for 0.29 ms, and the loss by attenuation.
    let lost = lost_mass(&r);
    assert!((1e-6..4e-6).contains(&lost), "{lost}");
}

#[test]
fn every_switch_changes_the_shot() {
    let base = run(&n80cb()).figures.events;
    let switches: [fn(&mut Model); 9] = [
        |m| m.gas = Form::Published,
        |m| m.valve_underside = Form::Published,
        |m| m.nail = Form::Published,
        |m| m.impact = Form::Published,
        |m| m.contacts = Form::Published,
        |m| m.intake = Form::Published,
        |m| m.delay = Form::Published,
        |m| m.channel = Form::Published,
        |m| m.refill = Form::Published,
    ];
    for (i, switch) in switches.into_iter().enumerate() {
        assert_ne!(run(&with(switch)).figures.events, base, "switch {i}");
    }
}
