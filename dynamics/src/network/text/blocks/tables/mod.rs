//! The tables of `[cycle]`, one module per kind, with the domains and examples that the readers use.

pub(super) mod blow;
pub(super) mod events;
pub(super) mod fastener;
pub(super) mod gas;
pub(super) mod mechanics;
pub(super) mod outputs;
mod phrases;

use nailnoise_quantities::dimension::{ACCELERATION, GAS_CONSTANT, NUMBER, TEMPERATURE, TIME};
use nailnoise_quantities::{any, nonnegative, positive};

use crate::network::assembly::Ledger;
use crate::network::text::table::FieldType::{Either, List, Pair, Table, Text, Value};
use crate::network::text::table::{TableSpec, blocks, field, one_of, quantity, table, text, words};

/// Balances that a record contains.
pub(super) const LEDGERS: [(&str, Ledger); 2] = [("lean", Ledger::Lean), ("full", Ledger::Full)];
const LEDGER_WORDS: [&str; 2] = words(&LEDGERS);

const GAS: TableSpec = TableSpec::of(
    "gas",
    &[
        quantity(
            "constant",
            positive(GAS_CONSTANT),
            "\"287.05 J/(kg K)\"",
            "specific gas constant",
        ),
        quantity(
            "ratio",
            positive(NUMBER).within(1.01, 1.7),
            "1.4",
            "ratio of the heat capacities",
        ),
        one_of(
            "law",
            &gas::GAS_WORDS,
            "balance of energy, or a polytropic law (\"ideal\")",
        ),
        quantity(
            "exponent",
            gas::EXPONENT,
            "\"=model.polytropic\"",
            "polytropic exponent of a change of volume",
        ),
        quantity(
            "inflow_exponent",
            gas::EXPONENT,
            "\"=model.polytropic_inflow\"",
            "polytropic exponent of the gas that flows",
        ),
        quantity(
            "temperature",
            positive(TEMPERATURE),
            "\"=ambient.temperature\"",
            "constant temperature of a polytropic gas",
        ),
    ],
);

const FINISH: TableSpec = TableSpec::of(
    "finish",
    &[
        text("event", "the name of an event", "event after which the cycle ends").such_as("\"t18\""),
        quantity("tail", nonnegative(TIME), "\"5 ms\"", "time computed after it (0)"),
        text(
            "never_past",
            "the name of an event",
            "event at which the cycle ends in any case",
        ),
    ],
);

const TEST: &str = "\"EVENT\", \"no EVENT\", \"EVENT before EVENT\", or a condition at the end";
const OUTCOMES: TableSpec = TableSpec::open("outcome", &Text(TEST));
/// Values of names; groups of them are layout only.
const LETS: TableSpec = TableSpec::open("let", &Value);

/// `[cycle]`: families of blocks, and fields of the cycle.
pub const CYCLE: TableSpec = TableSpec::of(
    "cycle",
    &[
        blocks(
            "reservoir",
            &gas::RESERVOIR,
            "spaces of constant pressure; `atmosphere` must exist",
        ),
        blocks(
            "body",
            &mechanics::BODY,
            "bodies that move along the axis of the tool, +y down",
        ),
        blocks("volume", &gas::VOLUME, "volumes of gas"),
        blocks(
            "face",
            &gas::FACE,
            "places where gas acts on a body, and the body sweeps the volume",
        ),
        blocks("passage", &gas::PASSAGE, "flows between two spaces"),
        blocks("contact", &mechanics::CONTACT, "stops of a body"),
        blocks("spring", &mechanics::SPRING, "springs"),
        blocks("friction", &mechanics::FRICTION, "friction"),
        blocks(
            "force",
            &mechanics::FORCE_TABLE,
            "forces: constant, over time, or of a jet",
        ),
        blocks("motor", &mechanics::MOTOR, "motors whose force falls with the speed"),
        blocks("hold", &mechanics::HOLD, "latches"),
        blocks(
            "fastener",
            &fastener::FASTENER,
            "fasteners that a body drives into another",
        ),
        blocks(
            "blow",
            &blow::BLOW,
            "for each fastener, elastic bars of driver and fastener: the waves of the impact",
        ),
        blocks(
            "trigger",
            &events::TRIGGER,
            "switches, which passages, motors and latches follow",
        ),
        blocks("sensor", &events::SENSOR, "expressions over channels that are recorded"),
        blocks("event", &events::EVENT, "conditions whose times are recorded"),
        blocks(
            "opening",
            &outputs::OPENING,
            "passages to the atmosphere that make noise",
        ),
        blocks(
            "load",
            &outputs::LOAD,
            "for each body, forces on its surfaces, down; they add up to the force on it",
        ),
        table("gas", &GAS, "gas of all volumes").such_as("{ constant = \"287.05 J/(kg K)\", ratio = 1.4 }"),
        quantity(
            "gravity",
            any(ACCELERATION),
            "\"9.81 m/s2\"",
            "acceleration due to gravity, down (0)",
        ),
        quantity(
            "linear",
            positive(NUMBER).within(1e-6, 0.1),
            "1e-3",
            "relative pressure difference below which a flow is linear (0.001)",
        ),
        quantity(
            "end",
            positive(TIME).within(1e-6, 10.0),
            "\"100 ms\"",
            "end of the cycle",
        ),
        table("finish", &FINISH, "earlier end, after an event"),
        one_of("ledger", &LEDGER_WORDS, "which balances are recorded (\"lean\")"),
        table("let", &LETS, "names for formulas"),
        field(
            "outcome",
            Either(&[Table(&OUTCOMES), List(&Pair(&[Text("a name"), Text(TEST)]))]),
            "names and tests of outcomes; the first that is satisfied names the shot",
        ),
        blocks(
            "pressure",
            &outputs::PRESSURE,
            "for each body, spaces whose pressure acts on its walls without a net force",
        ),
        table(
            "columns",
            &outputs::COLUMNS,
            "names of columns of files, each with a channel, a sensor, a quantity of an opening or an expression",
        ),
        table(
            "marker",
            &outputs::MARKERS,
            "events of the markers of a measurement (the events of the N80CB that the assembly has)",
        ),
    ],
);
