//! The event log: complete, in order, and the only source of t0..t18.

use std::collections::HashMap;

use nailnoise_dynamics::{Crossing, CycleError, Direction, LogEntry, Parameters, Settings, simulate};

use crate::common::n80cb;
use crate::{BASE, run};

fn of(crossing: Crossing) -> impl Iterator<Item = &'static LogEntry> {
    BASE.figures.log.iter().filter(move |e| e.crossing == crossing)
}

fn first(crossing: Crossing, direction: Direction, after: f64) -> Option<f64> {
    of(crossing)
        .find(|e| e.direction == direction && e.time >= after)
        .map(|e| e.time)
}

#[test]
fn entries_are_in_order_and_alternate() {
    let log = &BASE.figures.log;
    assert!(log.windows(2).all(|pair| pair[0].time <= pair[1].time));
    let mut last = HashMap::new();
    for entry in log {
        if let Some(before) = last.insert(entry.crossing, entry.direction) {
            assert_ne!(before, entry.direction, "{entry:?}");
        }
    }
}

#[test]
fn every_event_is_a_logged_crossing() {
    use Crossing as C;
    use Direction::{Falling, Rising};
    let e = &BASE.figures.events;
    let (t6, t9, t12) = (e.t6.unwrap(), e.t9.unwrap(), e.t12.unwrap());
    let expected = [
        (e.t0, first(C::Trigger, Rising, 0.0)),
        (e.t1, first(C::FirstLift, Rising, 0.0)),
        (e.t2, first(C::ControlPressure, Falling, 0.0)),
        (e.t3, first(C::Intake, Rising, 0.0)),
        (e.t4, first(C::FirstTravel, Rising, 0.0)),
        (e.t5, first(C::NailDriven, Rising, 0.0)),
        (e.t6, first(C::TipInWood, Rising, 0.0)),
        (e.t7, first(C::PositionMark, Rising, 0.0)),
        (e.t8, first(C::CheckHoles, Rising, 0.0)),
        (e.t9, first(C::Advance, Falling, t6)),
        (e.t10, first(C::BumperContact, Rising, t9)),
        (e.t12, first(C::Trigger, Falling, 0.0)),
        (e.t13, first(C::ExhaustShut, Falling, t12)),
        (e.t15, first(C::PositionMark, Falling, t9)),
        (e.t16, first(C::StopperContact, Rising, t12)),
        (e.t17, first(C::ChamberPressure, Falling, e.t13.unwrap() + 1e-3)),
    ];
    for (event, logged) in expected {
        let (event, logged) = (event.unwrap(), logged.unwrap());
        assert!((event - logged).abs() < 1e-9, "{event} s, logged {logged} s");
    }
    // Rest, after which the piston stays slow: entries too.
    for t in [e.t11, e.t18] {
        assert!(
            of(C::RestSpeed).any(|c| Some(c.time) == t && c.direction == Falling),
            "{t:?}"
        );
    }
    assert!(of(C::StillSpeed).any(|c| Some(c.time) == e.t14 && c.direction == Rising));
}

#[test]
fn the_trigger_reaches_the_valve_one_delay_later() {
    let delay = nailnoise_dynamics::Geometry::new(&n80cb()).channel_delay;
    let e = &BASE.figures.events;
    let close = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-12, "{a:?} {b}");
    close(first(Crossing::Vent, Direction::Rising, 0.0), delay);
    close(first(Crossing::Vent, Direction::Falling, 0.0), e.t12.unwrap() + delay);
    close(first(Crossing::Fill, Direction::Rising, 0.0), e.t12.unwrap() + delay);
}

#[test]
fn logged_states_lie_between_the_samples_of_the_record() {
    let r = &*BASE;
    for entry in &r.figures.log {
        let i = (entry.time / r.sample_interval()).floor() as usize;
        // Samples on either side bound smooth quantities to within their change over one interval.
        let Some(j) = Some(i + 1).filter(|j| *j < r.len()) else {
            continue;
        };
        let between = |name: &str, column: &[f64], value: f64, slack: f64| {
            let (low, high) = (column[i].min(column[j]), column[i].max(column[j]));
            assert!(
                value > low - slack && value < high + slack,
                "{entry:?} {name}: {low} {value} {high}"
            );
        };
        between("travel", r.history("piston.travel"), entry.state.piston_travel, 1e-7);
        between("lift", r.history("valve_lift"), entry.state.valve_lift, 1e-6);
        between("P_1", r.history("above_piston.pressure"), entry.state.pressures[0], 5.0);
        between("P_ext", r.history("supply.pressure"), entry.state.pressures[4], 5.0);
    }
}

#[test]
fn the_log_and_the_summary_count_the_same_contacts() {
    let count = |crossing| of(crossing).filter(|e| e.is_rising()).count();
    assert_eq!(count(Crossing::CapContact), BASE.figures.summary.cap_contacts);
    assert_eq!(count(Crossing::SeatContact), BASE.figures.summary.seat_contacts);
    assert_eq!((count(Crossing::NailDriven), count(Crossing::NoseContact)), (1, 0));
}

