//! Dependence of friction and crushing on speed.
//!
//! ```text
//! c(v) = 1 + beta lg(|v|/v_ref)              lg(|v|/v_ref) as lg[(1 + v^2/v_ref^2)/2]/2
//! m(v) = m_1 + (m_0 - m_1) exp(-v/v_m)
//! ```
//!
//! The sources are those of `wood.rate = "speed"`.

use serde::{Deserialize, Serialize};

use super::REFERENCE_SPEED;

/// Coefficients of the dependence on speed of the penetration resistance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedTerms {
    /// beta, increase of the crushing strength per decade of speed \[-\].
    pub crushing: f64,
    /// m_0, coefficient of friction at rest \[-\].
    pub rest: f64,
    /// m_1, coefficient of friction at high speed \[-\].
    pub sliding: f64,
    /// v_m, speed over which friction falls \[m/s\].
    pub width: f64,
}

impl Default for SpeedTerms {
    /// The published dependences: see `wood.rate` in the base design.
    fn default() -> Self {
        Self {
            crushing: 0.05,
            rest: 0.65,
            sliding: 0.40,
            width: 1.0,
        }
    }
}

impl SpeedTerms {
    /// Factors of deformation and friction at the speed `v` \[m/s\], relative to the quasi-static force.
    pub fn factors(&self, v: f64) -> [f64; 2] {
        [
            self.crushing(v).0 / self.crushing(REFERENCE_SPEED).0,
            self.friction(v).0 / self.friction(REFERENCE_SPEED).0,
        ]
    }

    /// m(v) and its derivative.
    pub(super) fn friction(&self, v: f64) -> (f64, f64) {
        // Newton steps may pass through small negative speeds.
        let fall = (self.rest - self.sliding) * (-v.max(-self.width) / self.width).exp();
        let slope = if v > -self.width { -fall / self.width } else { 0.0 };
        (self.sliding + fall, slope)
    }

    /// 1 + beta lg(v/v_ref) and its derivative.
    pub(super) fn crushing(&self, v: f64) -> (f64, f64) {
        let ratio = v / REFERENCE_SPEED;
        let square = 1.0 + ratio * ratio;
        let derivative = ratio / (square * REFERENCE_SPEED * std::f64::consts::LN_10);
        (
            1.0 + 0.5 * self.crushing * (0.5 * square).log10(),
            self.crushing * derivative,
        )
    }
}
