//! The record of a nailer is that of its assembly.

use nailnoise_dynamics::network::{Numerics, Record, simulate};
use nailnoise_dynamics::{Geometry, Outcome, Settings};

use crate::BASE;
use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;

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
