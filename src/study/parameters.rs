//! The keys of a design that have a range and take part in the nailing cycle.

use serde::Serialize;

use crate::design::inputs::cycle::parameters as cycle_parameters;
use crate::design::{Design, Value};
use crate::error::Error;

/// A key with a range that takes part in the cycle.
#[derive(Debug, Clone, Serialize)]
pub struct Parameter {
    /// Full name, as `piston.mass`.
    pub key: String,
    /// Symbol; empty where there is none.
    pub symbol: &'static str,
    /// SI unit; empty for plain numbers and counts.
    pub unit: String,
    /// Value in the design: a quantity in SI units, or a count.
    pub value: Value,
    /// Ends of the range.
    pub range: [f64; 2],
}

impl Parameter {
    /// Half the range.
    pub fn half_range(&self) -> f64 {
        0.5 * (self.range[1] - self.range[0])
    }

    /// The value `x` as this key holds it; a count is rounded and at least 1.
    pub(crate) fn hold(&self, x: f64) -> Value {
        match self.value {
            Value::Count(_) => Value::Count(x.round().clamp(1.0, f64::from(u32::MAX)) as u32),
            _ => Value::Number(x),
        }
    }
}

/// The keys that have a range and take part in the cycle, in the order of the reference.
///
/// Whether a key takes part is found by setting it: it does where the cycle's parameters change. Keys of the chosen
/// form of the physics alone do not show there, so that those of a form that is not chosen are among them; what they do
/// to the cycle is nothing.
///
/// # Errors
/// As [`parameters`](cycle_parameters).
pub fn taking_part(design: &Design) -> Result<Vec<Parameter>, Error> {
    let base = cycle_parameters(design)?;
    let mut found = Vec::new();
    for entry in design.entries() {
        let Some(range) = entry.range.filter(|range| range[0] < range[1]) else {
            continue;
        };
        let value = match entry.value {
            Value::Number(value) => value,
            Value::Count(count) => f64::from(count),
            Value::Switch(_) | Value::Choice(_) | Value::File(_) => continue,
        };
        let (key, symbol, unit, value_kept) = (entry.key, entry.symbol, entry.unit, entry.value);
        let parameter = Parameter {
            key,
            symbol,
            unit,
            value: value_kept,
            range,
        };
        let other = if range[0] == value { range[1] } else { range[0] };
        let mut changed = design.clone();
        let moved = changed.set(&[(parameter.key.as_str(), parameter.hold(other))]).is_ok()
            && cycle_parameters(&changed).is_ok_and(|parameters| parameters != base);
        if moved {
            found.push(parameter);
        }
    }
    Ok(found)
}
