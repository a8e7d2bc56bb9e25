//! Openings, loads on surfaces and pressures on walls.

use nailnoise_quantities::dimension::{FORCE, LENGTH};

use super::events::{Measured, dimensions, expect, expression};
use super::gas::to_atmosphere;
use super::list::{entries, of_named};
use super::tables::outputs::{LOAD, OPENING, PRESSURE};
use crate::network::assembly::{Family, Load, Opening, Opens, Passage, PressurePatch, PressureSurface};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

/// Largest difference of an opening's area from that of its restriction, as a fraction of it: dimensions are rounded.
const AREA_TOLERANCE: f64 = 0.01;

/// Family of the blocks that give the tables of `[cycle.load]` and `[cycle.pressure]` their names.
const BODY: (Family, &str) = (Family::Body, "body");

pub(super) fn openings(resolver: &Resolver<'_>, passages: &[Passage]) -> Result<Vec<Opening>, AssemblyError> {
    let read = |(name, fields): (&str, &Fields<'_, '_>)| {
        let passage = fields.index("passage", Family::Passage, "passage")?;
        let names: Vec<String> = passages
            .get(passage)
            .map_or(&[][..], |passage| &passage.restrictions)
            .iter()
            .map(|restriction| restriction.name.clone())
            .collect();
        let restriction = match fields.text("restriction")? {
            None => names.len().saturating_sub(1),
            Some(found) => names.iter().position(|name| name == found).ok_or_else(|| {
                let found = found.to_owned();
                let passage = passages.get(passage).map_or_else(String::new, |own| own.name.clone());
                let fault = match names.as_slice() {
                    [single] if single.is_empty() => Fault::SingleRestriction { found, passage },
                    _ => Fault::Word {
                        found,
                        words: names.clone(),
                    },
                };
                fields.error("restriction", fault)
            })?,
        };
        let count = fields.or("count", 1.0)?;
        if count.fract() != 0.0 {
            let allowed = "a whole number".to_owned();
            return Err(fields.error("count", Fault::Domain { value: count, allowed }));
        }
        let constant = passages
            .get(passage)
            .and_then(|passage| match passage.restrictions.get(restriction)?.opens {
                Opens::Constant { area } => Some(area),
                _ => None,
            });
        let (field, area) = match (fields.quantity("diameter")?, fields.quantity("area")?) {
            (None, None) => ("area", constant.ok_or_else(|| fields.missing("area"))?),
            (Some(diameter), None) => ("diameter", count * (0.25 * std::f64::consts::PI * diameter * diameter)),
            (None, Some(area)) => ("area", area),
            (Some(_), Some(_)) => {
                let fields_found = ["area", "diameter"].map(str::to_owned).to_vec();
                return Err(fields.own_error(Fault::Exclusive { fields: fields_found }));
            }
        };
        if let Some(restriction) = constant
            && (area - restriction).abs() > AREA_TOLERANCE * restriction
        {
            return Err(fields.error(
                field,
                Fault::OpeningArea {
                    found: area,
                    restriction,
                },
            ));
        }
        Ok(Opening {
            name: name.to_owned(),
            passage: noisy_passage(fields, passages, passage)?,
            restriction,
            count,
            area,
            pitch: fields.quantity("pitch")?,
            outlet: outlet(fields)?,
        })
    };
    let blocks = entries(resolver, "opening", &OPENING)?;
    let mut openings: Vec<Opening> = Vec::with_capacity(blocks.len());
    for (name, fields) in blocks {
        let opening = read((name, &fields))?;
        if let Some(other) = openings.iter().find(|other| other.passage == opening.passage) {
            let fault = Fault::TwoOpenings {
                passage: passages[opening.passage].name.clone(),
                other: other.name.clone(),
            };
            return Err(fields.error("passage", fault));
        }
        openings.push(opening);
    }
    Ok(openings)
}

/// The passage of an opening, if it leads to the atmosphere and is not silent.
fn noisy_passage(fields: &Fields<'_, '_>, passages: &[Passage], index: usize) -> Result<usize, AssemblyError> {
    if passages.get(index).is_some_and(|passage| passage.silent) {
        let found = ["silent = true", "an opening"].map(str::to_owned).to_vec();
        return Err(fields.error("passage", Fault::Exclusive { fields: found }));
    }
    to_atmosphere(fields, "passage", passages, index)
}

fn outlet(fields: &Fields<'_, '_>) -> Result<Option<String>, AssemblyError> {
    let Some(text) = fields.text("outlet")? else {
        return Ok(None);
    };
    let group = text.strip_prefix('=').map(str::trim);
    let group = group.ok_or_else(|| fields.wrong("outlet", &fields.expected("outlet")))?;
    if fields.resolver.has_group(group) {
        return Ok(Some(group.to_owned()));
    }
    let fault = Fault::Formula {
        formula: text.to_owned(),
        problem: format!("no key of `{group}` has a value"),
        help: "name the design that has them, as base = \"designs/n80cb.toml\", or leave the outlet out".to_owned(),
    };
    Err(fields.error("outlet", fault))
}

pub(super) fn loads(resolver: &Resolver<'_>, sensors: &[Measured]) -> Result<Vec<Load>, AssemblyError> {
    let dimensions = dimensions(sensors);
    let mut loads = Vec::new();
    for (body, fields) in of_named(resolver, "load", BODY, &LOAD)? {
        for surface in fields.node.entries().iter().filter(|surface| surface.key != "if") {
            let force =
                expression(&fields, &surface.key, &dimensions, true)?.ok_or_else(|| fields.missing(&surface.key))?;
            expect(&fields, &surface.key, &force, FORCE)?;
            loads.push(Load {
                body,
                surface: surface.key.clone(),
                force: force.value,
            });
        }
    }
    Ok(loads)
}

pub(super) fn pressures(resolver: &Resolver<'_>, sensors: &[Measured]) -> Result<Vec<PressureSurface>, AssemblyError> {
    let dimensions = dimensions(sensors);
    let mut pressures = Vec::new();
    for (body, fields) in of_named(resolver, "pressure", BODY, &PRESSURE)? {
        for surface in fields.node.entries().iter().filter(|surface| surface.key != "if") {
            let key = surface.key.as_str();
            let patch = match surface.node.text() {
                Some(text) => match text.strip_suffix(".plenum") {
                    Some(passage) => {
                        PressurePatch::Plenum(fields.block_of(key, passage, &[Family::Passage], "passage")?.index)
                    }
                    None => PressurePatch::Uniform(fields.space(key, text)?),
                },
                None => {
                    let divided = fields.table(key)?.ok_or_else(|| fields.missing(key))?;
                    let space = |side: &str| {
                        let name = divided.text(side)?;
                        let name = name.ok_or_else(|| divided.missing(side))?;
                        divided.space(side, name)
                    };
                    let at = expression(&divided, "at", &dimensions, false)?.ok_or_else(|| divided.missing("at"))?;
                    expect(&divided, "at", &at, LENGTH)?;
                    PressurePatch::Divided {
                        above: space("above")?,
                        below: space("below")?,
                        at: at.value,
                    }
                }
            };
            pressures.push(PressureSurface {
                body,
                surface: key.to_owned(),
                patch,
            });
        }
    }
    Ok(pressures)
}
