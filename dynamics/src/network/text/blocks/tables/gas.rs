//! Fields of reservoirs, volumes, faces and passages.

use nailnoise_quantities::dimension::{
    ANGLE, AREA, HEAT_TRANSFER, LENGTH, NUMBER, TEMPERATURE, TIME, VOLUME as OF_VOLUME,
};
use nailnoise_quantities::{Kind, any, gas_pressure, nonnegative, positive};

use super::phrases::{BASE, BODY_NAME, OPENS, PUSH};
use crate::network::assembly::Cone;
use crate::network::text::table::FieldType::{Either, List, Name, Number, Quantity, Table, Words};
use crate::network::text::table::{FieldSpec, TableSpec, field, flag, name_of, one_of, quantity, table, text, words};

/// Shapes of a seat.
pub(in crate::network::text::blocks) const CONES: [(&str, Cone); 2] =
    [("narrows", Cone::Narrows), ("widens", Cone::Widens)];
const CONE_WORDS: [&str; 2] = words(&CONES);
/// Laws of a flow that a table describes.
pub(in crate::network::text::blocks) const FLOW_LAWS: [(&str, ()); 1] = [("iso6358", ())];
const FLOW_WORDS: [&str; 1] = words(&FLOW_LAWS);
/// Laws of a flow by their name, and whether the name suffices.
pub(in crate::network::text::blocks) const LAW_WORDS: [(&str, bool); 2] = [("nozzle", true), ("iso6358", false)];
const LAWS: [&str; 2] = words(&LAW_WORDS);

/// Laws of the gas, and whether it is polytropic.
pub(in crate::network::text::blocks) const GASES: [(&str, bool); 2] = [("ideal", false), ("polytropic", true)];
pub(in crate::network::text::blocks) const GAS_WORDS: [&str; 2] = words(&GASES);
/// Words for the object of the delay of a gate, and whether it is the flow.
pub(in crate::network::text::blocks) const DELAYS: [(&str, bool); 2] = [("switching", false), ("flow", true)];
const DELAY_WORDS: [&str; 2] = words(&DELAYS);
/// Words for the time when gas leaves the first space, and whether it is without the delay.
pub(in crate::network::text::blocks) const LEAVES: [(&str, bool); 2] = [("delayed", false), ("undelayed", true)];
const LEAVE_WORDS: [&str; 2] = words(&LEAVES);
/// A polytropic exponent.
pub(in crate::network::text::blocks) const EXPONENT: Kind = positive(NUMBER).within(0.5, 2.0);

const SPACE: &str = "volume or reservoir";
const COEFFICIENT: Kind = nonnegative(NUMBER).within(0.0, 10.0);

const fn temperature(text: &'static str) -> FieldSpec {
    quantity("temperature", positive(TEMPERATURE), "\"20 degC\"", text)
}

const fn area(text: &'static str) -> FieldSpec {
    quantity("area", nonnegative(AREA), "\"20 mm2\"", text)
}

const fn at(text: &'static str) -> FieldSpec {
    quantity("at", any(LENGTH), "\"5 mm\"", text)
}

pub(in crate::network::text::blocks) const RESERVOIR: TableSpec = TableSpec::of(
    "reservoir",
    &[
        quantity(
            "pressure",
            gas_pressure(),
            "\"101.325 kPa\"",
            "pressure, absolute or gauge (barg)",
        ),
        temperature("temperature"),
    ],
);

const WALL: TableSpec = TableSpec::of(
    "wall",
    &[
        quantity(
            "area",
            nonnegative(AREA),
            "\"100 cm2\"",
            "area without that of the faces (0)",
        ),
        quantity(
            "transfer",
            nonnegative(HEAT_TRANSFER),
            "\"200 W/(m2 K)\"",
            "heat transfer coefficient",
        ),
        temperature("temperature of the wall (that of the atmosphere)"),
    ],
);

