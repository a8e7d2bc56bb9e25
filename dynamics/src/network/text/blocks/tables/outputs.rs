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
