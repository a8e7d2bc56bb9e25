//! Fields of bodies and of the forces between them.

use nailnoise_quantities::dimension::{
    ACCELERATION, DAMPING, FORCE, LENGTH, MASS, NUMBER, STIFFNESS as OF_STIFFNESS, TIME, VELOCITY,
};
use nailnoise_quantities::{Kind, any, component, nonnegative, positive};

use super::phrases::{BASE, BODY_NAME, PUSH};
use crate::network::assembly::Stop;
use crate::network::text::table::FieldType::{Either, List, Number, Pair, Quantity};
use crate::network::text::table::{FieldSpec, TableSpec, field, flag, name_of, one_of, quantity, table, text, words};

/// A stiffness, up to that of a rigid stop.
const STIFFNESS: Kind = nonnegative(OF_STIFFNESS).within(0.0, 1e21);
/// A damping ratio.
const DAMPING_RATIO: Kind = nonnegative(NUMBER).within(0.0, 10.0);

/// Sides of the stop of a contact.
pub(in crate::network::text::blocks) const STOPS: [(&str, Stop); 2] = [("below", Stop::Below), ("above", Stop::Above)];
const STOP_WORDS: [&str; 2] = words(&STOPS);
const ON: FieldSpec = name_of("on", BODY_NAME, "body on which the force acts");
const AGAINST: FieldSpec = name_of("against", BASE, "body that carries the reaction (the parent of `on`)");
const PUSHES: FieldSpec = one_of("push", &PUSH, "direction of the force on the body").such_as("\"down\"");
const WHILE: FieldSpec = name_of("while", "trigger", "trigger during which it acts");

const fn stiffness(example: &'static str) -> FieldSpec {
    quantity("stiffness", STIFFNESS, example, "stiffness")
}

const fn damping(text: &'static str) -> FieldSpec {
    quantity("damping", nonnegative(DAMPING), "\"80 N s/m\"", text)
}

const fn at(text: &'static str) -> FieldSpec {
    quantity("at", any(LENGTH), "\"24 mm\"", text)
}

pub(super) const fn force(name: &'static str, example: &'static str, text: &'static str) -> FieldSpec {
    quantity(name, nonnegative(FORCE), example, text)
}

const START: TableSpec = TableSpec::of(
    "start",
    &[
        name_of(
            "rest_on",
            "contact or spring",
            "contact or spring on which the body rests",
        ),
        quantity("travel", any(LENGTH), "\"0 mm\"", "travel at t = 0 (0)"),
        quantity("speed", any(VELOCITY), "\"0 m/s\"", "speed at t = 0 (0)"),
    ],
);

const WEIGHTED: TableSpec = TableSpec::of(
    "error weight",
    &[
        quantity("position", positive(LENGTH), "\"10 mm\"", "typical position (1 mm)"),
        quantity("velocity", positive(VELOCITY), "\"10 m/s\"", "typical velocity (1 m/s)"),
    ],
);

pub(in crate::network::text::blocks) const BODY: TableSpec = TableSpec::of(
    "body",
    &[
        name_of("parent", BASE, "body relative to which its travel is measured (ground)"),
        quantity("mass", positive(MASS), "\"131 g\"", "mass"),
        table("start", &START, "state at t = 0 (travel and speed 0)"),
        quantity(
            "gravity",
            any(ACCELERATION),
            "\"9.81 m/s2\"",
            "acceleration due to gravity, down (that of the cycle)",
        ),
        table(
            "weighted",
            &WEIGHTED,
            "typical magnitudes, which weight the error of the integration",
        ),
        flag("unbalanced", "whether a uniform pressure may move it (false)"),
    ],
);

pub(in crate::network::text::blocks) const CONTACT: TableSpec = TableSpec::of(
    "contact",
    &[
        ON,
        AGAINST,
        one_of("stop", &STOP_WORDS, "side of the body on which the stop is").such_as("\"below\""),
        at("travel at which it closes (0)"),
        field(
            "stiffness",
            Either(&[Quantity(STIFFNESS), Number]),
            "stiffness; with an exponent n other than 1 a plain number in N/m^n",
        )
        .such_as("\"1 kN/mm\""),
        damping("coefficient of a dashpot (0)"),
        quantity(
            "damping_ratio",
            DAMPING_RATIO,
            "0.05",
            "damping ratio with the mass of `on`, instead of `damping`",
        ),
        quantity(
            "hysteresis",
            nonnegative(NUMBER),
            "\"0.2 s/m\"",
            "factor of Hunt and Crossley in s/m, instead of `damping`",
        ),
        quantity(
            "exponent",
            positive(NUMBER).within(1.0, 10.0),
            "1.5",
            "exponent of the overlap (1)",
        ),
        flag("may_pull", "whether the damping may pull (false)"),
    ],
);

