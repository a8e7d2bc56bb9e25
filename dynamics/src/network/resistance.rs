//! Resistance of the work to a fastener.

use nailnoise_penetration::fit::LawOfDrive;
use nailnoise_penetration::{Curve, Envelope, PenetrationLaw};

use super::assembly::{Fastener, FastenerLaw};

/// Law of the resistance along the shank.
#[derive(Debug, Clone)]
pub(crate) enum ShankLaw {
    Solid(Curve),
    Constant(f64),
    Table(Vec<[f64; 2]>),
    /// Over depth and speed, with the force under the head.
    Envelope(Box<Envelope>),
}

impl ShankLaw {
    pub(crate) fn of(fastener: &Fastener) -> Self {
        match &fastener.law {
            FastenerLaw::SolidWood { hardness, offset } => {
                let mut root = [0.0; 8];
                root.copy_from_slice(&PenetrationLaw::SolidWood.coefficients()[..8]);
                root[0] += offset;
                Self::Solid(Curve::of(root, fastener.length, hardness * fastener.length))
            }
            FastenerLaw::Constant(force) => Self::Constant(*force),
            FastenerLaw::Table(points) => Self::Table(points.clone()),
            FastenerLaw::Wood(wood) => Self::Envelope(Box::new(wood.envelope(fastener))),
        }
    }

    /// Impact speed of the driver that is assumed if none is known \[m/s\].
    pub(crate) fn usual_impact(&self) -> f64 {
        match self {
            Self::Envelope(envelope) => envelope.usual_impact(),
            _ => 0.0,
        }
    }

    /// The fitted law, if one is used.
    pub(crate) fn fitted(&self) -> Option<&LawOfDrive> {
        match self {
            Self::Envelope(envelope) => envelope.law().fitted(),
            _ => None,
        }
    }
}

/// Resistance of the work over the depth z of a fastener's tip, on the way in, at rest.
///
/// ```text
/// E(z) = F_r(min(z, l)) + k_h max(0, z - l)
/// ```
#[derive(Debug, Clone)]
pub struct FastenerResistance {
    law: ShankLaw,
    length: f64,
    head_stiffness: f64,
    /// Whether the force along the shank vanishes when the head meets the work (published form).
    reversible: bool,
}

impl FastenerResistance {
    /// The resistance to a fastener.
    pub fn of(fastener: &Fastener) -> Self {
        Self {
            law: ShankLaw::of(fastener),
            length: fastener.length,
            head_stiffness: fastener.seated.head_stiffness,
            reversible: fastener.reversible,
        }
    }

    /// Force along the shank with the tip at `depth` \[m\] \[N\].
    pub fn shank(&self, depth: f64) -> f64 {
        if depth <= 0.0 || self.reversible && depth > self.length {
            return 0.0;
        }
        let embedded = depth.min(self.length);
        match &self.law {
            ShankLaw::Solid(curve) => curve.evaluate(embedded),
            ShankLaw::Constant(force) => *force,
            ShankLaw::Table(points) => interpolate(points, embedded).0,
            ShankLaw::Envelope(envelope) => envelope.shank(embedded),
        }
    }

    /// Friction along the shank, force of the tip and force under the head of a fastener that moves into the work at
    /// `speed` \[m/s\], with the tip at `depth` \[m\] \[N\]. The friction is `friction_share` of the force at full
    /// depth and linear in depth, unless the law of a wood states it.
    pub fn parts(&self, depth: f64, speed: f64, friction_share: f64) -> [f64; 3] {
        self.parts_after(self.law.usual_impact(), depth, speed, friction_share)
    }

    /// Same as [`parts`](Self::parts), after an impact of the driver at the speed `impact` \[m/s\]. A fitted law
    /// depends on this speed.
    pub(crate) fn parts_after(&self, impact: f64, depth: f64, speed: f64, friction_share: f64) -> [f64; 3] {
        if let ShankLaw::Envelope(envelope) = &self.law {
            return envelope.parts(depth, speed, impact);
        }
        let law = self.shank(depth);
        let full = friction_share * self.shank(self.length);
        let friction = (full * depth.min(self.length) / self.length).min(law);
        [friction, law - friction, self.head(depth)]
    }

    /// Force under the head with the tip at `depth` \[m\] \[N\].
    pub fn head(&self, depth: f64) -> f64 {
        match &self.law {
            ShankLaw::Envelope(envelope) => envelope.head(depth),
            _ => self.head_stiffness * (depth - self.length).max(0.0),
        }
    }
}

/// Value and slope of a table with linear interpolation; constant outside.
#[inline]
pub(crate) fn interpolate(points: &[[f64; 2]], x: f64) -> (f64, f64) {
    let right = points.partition_point(|point| point[0] <= x);
    match (right.checked_sub(1).map(|left| points[left]), points.get(right)) {
        (Some(a), Some(b)) => {
            let slope = (b[1] - a[1]) / (b[0] - a[0]);
            (a[1] + slope * (x - a[0]), slope)
        }
        (Some(last), None) => (last[1], 0.0),
        (None, first) => (first.map_or(0.0, |first| first[1]), 0.0),
    }
}
