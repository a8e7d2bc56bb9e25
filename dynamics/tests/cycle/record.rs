//! The fixed fields of a record are channels, events and integrals of the assembly.

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
    for (channel, history) in [
        ("piston.velocity", &r.piston.velocity),
        ("head_valve.position", &r.head_valve.position),
        ("tool.acceleration", &r.tool.acceleration),
        ("workpiece.position", &r.workpiece.position),
        ("valve_lift", &r.motion.valve_lift),
        ("nail.tip", &r.motion.tip_depth),
        ("above_piston.pressure", &r.above_piston.pressure),
        ("supply.temperature", &r.supply.temperature),
        ("below_piston.mass", &r.below_piston.mass),
        ("nail.force", &r.forces.penetration),
        ("cap.force", &r.forces.cap),
        ("hand.force", &r.forces.hand),
        ("intake.mass_flow", &r.exhaust.intake_mass_flow),
        ("exhaust.mass_flow", &r.exhaust.mass_flow),
        ("vent.mass_flow", &r.vent.mass_flow),
    ] {
        let found = of.get(channel).unwrap();
        let size = history.iter().fold(0.0f64, |size, value| size.max(value.abs()));
        assert!(size > 0.0 && found.len() == history.len(), "{channel}");
        let apart = found.iter().zip(history).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 1e-9 * size, "{channel}");
    }
    for (i, time) in r.events.to_array().into_iter().enumerate() {
        let apart = time.unwrap() - of.event(&format!("t{i}")).unwrap();
        assert!(apart.abs() < 1e-12, "t{i}: {apart} s");
    }
    assert_eq!(of.outcome.as_deref(), Some(Outcome::Drives.name()));
}

#[test]
fn gas_forces_are_pressures_on_the_areas_of_the_geometry() {
    let (p, r) = (n80cb(), &*BASE);
    let (g, f) = (Geometry::new(&p), &r.forces);
    for n in (0..r.len()).step_by(100) {
        let gauge = |volume: &nailnoise_dynamics::Volume| volume.pressure[n] - p.ambient.pressure;
        let piston = gauge(&r.above_piston) * g.piston_area - gauge(&r.below_piston) * g.ring_area;
        assert!(
            (f.piston_gas[n] - piston).abs() < 1e-9,
            "{n}: {} {piston} N",
            f.piston_gas[n]
        );
    }
}