pub(in crate::network::text::blocks) const VOLUME: TableSpec = TableSpec::of(
    "volume",
    &[
        quantity(
            "dead",
            nonnegative(OF_VOLUME),
            "\"100 cm3\"",
            "volume without that of the faces",
        ),
        quantity(
            "pressure",
            gas_pressure(),
            "\"=ambient.pressure\"",
            "pressure at t = 0, absolute or gauge (barg)",
        ),
        temperature("temperature at t = 0 (that of the atmosphere)"),
        table("wall", &WALL, "heat transfer to a wall"),
        flag("isothermal", "whether the temperature is constant (false)"),
        flag(
            "exhaust_path",
            "whether the exhaust passes this volume: results state how much of its gas leaves choked (false)",
        ),
    ],
);

pub(in crate::network::text::blocks) const FACE: TableSpec = TableSpec::of(
    "face",
    &[
        name_of("volume", SPACE, "gas that presses on the face"),
        name_of("body", BODY_NAME, "body on which the gas presses"),
        one_of("push", &PUSH, "direction of the force on the body").such_as("\"down\""),
        quantity("area", nonnegative(AREA), "\"=disc(piston.bore)\"", "area"),
        quantity(
            "zero",
            any(LENGTH),
            "\"24 mm\"",
            "travel at which the volume is `dead` (0)",
        ),
        name_of("against", BASE, "body that carries the reaction (the body's parent)"),
        quantity(
            "perimeter",
            nonnegative(LENGTH),
            "\"85 mm\"",
            "perimeter, for heat transfer along the travel (0)",
        ),
        flag(
            "constant_volume",
            "whether its travel leaves the volume unchanged (false)",
        ),
    ],
);

const POLYNOMIAL: TableSpec = TableSpec::of(
    "coefficient",
    &[
        field(
            "ratio_polynomial",
            List(&Number),
            "coefficients of r^0, r^1, ..., r the ratio of the pressures",
        )
        .such_as("[1.1, -0.71]"),
        quantity("from", COEFFICIENT, "0.4", "lowest ratio of the pressures"),
        quantity("to", COEFFICIENT, "0.9", "highest ratio of the pressures"),
    ],
);

const SEAT: TableSpec = TableSpec::of(
    "seat",
    &[
        name_of("body", BODY_NAME, "body that opens the seat"),
        name_of("against", BASE, "body with the seat (the body's parent)"),
        one_of("opens", &OPENS, "direction in which the body opens it").such_as("\"down\""),
        at("travel at which it opens (0)"),
        quantity("diameter", positive(LENGTH), "\"20 mm\"", "diameter"),
        quantity("angle", positive(ANGLE), "\"45 deg\"", "angle of the cone to the axis"),
        one_of("cone", &CONE_WORDS, "whether the cone narrows or widens along the flow").such_as("\"widens\""),
    ],
);

const HOLES: TableSpec = TableSpec::of(
    "row of holes",
    &[
        name_of("body", BODY_NAME, "body that uncovers the holes"),
        name_of("against", BASE, "body with the holes (the body's parent)"),
        one_of("opens", &OPENS, "direction in which the body uncovers them").such_as("\"down\""),
        at("travel at which it uncovers them (0)"),
        quantity("area", nonnegative(AREA), "\"50 mm2\"", "area of all holes"),
        quantity(
            "diameter",
            positive(LENGTH),
            "\"3 mm\"",
            "diameter of round holes, which open gradually",
        ),
    ],
);

const RAMP: TableSpec = TableSpec::of(
    "ramp",
    &[
        area("area when open"),
        quantity(
            "time",
            nonnegative(TIME),
            "\"1 ms\"",
            "time in which it opens, from t = 0",
        ),
    ],
);

