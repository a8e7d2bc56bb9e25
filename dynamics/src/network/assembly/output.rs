//! Outputs of the cycle for noise and structural vibration.

use serde::Serialize;

use super::{Expression, Space};

/// Opening to the atmosphere that makes noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Opening {
    /// Name.
    pub name: String,
    /// Index of the passage.
    pub passage: usize,
    /// Index of the restriction inside the passage; the last one by default.
    pub restriction: usize,
    /// Number of equal holes.
    pub count: f64,
    /// Total area \[m2\].
    pub area: f64,
    /// Distance between hole centres \[m\].
    pub pitch: Option<f64>,
    /// Group of keys that describe the outlet's fitting and muffler.
    pub outlet: Option<String>,
}

/// Force on a named surface of a body, down \[N\].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Load {
    /// Index of the body.
    pub body: usize,
    /// Name of the surface.
    pub surface: String,
    /// Force.
    pub force: Expression,
}

/// A column of the files of a shot under a name that the assembly gives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedColumn {
    /// Name.
    pub name: String,
    /// Channel or sensor whose own column it replaces; empty for another expression.
    pub channel: String,
    /// Value.
    pub value: ColumnValue,
    /// SI unit.
    pub unit: String,
}

/// Value of a column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum ColumnValue {
    /// An expression over the state.
    Expression(Expression),
    /// A quantity of the jet of an opening, by its index.
    Jet(usize, JetQuantity),
}

/// Quantity of the jet of an opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum JetQuantity {
    /// Pressure before the opening.
    Pressure,
    /// Pressure behind it.
    BackPressure,
    /// Stagnation temperature upstream.
    Temperature,
}

/// Event that a marker of a measurement denotes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Marker {
    /// Name of the marker.
    pub name: String,
    /// Name of the event.
    pub event: String,
}

/// Pressures on walls of a body that exert no net force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressureSurface {
    /// Index of the body.
    pub body: usize,
    /// Name of the surface.
    pub surface: String,
    /// Pressure on it.
    pub patch: PressurePatch,
}

/// Gas in contact with a wall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum PressurePatch {
    /// One space.
    Uniform(Space),
    /// Two spaces separated at a movable position.
    Divided {
        /// Space above the divide.
        above: Space,
        /// Space below the divide.
        below: Space,
        /// Position of the divide \[m\].
        at: Expression,
    },
    /// Pressure upstream of the opening of a passage (index); without an opening, upstream of its last restriction.
    Plenum(usize),
}
