//! The N80CB as an assembly, block by block from the parameters of the fixed cycle.

use nailnoise_dynamics::network::Assembly;
use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::{Geometry, Parameters};

use crate::assembly::{at_most, body, channel, compare, constant, contact, empty, event, passage, restriction, volume};

const PISTON: usize = 0;
const VALVE: usize = 1;
const TOOL: usize = 2;
const WORKPIECE: usize = 3;
const ABOVE: usize = 0;
const BELOW: usize = 1;
const RETURN: usize = 2;
const CONTROL: usize = 3;
const SUPPLY: usize = 4;
const SPRING: [f64; 9] = [
    4.17, 79_135.7, -7.55e7, 3.56e10, -8.57e12, 1.13e15, -8.28e16, 3.14e18, -4.79e19,
];

fn bodies(p: &Parameters, g: &Geometry) -> Vec<Body> {
    let rest = |index| {
        Start::RestOn(BlockRef {
            family: Family::Contact,
            index,
        })
    };
    let home = Start::At {
        travel: 0.0,
        speed: 0.0,
    };
    let made = |name: &str, parent, mass, start, position, velocity| Body {
        parent,
        gravity: p.ambient.gravity,
        weights: Weights { position, velocity },
        ..body(name, mass, start)
    };
    let tool = Base::Body(TOOL);
    vec![
        made("piston", tool, p.piston.mass, home, 1e-2, 10.0),
        made("head_valve", tool, p.head_valve.mass, rest(3), 1e-3, 5.0),
        made("tool", Base::Ground, p.tool.mass, rest(4), 1e-4, 0.5),
        made("workpiece", Base::Ground, g.workpiece_mass, rest(6), 1e-4, 0.5),
    ]
}

fn volumes(p: &Parameters) -> Vec<Volume> {
    let c = &p.chambers;
    let made = |name: &str, dead, pressure, area| Volume {
        temperature: p.ambient.temperature,
        wall: Some(Wall {
            area,
            transfer: c.wall_heat_transfer,
            temperature: p.ambient.temperature,
        }),
        ..volume(name, dead, pressure)
    };
    let (low, high) = (p.ambient.pressure, p.supply.pressure);
    vec![
        made("above_piston", c.above_piston, low, c.wall_above_piston),
        made("below_piston", c.below_piston, low, c.wall_below_piston),
        made("return_volume", c.return_volume, low, c.wall_return),
        made("above_valve", c.above_valve, high, c.wall_above_valve),
        made("supply", c.supply_volume, high, c.wall_supply),
    ]
}

fn faces(p: &Parameters, g: &Geometry) -> Vec<Face> {
    let made = |name: &str, gas, body, push, area, zero| Face {
        name: name.to_owned(),
        gas,
        body,
        against: Base::Body(TOOL),
        push,
        area,
        zero,
        perimeter: 0.0,
    };
    let bore = std::f64::consts::PI * p.piston.bore;
    let gas = Space::Volume;
    vec![
        Face {
            perimeter: bore,
            ..made("piston_top", gas(ABOVE), PISTON, Push::Down, g.piston_area, 0.0)
        },
        Face {
            perimeter: bore,
            ..made(
                "piston_ring",
                gas(BELOW),
                PISTON,
                Push::Up,
                g.ring_area,
                p.piston.stroke,
            )
        },
        made("piston_rod", Space::Reservoir(0), PISTON, Push::Up, g.rod_area, 0.0),
        made("valve_top", gas(CONTROL), VALVE, Push::Down, g.valve_control_area, 0.0),
        made(
            "valve_outer",
            gas(SUPPLY),
            VALVE,
            Push::Up,
            g.valve_supply_area,
            p.head_valve.lift,
        ),
        made(
            "valve_inner",
            gas(ABOVE),
            VALVE,
            Push::Up,
            g.valve_cylinder_area,
            p.head_valve.lift,
        ),
    ]
}

