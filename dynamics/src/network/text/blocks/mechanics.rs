//! Bodies and the forces between them.

use nailnoise_quantities::dimension::{DAMPING, FORCE, NUMBER, VELOCITY};
use nailnoise_quantities::{Kind, nonnegative, positive};

use super::gas::to_atmosphere;
use super::list::each;
use super::tables::mechanics::{BODY, CONTACT, FORCE_TABLE, FRICTION, HOLD, MOTOR, SPRING, STOPS};
use crate::network::assembly::{
    Base, Body, Contact, ContactDamping, Family, Force, ForceLaw, Friction, Hold, Motor, Passage, Spring, SpringLaw,
    Start, Weights,
};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

/// Velocity scale over which friction changes its sign, unless the block gives another \[m/s\].
pub(super) const WIDTH: f64 = 1e-3;
/// Velocity scale over which friction falls from static to sliding, unless the block gives another \[m/s\].
const STRIBECK: f64 = 10e-3;

/// Parents of all bodies, without cycles.
pub(super) fn parents(resolver: &Resolver<'_>) -> Result<Vec<Base>, AssemblyError> {
    let bodies = each(resolver, Family::Body, &BODY)?;
    let parent = |(_, fields): &(&str, Fields<'_, '_>)| Ok(fields.base("parent")?.unwrap_or(Base::Ground));
    let parents = bodies.iter().map(parent).collect::<Result<Vec<_>, AssemblyError>>()?;
    for index in 0..bodies.len() {
        let mut path = vec![index];
        while let Base::Body(next) = parents[path[path.len() - 1]] {
            if next == index {
                let others: Vec<_> = path[1..].iter().map(|body| &bodies[*body].1).collect();
                return Err(bodies[index].1.circle(&others, "parent"));
            }
            // A cycle that this body only leads to is reported for its own bodies.
            if path.len() > parents.len() {
                break;
            }
            path.push(next);
        }
    }
    Ok(parents)
}

/// For each body, whether a uniform pressure on its faces may have a resultant.
pub(in crate::network::text) fn unbalanced(resolver: &Resolver<'_>) -> Result<Vec<bool>, AssemblyError> {
    let bodies = each(resolver, Family::Body, &BODY)?;
    bodies
        .iter()
        .map(|(_, fields)| fields.flag("unbalanced", false))
        .collect()
}

/// Bodies; `gravity` is the acceleration of those that give none \[m/s2\].
pub(super) fn bodies(resolver: &Resolver<'_>, parents: &[Base], gravity: f64) -> Result<Vec<Body>, AssemblyError> {
    let read = |((name, fields), parent): ((&str, Fields<'_, '_>), &Base)| {
        let start = fields.table("start")?;
        let start = match start {
            None => Start::At {
                travel: 0.0,
                speed: 0.0,
            },
            Some(start) => read_start(&start)?,
        };
        let weights = fields.table("weighted")?;
        let mut weighted = Weights {
            position: 1e-3,
            velocity: 1.0,
        };
        if let Some(weights) = weights {
            weighted.position = weights.or("position", weighted.position)?;
            weighted.velocity = weights.or("velocity", weighted.velocity)?;
        }
        Ok(Body {
            name: name.to_owned(),
            parent: *parent,
            mass: fields.required("mass")?,
            start,
            gravity: fields.or("gravity", gravity)?,
            weights: weighted,
        })
    };
    each(resolver, Family::Body, &BODY)?
        .into_iter()
        .zip(parents)
        .map(read)
        .collect()
}

fn read_start(start: &Fields<'_, '_>) -> Result<Start, AssemblyError> {
    let rest_on = start.block("rest_on", &[Family::Contact, Family::Spring], "contact or spring")?;
    if let Some(block) = rest_on {
        let others = ["travel", "speed"].iter().any(|key| start.get(key).is_some());
        if others {
            let fields = ["rest_on", "travel or speed"].map(str::to_owned).to_vec();
            return Err(start.own_error(Fault::Exclusive { fields }));
        }
        return Ok(Start::RestOn(block));
    }
    Ok(Start::At {
        travel: start.or("travel", 0.0)?,
        speed: start.or("speed", 0.0)?,
    })
}

