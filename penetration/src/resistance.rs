//! The penetration law used by a nailing cycle: a published law, a constant force, a fitted law or a table.

use super::dual::Real;
use super::extension::extended;
use super::fit::{FittedLaw, LawOfDrive};
use super::law::Curve;
use super::rate::RateSplit;
use super::rings::GrowthRings;
use super::shanks::Shanks;
use super::{ForceTable, NailedWood, PenetrationLaw, REFERENCE_SPEED, ResistanceLaw, Specimen};

/// A fastener that a mass drives into a wood.
#[derive(Debug, Clone, Copy)]
pub struct Driven<'a> {
    /// The wood.
    pub wood: &'a NailedWood,
    /// Tabulated resistance, which replaces the law of the wood.
    pub table: Option<&'a ForceTable>,
    /// The fitted law, used if the design chooses `fitted`.
    pub fit: Option<&'a FittedLaw>,
    /// Nail and wood.
    pub specimen: &'a Specimen,
    /// The driving mass \[kg\].
    pub mass: f64,
    /// The fastener's shanks.
    pub shanks: Shanks,
}

/// F_r as a function of depth, times a scale factor.
#[derive(Debug, Clone)]
pub struct Resistance {
    law: Law,
    scale: f64,
    split: RateSplit,
    rings: Option<GrowthRings>,
    deviation: Option<Deviation>,
}

/// Deviation of a specimen from its law: s = sqrt(F_r/(H_M NL)) is greater by b.
#[derive(Debug, Clone, Copy)]
struct Deviation {
    /// H_M NL \[N\].
    scale: f64,
    b: f64,
}

impl Deviation {
    #[inline]
    fn of<S: Real>(&self, force: S) -> S {
        let root = (force.value() / self.scale).max(0.0).sqrt();
        let moved = (root + self.b).max(0.0);
        // dF'/dF = s'/s; the law is cut off where the force is 0.
        let slope = if root > 0.0 { moved / root } else { 0.0 };
        force.chain(self.scale * moved * moved, slope)
    }
}

#[derive(Debug, Clone)]
enum Law {
    Published(Curve),
    Constant(f64),
    Fitted(LawOfDrive),
    Tabulated(ForceTable),
}

impl Resistance {
    /// Creates the resistance from the law of the wood, or from the table or fit that replaces it. A published law is
    /// for one shank and is multiplied by the number of shanks. The user's laws are for the complete fastener.
    pub fn new(driven: &Driven<'_>) -> Self {
        let Driven {
            wood,
            table,
            fit,
            specimen,
            mass,
            shanks,
        } = *driven;
        let mut scale = wood.resistance_scale;
        let law = match (table, wood.penetration_law) {
            (Some(table), _) => Law::Tabulated(table.clone()),
            (None, ResistanceLaw::Published(law)) => {
                let mut coefficients = law.coefficients();
                if law == PenetrationLaw::SolidWood {
                    coefficients[8] = wood.speed_term / (REFERENCE_SPEED * REFERENCE_SPEED);
                    coefficients[9] = wood.slenderness_term;
                }
                scale *= f64::from(shanks.legs);
                let tested = specimen.nearest_tested();
                let curve = Curve::new(&coefficients, tested.as_ref().unwrap_or(specimen), REFERENCE_SPEED);
                tested
                    .and_then(|size| extended(&curve, &size, specimen, shanks.friction_share))
                    .map_or(Law::Published(curve), Law::Tabulated)
            }
            (None, ResistanceLaw::Constant) => Law::Constant(wood.penetration_force),
            // Already checked before a cycle starts; without a law the force is zero.
            (None, ResistanceLaw::Fitted) => match fit {
                Some(fit) => Law::Fitted(fit.of(specimen, mass)),
                None => Law::Constant(0.0),
            },
        };
        let quasi_static = Self {
            law,
            scale,
            split: RateSplit::inert(&shanks, 0.0, specimen.length),
            rings: None,
            deviation: None,
        };
        let impact = quasi_static.fitted().map_or(0.0, LawOfDrive::usual_impact);
        let full = quasi_static.evaluate(specimen.length, 0.0, impact);
        // A fitted law already contains the effects of speed and coating of its tests.
        let split = match &quasi_static.law {
            Law::Fitted(law) => match law.rate() {
                Some(own) => RateSplit::fitted(own.friction_share, own.speed, full, specimen.length),
                None => RateSplit::inert(&shanks, full, specimen.length),
            },
            _ => RateSplit::new(wood, &shanks, full, specimen.length),
        };
        Self {
            split,
            rings: GrowthRings::new(wood, specimen.length),
            ..quasi_static
        }
    }

    /// The same resistance in a specimen whose s = sqrt(F_r/(H_M NL)) deviates from the law by b.
    #[must_use]
    pub fn with_deviation(self, b: f64, specimen: &Specimen) -> Self {
        let scale = specimen.hardness_modulus * specimen.length;
        Self {
            deviation: (b != 0.0).then_some(Deviation { scale, b }),
            ..self
        }
    }

    /// Force at depth `z` and nail speed `v` in the wood, after an impact of the rod at `impact` \[m/s\], with its
    /// derivatives, smoothly continued above the surface.
    #[inline]
    pub fn evaluate<S: Real>(&self, z: S, v: S, impact: f64) -> S {
        if self.split.changes() || self.rings.is_some() {
            let [friction, tip] = self.parts(z, v, impact);
            friction + tip
        } else {
            self.quasi_static(z, v, impact)
        }
    }

    /// Friction along the shank and force of the tip, whose sum is [`evaluate`](Self::evaluate).
    #[inline]
    pub fn parts<S: Real>(&self, z: S, v: S, impact: f64) -> [S; 2] {
        let [friction, tip] = self.split.parts(self.quasi_static(z, v, impact), z, v);
        match &self.rings {
            Some(rings) => [friction, rings.on_tip(tip, z)],
            None => [friction, tip],
        }
    }

    #[inline]
    fn quasi_static<S: Real>(&self, z: S, v: S, impact: f64) -> S {
        let force = match &self.law {
            Law::Published(curve) => curve.evaluate(z),
            Law::Constant(force) => S::constant(*force),
            Law::Fitted(law) => {
                let at = law.evaluate(z.value(), v.value(), impact);
                z.chain(at.force, at.by_depth) + v.chain(0.0, at.by_speed)
            }
            Law::Tabulated(table) => {
                let (force, slope) = table.evaluate(z.value());
                z.chain(force, slope)
            }
        };
        let force = force * self.scale;
        match &self.deviation {
            Some(deviation) => deviation.of(force),
            None => force,
        }
    }

    /// Force at `depth` with the nail at rest, 0 at or above the surface \[N\].
    #[inline]
    pub fn force(&self, depth: f64, impact: f64) -> f64 {
        if depth <= 0.0 {
            0.0
        } else {
            self.evaluate(depth, 0.0, impact)
        }
    }

    /// The fitted law, if one is used.
    pub fn fitted(&self) -> Option<&LawOfDrive> {
        match &self.law {
            Law::Fitted(law) => Some(law),
            _ => None,
        }
    }
}
