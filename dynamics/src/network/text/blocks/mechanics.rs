//! Bodies and the forces between them.

use nailnoise_quantities::dimension::{ACCELERATION, DAMPING, FORCE, LENGTH, MASS, NUMBER, STIFFNESS, TIME, VELOCITY};
use nailnoise_quantities::{Kind, any, component, nonnegative, positive};

use super::list::each;
use crate::network::assembly::{
    Base, Body, Contact, ContactDamping, Family, Fastener, FastenerLaw, Force, ForceLaw, Friction, Hold, Motor, Seated,
    Spring, SpringLaw, Start, Stop, Weights,
};
use crate::network::text::fault::{AssemblyError, Fault};
use crate::network::text::fields::Fields;
use crate::network::text::resolver::Resolver;

const BODY: [&str; 6] = ["parent", "mass", "start", "gravity", "weighted", "unbalanced"];

/// Velocity scale over which friction changes its sign, unless the block gives another \[m/s\].
const WIDTH: f64 = 1e-3;
/// Velocity scale over which friction falls from static to sliding, unless the block gives another \[m/s\].
const STRIBECK: f64 = 10e-3;

/// A stiffness, up to that of a rigid stop.
fn stiffness() -> Kind {
    nonnegative(STIFFNESS).within(0.0, 1e21)
}

/// A damping ratio.
fn damping_ratio() -> Kind {
    nonnegative(NUMBER).within(0.0, 10.0)
}

