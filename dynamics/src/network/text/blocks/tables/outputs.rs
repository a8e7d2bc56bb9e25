//! Fields of openings, loads on surfaces and pressures on walls.

use nailnoise_quantities::dimension::{AREA, LENGTH, NUMBER};
use nailnoise_quantities::positive;

use crate::network::text::table::FieldType::{Either, Table, Text};
use crate::network::text::table::{TableSpec, name_of, quantity, text};

pub(in crate::network::text::blocks) const OPENING: TableSpec = TableSpec::of(
    "opening",
    &[
        name_of("passage", "passage", "passage to the atmosphere"),
        text(
            "restriction",
            "the name of a restriction",
            "restriction of a series from which the jet starts (the last)",
        ),
        quantity("count", positive(NUMBER).within(1.0, 1e4), "8", "number of holes (1)"),
        quantity("diameter", positive(LENGTH), "\"4 mm\"", "diameter of a hole"),
        quantity(
            "area",
            positive(AREA),
            "\"20 mm2\"",
            "area of all holes, instead of `diameter` (the constant area of the restriction)",
        ),
        quantity("pitch", positive(LENGTH), "\"8 mm\"", "distance of the holes"),
        text(
            "outlet",
            "a group of keys, as \"=exhaust\"",
            "group of keys with plenum, pipe fitting and muffler of the design",
        ),
    ],
);

pub(in crate::network::text::blocks) const LOAD: TableSpec =
    TableSpec::open("load", &Text("an expression, as \"piston.travel\""));

pub(in crate::network::text::blocks) const COLUMNS: TableSpec =
    TableSpec::open("table of columns", &Text("an expression, as \"piston.travel\""));

const EVENT_NAME: &str = "the name of an event";

/// The markers that accelerometers and pressure transducers show.
pub(in crate::network::text::blocks) const MARKERS: TableSpec = TableSpec::of(
    "table of markers",
    &[
        text("t0", EVENT_NAME, "trigger"),
        text("t3", EVENT_NAME, "block or table starts to move"),
        text("t4", EVENT_NAME, "piston passes the transducer downwards"),
        text("t7", EVENT_NAME, "largest acceleration of table or block"),
        text("t8", EVENT_NAME, "pressure in the cylinder has come to rest"),
        text("t10", EVENT_NAME, "handle is quiet"),
        text("t11", EVENT_NAME, "piston passes the transducer upwards"),
        text("t12", EVENT_NAME, "piston hits its stop"),
        text("t13", EVENT_NAME, "handle is quiet for good"),
    ],
);

const SPACE_NAME: &str = "the name of a volume or reservoir";

const DIVIDED: TableSpec = TableSpec::of(
    "divided wall",
    &[
        text("above", SPACE_NAME, "space above the body that divides the wall").such_as("\"above_piston\""),
        text("below", SPACE_NAME, "space below it").such_as("\"above_piston\""),
        text(
            "at",
            "an expression, as \"piston.travel\"",
            "place of the division along the wall",
        )
        .such_as("\"piston.travel\""),
    ],
);

pub(in crate::network::text::blocks) const PRESSURE: TableSpec =
    TableSpec::open("pressure", &Either(&[Text(SPACE_NAME), Table(&DIVIDED)]));
