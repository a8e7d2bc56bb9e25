//! A chain of equal links: a volume, a passage to the next, a piston on a spring that faces the volume.

use nailnoise_dynamics::network::Assembly;
use nailnoise_dynamics::network::assembly::*;

use crate::assembly::{body, constant, empty, passage, volume};

/// `count` links, the first at 800 kPa, the last open to the atmosphere.
pub(crate) fn chain(count: usize) -> Assembly {
    let mut chain = empty("chain", 0.05);
    chain.ledger = Ledger::Lean;
    for i in 0..count {
        let pressure = if i == 0 { 800e3 } else { 101_325.0 };
        chain.volumes.push(volume(&format!("volume{i}"), 100e-6, pressure));
        let next = if i + 1 < count {
            Space::Volume(i + 1)
        } else {
            Space::Reservoir(0)
        };
        chain
            .passages
            .push(passage(&format!("passage{i}"), Space::Volume(i), next, constant(20e-6)));
        let start = Start::At {
            travel: 0.0,
            speed: 0.0,
        };
        chain.bodies.push(body(&format!("piston{i}"), 0.1, start));
        let face = |name: String, gas, push| Face {
            name,
            gas,
            body: i,
            against: Base::Ground,
            push,
            area: 500e-6,
            zero: 0.0,
            perimeter: 0.0,
            sweeps: true,
        };
        chain
            .faces
            .push(face(format!("inside{i}"), Space::Volume(i), Push::Down));
        chain
            .faces
            .push(face(format!("outside{i}"), Space::Reservoir(0), Push::Up));
        chain.springs.push(Spring {
            name: format!("spring{i}"),
            on: i,
            against: Base::Ground,
            push: Push::Up,
            free: 0.0,
            preload: 0.0,
            law: SpringLaw::Linear(10e3),
            limit: None,
            unilateral: false,
            damping: 20.0,
        });
    }
    chain
}
