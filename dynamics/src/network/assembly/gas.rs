//! Volumes, reservoirs, faces and passages.

use serde::Serialize;

use super::{Base, Expression, Space};

/// Polytropic law of all volumes. Their gas has the same constant temperature (published form, thesis Eq. 4.26):
///
/// ```text
/// P' = R T/V (sum alpha mdot) - alpha_0 P V'/V
/// ```
/// with alpha = `inflow`, or that of the passage for the gas that leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Polytropic {
    /// Exponent alpha_0 of a change of volume.
    pub exponent: f64,
    /// Exponent of the gas that flows.
    pub inflow: f64,
    /// Temperature T \[K\].
    pub temperature: f64,
}

/// Gas of constant pressure and temperature, without a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reservoir {
    /// Name.
    pub name: String,
    /// Absolute pressure \[Pa\].
    pub pressure: f64,
    /// Temperature \[K\].
    pub temperature: f64,
}

/// Gas volume of uniform state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Volume {
    /// Name.
    pub name: String,
    /// Volume with all its faces at their zero travel \[m3\].
    pub dead: f64,
    /// Absolute pressure at the start \[Pa\].
    pub pressure: f64,
    /// Temperature at the start \[K\].
    pub temperature: f64,
    /// Heat transfer to the wall.
    pub wall: Option<Wall>,
    /// Whether the temperature remains that of the start.
    pub isothermal: bool,
    /// Whether its pressure belongs to the exhaust path (for transducers and the choked fraction).
    pub exhaust_path: bool,
}

/// Wall that exchanges heat with the gas of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Wall {
    /// Area with all faces at their zero travel \[m2\].
    pub area: f64,
    /// Heat transfer coefficient \[W/(m2 K)\].
    pub transfer: f64,
    /// Temperature of the wall \[K\].
    pub temperature: f64,
}

/// Area where gas acts on a body: force and swept volume.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Face {
    /// Name.
    pub name: String,
    /// Gas that acts.
    pub gas: Space,
    /// Index of the body it acts on.
    pub body: usize,
    /// Body that carries the reaction; the travel is measured relative to it.
    pub against: Base,
    /// Direction of the force on `body`.
    pub push: super::Push,
    /// Area \[m2\].
    pub area: f64,
    /// Travel at which the face adds nothing to the dead volume \[m\].
    pub zero: f64,
    /// Wall length around the face: the volume's wall area changes by this times the swept travel \[m\].
    pub perimeter: f64,
    /// Whether its travel changes the volume.
    pub sweeps: bool,
}

/// Passage between two spaces; a flow from `from` to `to` is positive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Passage {
    /// Name.
    pub name: String,
    /// First end.
    pub from: Space,
    /// Second end.
    pub to: Space,
    /// One restriction, or several in series from `from` to `to`.
    pub restrictions: Vec<Restriction>,
    /// Flow function.
    pub law: PassageLaw,
    /// Whether flow from `to` to `from` is blocked.
    pub one_way: bool,
    /// Polytropic exponents of the gas that leaves the first and the second space, if they differ from that of inflow.
    pub exponents: [Option<f64>; 2],
    /// Switching by a trigger, if any.
    pub gate: Option<Gate>,
    /// Whether an opening to the atmosphere is treated as silent.
    pub silent: bool,
}

/// A restriction of a passage: an area and a discharge coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Restriction {
    /// Name within its series; empty for a single restriction.
    pub name: String,
    /// Area as a function of the state.
    pub opens: Opens,
    /// Discharge coefficient.
    pub coefficient: Coefficient,
    /// Pipe whose friction reduces the coefficient.
    pub pipe: Option<Pipe>,
}

impl Restriction {
    /// The discharge coefficient with the friction of the pipe, 1/sqrt(1/C^2 + f L/d); none if it depends on the
    /// pressure ratio.
    pub fn discharge_coefficient(&self) -> Option<f64> {
        match (&self.coefficient, self.pipe) {
            (Coefficient::Constant(c), None) => Some(*c),
            (Coefficient::Constant(c), Some(pipe)) => {
                Some(1.0 / (1.0 / (c * c) + pipe.friction * pipe.length / pipe.diameter).sqrt())
            }
            (Coefficient::RatioPolynomial { .. }, _) => None,
        }
    }
}

/// Area of a restriction as a function of the state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Opens {
    /// Constant area \[m2\].
    Constant {
        /// Area \[m2\].
        area: f64,
    },
    /// Conical seat: Y = +-(x - at), A = pi Y sin th (d -+ Y sin th cos th).
    Seat {
        /// Index of the body whose travel opens it.
        body: usize,
        /// Reference body of the travel.
        against: Base,
        /// Direction of travel that opens it.
        push: super::Push,
        /// Travel at which it opens \[m\].
        at: f64,
        /// Diameter of the seat \[m\].
        diameter: f64,
        /// Angle of the cone \[rad\].
        angle: f64,
        /// Whether the cone narrows or widens with the opening.
        cone: Cone,
    },
    /// Holes that a body's travel uncovers.
    Holes {
        /// Index of the body.
        body: usize,
        /// Reference body of the travel.
        against: Base,
        /// Direction of travel that uncovers them.
        push: super::Push,
        /// Travel at which the holes begin to open \[m\].
        at: f64,
        /// Total area \[m2\].
        area: f64,
        /// Diameter of one hole for gradual uncovering \[m\]; `None` opens the total area at once.
        diameter: Option<f64>,
    },
    /// Area that grows linearly with time, A min(1, t/time).
    Ramp {
        /// Final area \[m2\].
        area: f64,
        /// Time to the final area \[s\].
        time: f64,
    },
}

/// Shape of a conical seat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Cone {
    /// The free diameter decreases with the opening (minus sign).
    Narrows,
    /// The free diameter increases with the opening (plus sign).
    Widens,
}

/// Discharge coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Coefficient {
    /// Constant.
    Constant(f64),
    /// Polynomial in the pressure ratio r, clipped to a range.
    RatioPolynomial {
        /// Coefficients of r^0, r^1, ...
        coefficients: Vec<f64>,
        /// Lowest value.
        from: f64,
        /// Highest value.
        to: f64,
    },
}

/// Pipe in a restriction: C A = A/sqrt(1/C^2 + friction L/d).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pipe {
    /// Length \[m\].
    pub length: f64,
    /// Diameter \[m\].
    pub diameter: f64,
    /// Darcy friction factor.
    pub friction: f64,
}

/// Flow function of a passage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum PassageLaw {
    /// Ideal nozzle (Saint-Venant and Wantzel 1839).
    Nozzle,
    /// Elliptic subsonic function of ISO 6358-1:2013 with critical ratio b.
    Iso6358 {
        /// Critical pressure ratio b.
        critical_ratio: f64,
    },
}

/// Switching of a passage by a trigger.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gate {
    /// Index of the trigger.
    pub trigger: usize,
    /// Whether the passage is open while the trigger is off.
    pub inverted: bool,
    /// Delay between the trigger's change and the passage's \[s\].
    pub delay: f64,
    /// State of the passage before the first change takes effect.
    pub before: bool,
    /// Whether the delay applies to the flow. The flow that arrives is then that of one delay earlier.
    pub delays_flow: bool,
    /// Whether the flow leaves the first space at the trigger's change, without the discharge coefficient.
    pub leaves_undelayed: bool,
    /// A further condition on the state, if any.
    pub also: Option<Expression>,
}
