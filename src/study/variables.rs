//! Variables of a study: keys with a range, alternatives, and errors of methods.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::parameters::Parameter;
use super::{law, normal};
use crate::chain::{Chain, Options};
use crate::design::{Alternative, Carrier, Derived, Design, Entry, Provenance, Value};
use crate::error::Error;
use crate::graph::Graph;
use crate::model::sources;
use crate::stages::Digest;

/// Part that a variable affects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// The shot: cycle, loads, damping, contact, exhaust. Modes and radiation matrices are unchanged.
    Shot,
    /// Modes or radiation matrices of a body, which are expensive.
    Structure,
    /// The level of a source, through the error of its method.
    Method,
}

/// A random variable of a study.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Key, name of alternatives, `wood.penetration_fit.SCORE`, or `method.SOURCE`.
    pub name: String,
    /// The outputs that it affects.
    pub scope: Scope,
    /// The kind of quantity.
    pub kind: VariableKind,
}

/// The kind of a variable.
#[derive(Debug, Clone)]
pub enum VariableKind {
    /// The value of a key.
    Quantity(Parameter),
    /// One of several sets of values.
    Alternatives(Vec<Alternative>),
    /// A standard normal score with which a fitted penetration law is drawn.
    LawScore,
    /// The error of a method, uniform between the given bounds \[dB\] or, without them, the method's own.
    Method(Option<[f64; 2]>),
}

/// The value of a variable in a draw.
#[derive(Debug, Clone, PartialEq)]
pub enum Drawn {
    /// Value of a key.
    Value(Value),
    /// Number of an alternative.
    Alternative(usize),
    /// Position between the lower and upper bound of a method's error, 0 to 1.
    Share(f64),
}

impl Variable {
    /// Its value in a draw, for a quantile of its distribution; `None` if it is fixed, for which the quantile is NaN.
    pub fn drawn(&self, share: f64) -> Option<Drawn> {
        (!share.is_nan()).then(|| self.at(share))
    }

    /// The quantile `u` of the distribution, 0 < u < 1.
    pub fn at(&self, u: f64) -> Drawn {
        match &self.kind {
            VariableKind::Quantity(parameter) => Drawn::Value(parameter.at(u)),
            VariableKind::Alternatives(options) => {
                let mut above = u;
                let chosen = options.iter().position(|option| {
                    above -= option.probability;
                    above < 0.0
                });
                Drawn::Alternative(chosen.unwrap_or(options.len() - 1))
            }
            VariableKind::LawScore => Drawn::Value(Value::Number(normal::quantile(u))),
            VariableKind::Method(_) => Drawn::Share(u),
        }
    }

    /// Keys and values that a draw sets.
    pub fn changes<'a>(&'a self, drawn: &Drawn) -> Vec<(&'a str, Value)> {
        match (&self.kind, drawn) {
            (VariableKind::Quantity(parameter), Drawn::Value(value)) => vec![(parameter.change(), value.clone())],
            (VariableKind::Alternatives(options), Drawn::Alternative(chosen)) => {
                let values = options[*chosen].values.iter();
                values.map(|(key, value)| (key.as_str(), value.clone())).collect()
            }
            _ => Vec::new(),
        }
    }

    /// SI unit; empty if there is none.
    pub fn unit(&self) -> &str {
        match &self.kind {
            VariableKind::Quantity(parameter) => &parameter.unit,
            VariableKind::Alternatives(_) | VariableKind::LawScore => "",
            VariableKind::Method(_) => "dB",
        }
    }
}

/// The scores with which the fitted penetration laws of these designs are drawn.
pub(super) fn law_scores(designs: &[Design]) -> Result<Vec<Variable>, Error> {
    let score = |name: String| Variable {
        name,
        scope: Scope::Shot,
        kind: VariableKind::LawScore,
    };
    Ok(law::score_names(designs)?.into_iter().map(score).collect())
}