#[test]
fn contact_forces_begin_and_end_at_the_logged_times() {
    let r = &*BASE;
    for (crossing, force) in [
        (Crossing::BumperContact, r.history("bumper.force")),
        (Crossing::StopperContact, r.history("stopper.force")),
        (Crossing::CapContact, r.history("cap.force")),
        (Crossing::SeatContact, r.history("seat.force")),
    ] {
        for entry in of(crossing) {
            let i = (entry.time / r.sample_interval()) as usize;
            let (before, after) = (force[i - 1].abs() > 0.0, force[i + 2].abs() > 0.0);
            assert_eq!((before, after), (!entry.is_rising(), entry.is_rising()), "{entry:?}");
        }
    }
}

#[test]
fn the_exhaust_is_choked_between_the_logged_times() {
    let r = &*BASE;
    let (from, to) = (
        first(Crossing::HolesChoked, Direction::Rising, 0.0).unwrap(),
        first(Crossing::HolesChoked, Direction::Falling, 0.0).unwrap(),
    );
    let choked = &r.record.opening("exhaust").unwrap().choked;
    assert_eq!(choked.len(), r.len());
    for (i, choked) in choked.iter().enumerate() {
        assert_eq!(*choked, r.time(i) >= from && r.time(i) < to, "{i}");
    }
    let share = (to - from) / (r.figures.events.t17.unwrap() - r.figures.events.t13.unwrap());
    assert!((share - r.figures.summary.exhaust_choked_fraction.unwrap()).abs() < 5e-4);
}

#[test]
fn an_entry_is_described_in_words() {
    let e = of(Crossing::BumperContact).next().unwrap();
    assert_eq!(e.crossing.describe(e.direction), "the piston meets the bumper");
}

#[test]
fn an_entry_serialises() {
    let e = of(Crossing::BumperContact).next().unwrap();
    let json = serde_json::to_value(e).unwrap();
    assert_eq!(
        (&json["crossing"], &json["direction"]),
        (&"bumper_contact".into(), &"rising".into())
    );
    assert!(json["state"]["piston_travel"].as_f64().unwrap() > 0.12);
}

#[test]
fn chatter_ends_the_run_with_an_error_that_names_the_contact() {
    let contact = |change: fn(&mut Parameters)| {
        let mut p = n80cb();
        change(&mut p);
        match simulate(&p, &Settings::default()) {
            Err(CycleError::Chatter {
                contact, count, window, ..
            }) => {
                assert!(count > 1000 && window <= 1e-3);
                contact
            }
            other => panic!("{:?}", other.map(|r| r.figures.outcome)),
        }
    };
    // A seat as hard as no solid is and without damping: bounces follow each other within nanoseconds.
    let seat = |p: &mut Parameters| {
        p.contacts.seat_stiffness = 1e14;
        p.contacts.valve_damping_ratio = 0.0;
    };
    assert_eq!(contact(seat), "the head valve's seat");
}

#[test]
fn the_printed_cap_stiffness_does_not_chatter_and_gives_the_force_of_a_damped_bounce() {
    // The valve vibrates on the cap at 217 kHz. The peak force of a damped bounce is F = v sqrt(k m) exp(-zeta
    // phi/sqrt(1 - zeta^2)) with tan phi = sqrt(1 - zeta^2) (1 - 4 zeta^2)/(zeta (3 - 4 zeta^2)).
    let mut printed = n80cb();
    printed.contacts.cap_stiffness = 1.1e11;
    let r = run(&printed);
    let hit = r
        .figures
        .log
        .iter()
        .find(|e| e.crossing == Crossing::CapContact)
        .unwrap();
    let zeta = printed.contacts.valve_damping_ratio;
    let root = (1.0 - zeta * zeta).sqrt();
    let phase = (root * (1.0 - 4.0 * zeta * zeta) / (zeta * (3.0 - 4.0 * zeta * zeta))).atan();
    let peak = hit.state.valve_velocity * (1.1e11 * printed.head_valve.mass).sqrt() * (-zeta * phase / root).exp();
    let found = r.figures.summary.peak_cap_force;
    assert!(
        r.is_certified() && (found / peak - 1.0).abs() < 0.02,
        "{found} N, {peak} N"
    );
}

#[test]
fn the_number_of_bounces_does_not_depend_on_the_stiffness_of_a_hard_cap() {
    // The valve's friction ends the bounces on an undamped cap, however short they are.
    let closings = |stiffness: f64| {
        let mut p = n80cb();
        p.contacts.cap_stiffness = stiffness;
        p.contacts.valve_damping_ratio = 0.0;
        let r = run(&p);
        assert!(r.is_certified());
        (r.figures.summary.cap_contacts, r.figures.summary.seat_contacts)
    };
    let hard = closings(1e14);
    assert_eq!([1e16, 1e18, 1e20].map(closings), [hard; 3]);
}

#[test]
fn a_contact_that_grazes_opens_once() {
    // The damped cap lets the valve go just as the pressure presses it shut: the push touches zero and turns. Seven of
    // a thousand designs drawn from the ranges ended here in chatter of the last digits.
    let mut p = n80cb();
    p.contacts.cap_stiffness = 1.1e11 * 23.0 / 24.0;
    p.contacts.valve_damping_ratio = 0.28;
    let closings = |tolerance: f64| {
        let settings = Settings {
            relative_tolerance: tolerance,
            end: 0.02,
            ..Settings::default()
        };
        simulate(&p, &settings).unwrap().figures.summary.cap_contacts
    };
    let counts = [1e-7, 1e-8, 1e-9].map(closings);
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");
}
