//! Dependence of the resistance on speed, and the force under the nail's head.

use super::REFERENCE_SPEED;
use super::dual::Real;
use super::shanks::Shanks;
use super::speed_terms::SpeedTerms;
use super::wood::{HeadLaw, NailedWood, RateLaw};

/// Split of a quasi-static resistance F(z) into friction along the shank and deformation at the tip, each with its
/// dependence on the speed v.
///
/// ```text
/// F_fric = min(phi F(l_n) z/l_n, F)        F_def = F - F_fric
/// F(z, v) = F_def (1 + beta lg(|v|/v_ref)) + q F_fric m(v)/m(v_ref)
/// m(v) = m_1 + (m_0 - m_1) exp(-v/v_m)     lg(|v|/v_ref) as lg[(1 + v^2/v_ref^2)/2]/2
/// ```
///
/// - v_ref is [`REFERENCE_SPEED`], at which the quasi-static laws apply; F(z, v_ref) = F(z) with q = 1.
/// - m: friction of wood on unpolished steel, 0.65 at rest and about 0.4 at 4 m/s (W. M. McKenzie and H. Karpovich, The
///   frictional behaviour of wood, Wood Sci. Technol. 2, 139, 1968).
/// - beta: increase of the crushing strength per decade of speed (S. R. Reid and C. Peng, Dynamic uniaxial crushing of
///   wood, Int. J. Impact Eng. 19, 531, 1997).
/// - The smooth logarithm is finite at rest: -0.15 instead of minus infinity. Two decades above v_ref it is 0.15 below
///   lg(|v|/v_ref).
/// - q: factor of a coating on the shank; 1 for a bright nail. It is independent of [`RateLaw`].
#[derive(Debug, Clone, Copy)]
pub(super) struct RateSplit {
    /// phi F(l_n)/l_n \[N/m\].
    friction_slope: f64,
    coating: f64,
    speed: Option<SpeedTerms>,
}

impl RateSplit {
    /// The split of a law with the force `full` \[N\] at the nail's full length.
    pub(super) fn new(wood: &NailedWood, shanks: &Shanks, full: f64, length: f64) -> Self {
        Self {
            friction_slope: shanks.friction_share * full / length,
            coating: shanks.coating,
            speed: (wood.rate == RateLaw::Speed).then_some(SpeedTerms {
                crushing: wood.crushing_rate,
                rest: wood.friction_at_rest,
                sliding: wood.friction_sliding,
                width: wood.friction_speed,
            }),
        }
    }

    /// The split of a fitted law that is quasi-static, with the dependence on speed of its tests.
    pub(super) fn fitted(friction_share: f64, speed: SpeedTerms, full: f64, length: f64) -> Self {
        Self {
            friction_slope: friction_share * full / length,
            coating: 1.0,
            speed: Some(speed),
        }
    }

    /// The split of a law that contains the effects of speed and coating.
    pub(super) fn inert(shanks: &Shanks, full: f64, length: f64) -> Self {
        Self {
            friction_slope: shanks.friction_share * full / length,
            coating: 1.0,
            speed: None,
        }
    }

    /// Whether the sum of the parts differs from the quasi-static force.
    pub(super) fn changes(&self) -> bool {
        self.speed.is_some() || self.coating != 1.0
    }

    /// Friction and deformation at depth `z` and speed `v`, from the quasi-static `force`.
    #[inline]
    pub(super) fn parts<S: Real>(&self, force: S, z: S, v: S) -> [S; 2] {
        let friction = if z.value() <= 0.0 {
            S::constant(0.0)
        } else if self.friction_slope * z.value() < force.value() {
            z * self.friction_slope
        } else {
            force
        };
        let deformation = force - friction;
        match &self.speed {
            None => [friction * self.coating, deformation],
            Some(terms) => {
                let reference = terms.friction(REFERENCE_SPEED).0;
                let (m, slope) = terms.friction(v.value());
                let factor = self.coating / reference;
                let (crushing, rise) = terms.crushing(v.value());
                [
                    friction * v.chain(factor * m, factor * slope),
                    deformation * v.chain(crushing, rise),
                ]
            }
        }
    }
}

/// Force under a head at a depth d below the wood's surface.
///
/// ```text
/// linear:  F = k_w d                          yields:  F = F_y (1 - exp(-k_w d/F_y))
/// F_y = s f_head d_h^2,   f_head = 70e-6 rho^2   (N/mm2, kg/m3)
/// ```
///
/// F_y is the pull-through resistance of the heads of smooth nails, EN 1995-1-1:2004, 8.3.2 (7), with the density of
/// this wood instead of the characteristic density, times a factor s. The exponential is the load-slip curve of R. O.
/// Foschi, Load-slip characteristics of nails, Wood Sci. 7, 69, 1974, without hardening.
#[derive(Debug, Clone, Copy)]
pub struct HeadContact {
    stiffness: f64,
    yield_force: Option<f64>,
}

