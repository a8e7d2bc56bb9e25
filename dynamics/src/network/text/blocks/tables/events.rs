//! Fields of triggers, sensors and events.

use nailnoise_quantities::dimension::TIME;
use nailnoise_quantities::nonnegative;

use crate::network::assembly::Pick;
use crate::network::text::table::FieldType::{Either, Flag, List, Pair, Quantity, Table, Text};
use crate::network::text::table::{FieldSpec, TableSpec, field, flag, one_of, quantity, text, words};

/// Which of several edges counts.
pub(in crate::network::text::blocks) const PICKS: [(&str, Pick); 2] = [("first", Pick::First), ("last", Pick::Last)];
const PICK_WORDS: [&str; 2] = words(&PICKS);

const TIMES: crate::network::text::table::FieldType = Quantity(nonnegative(TIME));
const WORD: &str = "what a block logs, as \"guard opens\", or a list of these";
const CONDITION: &str = "a condition, as \"piston.travel > 1 mm\"";

const fn logged(name: &'static str, text: &'static str) -> FieldSpec {
    field(name, Either(&[Text(WORD), List(&Text(WORD))]), text)
}

pub(in crate::network::text::blocks) const STEP: TableSpec = TableSpec::of(
    "step of a schedule",
    &[
        quantity("at", nonnegative(TIME), "\"5 ms\"", "time"),
        flag("on", "whether the trigger is on from then"),
    ],
);

pub(in crate::network::text::blocks) const TRIGGER: TableSpec = TableSpec::of(
    "trigger",
    &[
        flag("starts", "whether it is on at t = 0 (false)"),
        logged("set", "words of blocks that switch it on"),
        logged("clear", "words of blocks that switch it off"),
        field(
            "schedule",
            List(&Either(&[Pair(&[TIMES, Flag]), Table(&STEP)])),
            "times at which it is switched, in ascending order",
        )
        .such_as("[[\"5 ms\", false]]"),
    ],
);

pub(in crate::network::text::blocks) const SENSOR: TableSpec = TableSpec::of(
    "sensor",
    &[
        text("is", "an expression, as \"piston.travel\"", "expression over channels").such_as("\"piston.travel\""),
        text("unit", "a unit", "unit of the expression").such_as("\"m\""),
    ],
);

pub(in crate::network::text::blocks) const EVENT: TableSpec = TableSpec::of(
    "event",
    &[
        text(
            "text",
            "a text",
            "description, which tables and charts show with the name",
        ),
        quantity("at", nonnegative(TIME), "\"0 s\"", "time of the event"),
        text(
            "becomes",
            CONDITION,
            "condition at whose beginning it happens, or a word of a block, as \"bumper closes\"",
        )
        .such_as("\"piston.travel > 1 mm\""),
        text(
            "is",
            CONDITION,
            "condition that may be satisfied from the start of the search",
        ),
        text("after", "the name of an event", "event that must have happened"),
        quantity(
            "delay",
            nonnegative(TIME),
            "\"1 ms\"",
            "time that must have passed since `after` (0)",
        ),
        text("before", "the name of an event", "event that must not have happened"),
        text("until", "the name of an event", "event at which the search ends"),
        text("where", CONDITION, "further condition at that time"),
        quantity(
            "for",
            nonnegative(TIME),
            "\"2 ms\"",
            "duration for which the condition must be satisfied (0)",
        ),
        one_of("pick", &PICK_WORDS, "which of several counts (\"first\")"),
    ],
);
