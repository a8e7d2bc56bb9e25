//! The law a cycle is driven against: a published one, a constant force, or a table.

use serde::{Deserialize, Serialize};

use super::law::Curve;
use super::{ForceTable, PenetrationLaw, REFERENCE_SPEED, Specimen};
use crate::Wood;
use crate::cycle::Real;

/// A law of the penetration resistance force for the nailing cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResistanceLaw {
    /// A published law, evaluated at [`REFERENCE_SPEED`].
    Published(PenetrationLaw),
    /// The same force at every depth \[N\].
    Constant(f64),
    /// A measured or fitted force over depth.
    Tabulated(ForceTable),
}

impl From<PenetrationLaw> for ResistanceLaw {
    fn from(law: PenetrationLaw) -> Self {
        Self::Published(law)
    }
}

impl From<ForceTable> for ResistanceLaw {
    fn from(table: ForceTable) -> Self {
        Self::Tabulated(table)
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
    pub(crate) fn new(wood: &Wood, specimen: &Specimen) -> Self {
        let law = match &wood.law {
            ResistanceLaw::Published(law) => {
                let mut coefficients = law.coefficients();
                if *law == PenetrationLaw::SolidWood {
                    coefficients[8] = wood.speed_term / (REFERENCE_SPEED * REFERENCE_SPEED);
                    coefficients[9] = wood.slenderness_term;
                }
                Law::Published(Curve::new(&coefficients, specimen, REFERENCE_SPEED))
            }
            ResistanceLaw::Constant(force) => Law::Constant(*force),
            ResistanceLaw::Tabulated(table) => Law::Tabulated(table.clone()),
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