fn passages(p: &Parameters, g: &Geometry) -> Vec<Passage> {
    let c = &p.chambers;
    let cd = Coefficient::Constant(c.discharge_coefficient);
    let valve = &p.head_valve;
    let seat = |push, lap: f64, diameter, angle, cone| Opens::Seat {
        body: VALVE,
        against: Base::Body(TOOL),
        push,
        at: valve.lift - lap,
        diameter,
        angle,
        cone,
    };
    let gas = Space::Volume;
    let (outside, hose) = (Space::Reservoir(0), Space::Reservoir(1));
    let hole = |area| restriction(Opens::Constant { area }, cd.clone());
    let attenuated = |area, factor| restriction(Opens::Constant { area }, Coefficient::Constant(factor));
    let gate = |inverted| {
        Some(Gate {
            trigger: 0,
            inverted,
            delay: g.channel_delay,
            before: false,
            also: None,
        })
    };
    let intake = restriction(
        seat(
            Push::Up,
            valve.intake_lap,
            p.piston.bore,
            valve.intake_angle,
            Cone::Narrows,
        ),
        Coefficient::RatioPolynomial {
            coefficients: vec![1.1, -0.71, 0.49, -0.14],
            from: 0.390,
            to: 0.913,
        },
    );
    let exhaust = [
        restriction(
            seat(
                Push::Down,
                valve.exhaust_lap,
                valve.exhaust_seat_diameter,
                valve.exhaust_angle,
                Cone::Widens,
            ),
            cd.clone(),
        ),
        hole(g.exhaust_area),
    ];
    let check = restriction(
        Opens::Holes {
            body: PISTON,
            against: Base::Body(TOOL),
            push: Push::Down,
            at: c.check_hole_position,
            area: c.check_hole_area,
            diameter: None,
        },
        cd.clone(),
    );
    vec![
        passage("intake", gas(SUPPLY), gas(ABOVE), intake),
        Passage {
            restrictions: exhaust.to_vec(),
            ..passage("exhaust", gas(ABOVE), outside, constant(0.0))
        },
        Passage {
            one_way: true,
            ..passage("check", gas(ABOVE), gas(RETURN), check)
        },
        passage("foot", gas(BELOW), gas(RETURN), hole(c.return_hole_area)),
        passage("leak", gas(BELOW), outside, hole(c.leak_area)),
        Passage {
            gate: gate(true),
            ..passage(
                "vent",
                gas(CONTROL),
                outside,
                attenuated(p.trigger.vent_area, g.attenuation_vent),
            )
        },
        Passage {
            gate: gate(false),
            ..passage(
                "fill",
                gas(SUPPLY),
                gas(CONTROL),
                attenuated(p.trigger.fill_area, g.attenuation_fill),
            )
        },
        Passage {
            one_way: true,
            ..passage("refill", hose, gas(SUPPLY), hole(p.supply.hose_area))
        },
    ]
}

fn contacts(p: &Parameters, g: &Geometry) -> Vec<Contact> {
    let c = &p.contacts;
    let ratio = |zeta: f64, k: f64, mass: f64| 2.0 * zeta * (k * mass).sqrt();
    let (tool, wood) = (Base::Body(TOOL), Base::Body(WORKPIECE));
    let (stroke, lift) = (p.piston.stroke, p.head_valve.lift);
    let valve = |k| ratio(c.valve_damping_ratio, k, p.head_valve.mass);
    let nose = ratio(c.nose_damping_ratio, c.nose_stiffness, p.tool.mass);
    let guard = c.guard_stiffness * c.nose_stiffness / (c.guard_stiffness + c.nose_stiffness);
    vec![
        contact(
            "bumper",
            PISTON,
            tool,
            Stop::Below,
            stroke,
            c.bumper_stiffness,
            c.bumper_damping,
        ),
        contact(
            "stopper",
            PISTON,
            tool,
            Stop::Above,
            0.0,
            c.stopper_stiffness,
            c.stopper_damping,
        ),
        contact(
            "cap",
            VALVE,
            tool,
            Stop::Above,
            0.0,
            c.cap_stiffness,
            valve(c.cap_stiffness),
        ),
        contact(
            "seat",
            VALVE,
            tool,
            Stop::Below,
            lift,
            c.seat_stiffness,
            valve(c.seat_stiffness),
        ),
        contact("nose", TOOL, wood, Stop::Below, 0.0, c.nose_stiffness, nose),
        contact("guard", TOOL, wood, Stop::Below, -c.guard_travel, guard, 0.0),
        contact(
            "support",
            WORKPIECE,
            Base::Ground,
            Stop::Below,
            0.0,
            p.support.stiffness,
            g.support_damping,
        ),
    ]
}

