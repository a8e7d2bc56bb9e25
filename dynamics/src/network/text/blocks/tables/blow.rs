//! Fields of elastic blows on fasteners.

use nailnoise_quantities::dimension::{AREA, DENSITY, LENGTH, PRESSURE, VELOCITY};
use nailnoise_quantities::{Kind, positive};

use crate::network::text::table::{FieldSpec, TableSpec, quantity, table};

/// Domain of Young's modulus.
const MODULUS: Kind = positive(PRESSURE).within(1e9, 1e12);

const fn modulus(text: &'static str) -> FieldSpec {
    quantity("modulus", MODULUS, "\"205 GPa\"", text)
}

const fn density(text: &'static str) -> FieldSpec {
    quantity("density", positive(DENSITY), "\"7850 kg/m3\"", text)
}

const ROD: TableSpec = TableSpec::of(
    "rod of a driver",
    &[
        quantity("length", positive(LENGTH), "\"120 mm\"", "length"),
        quantity("area", positive(AREA), "\"30 mm2\"", "cross-section"),
        modulus("Young's modulus"),
        density("density"),
    ],
);

const SHANK: TableSpec = TableSpec::of(
    "shank of a fastener",
    &[
        quantity(
            "diameter",
            positive(LENGTH),
            "\"1.2 mm\"",
            "diameter of a shank (that of the law of a wood)",
        ),
        quantity(
            "legs",
            Kind::Count(2),
            "2",
            "number of shanks (that of the law of a wood, or 1)",
        ),
        quantity(
            "head_diameter",
            positive(LENGTH),
            "\"2 mm\"",
            "diameter of the head, or of a circle with the area of a crown (that of the law of a wood)",
        ),
        modulus("Young's modulus (that of the rod)"),
        density("density (that of the rod)"),
    ],
);

const WOOD: TableSpec = TableSpec::of(
    "wood of a blow",
    &[
        density("density (that of the law of a wood)").such_as("\"500 kg/m3\""),
        quantity(
            "shear_speed",
            positive(VELOCITY).within(10.0, 1e4),
            "\"700 m/s\"",
            "speed of the shear waves that the fastener radiates",
        ),
    ],
);

pub(in crate::network::text::blocks) const BLOW: TableSpec = TableSpec::of(
    "blow",
    &[
        table("rod", &ROD, "the part of the driver that strikes the fastener")
            .such_as("{ length = \"120 mm\", area = \"30 mm2\", modulus = \"205 GPa\", density = \"7850 kg/m3\" }"),
        table("shank", &SHANK, "the shank of the fastener")
            .such_as("{ diameter = \"1.2 mm\", head_diameter = \"2 mm\" }"),
        table("wood", &WOOD, "the wood around the fastener")
            .such_as("{ density = \"500 kg/m3\", shear_speed = \"700 m/s\" }"),
    ],
);
