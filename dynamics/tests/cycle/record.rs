//! The record of a nailer is that of its assembly.

use nailnoise_dynamics::network::{Numerics, Record, simulate};
use nailnoise_dynamics::{Geometry, Outcome, Settings, simulate_figures, simulate_loads};

use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;
use crate::{BASE, run};

fn assembly_record() -> Record {
    let settings = Settings::default();
    let assembly = n80cb_assembly(&n80cb(), settings.end, settings.tail);
    let numerics = Numerics {
        sample_interval: Some(settings.sample_interval),
        relative_tolerance: settings.relative_tolerance,
        ..Numerics::default()
    };
    simulate(&assembly, &numerics).unwrap()
}

#[test]
fn histories_are_channels_and_events_have_their_times() {
    let (r, of) = (&*BASE, assembly_record());
    for channel in [
        "piston.velocity",
        "head_valve.position",
        "tool.acceleration",
        "workpiece.position",
        "valve_lift",
        "nail.tip",
        "above_piston.pressure",
        "supply.temperature",
        "below_piston.mass",
        "nail.force",
        "cap.force",
        "hand.force",
        "intake.mass_flow",
        "exhaust.mass_flow",
        "vent.mass_flow",
    ] {
        let history = r.history(channel);
        let found = of.get(channel).unwrap();
        let size = history.iter().fold(0.0f64, |size, value| size.max(value.abs()));
        assert!(size > 0.0 && found.len() == history.len(), "{channel}");
        let apart = found.iter().zip(history).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 1e-9 * size, "{channel}");
    }
    for (i, time) in r.figures.events.to_array().into_iter().enumerate() {
        let apart = time.unwrap() - of.event(&format!("t{i}")).unwrap();
        assert!(apart.abs() < 1e-12, "t{i}: {apart} s");
    }
    let names: Vec<String> = (0..19).map(|number| format!("t{number}")).collect();
    assert!(r.record.events.iter().map(|event| &event.name).eq(&names));
    assert_eq!(of.outcome.as_deref(), Some(Outcome::Drives.name()));
}

#[test]
fn gas_forces_are_pressures_on_the_areas_of_the_geometry() {
    let (p, r) = (n80cb(), &*BASE);
    let (g, gas) = (Geometry::new(&p), r.history("piston_gas_force"));
    for n in (0..r.len()).step_by(100) {
        let gauge = |volume: &str| r.history(&format!("{volume}.pressure"))[n] - p.ambient.pressure;
        let piston = gauge("above_piston") * g.piston_area - gauge("below_piston") * g.ring_area;
        assert!((gas[n] - piston).abs() < 1e-9, "{n}: {} {piston} N", gas[n]);
    }
}

#[test]
fn figures_are_the_same_without_histories() {
    for p in [n80cb(), n80cb().published_all()] {
        let (figures, work) = simulate_figures(&p, &Settings::default()).unwrap();
        let whole = run(&p);
        assert_eq!((figures, work.steps), (whole.figures, whole.record.work.steps));
    }
}

/// Forces on the surfaces of the housing, from gauge pressures on the areas of the geometry and forces of the stops.
#[test]
fn loads_on_the_housing_are_gas_on_its_surfaces_and_forces_of_its_stops() {
    let (p, r) = (n80cb(), &*BASE);
    let g = Geometry::new(&p);
    let loaded = simulate_loads(&p, &Settings::default()).unwrap();
    assert_eq!(loaded.record.channels, r.record.channels);
    assert!(r.record.loads.is_empty() && r.record.pressures.is_empty());
    assert_eq!(loaded.record.pressures.len(), 4);
    let within = 0.25 * std::f64::consts::PI * p.head_valve.inner_diameter.powi(2);
    let force = |name: &str, n: usize| r.history(&format!("{name}.force"))[n];
    let over = |volume: &str, n: usize| r.history(&format!("{volume}.pressure"))[n] - p.ambient.pressure;
    let expected = |surface: &str, n: usize| match surface {
        "roof" => force("stopper", n) - over("above_piston", n) * within,
        "cap" => {
            let stops = force("cap", n) - force("spring", n) + force("valve_friction", n) + force("thrust", n);
            stops - over("above_valve", n) * g.valve_control_area
        }
        "rim" => {
            let underside = within + g.valve_cylinder_area - g.piston_area;
            force("seat", n) + over("above_piston", n) * underside + over("supply", n) * g.valve_supply_area
        }
        "floor" => force("bumper", n) + over("below_piston", n) * g.ring_area,
        "bore" => force("piston_friction", n),
        "nose" => r.history("nail.guide_force")[n] - force("nose", n) - force("guard", n),
        "handle" => force("hand", n),
        other => panic!("{other}"),
    };
    let loads = loaded.record.loads.iter().filter(|load| load.body == "tool");
    let surfaces: Vec<&str> = loads.clone().map(|load| load.surface.as_str()).collect();
    assert_eq!(surfaces.len(), 7, "{surfaces:?}");
    for load in loads {
        let peak = load.force.iter().fold(1.0f64, |peak, force| peak.max(force.abs()));
        for n in (0..r.len()).step_by(50) {
            let (found, expected) = (load.force[n], expected(&load.surface, n));
            assert!(
                (found - expected).abs() < 1e-9 * peak,
                "{} {n}: {found} {expected} N",
                load.surface
            );
        }
    }
}