fn fastener(p: &Parameters, g: &Geometry) -> Fastener {
    let wood = &p.wood;
    let offset = wood.speed_term * p.nail.length * wood.density / wood.hardness_modulus
        + wood.slenderness_term * p.nail.diameter / p.nail.length;
    Fastener {
        name: "nail".to_owned(),
        driver: PISTON,
        into: WORKPIECE,
        guide: Base::Body(TOOL),
        head_at: g.head_gap,
        tip_at: g.tip_gap,
        length: p.nail.length,
        mass: g.nail_mass,
        impact: true,
        law: FastenerLaw::SolidWood {
            hardness: wood.hardness_modulus * wood.resistance_scale,
            offset,
        },
        reversible: false,
        seated: Seated {
            head_stiffness: wood.head_stiffness_scale * wood.hardness_modulus,
            unloading: wood.unloading_stiffness,
            guide_friction: p.nail.magazine_friction,
            guide_width: p.model.friction_velocity,
        },
    }
}

fn events(p: &Parameters, g: &Geometry) -> Vec<Event> {
    let travel = || channel(Family::Body, PISTON, Quantity::Travel);
    let valve = || channel(Family::Body, VALVE, Quantity::Travel);
    let speed = || {
        let speed = channel(Family::Body, PISTON, Quantity::Speed);
        Expression::Function(Function::Abs, vec![speed])
    };
    let pressure = |index| channel(Family::Volume, index, Quantity::Pressure);
    let nail = |quantity| channel(Family::Fastener, 0, quantity);
    let lift = p.head_valve.lift;
    let lifted = |by: f64| compare(Expression::Negative(Box::new(valve())), by - lift, true);
    let (supply, ambient) = (p.supply.pressure, p.ambient.pressure);
    let gap = Expression::Binary(
        Binary::Subtract,
        Box::new(channel(Family::Body, TOOL, Quantity::Position)),
        Box::new(channel(Family::Body, WORKPIECE, Quantity::Position)),
    );
    let overlap = channel(Family::Contact, 5, Quantity::Overlap);
    let rest = || at_most_strict(speed(), 0.1);
    let after = |name: &str, edge, after| Event {
        after: Some(after),
        ..event(name, edge)
    };
    let becomes = Edge::Becomes;
    vec![
        event("t0", Edge::At(0.0)),
        after("t1", becomes(lifted(10e-6)), 0),
        after(
            "t2",
            becomes(at_most(pressure(CONTROL), ambient + 0.1 * (supply - ambient))),
            0,
        ),
        after("t3", becomes(lifted(p.head_valve.intake_lap)), 0),
        after("t4", becomes(compare(travel(), 0.1e-3, true)), 0),
        after("t5", becomes(compare(travel(), g.head_gap, true)), 0),
        after("t6", becomes(compare(nail(Quantity::Depth), 0.0, true)), 0),
        after("t7", becomes(compare(travel(), 50.51e-3, true)), 0),
        after(
            "t8",
            becomes(compare(travel(), p.chambers.check_hole_position, true)),
            0,
        ),
        after("t9", becomes(at_most(nail(Quantity::Advance), 0.0)), 6),
        after("t10", Edge::Is(compare(travel(), p.piston.stroke, false)), 9),
        Event {
            lasting: 2e-3,
            until: Some(14),
            ..after("t11", Edge::Is(rest()), 10)
        },
        after("t12", becomes(at_most(overlap, 0.0)), 0),
        Event {
            condition: Some(compare(pressure(ABOVE), ambient, true)),
            ..after(
                "t13",
                becomes(compare(valve(), lift - p.head_valve.exhaust_lap, false)),
                12,
            )
        },
        Event {
            before: Some(15),
            pick: Pick::Last,
            ..after("t14", becomes(compare(speed(), 0.05, true)), 6)
        },
        after("t15", becomes(at_most(travel(), 50.51e-3)), 6),
        after("t16", becomes(at_most(travel(), 0.0)), 15),
        Event {
            delay: 1e-3,
            ..after("t17", Edge::Is(at_most(pressure(ABOVE), 1.02 * ambient)), 13)
        },
        Event {
            lasting: 2e-3,
            ..after("t18", Edge::Is(rest()), 16)
        },
        after("landing", becomes(compare(gap, 0.0, true)), 12),
    ]
}

