//! Expressions over the state.

use serde::Serialize;

use super::BlockRef;

/// Scalar expression; numbers and keys are resolved to constants in SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Expression {
    /// Constant.
    Constant(f64),
    /// Channel of a block.
    Channel(Channel),
    /// Value of a sensor, by index in [`Assembly::sensors`](super::Assembly::sensors).
    Sensor(usize),
    /// -a.
    Negative(Box<Self>),
    /// a op b.
    Binary(Binary, Box<Self>, Box<Self>),
    /// f(a), or f(a, b) for min and max.
    Function(Function, Vec<Self>),
}

/// Binary operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Binary {
    /// a + b.
    Add,
    /// a - b.
    Subtract,
    /// a b.
    Multiply,
    /// a/b.
    Divide,
    /// a^b.
    Power,
}

/// Functions of expressions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Function {
    /// Square root.
    Sqrt,
    /// Exponential.
    Exp,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Smaller of two.
    Min,
    /// Larger of two.
    Max,
    /// Absolute value.
    Abs,
}

/// A quantity of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Channel {
    /// Block.
    pub block: BlockRef,
    /// Quantity.
    pub quantity: Quantity,
}

/// Quantities of blocks, in SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Quantity {
    /// Body: position from its parent \[m\].
    Travel,
    /// Body: velocity from its parent \[m/s\].
    Speed,
    /// Body: y \[m\].
    Position,
    /// Body: v \[m/s\].
    Velocity,
    /// Body: dv/dt \[m/s2\].
    Acceleration,
    /// Body: mass with an attached fastener \[kg\].
    MovingMass,
    /// Volume, reservoir: absolute pressure \[Pa\].
    Pressure,
    /// Volume, reservoir: pressure above the atmosphere \[Pa\].
    Gauge,
    /// Volume, reservoir: temperature \[K\].
    Temperature,
    /// Volume: mass of gas \[kg\].
    Mass,
    /// Volume: volume \[m3\].
    Volume,
    /// Passage: mass flow from its first to its second end \[kg/s\].
    MassFlow,
    /// Passage in series: pressure upstream of the last restriction \[Pa\].
    Plenum,
    /// Passage: 1 when choked, else 0.
    Choked,
    /// Contact: overlap \[m\].
    Overlap,
    /// Contact, fastener: force on `against`/`into`; others: on the body that is `on`; down is positive \[N\].
    Force,
    /// Fastener: depth z of the tip, at least zero \[m\].
    Depth,
    /// Fastener: z, negative while the tip is above the surface \[m\].
    Tip,
    /// Fastener: largest z so far, at least zero \[m\].
    Deepest,
    /// Fastener: dz/dt \[m/s\].
    Advance,
    /// Fastener: friction of the guide on the fastener, down on `guide` \[N\].
    GuideForce,
    /// Trigger: 1 when on, else 0.
    On,
}

/// Comparison of two expressions; `and`/`or` combine comparisons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The condition is satisfied while this is positive (or zero, unless `strict`).
    pub margin: Expression,
    /// Whether zero does not satisfy it.
    pub strict: bool,
}

/// Named expression with its own channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensor {
    /// Name.
    pub name: String,
    /// Value.
    pub value: Expression,
    /// SI unit, as written in tables.
    pub unit: String,
}