/// The scores of a point, in their order.
pub(super) fn drawn_scores(variables: &[Variable], shares: &[f64]) -> Vec<f64> {
    let score = |(variable, share): (&Variable, &f64)| match variable.kind {
        VariableKind::LawScore if !share.is_nan() => Some(normal::quantile(*share)),
        _ => None,
    };
    variables.iter().zip(shares).filter_map(score).collect()
}

/// The design in the form that a study runs: without sensors, which would reject draws that move the surface below
/// them.
pub(crate) fn without_sensors(design: &Design) -> Design {
    let mut design = design.clone();
    design.sensors.clear();
    design
}

/// The design with only its sensors on the workpiece.
pub(crate) fn with_workpiece_sensors(design: &Design) -> Design {
    let mut design = design.clone();
    design.sensors.retain(|_, sensor| sensor.body == Carrier::Workpiece);
    design
}

/// Keys of the stages that give a design's levels, modes and matrices.
struct Keys {
    levels: Digest,
    structures: Vec<Digest>,
}

fn keys(design: &Design) -> Result<Keys, Error> {
    let chain = Chain::new(&Graph::default(), design, Options::default())?;
    Ok(Keys {
        levels: *chain.levels.key(),
        structures: chain.structures,
    })
}

/// The variables of a study of `design`, in the order of the reference. They are every key with a range that changes
/// the levels, unless it is a property of the numerical method; the alternatives; the scores of a fitted penetration
/// law; and the error of each source's method.
///
/// A key changes the levels if the digest of the levels' inputs changes with it. Keys of forms of the physics that are
/// not chosen may be included; they have no effect on the levels.
///
/// # Errors
/// The errors of the chain for the design itself.
pub fn variables(design: &Design) -> Result<Vec<Variable>, Error> {
    let settings = design.study();
    let mut bases = vec![without_sensors(design)];
    for option in settings.alternatives.values().flatten() {
        let mut other = bases[0].clone();
        let changes: Vec<_> = option
            .values
            .iter()
            .map(|(key, value)| (key.as_str(), value.clone()))
            .collect();
        if other.set(&changes).is_ok() && other.conflict().is_none() {
            bases.push(other);
        }
    }
    // Whether a key is used may depend on the alternative, because `support.worktable.preset` introduces other keys.
    let known = bases.iter().map(|base| Ok((base, keys(base)?)));
    let known = known.collect::<Result<Vec<_>, Error>>()?;
    let scope = |changes: &[(&str, Value)]| {
        let mut scope = None;
        for (base, keys_of_base) in &known {
            let mut changed = Design::clone(base);
            let moved = changed.set(changes).ok().and_then(|()| keys(&changed).ok());
            match moved {
                Some(moved) if moved.structures != keys_of_base.structures => return Some(Scope::Structure),
                Some(moved) if moved.levels != keys_of_base.levels => scope = Some(Scope::Shot),
                _ => {}
            }
        }
        scope
    };
    let chosen = |key: &str| {
        let mut values = settings
            .alternatives
            .values()
            .flatten()
            .flat_map(|option| &option.values);
        values.any(|(own, _)| own == key)
    };
    let parameters = Parameter::all(&bases[0]).into_iter();
    let parameters = parameters.filter(|(own, provenance)| {
        let primaries = Derived::find(&own.key).map_or(&[][..], |derived| derived.primaries);
        *provenance != Provenance::Numerical && !chosen(&own.key) && !primaries.iter().any(|key| chosen(key))
    });
    let mut parameters: Vec<Parameter> = parameters.map(|(own, _)| own).collect();
    law::leave_out_held(design, &mut parameters)?;
    let in_force = parameters.into_par_iter().filter_map(|parameter| {
        let ends = [0.001, 0.5, 0.999].map(|u| parameter.at(u));
        let mut scopes = ends
            .map(|value| scope(&[(parameter.change(), value)]))
            .into_iter()
            .flatten();
        let first = scopes.next()?;
        let scope = if scopes.any(|other| other == Scope::Structure) {
            Scope::Structure
        } else {
            first
        };
        Some(Variable {
            name: parameter.key.clone(),
            scope,
            kind: VariableKind::Quantity(parameter),
        })
    });
    let mut variables: Vec<Variable> = in_force.collect();
    for (name, options) in &settings.alternatives {
        let scopes = options.iter().filter_map(|option| {
            let changes: Vec<_> = option
                .values
                .iter()
                .map(|(key, value)| (key.as_str(), value.clone()))
                .collect();
            scope(&changes)
        });
        let scopes: Vec<Scope> = scopes.collect();
        let structure = scopes.contains(&Scope::Structure);
        variables.push(Variable {
            name: name.clone(),
            scope: if structure { Scope::Structure } else { Scope::Shot },
            kind: VariableKind::Alternatives(options.clone()),
        });
    }
    variables.extend(law_scores(&bases)?);
    variables.extend(sources::names().map(|source| Variable {
        name: format!("method.{source}"),
        scope: Scope::Method,
        kind: VariableKind::Method(settings.model.get(source).copied()),
    }));
    Ok(variables)
}

