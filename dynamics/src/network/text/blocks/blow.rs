//! Elastic blows on fasteners.

use std::f64::consts::PI;

use super::list::of_named;
use super::tables::blow::BLOW;
use crate::network::assembly::{ElasticBlow, Family, Fastener, FastenerLaw, Rod, WoodLaw};
use crate::network::text::fault::AssemblyError;
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

/// The blows on the fasteners of an assembly. The law of a wood gives the dimensions of a shank that a blow omits.
pub(super) fn blows(resolver: &Resolver<'_>, fasteners: &[Fastener]) -> Result<Vec<ElasticBlow>, AssemblyError> {
    let read = |(fastener, fields): (usize, Fields<'_, '_>)| {
        let own = &fasteners[fastener];
        let law = match &own.law {
            FastenerLaw::Wood(law) => Some(law.as_ref()),
            FastenerLaw::SolidWood { .. } | FastenerLaw::Constant(_) | FastenerLaw::Table(_) => None,
        };
        let [rod, shank, wood] = ["rod", "shank", "wood"].map(|key| {
            let table = fields.table(key)?;
            table.ok_or_else(|| fields.missing(key))
        });
        let (rod, shank, wood) = (rod?, shank?, wood?);
        let rod = Rod {
            length: rod.required("length")?,
            area: rod.required("area")?,
            modulus: rod.required("modulus")?,
            density: rod.required("density")?,
        };
        // A field, or the value from the law of a wood.
        let or_law = |fields: &Fields<'_, '_>, key: &str, of_law: fn(&WoodLaw) -> f64| {
            let given = fields.quantity(key)?.or(law.map(of_law));
            given.ok_or_else(|| fields.missing(key))
        };
        let diameter = or_law(&shank, "diameter", |law| law.diameter)?;
        let head_diameter = or_law(&shank, "head_diameter", |law| law.head_diameter)?;
        let legs = shank.or("legs", law.map_or(1.0, |law| f64::from(law.legs)))?;
        let disc = |diameter: f64| 0.25 * PI * diameter * diameter;
        Ok(ElasticBlow {
            fastener,
            rod,
            shank: Rod {
                length: own.length,
                area: legs * disc(diameter),
                modulus: shank.or("modulus", rod.modulus)?,
                density: shank.or("density", rod.density)?,
            },
            perimeter: legs * PI * diameter,
            head_area: disc(head_diameter),
            wood_density: or_law(&wood, "density", |law| law.wood.density)?,
            shear_speed: wood.required("shear_speed")?,
        })
    };
    of_named(resolver, "blow", (Family::Fastener, "fastener"), &BLOW)?
        .into_iter()
        .map(read)
        .collect()
}
