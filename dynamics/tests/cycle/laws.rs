//! Laws that are true of every design, and designs that are refused.

use nailnoise_dynamics::{CycleError, CycleRecord, Geometry, Outcome, Parameters, Settings, SupportDamping, simulate};

use crate::common::n80cb;
use crate::{BASE, run};

#[test]
fn derived_quantities_equal_the_reference_set() {
    let g = Geometry::new(&n80cb());
    let close = |name, value: f64, expected: f64, part: f64| {
        assert!(
            (value / expected - 1.0).abs() < part,
            "{name}: {value}, expected {expected}"
        );
    };
    close("A_1", g.piston_area, 0.002_827_433_388_230_813_7, 1e-12);
    close("A_r", g.rod_area, 3.318_307_240_354_219e-5, 1e-12);
    close("A_2", g.ring_area, 0.002_794_250_315_827_271_3, 1e-12);
    close("A_h1", g.valve_control_area, 0.001_409_546_229_867_766_6, 1e-12);
    close("A_h2", g.valve_supply_area, 0.000_235_375_975_588_581_3, 1e-12);
    close("A_ma", g.exhaust_area, 1.4e-4, 3e-4);
    close("M_n", g.nail_mass, 0.007_814_578_377_566_488, 1e-12);
    close("M_w", g.workpiece_mass, 2.533_531_861_958_4, 1e-12);
    close("tau", g.channel_delay, 0.000_291_545, 1e-3);
    close("phi_in", g.attenuation_fill, 0.9998, 1e-4);
    close("phi_out", g.attenuation_vent, 0.998, 1e-4);
    close("A_1 - A_r", g.piston_area - g.rod_area, g.ring_area, 1e-15);
}

#[test]
fn more_supply_pressure_drives_faster_and_exhausts_more() {
    let mut p = n80cb();
    p.supply.pressure *= 1.1;
    let (low, high) = (&*BASE, run(&p));
    let drive = |r: &CycleRecord| r.figures.events.t9.unwrap() - r.figures.events.t6.unwrap();
    assert!(drive(&high) < drive(low));
    assert!(high.figures.summary.exhaust_mass > low.figures.summary.exhaust_mass);
    // The nail is overdriven, which breaks no balance.
    let failed: Vec<&str> = high.figures.checks.iter().filter(|c| !c.ok).map(|c| &*c.name).collect();
    assert_eq!(failed, ["head of the nail below the surface [m]"]);
}

#[test]
fn a_shorter_and_thinner_nail_waits_with_its_head_at_the_same_height_and_is_overdriven() {
    let mut p = n80cb();
    (p.nail.length, p.nail.diameter) = (0.065, 0.0029);
    let (base, geometry) = (Geometry::new(&n80cb()), Geometry::new(&p));
    assert!((geometry.head_gap - base.head_gap).abs() < 1e-12);
    assert!((geometry.tip_gap - base.tip_gap - (0.08255 - 0.065)).abs() < 1e-12);
    let r = run(&p);
    assert_eq!(r.figures.outcome, Outcome::Overdriven);
    // The bumper stops the piston: the head is at most as deep as the rod protrudes, and its overtravel on the bumper.
    let overtravel = r.history("piston.travel").iter().fold(0.0, |a: f64, b| a.max(*b)) - p.piston.stroke;
    assert!(r.figures.summary.head_depth > p.nail.overdrive_limit);
    assert!(r.figures.summary.head_depth < p.piston.rod_protrusion + overtravel);
}

#[test]
fn b13_without_air_nothing_moves() {
    let mut p = n80cb();
    p.supply.pressure = p.ambient.pressure;
    let r = simulate(
        &p,
        &Settings {
            end: 0.05,
            ..Settings::default()
        },
    )
    .unwrap();
    assert_eq!(r.figures.outcome, Outcome::DoesNotOpen);
    for body in ["piston", "head_valve", "tool", "workpiece"] {
        let position = r.history(&format!("{body}.position"));
        assert!(position.iter().all(|y| (y - position[0]).abs() < 5e-6));
    }
    assert!(r.is_certified(), "{:?}", r.figures.checks);
}

