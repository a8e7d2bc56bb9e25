//! The test machine: check values of launch and drive, sensors, the loop from virtual tests to a law.
#![allow(clippy::unwrap_used)]

#[path = "../../../tests/common/base_design.rs"]
mod base_design;
mod loop_closed;

use nailnoise_dynamics::machine::{
    Launch, Machine, MachineError, Projectile, ScatterOfWood, Sensors, Shot, TOOL_MASS, TOOL_SPEED, TestBlock,
    TestNail, drive, launch, plan, speed_for_mean,
};
use nailnoise_penetration::ResistanceLaw;

use base_design::{group, number};
use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::positive;

/// A 12d nail in pine by the law of Eq. 4.59.
pub(crate) fn machine(mass: f64) -> Machine {
    Machine {
        projectile: Projectile {
            mass,
            mass_ahead_of_cell: 0.0,
        },
        launch: Launch {
            speed: 0.0,
            reservoir_pressure: 1e6,
            reservoir_volume: 5e-3,
            valve_area: 0.0,
            dead_volume: 1e-9,
            bore: 0.05,
            rod_diameter: 0.0,
            vent_area: 0.0,
            below_volume: 1e-3,
            stroke: 0.3,
            carrier_mass: 1.5,
            friction: 0.0,
            bumpers: 4,
            bumper_stiffness: 1e6,
            bumper_damping: 1e4,
            nail_distance: 0.301,
        },
        nail: TestNail {
            length: number("nail.length", positive(LENGTH)),
            diameter: 3.81e-3,
            mass: 7.814_58e-3,
        },
        wood: nailnoise_dynamics::Wood {
            unloading_stiffness: 1e7,
            ..group("wood")
        },
        block: TestBlock { thickness: 0.2 },
        sensors: Sensors {
            rate: 1e5,
            depth_noise: 0.0,
            force_noise: 0.0,
            cell_frequency: 0.0,
            cell_damping: 0.7,
        },
        scatter: ScatterOfWood { sigma_between: 0.0 },
        ambient: group("ambient"),
    }
}

/// Within half of the last digit printed.
fn near(found: f64, printed: f64, digit: f64) {
    assert!((found - printed).abs() <= 0.51 * digit, "{found} {printed}");
}

fn shot(speed: f64) -> Shot {
    Shot { speed, deviation: 0.0 }
}

#[test]
fn the_tools_piston_stops_in_pine_where_it_was_computed() {
    let drive = drive(&machine(0.131), None, shot(25.36), 1e-5).unwrap();
    near(drive.joint_speed, 23.932_36, 1e-5);
    near(drive.energy.impact, 2.371_43, 1e-5);
    near(1e3 * drive.stop_depth, 45.901_67, 1e-5);
    near(1e3 * drive.stop_time, 3.297_27, 1e-5);
    near(drive.stop_force, 1301.887, 1e-3);
    near(drive.stop_cell, 1228.597, 1e-3);
    near(drive.rebound, 1.103_83, 1e-5);
    assert!(drive.energy.balance < 1e-9, "{:e}", drive.energy.balance);
    assert_eq!(drive.head_speed, None);
}

#[test]
fn a_heavy_projectile_drives_the_head_into_the_wood() {
    let drive = drive(&machine(0.5), None, shot(22.0), 1e-5).unwrap();
    near(drive.head_speed.unwrap(), 9.600_90, 1e-5);
    near(1e3 * drive.stop_depth, 89.863_29, 1e-5);
    near(drive.stop_force, 4608.08, 1e-2);
    near(drive.rebound, 2.042_67, 1e-5);
    assert!(drive.energy.balance < 1e-9, "{:e}", drive.energy.balance);
}

#[test]
fn a_constant_force_stops_the_nail_after_the_time_of_uniform_deceleration() {
    let mut machine = machine(0.131);
    machine.wood.penetration_law = ResistanceLaw::Constant;
    machine.wood.penetration_force = 1000.0;
    let drive = drive(&machine, None, shot(25.36), 1e-5).unwrap();
    near(1e3 * drive.stop_depth, 39.807_77, 1e-5);
    near(1e3 * drive.stop_time, 3.326_69, 1e-5);
    let machine = Machine {
        block: TestBlock { thickness: 0.03 },
        ..machine
    };
    let error = nailnoise_dynamics::machine::drive(&machine, None, shot(25.36), 1e-5).unwrap_err();
    assert!(matches!(error, MachineError::ThroughBlock { .. }), "{error}");
}

/// Speed at the nail that the adiabatic work of a reservoir gives to carrier and projectile \[m/s\]; a volume that is
/// infinite stays at its pressure.
fn adiabatic(l: &Launch, mass: f64, gravity: f64) -> f64 {
    let swept = 0.25 * std::f64::consts::PI * l.bore * l.bore * l.stroke;
    let volume = l.reservoir_volume + l.dead_volume;
    let work = if volume.is_finite() {
        l.reservoir_pressure * volume / 0.4 * -(-0.4 * (swept / volume).ln_1p()).exp_m1()
    } else {
        l.reservoir_pressure * swept
    };
    let gained = work - 101_325.0 * swept + mass * gravity * l.stroke;
    (2.0 * gained / mass + 2.0 * gravity * (l.nail_distance - l.stroke)).sqrt()
}

