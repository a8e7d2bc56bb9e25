//! Fields of fasteners and of the laws of the resistance to them.

use nailnoise_penetration::{HeadLaw, RateLaw, ResistanceLaw};
use nailnoise_quantities::dimension::{DENSITY, FORCE, LENGTH, MASS, NUMBER, STIFFNESS, VELOCITY, VELOCITY_SQUARED};
use nailnoise_quantities::{Kind, any, fraction, nonnegative, positive};

use super::mechanics::force;
use super::phrases::{BASE, BODY_NAME};
use crate::network::text::table::FieldType::{List, Pair, Quantity};
use crate::network::text::table::{TableSpec, field, flag, name_of, one_of, quantity, table, words};

/// Impacts of a driver on a fastener, and whether the impact is plastic.
pub(in crate::network::text::blocks) const IMPACTS: [(&str, bool); 2] = [("plastic", true), ("mass", false)];
const IMPACT_WORDS: [&str; 2] = words(&IMPACTS);
/// Words for the time when a driver leaves a fastener, and whether it is when the work no longer pushes back.
pub(in crate::network::text::blocks) const LEAVES: [(&str, bool); 2] = [("reversal", false), ("unloaded", true)];
const LEAVES_WORDS: [&str; 2] = words(&LEAVES);
/// Laws of the resistance to a fastener.
#[derive(Clone, Copy)]
pub(in crate::network::text::blocks) enum LawKind {
    SolidWood,
    Constant,
    Table,
    Wood,
}
pub(in crate::network::text::blocks) const LAW_KINDS: [(&str, LawKind); 4] = [
    ("solid_wood", LawKind::SolidWood),
    ("constant", LawKind::Constant),
    ("table", LawKind::Table),
    ("wood", LawKind::Wood),
];
const LAW_WORDS: [&str; 4] = words(&LAW_KINDS);
const FASTENER_LAW: TableSpec = TableSpec::of(
    "law of a fastener",
    &[
        one_of("kind", &LAW_WORDS, "law of the resistance").such_as("\"constant\""),
        quantity(
            "hardness",
            nonnegative(STIFFNESS),
            "\"=wood.hardness_modulus\"",
            "hardness modulus of a wood; of solid wood times a factor on the resistance",
        ),
        quantity("offset", any(NUMBER), "0", "sum of the other terms of solid wood (0)"),
        force("force", "\"600 N\"", "constant resistance"),
        one_of("resistance", ResistanceLaw::WORDS, "law of the resistance of a wood")
            .such_as("\"=wood.penetration_law\""),
        quantity("density", positive(DENSITY), "\"=wood.density\"", "density of a wood"),
        quantity(
            "scale",
            nonnegative(NUMBER).within(0.0, 1e3),
            "\"=wood.resistance_scale\"",
            "factor on the resistance of a wood (1)",
        ),
        quantity(
            "speed_term",
            any(VELOCITY_SQUARED).within(-1e5, 1e5),
            "\"=wood.speed_term\"",
            "speed term of solid wood (0)",
        ),
        quantity(
            "slenderness_term",
            any(NUMBER).within(-100.0, 100.0),
            "\"=wood.slenderness_term\"",
            "slenderness term of solid wood (0)",
        ),
        quantity(
            "diameter",
            positive(LENGTH),
            "\"=nail.diameter\"",
            "diameter of the shank",
        ),
        quantity(
            "head_diameter",
            positive(LENGTH),
            "\"=nail.head_diameter\"",
            "diameter of the head",
        ),
        quantity("legs", Kind::Count(2), "\"=nail.legs\"", "number of shanks (1)"),
        quantity(
            "friction_share",
            fraction(),
            "\"=wood.friction_share\"",
            "friction along the shank as a share of the resistance at full depth (0.81)",
        ),
        quantity(
            "coating",
            positive(NUMBER).within(0.01, 10.0),
            "\"=nail.coating\"",
            "factor of a coating on that friction (1)",
        ),
        quantity(
            "deviation",
            any(NUMBER).within(-1.0, 1.0),
            "\"=specimen.deviation\"",
            "deviation of a specimen from the law of a wood, of sqrt(F/(hardness length)) (0)",
        ),
        one_of("rate", RateLaw::WORDS, "dependence on the speed (\"none\")").such_as("\"=wood.rate\""),
        quantity(
            "crushing_rate",
            nonnegative(NUMBER).within(0.0, 1.0),
            "\"=wood.crushing_rate\"",
            "increase of the crushing strength per decade of speed (0)",
        ),
        quantity(
            "friction_at_rest",
            positive(NUMBER).within(0.01, 2.0),
            "\"=wood.friction_at_rest\"",
            "coefficient of friction of the shank at rest (1)",
        ),
        quantity(
            "friction_sliding",
            positive(NUMBER).within(0.01, 2.0),
            "\"=wood.friction_sliding\"",
            "coefficient of friction at high speed (1)",
        ),
        quantity(
            "friction_speed",
            positive(VELOCITY).within(1e-3, 1e3),
            "\"=wood.friction_speed\"",
            "speed over which friction falls from rest to high speed (1 m/s)",
        ),
        one_of("head", HeadLaw::WORDS, "force of a wood under the head (\"linear\")").such_as("\"=wood.head_law\""),
        quantity(
            "head_yield_scale",
            positive(NUMBER).within(0.01, 100.0),
            "\"=wood.head_yield_scale\"",
            "factor on the force at which it yields (1)",
        ),
        quantity(
            "ring_amplitude",
            fraction(),
            "\"=wood.ring_amplitude\"",
            "rise and fall of the tip's resistance in each growth ring (0)",
        ),
        quantity(
            "ring_width",
            positive(LENGTH).within(1e-4, 0.1),
            "\"=wood.ring_width\"",
            "mean width of a growth ring (4 mm)",
        ),
        quantity(
            "ring_seed",
            Kind::Count(1_000_000),
            "\"=wood.ring_seed\"",
            "number from which the rings are drawn (1)",
        ),
        field(
            "points",
            List(&Pair(&[Quantity(nonnegative(LENGTH)), Quantity(nonnegative(FORCE))])),
            "resistance over the depth of the tip",
        )
        .such_as("[[\"0 mm\", \"0 N\"], [\"50 mm\", \"900 N\"]]"),
        flag(
            "reversible",
            "whether the resistance acts along the same curve upwards (false)",
        ),
    ],
);