#[test]
fn every_outcome_occurs() {
    assert_eq!(BASE.figures.outcome, Outcome::Drives);
    let mut soft = n80cb();
    soft.wood.hardness_modulus *= 0.9;
    assert_eq!(run(&soft).figures.outcome, Outcome::Overdriven);
    soft.nail.overdrive_limit = 0.02;
    assert_eq!(run(&soft).figures.outcome, Outcome::StrikesBumper);
    let mut hard = n80cb();
    hard.wood.hardness_modulus *= 1.3;
    assert_eq!(run(&hard).figures.outcome, Outcome::Underdriven);
    let mut stuck = n80cb();
    stuck.head_valve.seat_diameter = 0.0655;
    assert_eq!(run(&stuck).figures.outcome, Outcome::DoesNotOpen);
    let mut heavy = n80cb();
    heavy.hand.force = 1500.0;
    heavy.nail.overdrive_limit = 0.05;
    assert_eq!(run(&heavy).figures.outcome, Outcome::DoesNotRelease);
}

#[test]
fn moderate_changes_keep_the_order_of_the_events_and_the_drive_speed() {
    let changes: [fn(&mut Parameters); 8] = [
        |p| p.chambers.supply_volume = 0.9e-3,
        |p| p.chambers.return_volume = 0.24e-3,
        |p| p.tool.mass = 3.7,
        |p| p.hand.force = 90.0,
        |p| p.chambers.wall_heat_transfer = 0.0,
        |p| p.wood.unloading_stiffness = 3e7,
        |p| p.contacts.nose_stiffness = 1e7,
        |p| p.ambient.pressure = 98e3,
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut p = n80cb();
        change(&mut p);
        let r = run(&p);
        assert_eq!(r.figures.outcome, Outcome::Drives, "{i}");
        let speed = r.figures.summary.mean_drive_speed.unwrap();
        assert!((20.0..22.3).contains(&speed), "{i}: {speed}");
        let times: Vec<f64> = r.figures.events.to_array().into_iter().flatten().collect();
        assert!(times.windows(2).all(|w| w[0] <= w[1]), "{i}: {times:?}");
        assert!(r.is_certified(), "{i}: {:?}", r.figures.checks);
    }
}

#[test]
fn a_sandbox_support_is_given_by_stiffness_and_dashpot() {
    let mut p = n80cb();
    p.support.stiffness = 1.76e7;
    p.support.damping = SupportDamping::Coefficient(2.8e5 * 0.4064 * 0.1524);
    let r = run(&p);
    assert_eq!(r.figures.outcome, Outcome::Drives);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
}

fn refused(change: impl Fn(&mut Parameters)) -> CycleError {
    let mut p = n80cb();
    change(&mut p);
    simulate(&p, &Settings::default()).unwrap_err()
}

#[test]
fn a_design_outside_the_validity_of_the_model_is_refused_with_its_cause() {
    assert!(matches!(
        refused(|p| p.head_valve.lift = 0.005),
        CycleError::SpringRange { .. }
    ));
    assert!(matches!(
        refused(|p| p.head_valve.exhaust_lap = 0.0016),
        CycleError::LapOverlap { .. }
    ));
    assert!(matches!(refused(|p| p.hand.force = 0.0), CycleError::NotSeated { .. }));
    assert!(matches!(
        refused(|p| p.nail.length = 0.1),
        CycleError::NailLongerThanBlock { .. }
    ));
    assert!(matches!(
        refused(|p| p.nail.feed_height = 0.08),
        CycleError::NailBelowNose { .. }
    ));
    assert!(matches!(
        refused(|p| p.piston.rod_protrusion = 0.04),
        CycleError::NailAboveRod { .. }
    ));
    assert!(matches!(
        refused(|p| p.piston.rod_diameter = 0.07),
        CycleError::DiameterOrder { .. }
    ));
}

#[test]
fn a_value_out_of_range_is_refused_by_name() {
    let negative = refused(|p| p.piston.mass = -0.131);
    assert_eq!(
        negative.to_string(),
        "piston.mass = -0.131 must be from 1e-5 to 1000 kg"
    );
    assert!(
        matches!(refused(|p| p.chambers.leak_area = f64::NAN), CycleError::Value { name, .. }
            if name == "chambers.leak_area")
    );
    assert!(
        matches!(refused(|p| p.supply.pressure = 9e4), CycleError::Value { name, .. } if name == "supply.pressure")
    );
}

#[test]
fn a_piston_without_resistance_is_a_dry_fire() {
    let error = refused(|p| {
        p.wood.resistance_scale = 0.0;
        p.wood.head_stiffness_scale = 1e-6;
        p.chambers.below_piston = 1e-6;
        p.contacts.bumper_stiffness = 1e5;
    });
    assert!(matches!(error, CycleError::DryFire { .. }), "{error}");
}