/// a < b.
fn at_most_strict(a: Expression, b: f64) -> Condition {
    compare(Expression::Negative(Box::new(a)), -b, true)
}

/// The assembly of a design without a hand's mass, muffler, thrust or published forms.
pub(crate) fn n80cb_assembly(p: &Parameters, end: f64, tail: f64) -> Assembly {
    let g = Geometry::new(p);
    let friction = |name: &str, on, law: &nailnoise_dynamics::Friction| Friction {
        name: name.to_owned(),
        on,
        against: Base::Body(TOOL),
        static_force: law.static_force,
        sliding_force: law.sliding_force,
        viscous: law.viscous,
        width: p.model.friction_velocity,
        stribeck: p.model.stribeck_velocity,
        stick: None,
    };
    let guard = |action| Word {
        block: BlockRef {
            family: Family::Contact,
            index: 5,
        },
        restriction: 0,
        action,
    };
    Assembly {
        gas_constant: p.ambient.gas_constant,
        heat_capacity_ratio: p.ambient.heat_capacity_ratio,
        gravity: p.ambient.gravity,
        linear_ratio: p.model.orifice_linear,
        ledger: Ledger::Lean,
        finish: Some(Finish {
            event: 18,
            tail,
            never_past: Some(19),
        }),
        reservoirs: vec![
            Reservoir {
                name: "atmosphere".to_owned(),
                pressure: p.ambient.pressure,
                temperature: p.ambient.temperature,
            },
            Reservoir {
                name: "hose".to_owned(),
                pressure: p.supply.pressure,
                temperature: p.ambient.temperature,
            },
        ],
        bodies: bodies(p, &g),
        volumes: volumes(p),
        faces: faces(p, &g),
        passages: passages(p, &g),
        contacts: contacts(p, &g),
        springs: vec![Spring {
            name: "spring".to_owned(),
            on: VALVE,
            against: Base::Body(TOOL),
            push: Push::Down,
            free: p.head_valve.lift,
            preload: p.head_valve.spring_preload,
            law: SpringLaw::Polynomial(SPRING.map(|c| c * p.head_valve.spring_scale).to_vec()),
            limit: Some(5e-3),
            unilateral: false,
            damping: 0.0,
        }],
        frictions: vec![
            friction("piston_friction", PISTON, &p.piston.friction),
            friction("valve_friction", VALVE, &p.head_valve.friction),
        ],
        forces: vec![Force {
            name: "hand".to_owned(),
            on: TOOL,
            against: Base::Ground,
            law: ForceLaw::Constant(p.hand.force),
        }],
        fasteners: vec![fastener(p, &g)],
        triggers: vec![Trigger {
            name: "released".to_owned(),
            starts: false,
            set: vec![guard(Action::Opens)],
            clear: Vec::new(),
            schedule: Vec::new(),
        }],
        events: events(p, &g),
        ..empty("n80cb", end)
    }
}
