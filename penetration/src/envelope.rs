//! Resistance of the wood to a nail as a function of its deepest penetration.

use super::Specimen;
use super::dual::Real;
use super::rate::HeadContact;
use super::resistance::{Driven, Resistance};

/// Envelope E(z) of the penetration resistance of one design, where z is the deepest position of the nail's tip.
///
/// ```text
/// E(z) = F_r(min(z, l_n)) + k_w max(0, z - l_n),   k_w = scale H_M
/// ```
/// This form applies if the head does not yield ([`HeadContact`]). F_r is the design's law times its scale factor; a
/// published law is evaluated at [`REFERENCE_SPEED`](super::REFERENCE_SPEED). The published nail model drops F_r once
/// the head meets the wood: E(z) = k_w (z - l_n) for z > l_n (C-09).
#[derive(Debug, Clone)]
pub struct Envelope {
    law: Resistance,
    length: f64,
    head: HeadContact,
    /// Whether the shank force persists beyond l_n.
    seated: bool,
    /// Assumed impact speed if none is known \[m/s\].
    usual_impact: f64,
}

impl Envelope {
    /// Creates the envelope of a fastener with this head diameter \[m\]. If `seated`, the shank force persists after
    /// the head meets the wood, unlike in the published nail model.
    pub fn new(driven: &Driven<'_>, head_diameter: f64, seated: bool) -> Self {
        let law = Resistance::new(driven);
        Self {
            seated,
            usual_impact: law.fitted().map_or(0.0, |fitted| fitted.usual_impact()),
            law,
            length: driven.specimen.length,
            head: HeadContact::new(driven.wood, head_diameter),
        }
    }

    /// The same envelope with another stiffness k_w under the head \[N/m\].
    #[must_use]
    pub fn with_head_stiffness(self, stiffness: f64) -> Self {
        Self {
            head: self.head.with_stiffness(stiffness),
            ..self
        }
    }

    /// The same envelope in a specimen whose s = sqrt(F_r/(H_M NL)) deviates from the law by b.
    #[must_use]
    pub fn with_deviation(self, b: f64, specimen: &Specimen) -> Self {
        Self {
            law: self.law.with_deviation(b, specimen),
            ..self
        }
    }

    /// Shank and tip contribution to E(z) \[N\]; zero at or above the surface. A speed-dependent law is evaluated at
    /// rest, after an impact at the middle of its data range.
    #[inline]
    pub fn shank(&self, depth: f64) -> f64 {
        self.shank_after(depth, self.usual_impact)
    }

    /// Same as `shank`, after an impact at `impact` \[m/s\].
    fn shank_after(&self, depth: f64, impact: f64) -> f64 {
        if depth > self.length {
            self.seated(0.0, impact)
        } else {
            self.law.force(depth, impact)
        }
    }

    /// Head contribution to E(z) \[N\]; zero until the head meets the wood.
    #[inline]
    pub fn head(&self, depth: f64) -> f64 {
        self.head.evaluate((depth - self.length).max(0.0))
    }

    /// E(z) \[N\].
    #[inline]
    pub fn force(&self, depth: f64) -> f64 {
        self.shank(depth) + self.head(depth)
    }

    /// Friction along the shank, force of the tip and force under the head \[N\] at the nail's speed `v` \[m/s\] in the
    /// wood; zero at or above the surface.
    pub fn parts(&self, depth: f64, v: f64, impact: f64) -> [f64; 3] {
        if depth <= 0.0 || (depth > self.length && !self.seated) {
            return [0.0, 0.0, self.head(depth)];
        }
        let [friction, tip] = self.law.parts(depth.min(self.length), v, impact);
        [friction, tip, self.head(depth)]
    }

    /// E(z) of a nail at rest after an impact at `impact` \[m/s\]; unloading starts at this force \[N\].
    pub fn at_rest(&self, depth: f64, impact: f64) -> f64 {
        self.shank_after(depth, impact) + self.head(depth)
    }

    /// Assumed impact speed if none is known \[m/s\].
    pub fn usual_impact(&self) -> f64 {
        self.usual_impact
    }

    /// The law F_r used within the nail's length.
    pub fn law(&self) -> &Resistance {
        &self.law
    }

    /// The force under the head where the tip's depth is beyond l_n, with its derivatives.
    #[inline]
    pub fn head_at<S: Real>(&self, depth: S) -> S {
        self.head.evaluate(depth + -self.length)
    }

    /// Shank force beyond l_n \[N\].
    #[inline]
    pub fn seated<S: Real>(&self, v: S, impact: f64) -> S {
        if self.seated {
            self.law.evaluate(S::constant(self.length), v, impact)
        } else {
            S::constant(0.0)
        }
    }
}