pub(in crate::network::text::blocks) const SPRING: TableSpec = TableSpec::of(
    "spring",
    &[
        ON,
        AGAINST,
        PUSHES,
        quantity(
            "free",
            any(LENGTH),
            "\"24 mm\"",
            "travel at which it is compressed by `preload` (0)",
        ),
        quantity("preload", any(LENGTH), "\"20 mm\"", "compression there (0)"),
        stiffness("\"1 N/mm\""),
        field(
            "polynomial",
            List(&Number),
            "force in N over the compression in m: coefficients of x^0, x^1, ...",
        )
        .such_as("[4.17, 79135.7]"),
        quantity(
            "scale",
            nonnegative(NUMBER).within(0.0, 1e3),
            "1",
            "factor on the force (1)",
        ),
        quantity(
            "limit",
            positive(LENGTH),
            "\"5 mm\"",
            "largest compression for which the law is valid",
        ),
        flag("unilateral", "whether it only pushes (false)"),
        damping("coefficient of a dashpot in parallel (0)"),
    ],
);

const STICK: TableSpec = TableSpec::of(
    "sticking friction",
    &[
        stiffness("\"1 kN/mm\""),
        damping("coefficient of a dashpot in parallel (0)"),
    ],
);

pub(in crate::network::text::blocks) const FRICTION: TableSpec = TableSpec::of(
    "friction",
    &[
        ON,
        AGAINST,
        text(
            "law",
            "a group of keys, as \"=piston.friction\"",
            "group of keys with static_force, sliding_force and viscous, instead of these fields",
        )
        .such_as("\"=piston.friction\""),
        force("static", "\"20 N\"", "largest force at rest (that of sliding)"),
        force("sliding", "\"15 N\"", "force of sliding"),
        quantity(
            "viscous",
            nonnegative(DAMPING),
            "\"2 N s/m\"",
            "viscous coefficient (0)",
        ),
        quantity(
            "width",
            positive(VELOCITY),
            "\"1 mm/s\"",
            "velocity over which the force changes its sign (1 mm/s)",
        ),
        quantity(
            "stribeck",
            positive(VELOCITY),
            "\"10 mm/s\"",
            "velocity over which it falls from static to sliding (10 mm/s)",
        ),
        table("stick", &STICK, "stiffness and damping while it sticks"),
    ],
);

pub(in crate::network::text::blocks) const FORCE_TABLE: TableSpec = TableSpec::of(
    "force",
    &[
        ON,
        name_of("against", BASE, "body that carries the reaction (ground)"),
        quantity("force", any(FORCE), "\"80 N\"", "constant force, down"),
        field(
            "table",
            List(&Pair(&[Quantity(any(TIME)), Quantity(any(FORCE))])),
            "force over time, down",
        )
        .such_as("[[\"0 s\", \"0 N\"], [\"5 ms\", \"100 N\"]]"),
        name_of("jet", "passage", "passage whose outflow pushes the body"),
        quantity(
            "share",
            component(),
            "1",
            "share of the outflow's momentum along the axis",
        ),
    ],
);

pub(in crate::network::text::blocks) const MOTOR: TableSpec = TableSpec::of(
    "motor",
    &[
        ON,
        AGAINST,
        PUSHES,
        force("stall", "\"1500 N\"", "force at rest"),
        quantity("free_speed", positive(VELOCITY), "\"0.6 m/s\"", "speed without a force"),
        WHILE,
    ],
);

pub(in crate::network::text::blocks) const HOLD: TableSpec = TableSpec::of(
    "hold",
    &[
        ON,
        AGAINST,
        at("travel at which it holds the body (0)"),
        stiffness("\"5 kN/mm\""),
        quantity(
            "damping_ratio",
            DAMPING_RATIO,
            "0.1",
            "damping ratio with the mass of `on` (0.1)",
        ),
        WHILE,
    ],
);