#[test]
fn gas_throws_the_projectile_at_the_speed_of_its_work() {
    let machine = machine(0.131);
    let closed = |reservoir_volume: f64, reservoir_pressure: f64, nail_distance: f64| {
        let launch = Launch {
            reservoir_volume,
            reservoir_pressure,
            nail_distance,
            ..machine.launch.clone()
        };
        adiabatic(&launch, 1.631, machine.ambient.gravity)
    };
    near(closed(f64::INFINITY, 1e6, 0.3), 25.593_23, 1e-5);
    near(closed(5e-3, 1e6, 0.3), 24.506_14, 1e-5);
    near(closed(5e-3, 1.063_755e6, 0.3), 25.36, 2e-5);
    for (volume, pressure) in [(5e-3, 1e6), (5e-3, 1.063_755e6), (0.9, 1e6)] {
        let mut machine = machine.clone();
        (machine.launch.reservoir_volume, machine.launch.reservoir_pressure) = (volume, pressure);
        let found = launch(&machine).unwrap();
        let exact = closed(volume, pressure, machine.launch.nail_distance);
        assert!(
            (found.speed / exact - 1.0).abs() < 1e-6,
            "{volume} m3: {} {exact}",
            found.speed
        );
        assert!(found.balance < 1e-9, "{:e}", found.balance);
    }
}

#[test]
fn a_valve_a_rod_and_a_shut_cylinder_slow_the_launch() {
    let base = launch(&machine(0.131)).unwrap().speed;
    let with = |change: &dyn Fn(&mut Launch)| {
        let mut machine = machine(0.131);
        machine.launch.dead_volume = 1e-4;
        change(&mut machine.launch);
        launch(&machine).unwrap()
    };
    for (name, slower) in [
        ("valve", with(&|l| l.valve_area = 3e-4)),
        ("vent", with(&|l| (l.rod_diameter, l.vent_area) = (0.02, 1e-4))),
        ("friction", with(&|l| l.friction = 100.0)),
    ] {
        assert!(slower.speed < base - 0.1, "{name} {}", slower.speed);
        assert!(slower.balance < 1e-8, "{name} {:e}", slower.balance);
    }
    let mut fitted = machine(0.131);
    fitted.wood.penetration_law = ResistanceLaw::Fitted;
    assert_eq!(launch(&fitted).unwrap().speed, base);
    let mut near = machine(0.131);
    near.launch.nail_distance = 0.29;
    assert!(matches!(launch(&near).unwrap_err(), MachineError::StillPushing { .. }));
    let mut empty = machine(0.131);
    empty.launch.reservoir_pressure = 101_325.0;
    empty.launch.friction = 100.0;
    assert!(matches!(launch(&empty).unwrap_err(), MachineError::NoLaunch { .. }));
}

/// A force of less than twice the weight does not throw the projectile back.
#[test]
fn a_projectile_that_the_wood_hardly_pushes_stays_on_the_nail() {
    let mut machine = machine(0.131);
    machine.wood.penetration_law = ResistanceLaw::Constant;
    machine.wood.penetration_force = 2.5;
    let drive = drive(&machine, None, shot(1.0), 1e-5).unwrap();
    let joint = 0.131 + machine.nail.mass;
    let depth = drive.joint_speed * drive.joint_speed / (2.0 * (2.5 / joint - machine.ambient.gravity));
    assert!(
        (drive.stop_depth / depth - 1.0).abs() < 1e-9,
        "{} {depth}",
        drive.stop_depth
    );
    assert_eq!(drive.rebound, 0.0);
    assert!(drive.energy.balance < 1e-9, "{:e}", drive.energy.balance);
}

#[test]
fn the_plan_for_a_12d_nail_is_the_published_one() {
    let energy = 0.5 * TOOL_MASS * TOOL_SPEED * TOOL_SPEED;
    let rows = plan(energy, &[0.131, 0.2, 0.3, 0.4, 0.5]).unwrap();
    let published = [
        [20.36, 25.36, 30.36, 27.15, 42.12, 60.37],
        [15.52, 20.52, 25.52, 24.10, 42.12, 65.15],
        [11.76, 16.76, 21.76, 20.74, 42.12, 71.01],
        [9.51, 14.51, 19.51, 18.10, 42.12, 76.15],
        [7.98, 12.98, 17.98, 15.92, 42.12, 80.83],
    ];
    for (row, published) in rows.iter().zip(published) {
        for (found, printed) in row.speeds.iter().chain(&row.energies).zip(published) {
            near(*found, printed, 0.01);
        }
    }
    assert!(plan(1.0, &[0.131]).is_err() && plan(f64::NAN, &[0.131]).is_err());
}

#[test]
fn a_mean_speed_asks_for_a_faster_impact() {
    let found = speed_for_mean(&machine(0.131), None, 25.36).unwrap().unwrap();
    near(found, 40.21, 0.01);
    // Slower on the mean it does not reach full depth.
    assert_eq!(speed_for_mean(&machine(0.131), None, 20.36).unwrap(), None);
}