/// The variables of designs with common draws: those of all of them, except keys whose values differ between the
/// designs, because each design keeps its values.
///
/// # Errors
/// Same as [`variables`].
pub fn common_variables(designs: &[&Design]) -> Result<Vec<Variable>, Error> {
    let Some((first, others)) = designs.split_first() else {
        return Ok(Vec::new());
    };
    let mut joint = variables(first)?;
    for other in others {
        for variable in variables(other)? {
            match joint.iter_mut().find(|own| own.name == variable.name) {
                Some(own) if variable.scope == Scope::Structure => own.scope = Scope::Structure,
                Some(_) => {}
                None => joint.push(variable),
            }
        }
    }
    let differing = differing_keys(designs);
    // A derived quantity differs if one of its primary quantities differs.
    let primaries = |name: &str| Derived::find(name).map_or(&[][..], |derived| derived.primaries);
    let differs = |name: &str| differing.iter().any(|key| key == name);
    joint.retain(|own| !differs(&own.name) && !primaries(&own.name).iter().any(|key| differs(key)));
    Ok(joint)
}

/// Keys whose values differ between designs, in the order of the reference.
pub fn differing_keys(designs: &[&Design]) -> Vec<String> {
    let Some((first, others)) = designs.split_first() else {
        return Vec::new();
    };
    let values = |design: &Design| -> BTreeMap<String, Value> {
        design
            .entries()
            .into_iter()
            .map(|entry| (entry.key, entry.value))
            .collect()
    };
    let others: Vec<_> = others.iter().map(|other| values(other)).collect();
    let differs = |entry: &Entry| others.iter().any(|other| other.get(&entry.key) != Some(&entry.value));
    first
        .entries()
        .into_iter()
        .filter(differs)
        .map(|entry| entry.key)
        .collect()
}

/// For each of these keys, whether the levels of a design depend on it.
///
/// # Errors
/// Same as [`variables`].
pub fn in_force(design: &Design, wanted: &[String]) -> Result<Vec<bool>, Error> {
    let base = without_sensors(design);
    let own = keys(&base)?;
    let entries = base.entries();
    let depends = |key: &String| {
        let value = entries
            .iter()
            .find(|entry| entry.key == *key)
            .map(|entry| entry.value.clone());
        let other = match value {
            Some(Value::Number(0.0)) => Value::Number(1e-3),
            Some(Value::Number(value)) => Value::Number(value * 1.001),
            Some(Value::Count(count)) => Value::Count(count + 1),
            _ => return true,
        };
        let mut moved = base.clone();
        // A value that is rejected is used by a rule.
        let set = moved.set(&[(key.as_str(), other)]);
        set.is_err()
            || keys(&moved).map_or(true, |moved| {
                moved.levels != own.levels || moved.structures != own.structures
            })
    };
    Ok(wanted.par_iter().map(depends).collect())
}
