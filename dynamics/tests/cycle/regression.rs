//! Results of the base design as this program computes them: they are no laws, and a change of the model may change
//! them.

use nailnoise_dynamics::{Settings, simulate};

use crate::BASE;
use crate::common::n80cb;

#[test]
fn regression_the_piston_meets_the_bumper_after_the_drive() {
    let r = &*BASE;
    let (t9, t10) = (r.figures.events.t9.unwrap(), r.figures.events.t10.unwrap());
    let at = |t: f64| (t / r.sample_interval()).round() as usize;
    assert!((r.history("piston.travel")[at(t9)] - 118.7e-3).abs() < 0.1e-3);
    assert!(r.history("bumper.force")[..at(t10) - 1].iter().all(|f| *f == 0.0));
    let speed = r.history("piston.velocity")[at(t10)] - r.history("tool.velocity")[at(t10)];
    assert!((speed - 1.65).abs() < 0.02, "{speed}");
}

#[test]
fn regression_depth_of_the_nail() {
    let s = &BASE.figures.summary;
    assert!((s.full_penetration.unwrap() - 21.175e-3).abs() < 5e-6);
    assert!((s.penetration - 86.6e-3).abs() < 0.05e-3);
}

#[test]
fn regression_speeds_before_and_after_the_impact() {
    let s = &BASE.figures.summary;
    assert!((s.mean_drive_speed.unwrap() - 21.9).abs() < 0.05);
    assert!((s.speed_before_impact.unwrap() - 21.8).abs() < 0.05);
    assert!((s.speed_after_impact.unwrap() - 20.6).abs() < 0.05);
}

#[test]
fn regression_speed_of_variant_b() {
    let mut p = n80cb();
    p.wood.resistance_scale = 0.78;
    // Both gaps 3 mm smaller.
    p.piston.rod_protrusion = 0.0152;
    let s = simulate(
        &p,
        &Settings {
            end: 0.03,
            ..Settings::default()
        },
    )
    .unwrap()
    .figures
    .summary;
    assert!(
        (s.mean_drive_speed.unwrap() - 24.6).abs() < 0.1,
        "{:?}",
        s.mean_drive_speed
    );
}

#[test]
fn regression_choked_part_of_the_intake() {
    let (p, r) = (n80cb(), &*BASE);
    let fraction = r.figures.summary.intake_choked_fraction.unwrap();
    assert!((fraction - 1.0 / 27.8).abs() < 2e-3, "{fraction}");
    let [lift, above, supply] = ["valve_lift", "above_piston.pressure", "supply.pressure"].map(|name| r.history(name));
    let choked = |n: &usize| above[*n] < p.ambient.critical_ratio() * supply[*n];
    let last = (0..r.len())
        .rfind(|n| lift[*n] > p.head_valve.intake_lap && choked(n))
        .unwrap();
    assert!((r.time(last) - r.figures.events.t4.unwrap() - 0.30e-3).abs() < 0.05e-3);
    let t4 = (r.figures.events.t4.unwrap() / r.sample_interval()) as usize;
    assert!((above[t4] / supply[t4] - 0.32).abs() < 0.01);
}

#[test]
fn regression_choked_part_of_the_blow_down() {
    let s = &BASE.figures.summary;
    assert!((s.exhaust_chamber_choked_fraction.unwrap() - 0.897).abs() < 2e-3);
    assert!((s.exhaust_choked_fraction.unwrap() - 0.607).abs() < 2e-3);
}

#[test]
fn regression_bounces_of_the_head_valve() {
    assert_eq!(
        (BASE.figures.summary.cap_contacts, BASE.figures.summary.seat_contacts),
        (8, 5)
    );
}

#[test]
fn regression_pressures_when_the_exhaust_opens() {
    let r = &*BASE;
    let t13 = (r.figures.events.t13.unwrap() / r.sample_interval()) as usize;
    let (p1, pr) = (
        r.history("above_piston.pressure")[t13],
        r.history("return_volume.pressure")[t13],
    );
    assert!(
        (p1 / 508e3 - 1.0).abs() < 5e-3 && (pr / p1 - 1.0).abs() < 5e-3,
        "{p1} {pr}"
    );
}

#[test]
fn regression_pressure_of_the_return_volume_after_the_return_stroke() {
    let r = &*BASE;
    let t16 = (r.figures.events.t16.unwrap() / r.sample_interval()) as usize;
    let (first, last) = (
        r.history("return_volume.pressure")[t16],
        r.history("return_volume.pressure")[r.len() - 1],
    );
    assert!((first / 182e3 - 1.0).abs() < 0.01, "{first}");
    // The leak and the warming by the walls all but cancel.
    assert!((last / first - 1.0).abs() < 5e-3, "{first} {last}");
}
