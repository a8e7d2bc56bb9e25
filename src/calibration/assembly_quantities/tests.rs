//! Quantities of assemblies against those of the tool of the keys.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::calibration::quantities::{Chamber, Moment, Quantity};
use crate::calibration::shot::{Shot, assembly_of};
use crate::design::Design;

fn design(text: &str) -> Design {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/over.toml");
    Design::parse(&format!("base = \"n80cb.toml\"\n{text}"), beside).unwrap()
}

fn figure(assembly: &Assembly, name: &str) -> AssemblyQuantity {
    AssemblyQuantity::Figure(figures(assembly).into_iter().find(|own| own.name == name).unwrap())
}

#[test]
fn the_n80cb_as_an_assembly_is_measured_as_its_keys_are() {
    let (keys, own) = (design(""), design("[cycle]\nassembly = \"n80cb\""));
    let assembly = assembly_of(&own).unwrap().unwrap();
    let end = keys.analysis.cycle_end;
    let shots = [&keys, &own].map(|design| Shot::of(design, end, false).unwrap());
    let interval = |from: &str, to: &str| AssemblyQuantity::Interval {
        from: from.to_owned(),
        to: to.to_owned(),
    };
    let at_impact = |volume: &str| AssemblyQuantity::Pressure {
        volume: volume.to_owned(),
        at: AssemblyMoment::event("t9"),
    };
    let pairs = [
        (Quantity::Interval { from: 6, to: 9 }, interval("t6", "t9")),
        (Quantity::Interval { from: 0, to: 6 }, interval(START, "t6")),
        (Quantity::SpeedBeforeImpact, figure(&assembly, "speed_before_nail")),
        (
            Quantity::PistonTravel(Moment::time(8e-3)),
            AssemblyQuantity::Travel {
                body: "piston".to_owned(),
                at: AssemblyMoment::time(8e-3),
            },
        ),
        (
            Quantity::Pressure(Chamber::AbovePiston, Moment::event(9)),
            at_impact("above_piston"),
        ),
        (
            Quantity::PeakPressure(Chamber::Return),
            AssemblyQuantity::PeakPressure {
                volume: "return_volume".to_owned(),
            },
        ),
    ];
    for (of_keys, of_assembly) in pairs {
        let [expected, found] = [
            (of_keys, &shots[0], &keys),
            (Quantity::OfAssembly(of_assembly), &shots[1], &own),
        ]
        .map(|(own, shot, design)| own.predict(shot, &design.ambient, end).value());
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
    let depth = figure(&assembly, "nail_depth").predict_in(&shots[1], &own);
    let head = Quantity::HeadDepth.predict(&shots[0], &keys.ambient, end).value();
    assert!((depth - keys.nail.length - head).abs() < 1e-6, "{depth} {head}");
    assert_eq!(shots[0].outcome(), shots[1].outcome());
}

impl AssemblyQuantity {
    fn predict_in(&self, shot: &Shot, design: &Design) -> f64 {
        Quantity::OfAssembly(self.clone())
            .predict(shot, &design.ambient, 0.0)
            .value()
    }
}

/// Air through the openings, and a bound if the chambers have not settled at the end of the record: before the exhaust,
/// and during it.
#[test]
fn air_of_a_shot_that_is_not_over_is_a_bound() {
    let air = |text: &str| {
        let own = design(&format!("[cycle]\nassembly = \"n80cb\"\n{text}"));
        let assembly = assembly_of(&own).unwrap().unwrap();
        let shot = Shot::of(&own, own.analysis.cycle_end, false).unwrap();
        Quantity::OfAssembly(air_per_shot(&assembly).unwrap()).predict(&shot, &own.ambient, 0.0)
    };
    let Prediction::Value(whole) = air("finish = false\nend = \"300 ms\"") else {
        panic!("the exhaust is over after 300 ms");
    };
    for (end, least) in [("30 ms", -1e-6), ("60 ms", 1e-5)] {
        let Prediction::AtLeast(part) = air(&format!("finish = false\nend = \"{end}\"")) else {
            panic!("the exhaust is not over after {end}");
        };
        assert!(part > least && part < 0.99 * whole, "{end}: {part} {whole}");
    }
}