fn on(fields: &Fields<'_, '_>) -> Result<usize, AssemblyError> {
    fields.index("on", Family::Body, "body")
}

/// Dashpot of a damping ratio on the mass of a body \[N s/m\].
fn dashpot(ratio: f64, stiffness: f64, mass: f64) -> f64 {
    2.0 * ratio * (stiffness * mass).sqrt()
}

pub(super) fn contacts(
    resolver: &Resolver<'_>,
    parents: &[Base],
    bodies: &[Body],
) -> Result<Vec<Contact>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let exponent = fields.or("exponent", 1.0)?;
        // For other exponents, the unit of the stiffness is N/m^exponent, and the value is given as a plain number.
        let stiffness = if exponent == 1.0 {
            fields.required("stiffness")?
        } else {
            let number = fields.quantity_of("stiffness", positive(NUMBER).within(1e-3, 1e30))?;
            number.ok_or_else(|| fields.missing("stiffness"))?
        };
        let given: Vec<String> = ["damping", "damping_ratio", "hysteresis"]
            .iter()
            .filter(|key| fields.get(key).is_some())
            .map(|key| (*key).to_owned())
            .collect();
        if given.len() > 1 {
            return Err(fields.own_error(Fault::Exclusive { fields: given }));
        }
        let mass = bodies.get(on).map_or(0.0, |body| body.mass);
        let damping = if let Some(factor) = fields.quantity_of("hysteresis", nonnegative(inverse_velocity()))? {
            ContactDamping::HuntCrossley(factor)
        } else if exponent != 1.0 && !given.is_empty() {
            return Err(fields.wrong(&given[0], "`hysteresis` in s/m, with an exponent other than 1"));
        } else if let Some(ratio) = fields.quantity("damping_ratio")? {
            ContactDamping::Dashpot(dashpot(ratio, stiffness, mass))
        } else {
            ContactDamping::Dashpot(fields.or("damping", 0.0)?)
        };
        Ok(Contact {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            stop: fields.word("stop", &STOPS)?.ok_or_else(|| fields.missing("stop"))?,
            at: fields.or("at", 0.0)?,
            stiffness,
            damping,
            exponent,
            may_pull: fields.flag("may_pull", false)?,
        })
    };
    each(resolver, Family::Contact, &CONTACT)?
        .into_iter()
        .map(read)
        .collect()
}

/// Dimension of the hysteresis factor of Hunt and Crossley, s/m.
fn inverse_velocity() -> nailnoise_quantities::Dimension {
    NUMBER.times(VELOCITY, -1).unwrap_or(NUMBER)
}

pub(super) fn springs(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Spring>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        fields.one_of(&["stiffness", "polynomial"], "stiffness = \"1 N/mm\"")?;
        let scale = fields.or("scale", 1.0)?;
        let coefficients = fields.numbers("polynomial", "coefficients in N over m, as [4.17, 79135.7]")?;
        let law = match coefficients {
            Some(coefficients) => SpringLaw::Polynomial(coefficients.iter().map(|c| c * scale).collect()),
            None => SpringLaw::Linear(fields.required("stiffness")? * scale),
        };
        Ok(Spring {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            push: fields.push("push")?,
            free: fields.or("free", 0.0)?,
            preload: fields.or("preload", 0.0)?,
            law,
            limit: fields.quantity("limit")?,
            unilateral: fields.flag("unilateral", false)?,
            damping: fields.or("damping", 0.0)?,
        })
    };
    each(resolver, Family::Spring, &SPRING)?.into_iter().map(read).collect()
}

