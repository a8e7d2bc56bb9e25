//! Reservoirs, volumes, faces and passages.

use super::list::{each, is_atmosphere, parent};
use super::tables::gas::{
    CONES, DELAYS, FACE, FLOW_LAWS, GASES, LAW_WORDS, LEAVES, PASSAGE, RESERVOIR, RESTRICTION, VOLUME,
};
use crate::network::assembly::{
    Base, Coefficient, Face, Family, Gate, Opens, Passage, PassageLaw, Pipe, Polytropic, Reservoir, Restriction, Space,
    Volume, Wall,
};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

/// The polytropic law of the gas, if it has one.
pub(super) fn polytropic(gas: &Fields<'_, '_>) -> Result<Option<Polytropic>, AssemblyError> {
    if gas.word("law", &GASES)? != Some(true) {
        return Ok(None);
    }
    Ok(Some(Polytropic {
        exponent: gas.required("exponent")?,
        inflow: gas.required("inflow_exponent")?,
        temperature: gas.required("temperature")?,
    }))
}

pub(super) fn reservoirs(resolver: &Resolver<'_>) -> Result<Vec<Reservoir>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        Ok(Reservoir {
            name: name.to_owned(),
            pressure: fields.required("pressure")?,
            temperature: fields.required("temperature")?,
        })
    };
    each(resolver, Family::Reservoir, &RESERVOIR)?
        .into_iter()
        .map(read)
        .collect()
}

/// Volumes; without a given temperature, they have that of the atmosphere \[K\].
pub(super) fn volumes(resolver: &Resolver<'_>, atmosphere: f64) -> Result<Vec<Volume>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let wall = fields.table("wall")?;
        let wall = wall
            .map(|wall| {
                Ok(Wall {
                    area: wall.or("area", 0.0)?,
                    transfer: wall.required("transfer")?,
                    temperature: wall.or("temperature", atmosphere)?,
                })
            })
            .transpose()?;
        Ok(Volume {
            name: name.to_owned(),
            dead: fields.required("dead")?,
            pressure: fields.required("pressure")?,
            temperature: fields.or("temperature", atmosphere)?,
            wall,
            isothermal: fields.flag("isothermal", false)?,
            exhaust_path: fields.flag("exhaust_path", false)?,
        })
    };
    each(resolver, Family::Volume, &VOLUME)?.into_iter().map(read).collect()
}

pub(super) fn faces(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Face>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let body = fields.index("body", Family::Body, "body")?;
        let gas = fields.text("volume")?.ok_or_else(|| fields.missing("volume"))?;
        Ok(Face {
            name: name.to_owned(),
            gas: fields.space("volume", gas)?,
            body,
            against: fields.against(body, parents)?,
            push: fields.push("push")?,
            area: fields.required("area")?,
            zero: fields.or("zero", 0.0)?,
            perimeter: fields.or("perimeter", 0.0)?,
            sweeps: !fields.flag("constant_volume", false)?,
        })
    };
    each(resolver, Family::Face, &FACE)?.into_iter().map(read).collect()
}

/// Fields that give the area of a restriction.
const AREAS: [&str; 5] = ["area", "seat", "holes", "ramp", "pipe"];

pub(super) fn passages(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Passage>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let [from, to] = between(&fields)?;
        fields.one_of(
            &["area", "seat", "holes", "ramp", "pipe", "series"],
            "area = \"20 mm2\"",
        )?;
        let coefficient = coefficient(&fields)?.unwrap_or(Coefficient::Constant(1.0));
        let restrictions = match fields.array("series", "a list of restrictions")? {
            Some(_) => series(&fields, &coefficient, parents)?,
            None => vec![restriction(&fields, String::new(), coefficient, parents)?],
        };
        let gate = fields.table("open")?;
        Ok(Passage {
            name: name.to_owned(),
            from,
            to,
            restrictions,
            law: law(&fields)?,
            one_way: fields.flag("one_way", false)?,
            exponents: [
                fields.quantity("outflow_exponent")?,
                fields.quantity("backflow_exponent")?,
            ],
            gate: gate.map(|gate| read_gate(&gate)).transpose()?,
            silent: fields.flag("silent", false)?,
        })
    };
    each(resolver, Family::Passage, &PASSAGE)?
        .into_iter()
        .map(read)
        .collect()
}

