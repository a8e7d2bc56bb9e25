//! The drawn variables, each with its distribution, and the positions of the design and the draws in it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::draws::Draws;
use super::level_table::number;
use super::request::Request;
use super::variables::{Drawn, Scope, Variable, VariableKind};
use crate::design::{Alternative, Value};

/// A variable.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct VariableReport {
    /// Key, name of alternatives, or `method.SOURCE`.
    pub name: String,
    /// The part it changes: `shot`, `structure` or `method`.
    pub scope: String,
    /// SI unit; empty if it has none.
    pub unit: String,
    /// Whether it was drawn; false for fixed structures.
    pub drawn: bool,
    /// Ends of the range in SI units; null for alternatives and for a method's own band.
    pub range: Option<[f64; 2]>,
    /// Distribution, or the names of the alternatives with their probabilities.
    pub distribution: String,
    /// Position of the design's value in the distribution, 0 .. 1; null for alternatives.
    pub nominal_place: Option<f64>,
    /// Mean position of the draws in the distribution, 0.5 without condition; null if it was not drawn.
    pub mean_place: Option<f64>,
}

/// Quantile of a parameter's value in the design, by bisection.
fn place_of_nominal(variable: &Variable) -> Option<f64> {
    let VariableKind::Quantity(parameter) = &variable.kind else {
        return None;
    };
    let value = |share: f64| number(Some(Drawn::Value(parameter.at(share.clamp(1e-9, 1.0 - 1e-9)))));
    // The largest quantile between two ends up to which a condition holds, starting from a quantile that satisfies it.
    let last = |low: f64, holds: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (low, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if holds(value(middle)?) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some((low, high))
    };
    let (low, high) = last(0.0, &|value| value < parameter.number())?;
    if !matches!(parameter.value, Value::Count(_)) {
        return Some(low);
    }
    // A count covers a part of the distribution; its centre is used.
    let (_, top) = last(high, &|value| value <= parameter.number())?;
    Some(0.5 * (low + top))
}

pub(super) fn variable_reports(request: &Request, made: &Draws) -> Vec<VariableReport> {
    let report = |(place, variable): (usize, &Variable)| {
        let shares = made.draws.iter().map(|draw| draw.shares[place]);
        let sum: f64 = shares.sum();
        let drawn = request.shots_a_structure.is_some() || variable.scope != Scope::Structure;
        let (range, distribution) = match &variable.kind {
            VariableKind::Quantity(parameter) => (Some(parameter.range), parameter.distribution.as_str().to_owned()),
            VariableKind::Alternatives(options) => {
                let option = |option: &Alternative| format!("{} ({:.0} %)", option.name, 100.0 * option.probability);
                (None, options.iter().map(option).collect::<Vec<_>>().join("; "))
            }
            VariableKind::LawScore => (None, "normal".to_owned()),
            VariableKind::Method(bounds) => (*bounds, "uniform".to_owned()),
        };
        VariableReport {
            name: variable.name.clone(),
            scope: match variable.scope {
                Scope::Shot => "shot",
                Scope::Structure => "structure",
                Scope::Method => "method",
            }
            .to_owned(),
            unit: variable.unit().to_owned(),
            drawn,
            range,
            distribution,
            nominal_place: place_of_nominal(variable),
            mean_place: drawn
                .then(|| sum / made.draws.len().max(1) as f64)
                .filter(|mean| mean.is_finite()),
        }
    };
    made.variables.iter().enumerate().map(report).collect()
}