const PIPE: TableSpec = TableSpec::of(
    "pipe",
    &[
        quantity("length", nonnegative(LENGTH), "\"100 mm\"", "length"),
        quantity("diameter", positive(LENGTH), "\"6 mm\"", "bore"),
        quantity(
            "friction",
            nonnegative(NUMBER).within(0.0, 1.0),
            "0.02",
            "Darcy friction factor (0.02)",
        ),
    ],
);

const AREA_OF: FieldSpec = area("constant area");
const OF_SEAT: FieldSpec = table("seat", &SEAT, "seat that a body opens");
const OF_HOLES: FieldSpec = table("holes", &HOLES, "holes that a body uncovers");
const OF_RAMP: FieldSpec = table("ramp", &RAMP, "area that grows with time from t = 0");
const OF_PIPE: FieldSpec = table("pipe", &PIPE, "pipe with friction");
const OF_COEFFICIENT: FieldSpec = field(
    "coefficient",
    Either(&[Quantity(COEFFICIENT), Table(&POLYNOMIAL)]),
    "discharge coefficient, or a polynomial of the ratio of the pressures (1)",
);

pub(in crate::network::text::blocks) const RESTRICTION: TableSpec = TableSpec::of(
    "restriction",
    &[
        text("name", "a name", "name of the restriction").such_as("\"holes\""),
        AREA_OF,
        OF_SEAT,
        OF_HOLES,
        OF_RAMP,
        OF_PIPE,
        OF_COEFFICIENT,
    ],
);

const GATE: TableSpec = TableSpec::of(
    "gate",
    &[
        text(
            "when",
            "the name of a trigger",
            "trigger that opens the passage, or `not` and the trigger that shuts it",
        )
        .such_as("\"released\", or \"not released\""),
        quantity(
            "delay",
            nonnegative(TIME),
            "\"0.2 ms\"",
            "time from the trigger to the passage (0)",
        ),
        flag(
            "before",
            "whether it is open until the first change of the trigger reaches it (false)",
        ),
        one_of(
            "delays",
            &DELAY_WORDS,
            "whether the delay applies to the switching, or to the flow (\"switching\")",
        ),
        one_of(
            "leaves",
            &LEAVE_WORDS,
            "whether the first space loses what arrives, or the flow without delay and coefficient (\"delayed\")",
        ),
    ],
);

const LAW: TableSpec = TableSpec::of(
    "law of a passage",
    &[
        one_of("kind", &FLOW_WORDS, "law of the flow").such_as("\"iso6358\""),
        quantity(
            "critical_ratio",
            nonnegative(NUMBER).within(0.0, 0.999),
            "0.3",
            "ratio of the pressures below which the flow chokes",
        ),
    ],
);

pub(in crate::network::text::blocks) const PASSAGE: TableSpec = TableSpec::of(
    "passage",
    &[
        field(
            "between",
            List(&Name(SPACE)),
            "two spaces; the flow is positive from the first to the second",
        )
        .such_as("[\"supply\", \"atmosphere\"]"),
        AREA_OF,
        OF_SEAT,
        OF_HOLES,
        OF_RAMP,
        OF_PIPE,
        field(
            "series",
            List(&Table(&RESTRICTION)),
            "one to three restrictions with names, in order",
        ),
        OF_COEFFICIENT,
        flag("one_way", "whether only the positive flow passes (false)"),
        quantity(
            "outflow_exponent",
            EXPONENT,
            "\"=model.polytropic_outflow\"",
            "polytropic exponent of the gas that leaves the first space (that of inflow)",
        ),
        quantity(
            "backflow_exponent",
            EXPONENT,
            "\"=model.polytropic_outflow\"",
            "polytropic exponent of the gas that leaves the second space (that of inflow)",
        ),
        table("open", &GATE, "trigger that opens and shuts the passage"),
        flag("silent", "whether a flow to the atmosphere makes no noise (false)"),
        field(
            "law",
            Either(&[Words(&LAWS), Table(&LAW)]),
            "law of the flow (\"nozzle\")",
        ),
    ],
);
