//! Options beyond the source: they are off by default and obey the balances.

use nailnoise_dynamics::{Crossing, CycleError, CycleRecord, Geometry, Outcome, Parameters, Settings, simulate};

use crate::common::n80cb;
use crate::{BASE, internal_forces_cancel, run};

fn with_hand(mass: f64) -> Parameters {
    let mut p = n80cb();
    p.hand.mass = mass;
    p
}

#[test]
fn options_are_off_in_the_base_design() {
    let (p, r) = (n80cb(), &*BASE);
    assert_eq!(
        (
            p.hand.mass,
            p.nail.magazine_friction,
            p.exhaust.thrust_share,
            p.trigger.release_after
        ),
        (0.0, 0.0, 0.0, 0.0)
    );
    for channel in ["hand.force", "nail.guide_force", "thrust.force"] {
        assert_eq!(r.history(channel).len(), r.len(), "{channel}");
    }
    assert!(r.history("hand.force").iter().all(|f| *f == p.hand.force));
    assert!(
        r.history("nail.guide_force")
            .iter()
            .chain(r.history("thrust.force"))
            .all(|f| *f == 0.0)
    );
}

#[test]
fn a_hand_with_mass_lowers_the_rise_of_the_tool() {
    let p = with_hand(1.5);
    let r = run(&p);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
    internal_forces_cancel(&p, &r);
    // In equilibrium before the shot the hand pushes with its constant force.
    assert!((r.history("hand.force")[0] - p.hand.force).abs() < 1e-9);
    let rise = |r: &CycleRecord| {
        let position = r.history("tool.position");
        position[0] - position.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(rise(&r) < 0.9 * rise(&BASE), "{} {}", rise(&r), rise(&BASE));
    assert!(r.figures.energy.hand_damping > 0.1);
}

#[test]
fn a_hand_on_a_stiff_spring_is_part_of_the_tool() {
    // A rigidly held mass makes the tool heavier, but gravity does not act on it.
    let mut held = with_hand(0.5);
    held.hand.stiffness = 1e9;
    held.hand.damping = 2e3;
    let mut heavy = n80cb();
    heavy.tool.mass += 0.5;
    heavy.hand.force -= 0.5 * heavy.ambient.gravity;
    // The nose's damping is a ratio of the tool's mass.
    heavy.contacts.nose_damping_ratio *= (4.1f64 / 4.6).sqrt();
    let (a, b) = (
        run(&held).figures.events.to_array(),
        run(&heavy).figures.events.to_array(),
    );
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        let apart = (a.unwrap() - b.unwrap()).abs();
        assert!(apart < if i == 11 || i == 18 { 1e-4 } else { 2e-5 }, "t{i}: {apart} s");
    }
}

/// A tool that is pressed on so hard that it does not rise by its long guard travel.
fn low_recoil() -> Parameters {
    let mut p = n80cb();
    p.contacts.guard_travel = 30e-3;
    p.hand.force = 300.0;
    p
}

#[test]
fn a_tool_that_hardly_recoils_ends_its_cycle_when_the_operator_lets_go() {
    let never = run(&low_recoil());
    assert_eq!(never.figures.outcome, Outcome::DoesNotRelease);
    assert_eq!((never.figures.events.t12, never.figures.events.t13), (None, None));
    let mut p = low_recoil();
    p.trigger.release_after = 0.035;
    let r = run(&p);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
    assert_eq!(
        (r.figures.outcome, r.figures.events.t12),
        (Outcome::Drives, Some(0.035))
    );
    // The channel carries the release to the head valve with the speed of sound, before the exhaust can open.
    let fills = r
        .figures
        .log
        .iter()
        .find(|entry| entry.crossing == Crossing::Fill)
        .unwrap();
    assert!(
        (fills.time - 0.035 - Geometry::new(&p).channel_delay).abs() < 1e-12,
        "{}",
        fills.time
    );
    assert!(
        r.figures.events.t13.unwrap() > fills.time && r.figures.events.t18.unwrap() > r.figures.events.t13.unwrap()
    );
    assert!(r.figures.summary.exhaust_mass > 0.5 * BASE.figures.summary.exhaust_mass);
    // Nothing differs before the release.
    let until = |r: &CycleRecord| r.history("piston.position")[..(0.034 / r.sample_interval()) as usize].to_vec();
    let apart = until(&r)
        .iter()
        .zip(until(&never))
        .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-7, "{apart} m");
}

#[test]
fn a_trigger_that_the_rising_tool_has_released_is_not_released_again() {
    let mut p = n80cb();
    p.trigger.release_after = 0.06;
    let r = run(&p);
    assert!(BASE.figures.events.t12.unwrap() < 0.06);
    assert_eq!(r.figures.events, BASE.figures.events);
    let releases = r
        .figures
        .log
        .iter()
        .filter(|entry| entry.crossing == Crossing::Trigger && !entry.is_rising());
    assert_eq!(releases.count(), 1);
}

#[test]
fn an_exhaust_that_has_not_opened_when_the_record_ends_is_an_outcome() {
    let mut p = low_recoil();
    p.trigger.release_after = 0.035;
    let settings = Settings {
        end: 0.0351,
        ..Settings::default()
    };
    let r = simulate(&p, &settings).unwrap();
    assert_eq!(r.figures.outcome, Outcome::DoesNotExhaust);
}

#[test]
fn a_light_hand_is_a_force() {
    let mut p = with_hand(1e-3);
    p.hand.damping = 1.0;
    let (a, b) = (run(&p).figures.events.to_array(), BASE.figures.events.to_array());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        let apart = (a.unwrap() - b.unwrap()).abs();
        assert!(apart < 1e-4, "t{i}: {apart} s");
    }
}

