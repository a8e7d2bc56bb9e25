//! The law a cycle is driven against: a published one, a constant force, or a table.

use nailnoise_quantities::{Held, Kind, Value};
use serde::{Deserialize, Serialize};

use super::law::Curve;
use super::{ForceTable, PenetrationLaw, REFERENCE_SPEED, Specimen};
use crate::Parameters;
use crate::cycle::Real;

/// A law of the penetration resistance force for the nailing cycle, by its word in a design.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResistanceLaw {
    /// A published law, evaluated at [`REFERENCE_SPEED`].
    Published(PenetrationLaw),
    /// The same force at every depth, `wood.penetration_force`.
    Constant,
}

/// Words of the published laws, then that of the constant force.
const WORDS: [&str; PenetrationLaw::WORDS.len() + 1] = {
    let mut words = ["constant"; PenetrationLaw::WORDS.len() + 1];
    let mut i = 0;
    while i < PenetrationLaw::WORDS.len() {
        words[i] = PenetrationLaw::WORDS[i];
        i += 1;
    }
    words
};

impl ResistanceLaw {
    /// What a key of this type holds.
    pub const KIND: Kind = Kind::Choice(&WORDS);
}

impl Held for ResistanceLaw {
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Choice("constant") => Some(Self::Constant),
            _ => PenetrationLaw::from_value(value).map(Self::Published),
        }
    }

    fn to_value(&self) -> Value {
        match self {
            Self::Published(law) => law.to_value(),
            Self::Constant => Value::Choice("constant"),
        }
    }
}

impl From<PenetrationLaw> for ResistanceLaw {
    fn from(law: PenetrationLaw) -> Self {
        Self::Published(law)
    }
}

/// F_r over depth, times a factor.
#[derive(Debug, Clone)]
pub(crate) struct Resistance {
    law: Law,
    scale: f64,
}

#[derive(Debug, Clone)]
enum Law {
    Published(Curve),
    Constant(f64),
    Tabulated(ForceTable),
}

impl Resistance {
    /// The law of a cycle for the nail in its wood.
    pub(crate) fn new(p: &Parameters, specimen: &Specimen) -> Self {
        let wood = &p.wood;
        let law = match (&p.penetration_table, wood.penetration_law) {
            (Some(table), _) => Law::Tabulated(table.clone()),
            (None, ResistanceLaw::Published(law)) => {
                let mut coefficients = law.coefficients();
                if law == PenetrationLaw::SolidWood {
                    coefficients[8] = wood.speed_term / (REFERENCE_SPEED * REFERENCE_SPEED);
                    coefficients[9] = wood.slenderness_term;
                }
                Law::Published(Curve::new(&coefficients, specimen, REFERENCE_SPEED))
            }
            (None, ResistanceLaw::Constant) => Law::Constant(wood.penetration_force),
        };
        Self {
            law,
            scale: wood.resistance_scale,
        }
    }

    /// Force at `z` with its derivative, continued smoothly above the surface.
    #[inline]
    pub(crate) fn evaluate<S: Real>(&self, z: S) -> S {
        let force = match &self.law {
            Law::Published(curve) => curve.evaluate(z),
            Law::Constant(force) => S::constant(*force),
            Law::Tabulated(table) => {
                let (force, slope) = table.evaluate(z.value());
                z.chain(force, slope)
            }
        };
        force * self.scale
    }

    /// Force at `depth`, 0 at or above the surface \[N\].
    #[inline]
    pub(crate) fn force(&self, depth: f64) -> f64 {
        if depth <= 0.0 { 0.0 } else { self.evaluate(depth) }
    }
}