pub(in crate::network::text::blocks) const FASTENER: TableSpec = TableSpec::of(
    "fastener",
    &[
        name_of("driver", BODY_NAME, "body that drives it"),
        name_of("into", BASE, "body that it enters"),
        name_of("guide", BASE, "body that guides it (ground)"),
        quantity(
            "head_at",
            any(LENGTH),
            "\"30 mm\"",
            "travel of the driver at which it strikes the head",
        ),
        quantity(
            "tip_at",
            any(LENGTH),
            "\"32 mm\"",
            "travel of the driver at which the tip enters the work",
        ),
        quantity("length", positive(LENGTH), "\"=nail.length\"", "length"),
        quantity("mass", nonnegative(MASS), "\"0.9 g\"", "mass"),
        one_of(
            "impact",
            &IMPACT_WORDS,
            "whether the driver's impact is plastic, or the mass only joins (\"plastic\")",
        ),
        one_of(
            "leaves",
            &LEAVES_WORDS,
            "whether the driver leaves it at its reversal, or where the work no longer pushes back (\"reversal\")",
        ),
        table("law", &FASTENER_LAW, "resistance of the work").such_as("{ kind = \"constant\", force = \"600 N\" }"),
        quantity(
            "head_stiffness",
            nonnegative(STIFFNESS),
            "\"400 N/mm\"",
            "stiffness of the work below the head",
        ),
        quantity(
            "unloading",
            positive(STIFFNESS),
            "\"5 kN/mm\"",
            "stiffness of the work when the tip moves back",
        ),
        force("guide_friction", "\"10 N\"", "friction in the guide (0)"),
        quantity(
            "guide_width",
            positive(VELOCITY),
            "\"1 mm/s\"",
            "velocity over which it changes its sign (1 mm/s)",
        ),
    ],
);
