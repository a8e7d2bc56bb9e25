//! An expansion chamber of 100 cm3 before the exhaust's holes, check (h) of the specification.

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, Numerics, simulate};

use crate::assembly::{constant, passage, volume};
use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;

/// The exhaust's series divided by a volume.
fn divided() -> Assembly {
    let mut tool = n80cb_assembly(&n80cb(), 0.1, 5e-3);
    let chamber = Space::Volume(tool.volumes.len());
    tool.volumes.push(volume("silencer", 100e-6, 101_325.0));
    let exhaust = tool.passages.iter_mut().find(|p| p.name == "exhaust").unwrap();
    let holes = exhaust.restrictions.pop().unwrap();
    let outside = std::mem::replace(&mut exhaust.to, chamber);
    tool.passages.push(Passage {
        restrictions: vec![holes],
        ..passage("holes", chamber, outside, constant(0.0))
    });
    tool
}

#[test]
fn a_chamber_lowers_and_delays_the_flow_through_the_holes() {
    let numerics = Numerics {
        relative_tolerance: 1e-9,
        sample_interval: Some(20e-6),
        ..Numerics::default()
    };
    let tool = divided();
    let record = simulate(&tool, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    for (name, expected) in [
        ("t3", 0.014_367_840_871_224_332),
        ("t6", 0.017_399_955_014_894_643),
        ("t10", 0.024_172_208_724_072_164),
        ("t13", 0.042_971_099_852_537_06),
        ("t15", 0.065_301_024_376_450_43),
        ("t16", 0.076_192_170_025_197_24),
        ("t17", 0.079_558_196_677_912_58),
        ("t18", 0.081_624_502_807_194_02),
    ] {
        let found = record.event(name).unwrap();
        assert!((found - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
    }
    let peak = |name: &str| record.get(name).unwrap().iter().copied().fold(0.0, f64::max);
    assert!((peak("holes.mass_flow") / 0.084_402_764_9 - 1.0).abs() < 1e-6);
    assert!((peak("exhaust.mass_flow") / 0.128_067_496_9 - 1.0).abs() < 1e-5);
    assert!((peak("silencer.pressure") / 301_105.917 - 1.0).abs() < 1e-6);
}