fn between(fields: &Fields<'_, '_>) -> Result<[Space; 2], AssemblyError> {
    const EXAMPLE: &str = "two spaces, as [\"supply\", \"atmosphere\"]";
    let items = fields
        .array("between", EXAMPLE)?
        .ok_or_else(|| fields.missing("between"))?;
    let names: Option<Vec<&str>> = items.iter().map(|item| item.text()).collect();
    let Some([from, to]) = names.as_deref() else {
        return Err(fields.wrong("between", EXAMPLE));
    };
    let spaces = [fields.space("between", from)?, fields.space("between", to)?];
    if spaces[0] == spaces[1] {
        let space = (*from).to_owned();
        return Err(fields.error("between", Fault::SelfLoop { space }));
    }
    Ok(spaces)
}

/// Largest number of restrictions in series.
const MOST_RESTRICTIONS: usize = 3;

fn series(
    fields: &Fields<'_, '_>,
    coefficient: &Coefficient,
    parents: &[Base],
) -> Result<Vec<Restriction>, AssemblyError> {
    const EXPECTED: &str = "one to three restrictions with different names";
    let mut restrictions: Vec<Restriction> = Vec::new();
    for item in fields.array("series", "a list of restrictions")?.unwrap_or_default() {
        let name = item.get("name").and_then(|name| name.text()).unwrap_or_default();
        let path = format!("{}.{name}", fields.full("series"));
        let inner = Fields::new(fields.resolver, path.clone(), item, &RESTRICTION)?;
        if name.is_empty() {
            return Err(inner.missing("name"));
        }
        if !fields.resolver.is_on(&path, item)? {
            continue;
        }
        if restrictions.iter().any(|known| known.name == name) {
            return Err(fields.wrong("series", EXPECTED));
        }
        inner.one_of(&AREAS, "area = \"20 mm2\"")?;
        let own = self::coefficient(&inner)?.unwrap_or_else(|| coefficient.clone());
        restrictions.push(restriction(&inner, name.to_owned(), own, parents)?);
    }
    if (1..=MOST_RESTRICTIONS).contains(&restrictions.len()) {
        Ok(restrictions)
    } else {
        Err(fields.wrong("series", EXPECTED))
    }
}

fn coefficient(fields: &Fields<'_, '_>) -> Result<Option<Coefficient>, AssemblyError> {
    let is_polynomial = fields
        .get("coefficient")
        .is_some_and(|node| node.is_table() && !node.is_literal_table());
    if !is_polynomial {
        let constant = fields.quantity("coefficient")?;
        return Ok(constant.map(Coefficient::Constant));
    }
    let Some(table) = fields.table("coefficient")? else {
        return Ok(None);
    };
    Ok(Some(Coefficient::RatioPolynomial {
        coefficients: table
            .numbers("ratio_polynomial", "coefficients of r^0, r^1, ..., as [1.1, -0.71]")?
            .ok_or_else(|| table.missing("ratio_polynomial"))?,
        from: table.required("from")?,
        to: table.required("to")?,
    }))
}

fn restriction(
    fields: &Fields<'_, '_>,
    name: String,
    coefficient: Coefficient,
    parents: &[Base],
) -> Result<Restriction, AssemblyError> {
    let pipe = fields.table("pipe")?;
    let pipe = pipe
        .map(|pipe| {
            Ok(Pipe {
                length: pipe.required("length")?,
                diameter: pipe.required("diameter")?,
                friction: pipe.or("friction", 0.02)?,
            })
        })
        .transpose()?;
    let opens = match pipe {
        Some(pipe) => Opens::Constant {
            area: 0.25 * std::f64::consts::PI * pipe.diameter * pipe.diameter,
        },
        None => opens(fields, parents)?,
    };
    Ok(Restriction {
        name,
        opens,
        coefficient,
        pipe,
    })
}