#[test]
fn friction_in_the_magazine_slows_the_nail() {
    let mut p = n80cb();
    p.nail.magazine_friction = 20.0;
    let r = run(&p);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
    internal_forces_cancel(&p, &r);
    assert!(r.figures.summary.mean_drive_speed < BASE.figures.summary.mean_drive_speed);
    // The constant force over the travel with the nail.
    let at = |t: f64| r.history("piston.travel")[(t / r.sample_interval()).round() as usize];
    let travel = at(r.figures.events.t9.unwrap()) - at(r.figures.events.t5.unwrap());
    let friction = r.figures.energy.magazine_friction;
    assert!(
        (friction / (20.0 * travel) - 1.0).abs() < 5e-3,
        "{friction} J over {travel} m"
    );
}

#[test]
fn friction_in_the_magazine_acts_only_while_the_rod_drives_the_nail() {
    let mut p = n80cb();
    p.nail.magazine_friction = 20.0;
    let r = run(&p);
    let driven = |i: usize| r.history("piston.moving_mass")[i] > p.piston.mass;
    assert!((0..r.len()).all(|i| driven(i) || r.history("nail.guide_force")[i] == 0.0));
}

#[test]
fn the_thrust_of_the_exhaust_is_that_of_an_ideal_nozzle() {
    let mut p = n80cb();
    p.exhaust.thrust_share = -0.5;
    let r = run(&p);
    assert!(r.is_certified(), "{:?}", r.figures.checks);
    internal_forces_cancel(&p, &r);
    let g: f64 = p.ambient.heat_capacity_ratio;
    let (rg, pa) = (p.ambient.gas_constant, p.ambient.pressure);
    let area = p.exhaust.coefficient(&p.chambers) * Geometry::new(&p).exhaust_area;
    let critical = (2.0 / (g + 1.0)).powf(g / (g - 1.0));
    let mut tried = [0; 2];
    let [plenum, flow] = ["exhaust_plenum_pressure", "exhaust.mass_flow"].map(|name| r.history(name));
    for i in (0..r.len()).filter(|i| plenum[*i] > 1.01 * pa && flow[*i] > 0.0) {
        // mdot U + (P_e - P_a) A, from the recorded flow.
        let (pm, t) = (plenum[i], r.history("exhaust_stagnation_temperature")[i]);
        let exit = pa.max(critical * pm);
        let speed = (2.0 * g / (g - 1.0) * rg * t * (1.0 - (exit / pm).powf((g - 1.0) / g))).sqrt();
        let thrust = flow[i] * speed + (exit - pa) * area;
        let found = -2.0 * r.history("thrust.force")[i];
        assert!((found / thrust - 1.0).abs() < 1e-9, "sample {i}: {found} N, {thrust} N");
        tried[usize::from(exit > pa)] += 1;
    }
    assert!(tried.iter().all(|n| *n > 100), "{tried:?}");
}

#[test]
fn upward_thrust_lifts_the_tool() {
    let mut p = n80cb();
    p.exhaust.thrust_share = -0.5;
    let r = run(&p);
    let lifted = |r: &CycleRecord| r.history("tool.position")[r.len() - 1];
    assert!(lifted(&r) < lifted(&BASE));
}

#[test]
fn an_option_out_of_range_is_refused_by_name() {
    let refused = |change: fn(&mut Parameters)| {
        let mut p = n80cb();
        change(&mut p);
        match simulate(&p, &Settings::default()) {
            Err(CycleError::Value { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(|p| p.exhaust.thrust_share = 1.2), "exhaust.thrust_share");
    assert_eq!(refused(|p| p.hand.mass = f64::NAN), "hand.mass");
    assert_eq!(
        refused(|p| {
            p.hand.mass = 1.0;
            p.hand.stiffness = 0.0;
        }),
        "hand.stiffness"
    );
    assert_eq!(refused(|p| p.nail.magazine_friction = -1.0), "nail.magazine_friction");
    assert_eq!(refused(|p| p.trigger.release_after = -0.01), "trigger.release_after");
}

/// Until its tip meets the wood, the nail moves as over a plain block; the tip then has `groove` farther to go.
#[test]
fn a_nail_in_a_groove_meets_the_wood_later_by_the_depth_of_the_groove() {
    let mut p = n80cb();
    p.workpiece.groove = 6.35e-3;
    let r = run(&p);
    let travel = |r: &CycleRecord| {
        let at = r.figures.events.to_array()[6].unwrap() / r.sample_interval();
        let (before, part) = (at as usize, at.fract());
        // The tool rises during the drive: in the frame of the wood the piston has moved less than in that of the tool.
        let names = ["piston.travel", "tool.position", "workpiece.position"];
        let [piston, tool, workpiece] = names.map(|name| r.history(name));
        let down = |k: usize| piston[k] + tool[k] - workpiece[k];
        down(before) + part * (down(before + 1) - down(before))
    };
    let farther = travel(&r) - travel(&BASE);
    assert!((farther - 6.35e-3).abs() < 1e-5, "{farther} m");
    // The head stops on the bottom of the groove, up to the wood's give under it.
    assert!(
        r.history("nail.deepest")
            .iter()
            .all(|depth| *depth < p.nail.length + p.nail.overdrive_limit)
    );
    assert!(r.is_certified(), "{:?}", r.figures.checks);
}

#[test]
fn a_nail_longer_than_the_wood_below_a_groove_is_refused() {
    let mut p = n80cb();
    p.workpiece.groove = 15e-3;
    let left = p.workpiece.thickness - p.workpiece.groove;
    let error = simulate(&p, &Settings::default()).unwrap_err();
    assert!(
        matches!(error, CycleError::NailLongerThanBlock { thickness, .. } if thickness == left),
        "{error}"
    );
}