/// Coefficient of the pull-through parameter f_head \[Pa/(kg/m3)^2\].
const PULL_THROUGH: f64 = 70.0;

impl HeadContact {
    /// The contact of a head with a diameter \[m\] in a wood.
    pub fn new(wood: &NailedWood, head_diameter: f64) -> Self {
        let pull_through = PULL_THROUGH * wood.density * wood.density * head_diameter * head_diameter;
        Self {
            stiffness: wood.head_stiffness_scale * wood.hardness_modulus,
            yield_force: (wood.head_law == HeadLaw::Yields).then_some(wood.head_yield_scale * pull_through),
        }
    }

    /// The same contact with another stiffness k_w \[N/m\].
    #[must_use]
    pub fn with_stiffness(self, stiffness: f64) -> Self {
        Self { stiffness, ..self }
    }

    /// Force at the depth `over` of the head below the surface, continued linearly above it.
    #[inline]
    pub fn evaluate<S: Real>(&self, over: S) -> S {
        let linear = over * self.stiffness;
        match self.yield_force {
            Some(limit) if over.value() > 0.0 => {
                let remaining = (-linear.value() / limit).exp();
                over.chain(limit * (1.0 - remaining), self.stiffness * remaining)
            }
            _ => linear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    const TERMS: SpeedTerms = SpeedTerms {
        crushing: 0.05,
        rest: 0.65,
        sliding: 0.40,
        width: 1.0,
    };
    const SPLIT: RateSplit = RateSplit {
        friction_slope: 20e3,
        coating: 1.0,
        speed: Some(TERMS),
    };

    #[test]
    fn the_quasi_static_force_applies_at_the_reference_speed() {
        let [friction, deformation] = SPLIT.parts(1000.0, 0.03, REFERENCE_SPEED);
        assert!((friction - 600.0).abs() < 1e-12 && (deformation - 400.0).abs() < 1e-12);
    }

    #[test]
    fn friction_falls_and_crushing_rises_as_their_sources_say() {
        let [friction, deformation] = SPLIT.parts(1000.0, 0.03, 20.0);
        // 0.40/0.648 and 1 + 0.05 lg(20/0.008333), less the smooth logarithm's 0.15 decades.
        assert!((friction / 600.0 - 0.40 / (0.40 + 0.25 * (-REFERENCE_SPEED).exp())).abs() < 1e-8);
        let decades = (20.0 / REFERENCE_SPEED).log10() - 0.5 * 2f64.log10();
        assert!((deformation / 400.0 - (1.0 + 0.05 * decades)).abs() < 1e-6);
        assert!((TERMS.friction(4.0).0 - 0.40).abs() < 0.005);
    }

    #[test]
    fn derivatives_are_those_of_the_force() {
        for (z, v) in [(0.01, 0.02), (0.03, 0.5), (0.06, 20.0), (0.03, 0.0)] {
            let force = |z: f64| 1e5 * z * z + 3e4 * z;
            let sum = |z: f64, v: f64| SPLIT.parts(force(z), z, v).iter().sum::<f64>();
            let dual = |value: f64, slope: [f64; 2]| Dual { value, slope };
            let (dz, dv) = (dual(z, [1.0, 0.0]), dual(v, [0.0, 1.0]));
            let [a, b] = SPLIT.parts(dz.chain(force(z), 2e5 * z + 3e4), dz, dv);
            let step = 1e-7;
            let by_depth = (sum(z + step, v) - sum(z - step, v)) / (2.0 * step);
            let by_speed = (sum(z, v + step) - sum(z, v - step)) / (2.0 * step);
            assert!((a.slope[0] + b.slope[0] - by_depth).abs() < 1e-3 * by_depth.abs());
            assert!((a.slope[1] + b.slope[1] - by_speed).abs() < 1e-3 * by_speed.abs().max(1.0));
        }
    }

    #[test]
    fn a_head_presses_as_a_spring_and_yields_at_its_pull_through_resistance() {
        let head = HeadContact {
            stiffness: 4e5,
            yield_force: Some(750.0),
        };
        assert!((head.evaluate(1e-6) / 0.4 - 1.0).abs() < 1e-3);
        assert!((head.evaluate(0.02) - 750.0).abs() < 0.1);
        let (at, step) = (2e-3, 1e-8);
        let slope = (head.evaluate(at + step) - head.evaluate(at - step)) / (2.0 * step);
        let dual = head.evaluate(Dual {
            value: at,
            slope: [1.0],
        });
        assert!((dual.slope[0] / slope - 1.0).abs() < 1e-6);
    }
}