/// The area of a restriction as a function of the state.
fn opens(fields: &Fields<'_, '_>, parents: &[Base]) -> Result<Opens, AssemblyError> {
    if let Some(seat) = fields.table("seat")? {
        let body = seat.index("body", Family::Body, "body")?;
        return Ok(Opens::Seat {
            body,
            against: seat.base("against")?.unwrap_or_else(|| parent(parents, body)),
            push: seat.push("opens")?,
            at: seat.or("at", 0.0)?,
            diameter: seat.required("diameter")?,
            angle: seat.required("angle")?,
            cone: seat.word("cone", &CONES)?.ok_or_else(|| seat.missing("cone"))?,
        });
    }
    if let Some(holes) = fields.table("holes")? {
        let body = holes.index("body", Family::Body, "body")?;
        return Ok(Opens::Holes {
            body,
            against: holes.base("against")?.unwrap_or_else(|| parent(parents, body)),
            push: holes.push("opens")?,
            at: holes.or("at", 0.0)?,
            area: holes.required("area")?,
            diameter: holes.quantity("diameter")?,
        });
    }
    if let Some(ramp) = fields.table("ramp")? {
        return Ok(Opens::Ramp {
            area: ramp.required("area")?,
            time: ramp.required("time")?,
        });
    }
    Ok(Opens::Constant {
        area: fields.required("area")?,
    })
}

fn law(fields: &Fields<'_, '_>) -> Result<PassageLaw, AssemblyError> {
    let Some(node) = fields.get("law") else {
        return Ok(PassageLaw::Nozzle);
    };
    if node.is_table() {
        let Some(law) = fields.table("law")? else {
            return Ok(PassageLaw::Nozzle);
        };
        law.word("kind", &FLOW_LAWS)?.ok_or_else(|| law.missing("kind"))?;
        return Ok(PassageLaw::Iso6358 {
            critical_ratio: law.required("critical_ratio")?,
        });
    }
    match fields.word("law", &LAW_WORDS)? {
        Some(false) => Err(fields.wrong("law", "{ kind = \"iso6358\", critical_ratio = 0.3 }")),
        Some(true) | None => Ok(PassageLaw::Nozzle),
    }
}

fn read_gate(gate: &Fields<'_, '_>) -> Result<Gate, AssemblyError> {
    let when = gate.text("when")?.ok_or_else(|| gate.missing("when"))?;
    let (inverted, name) = when
        .strip_prefix("not ")
        .map_or((false, when), |name| (true, name.trim()));
    Ok(Gate {
        trigger: gate.block_of("when", name, &[Family::Trigger], "trigger")?.index,
        inverted,
        delay: gate.or("delay", 0.0)?,
        before: gate.flag("before", false)?,
        delays_flow: gate.word("delays", &DELAYS)?.unwrap_or(false),
        leaves_undelayed: gate.word("leaves", &LEAVES)?.unwrap_or(false),
        also: None,
    })
}

/// The index of a passage, which a field names, if it leads to the atmosphere.
pub(super) fn to_atmosphere(
    fields: &Fields<'_, '_>,
    key: &str,
    passages: &[Passage],
    index: usize,
) -> Result<usize, AssemblyError> {
    let resolver = fields.resolver;
    let Some(passage) = passages.get(index).filter(|own| !reaches_atmosphere(resolver, own)) else {
        return Ok(index);
    };
    let others = passages.iter().filter(|own| reaches_atmosphere(resolver, own));
    Err(fields.error(
        key,
        Fault::UnknownName {
            name: passage.name.clone(),
            wanted: "passage to the atmosphere".to_owned(),
            known: others.map(|own| own.name.clone()).collect(),
        },
    ))
}

/// Whether one end of a passage is the atmosphere.
pub(in crate::network::text) fn reaches_atmosphere(resolver: &Resolver<'_>, passage: &Passage) -> bool {
    is_atmosphere(resolver, passage.from) || is_atmosphere(resolver, passage.to)
}