/// Parents of all bodies, without cycles.
pub(super) fn parents(resolver: &Resolver<'_>) -> Result<Vec<Base>, AssemblyError> {
    let bodies = each(resolver, Family::Body, &BODY)?;
    let parent = |(_, fields): &(&str, Fields<'_, '_>)| Ok(fields.base("parent")?.unwrap_or(Base::Ground));
    let parents = bodies.iter().map(parent).collect::<Result<Vec<_>, AssemblyError>>()?;
    for (index, (name, fields)) in bodies.iter().enumerate() {
        let mut names = vec![(*name).to_owned()];
        let mut at = parents[index];
        while let Base::Body(next) = at {
            names.push(bodies[next].0.to_owned());
            if next == index {
                return Err(fields.error("parent", Fault::Circle { names }));
            }
            // A cycle that this body only leads to is reported for its own bodies.
            if names.len() > parents.len() {
                break;
            }
            at = parents[next];
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
        let start = fields.table("start", "start", &["rest_on", "travel", "speed"])?;
        let start = match start {
            None => Start::At {
                travel: 0.0,
                speed: 0.0,
            },
            Some(start) => read_start(&start)?,
        };
        let weights = fields.table("weighted", "error weight", &["position", "velocity"])?;
        let mut weighted = Weights {
            position: 1e-3,
            velocity: 1.0,
        };
        if let Some(weights) = weights {
            weighted.position = weights.or("position", positive(LENGTH), weighted.position)?;
            weighted.velocity = weights.or("velocity", positive(VELOCITY), weighted.velocity)?;
        }
        Ok(Body {
            name: name.to_owned(),
            parent: *parent,
            mass: fields.required("mass", positive(MASS), "\"131 g\"")?,
            start,
            gravity: fields.or("gravity", any(ACCELERATION), gravity)?,
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
        travel: start.or("travel", any(LENGTH), 0.0)?,
        speed: start.or("speed", any(VELOCITY), 0.0)?,
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
    const FIELDS: [&str; 10] = [
        "on",
        "against",
        "stop",
        "at",
        "stiffness",
        "damping",
        "damping_ratio",
        "hysteresis",
        "exponent",
        "may_pull",
    ];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let exponent = fields.or("exponent", positive(NUMBER).within(1.0, 10.0), 1.0)?;
        // For other exponents, the unit of the stiffness is N/m^exponent, and the value is given as a plain number.
        let kind = if exponent == 1.0 {
            stiffness()
        } else {
            positive(NUMBER).within(1e-3, 1e30)
        };
        let stiffness = fields.required("stiffness", kind, "\"1 kN/mm\"")?;
        let given: Vec<String> = ["damping", "damping_ratio", "hysteresis"]
            .iter()
            .filter(|key| fields.get(key).is_some())
            .map(|key| (*key).to_owned())
            .collect();
        if given.len() > 1 {
            return Err(fields.own_error(Fault::Exclusive { fields: given }));
        }
        let mass = bodies.get(on).map_or(0.0, |body| body.mass);
        let damping = if let Some(factor) = fields.quantity("hysteresis", nonnegative(inverse_velocity()))? {
            ContactDamping::HuntCrossley(factor)
        } else if exponent != 1.0 && !given.is_empty() {
            return Err(fields.wrong(&given[0], "`hysteresis` in s/m, with an exponent other than 1"));
        } else if let Some(ratio) = fields.quantity("damping_ratio", damping_ratio())? {
            ContactDamping::Dashpot(dashpot(ratio, stiffness, mass))
        } else {
            ContactDamping::Dashpot(fields.or("damping", nonnegative(DAMPING), 0.0)?)
        };
        Ok(Contact {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            stop: fields
                .word("stop", &[("below", Stop::Below), ("above", Stop::Above)])?
                .ok_or_else(|| fields.missing("stop", "\"below\""))?,
            at: fields.or("at", any(LENGTH), 0.0)?,
            stiffness,
            damping,
            exponent,
            may_pull: fields.flag("may_pull", false)?,
        })
    };
    each(resolver, Family::Contact, &FIELDS)?
        .into_iter()
        .map(read)
        .collect()
}

/// Dimension of the hysteresis factor of Hunt and Crossley, s/m.
fn inverse_velocity() -> nailnoise_quantities::Dimension {
    NUMBER.times(VELOCITY, -1).unwrap_or(NUMBER)
}

pub(super) fn springs(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Spring>, AssemblyError> {
    const FIELDS: [&str; 11] = [
        "on",
        "against",
        "push",
        "free",
        "preload",
        "stiffness",
        "polynomial",
        "scale",
        "limit",
        "unilateral",
        "damping",
    ];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        fields.one_of(&["stiffness", "polynomial"], "stiffness = \"1 N/mm\"")?;
        let scale = fields.or("scale", nonnegative(NUMBER).within(0.0, 1e3), 1.0)?;
        let coefficients = fields.numbers("polynomial", "coefficients in N over m, as [4.17, 79135.7]")?;
        let law = match coefficients {
            Some(coefficients) => SpringLaw::Polynomial(coefficients.iter().map(|c| c * scale).collect()),
            None => SpringLaw::Linear(fields.required("stiffness", stiffness(), "\"1 N/mm\"")? * scale),
        };
        Ok(Spring {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            push: fields.push("push")?,
            free: fields.or("free", any(LENGTH), 0.0)?,
            preload: fields.or("preload", any(LENGTH), 0.0)?,
            law,
            limit: fields.quantity("limit", positive(LENGTH))?,
            unilateral: fields.flag("unilateral", false)?,
            damping: fields.or("damping", nonnegative(DAMPING), 0.0)?,
        })
    };
    each(resolver, Family::Spring, &FIELDS)?.into_iter().map(read).collect()
}

pub(super) fn frictions(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Friction>, AssemblyError> {
    const FIELDS: [&str; 9] = [
        "on", "against", "law", "static", "sliding", "viscous", "width", "stribeck", "stick",
    ];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let [static_force, sliding_force, viscous] =
            match fields.text("law", "a group of keys, as \"=piston.friction\"")? {
                Some(group) => friction_group(&fields, group)?,
                None => {
                    let sliding = fields.required("sliding", nonnegative(FORCE), "\"15 N\"")?;
                    let fixed = fields.or("static", nonnegative(FORCE), sliding)?;
                    [fixed, sliding, fields.or("viscous", nonnegative(DAMPING), 0.0)?]
                }
            };
        let stick = fields.table("stick", "sticking friction", &["stiffness", "damping"])?;
        let stick = stick
            .map(|stick| {
                let stiffness = stick.required("stiffness", stiffness(), "\"1 kN/mm\"")?;
                Ok((stiffness, stick.or("damping", nonnegative(DAMPING), 0.0)?))
            })
            .transpose()?;
        Ok(Friction {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            static_force,
            sliding_force,
            viscous,
            width: fields.or("width", positive(VELOCITY), WIDTH)?,
            stribeck: fields.or("stribeck", positive(VELOCITY), STRIBECK)?,
            stick,
        })
    };
    each(resolver, Family::Friction, &FIELDS)?
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

pub(super) fn forces(resolver: &Resolver<'_>) -> Result<Vec<Force>, AssemblyError> {
    const FIELDS: [&str; 6] = ["on", "against", "force", "table", "jet", "share"];
    const POINTS: &str = "[[\"0 s\", \"0 N\"], [\"5 ms\", \"100 N\"]]";
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        fields.one_of(&["force", "table", "jet"], "force = \"80 N\"")?;
        let law = if let Some(points) = fields.points("table", [any(TIME), any(FORCE)], POINTS)? {
            ForceLaw::Table(points)
        } else if let Some(passage) = fields.block("jet", &[Family::Passage], "passage")? {
            ForceLaw::Jet {
                passage: passage.index,
                share: fields.required("share", component(), "1")?,
            }
        } else {
            ForceLaw::Constant(fields.required("force", any(FORCE), "\"80 N\"")?)
        };
        Ok(Force {
            name: name.to_owned(),
            on,
            against: fields.against(on, &[])?,
            law,
        })
    };
    each(resolver, Family::Force, &FIELDS)?.into_iter().map(read).collect()
}

/// The trigger that a motor or latch follows.
fn follows(fields: &Fields<'_, '_>) -> Result<usize, AssemblyError> {
    fields.index("while", Family::Trigger, "trigger")
}

pub(super) fn motors(resolver: &Resolver<'_>, parents: &[Base]) -> Result<Vec<Motor>, AssemblyError> {
    const FIELDS: [&str; 6] = ["on", "against", "push", "stall", "free_speed", "while"];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        Ok(Motor {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            push: fields.push("push")?,
            stall: fields.required("stall", nonnegative(FORCE), "\"1500 N\"")?,
            free_speed: fields.required("free_speed", positive(VELOCITY), "\"0.6 m/s\"")?,
            trigger: follows(&fields)?,
        })
    };
    each(resolver, Family::Motor, &FIELDS)?.into_iter().map(read).collect()
}

pub(super) fn holds(resolver: &Resolver<'_>, parents: &[Base], bodies: &[Body]) -> Result<Vec<Hold>, AssemblyError> {
    const FIELDS: [&str; 6] = ["on", "against", "at", "stiffness", "damping_ratio", "while"];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let on = on(&fields)?;
        let stiffness = fields.required("stiffness", stiffness(), "\"5 kN/mm\"")?;
        let ratio = fields.or("damping_ratio", damping_ratio(), 0.1)?;
        Ok(Hold {
            name: name.to_owned(),
            on,
            against: fields.against(on, parents)?,
            at: fields.or("at", any(LENGTH), 0.0)?,
            stiffness,
            damping: dashpot(ratio, stiffness, bodies.get(on).map_or(0.0, |body| body.mass)),
            trigger: follows(&fields)?,
        })
    };
    each(resolver, Family::Hold, &FIELDS)?.into_iter().map(read).collect()
}

pub(super) fn fasteners(resolver: &Resolver<'_>) -> Result<Vec<Fastener>, AssemblyError> {
    const FIELDS: [&str; 13] = [
        "driver",
        "into",
        "guide",
        "head_at",
        "tip_at",
        "length",
        "mass",
        "impact",
        "law",
        "head_stiffness",
        "unloading",
        "guide_friction",
        "guide_width",
    ];
    let read = |(name, fields): (&str, Fields<'_, '_>)| {
        let law = fields
            .table(
                "law",
                "law of a fastener",
                &["kind", "hardness", "offset", "force", "points", "reversible"],
            )?
            .ok_or_else(|| fields.missing("law", "{ kind = \"constant\", force = \"600 N\" }"))?;
        Ok(Fastener {
            name: name.to_owned(),
            driver: fields.index("driver", Family::Body, "body")?,
            into: fields.index("into", Family::Body, "body")?,
            guide: fields.base("guide")?.unwrap_or(Base::Ground),
            head_at: fields.required("head_at", any(LENGTH), "\"30 mm\"")?,
            tip_at: fields.required("tip_at", any(LENGTH), "\"32 mm\"")?,
            length: fields.required("length", positive(LENGTH), "\"=nail.length\"")?,
            mass: fields.required("mass", nonnegative(MASS), "\"0.9 g\"")?,
            impact: fields
                .word("impact", &[("plastic", true), ("mass", false)])?
                .unwrap_or(true),
            reversible: law.flag("reversible", false)?,
            law: fastener_law(&law)?,
            seated: Seated {
                head_stiffness: fields.required("head_stiffness", nonnegative(STIFFNESS), "\"400 N/mm\"")?,
                unloading: fields.required("unloading", positive(STIFFNESS), "\"5 kN/mm\"")?,
                guide_friction: fields.or("guide_friction", nonnegative(FORCE), 0.0)?,
                guide_width: fields.or("guide_width", positive(VELOCITY), WIDTH)?,
            },
        })
    };
    each(resolver, Family::Fastener, &FIELDS)?
        .into_iter()
        .map(read)
        .collect()
}

fn fastener_law(law: &Fields<'_, '_>) -> Result<FastenerLaw, AssemblyError> {
    const POINTS: &str = "[[\"0 mm\", \"0 N\"], [\"50 mm\", \"900 N\"]]";
    let kinds = [("solid_wood", 0), ("constant", 1), ("table", 2)];
    match law.word("kind", &kinds)? {
        Some(0) => Ok(FastenerLaw::SolidWood {
            hardness: law.required("hardness", nonnegative(STIFFNESS), "\"=wood.hardness_modulus\"")?,
            offset: law.or("offset", any(NUMBER), 0.0)?,
        }),
        Some(1) => Ok(FastenerLaw::Constant(law.required(
            "force",
            nonnegative(FORCE),
            "\"600 N\"",
        )?)),
        Some(_) => {
            let points = law.points("points", [nonnegative(LENGTH), nonnegative(FORCE)], POINTS)?;
            points
                .map(FastenerLaw::Table)
                .ok_or_else(|| law.missing("points", POINTS))
        }
        None => Err(law.missing("kind", "\"constant\"")),
    }
}