pub(super) fn frictions(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Friction>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let [static_force, sliding_force, viscous] = match fields.text("law")? {
            Some(group) => friction_group(&fields, group)?,
            None => {
                let sliding = fields.required("sliding")?;
                let fixed = fields.or("static", sliding)?;
                [fixed, sliding, fields.or("viscous", 0.0)?]
            }
        };
        let stick = fields.table("stick")?;
        let stick = stick
            .map(|stick| {
                let stiffness = stick.required("stiffness")?;
                Ok((stiffness, stick.or("damping", 0.0)?))
            })
            .transpose()?;
        Ok(Friction {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            static_force,
            sliding_force,
            viscous,
            width: fields.or("width", WIDTH)?,
            stribeck: fields.or("stribeck", STRIBECK)?,
            stick,
        })
    };
    each(resolver, Family::Friction, &FRICTION)?
        .into_iter()
        .map(read)
        .collect()
}

/// Static force, sliding force and viscous coefficient of a group of keys.
fn friction_group(fields: &Fields<'_, '_>, text: &str) -> Result<[f64; 3], AssemblyError> {
    const EXPECTED: &str = "a group with static_force, sliding_force and viscous, as \"=piston.friction\"";
    let own: Vec<String> = ["static", "sliding", "viscous"]
        .iter()
        .filter(|key| fields.get(key).is_some())
        .map(|key| (*key).to_owned())
        .collect();
    if !own.is_empty() {
        let fields_found = [vec!["law".to_owned()], own].concat();
        return Err(fields.own_error(Fault::Exclusive { fields: fields_found }));
    }
    let group = text
        .strip_prefix('=')
        .map(str::trim)
        .filter(|group| fields.resolver.has_group(group));
    let group = group.ok_or_else(|| fields.wrong("law", EXPECTED))?;
    let key = |name: &str, kind: Kind| fields.key("law", &format!("{group}.{name}"), kind);
    Ok([
        key("static_force", nonnegative(FORCE))?,
        key("sliding_force", nonnegative(FORCE))?,
        key("viscous", nonnegative(DAMPING))?,
    ])
}

pub(super) fn forces(resolver: &Resolver<'_>, passages: &[Passage]) -> Result<Vec<Force>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        fields.one_of(&["force", "table", "jet"], "force = \"80 N\"")?;
        let law = if let Some(points) = fields.points("table")? {
            ForceLaw::Table(points)
        } else if let Some(passage) = fields.block("jet", &[Family::Passage], "passage")? {
            ForceLaw::Jet {
                passage: to_atmosphere(&fields, "jet", passages, passage.index)?,
                share: fields.required("share")?,
            }
        } else {
            ForceLaw::Constant(fields.required("force")?)
        };
        Ok(Force {
            name: name.to_owned(),
            on,
            against: fields.against(on, &[])?,
            law,
        })
    };
    each(resolver, Family::Force, &FORCE_TABLE)?
        .into_iter()
        .map(read)
        .collect()
}

/// The trigger that a motor or latch follows.
fn follows(fields: &Fields<'_, '_>) -> Result<usize, AssemblyError> {
    fields.index("while", Family::Trigger, "trigger")
}

pub(super) fn motors(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Motor>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        Ok(Motor {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            push: fields.push("push")?,
            stall: fields.required("stall")?,
            free_speed: fields.required("free_speed")?,
            trigger: follows(&fields)?,
        })
    };
    each(resolver, Family::Motor, &MOTOR)?.into_iter().map(read).collect()
}

pub(super) fn holds(resolver: &Resolver<'_>, parents: &[Base], bodies: &[Body]) -> Result<Vec<Hold>, AssemblyError> {
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let stiffness = fields.required("stiffness")?;
        let ratio = fields.or("damping_ratio", 0.1)?;
        Ok(Hold {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            at: fields.or("at", 0.0)?,
            stiffness,
            damping: dashpot(ratio, stiffness, bodies.get(on).map_or(0.0, |body| body.mass)),
            trigger: follows(&fields)?,
        })
    };
    each(resolver, Family::Hold, &HOLD)?.into_iter().map(read).collect()
}
