//! Assemblies in Rust, for tests.

use nailnoise_dynamics::network::Assembly;
use nailnoise_dynamics::network::assembly::*;

/// Ambient pressure \[Pa\] and temperature \[K\] of the closed forms.
pub(crate) const AMBIENT: (f64, f64) = (101_325.0, 293.15);

/// An assembly of the atmosphere only.
pub(crate) fn empty(name: &str, end: f64) -> Assembly {
    Assembly {
        name: name.to_owned(),
        gas_constant: 287.05,
        heat_capacity_ratio: 1.4,
        polytropic: None,
        gravity: 0.0,
        linear_ratio: 1e-3,
        end,
        finish: None,
        ledger: Ledger::Full,
        unbalanced: false,
        reservoirs: vec![Reservoir {
            name: "atmosphere".to_owned(),
            pressure: AMBIENT.0,
            temperature: AMBIENT.1,
        }],
        bodies: Vec::new(),
        volumes: Vec::new(),
        faces: Vec::new(),
        passages: Vec::new(),
        contacts: Vec::new(),
        springs: Vec::new(),
        frictions: Vec::new(),
        forces: Vec::new(),
        motors: Vec::new(),
        holds: Vec::new(),
        fasteners: Vec::new(),
        blows: Vec::new(),
        triggers: Vec::new(),
        sensors: Vec::new(),
        events: Vec::new(),
        outcomes: Vec::new(),
        openings: Vec::new(),
        loads: Vec::new(),
        pressures: Vec::new(),
        columns: Vec::new(),
        markers: Vec::new(),
    }
}

/// A body that starts at a travel from its parent.
pub(crate) fn body(name: &str, mass: f64, start: Start) -> Body {
    Body {
        name: name.to_owned(),
        parent: Base::Ground,
        mass,
        start,
        gravity: 0.0,
        weights: Weights {
            position: 1e-3,
            velocity: 1.0,
        },
    }
}

/// A volume without a wall.
pub(crate) fn volume(name: &str, dead: f64, pressure: f64) -> Volume {
    Volume {
        name: name.to_owned(),
        dead,
        pressure,
        temperature: AMBIENT.1,
        wall: None,
        isothermal: false,
        exhaust_path: false,
    }
}

/// A single restriction of constant effective area.
pub(crate) fn constant(area: f64) -> Restriction {
    restriction(Opens::Constant { area }, Coefficient::Constant(1.0))
}

/// A restriction without a name.
pub(crate) fn restriction(opens: Opens, coefficient: Coefficient) -> Restriction {
    Restriction {
        name: String::new(),
        opens,
        coefficient,
        pipe: None,
    }
}

/// An open passage.
pub(crate) fn passage(name: &str, from: Space, to: Space, restriction: Restriction) -> Passage {
    Passage {
        name: name.to_owned(),
        from,
        to,
        restrictions: vec![restriction],
        law: PassageLaw::Nozzle,
        one_way: false,
        exponents: [None; 2],
        gate: None,
        silent: false,
    }
}
