//! Fasteners, and the laws of the resistance to them.

use nailnoise_penetration::{HeadLaw, NailedWood, RateLaw, ResistanceLaw, Shanks, Wood};

use super::list::each;
use super::mechanics::WIDTH;
use super::tables::fastener::{FASTENER, IMPACTS, LAW_KINDS, LEAVES, LawKind};
use crate::network::assembly::{Base, Body, Family, Fastener, FastenerLaw, Seated, WoodLaw};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

/// Fasteners that the bodies drive.
pub(super) fn fasteners(resolver: &Resolver<'_>, bodies: &[Body]) -> Result<Vec<Fastener>, AssemblyError> {
    let read = |(name, fields): (&str, &Fields<'_, '_>)| {
        let law = fields.table("law")?.ok_or_else(|| fields.missing("law"))?;
        let driver = fields.index("driver", Family::Body, "body")?;
        let into = fields.base("into")?.ok_or_else(|| fields.missing("into"))?;
        if into == Base::Body(driver) {
            let space = fields.text("into")?.unwrap_or_default().to_owned();
            return Err(fields.error("into", Fault::SelfLoop { space }));
        }
        Ok(Fastener {
            name: name.to_owned(),
            driver,
            into,
            guide: fields.base("guide")?.unwrap_or(Base::Ground),
            head_at: fields.required("head_at")?,
            tip_at: fields.required("tip_at")?,
            length: fields.required("length")?,
            mass: fields.required("mass")?,
            impact: fields.word("impact", &IMPACTS)?.unwrap_or(true),
            leaves_unloaded: fields.word("leaves", &LEAVES)?.unwrap_or(false),
            reversible: law.flag("reversible", false)?,
            law: fastener_law(&law, bodies.get(driver).map_or(0.0, |body| body.mass))?,
            seated: Seated {
                head_stiffness: fields.required("head_stiffness")?,
                unloading: fields.required("unloading")?,
                guide_friction: fields.or("guide_friction", 0.0)?,
                guide_width: fields.or("guide_width", WIDTH)?,
            },
        })
    };
    let blocks = each(resolver, Family::Fastener, &FASTENER)?;
    let mut fasteners: Vec<Fastener> = Vec::with_capacity(blocks.len());
    for (name, fields) in blocks {
        let fastener = read((name, &fields))?;
        if let Some(other) = fasteners.iter().find(|other| other.driver == fastener.driver) {
            let driver = bodies
                .get(fastener.driver)
                .map_or_else(String::new, |own| own.name.clone());
            let other = other.name.clone();
            return Err(fields.error("driver", Fault::TwoFasteners { driver, other }));
        }
        fasteners.push(fastener);
    }
    Ok(fasteners)
}

/// The law of a fastener that a mass drives \[kg\].
fn fastener_law(law: &Fields<'_, '_>, driving_mass: f64) -> Result<FastenerLaw, AssemblyError> {
    match law.word("kind", &LAW_KINDS)? {
        Some(LawKind::SolidWood) => Ok(FastenerLaw::SolidWood {
            hardness: law.required("hardness")?,
            offset: law.or("offset", 0.0)?,
        }),
        Some(LawKind::Wood) => Ok(FastenerLaw::Wood(Box::new(wood_law(law, driving_mass)?))),
        Some(LawKind::Constant) => Ok(FastenerLaw::Constant(law.required("force")?)),
        Some(LawKind::Table) => {
            let points = law.points("points")?;
            points.map(FastenerLaw::Table).ok_or_else(|| law.missing("points"))
        }
        None => Err(law.missing("kind")),
    }
}

/// A wood by its properties; those without a field have no effect.
fn wood_law(law: &Fields<'_, '_>, driving_mass: f64) -> Result<WoodLaw, AssemblyError> {
    let resistance = law.choice("resistance", ResistanceLaw::WORDS)?;
    let quasi_static = Wood {
        density: law.required("density")?,
        hardness_modulus: law.required("hardness")?,
        penetration_law: resistance.ok_or_else(|| law.missing("resistance"))?,
        speed_term: law.or("speed_term", 0.0)?,
        slenderness_term: law.or("slenderness_term", 0.0)?,
        penetration_force: law.or("force", 0.0)?,
        resistance_scale: law.or("scale", 1.0)?,
        head_stiffness_scale: 1.0,
        unloading_stiffness: 1.0,
    };
    let plain = NailedWood::quasi_static(quasi_static);
    let wood = NailedWood {
        rate: law.choice("rate", RateLaw::WORDS)?.unwrap_or(plain.rate),
        crushing_rate: law.or("crushing_rate", plain.crushing_rate)?,
        friction_at_rest: law.or("friction_at_rest", plain.friction_at_rest)?,
        friction_sliding: law.or("friction_sliding", plain.friction_sliding)?,
        friction_speed: law.or("friction_speed", plain.friction_speed)?,
        head_law: law.choice("head", HeadLaw::WORDS)?.unwrap_or(plain.head_law),
        head_yield_scale: law.or("head_yield_scale", plain.head_yield_scale)?,
        ring_amplitude: law.or("ring_amplitude", plain.ring_amplitude)?,
        ring_width: law.or("ring_width", plain.ring_width)?,
        ring_seed: law.or("ring_seed", f64::from(plain.ring_seed))? as u32,
        ..plain
    };
    Ok(WoodLaw {
        wood,
        table: None,
        fit: None,
        diameter: law.required("diameter")?,
        head_diameter: law.required("head_diameter")?,
        driving_mass,
        legs: law.or("legs", 1.0)? as u32,
        friction_share: law.or("friction_share", Shanks::SMOOTH.friction_share)?,
        coating: law.or("coating", Shanks::SMOOTH.coating)?,
        deviation: law.or("deviation", 0.0)?,
    })
}
