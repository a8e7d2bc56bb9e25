//! The wood's grip on a section of the nail: a yield force in series with a spring and a radiation dashpot.

/// The soil model of pile driving: E. A. L. Smith, Pile-driving analysis by the wave equation, J. Soil Mech. Found.
/// Div. ASCE 86, 35, 1960; with the dashpot inside the slider, M. F. Randolph and H. A. Simons, An improved soil model
/// for one-dimensional pile driving analysis, Numerical Methods in Offshore Piling, 1986.
///
/// ```text
/// sticking:  f = k w + Z w',  w' = v                  |f| <= limit
/// slipping:  f = +-limit,     w' = (f - k w)/Z
/// ```
///
/// v is the nail's speed relative to the wood, and w the displacement of the wood's surface at the nail. Waves are
/// radiated through Z; while the nail slips, only the yield force acts on it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Grip {
    w: f64,
}

/// Properties of a grip in the current step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GripLaw {
    /// Yield force \[N\].
    pub(super) limit: f64,
    /// Stiffness \[N/m\].
    pub(super) stiffness: f64,
    /// Dashpot \[N s/m\].
    pub(super) dashpot: f64,
}

impl Grip {
    /// Force \[N\] that opposes a motion at the speed `v` \[m/s\] over a step of `dt` \[s\].
    pub(super) fn force(&mut self, law: &GripLaw, v: f64, dt: f64) -> f64 {
        if law.limit <= 0.0 {
            self.w = 0.0;
            return 0.0;
        }
        let sticking = law.stiffness * self.w + law.dashpot * v;
        let force = sticking.clamp(-law.limit, law.limit);
        // An implicit step of w, stable for every dashpot.
        self.w = if force == sticking {
            self.w + dt * v
        } else {
            (law.dashpot * self.w + dt * force) / (law.dashpot + dt * law.stiffness)
        };
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: GripLaw = GripLaw {
        limit: 100.0,
        stiffness: 1e6,
        dashpot: 200.0,
    };

    #[test]
    fn a_fast_nail_feels_the_yield_force_and_a_slow_vibration_a_spring_and_a_dashpot() {
        let mut grip = Grip::default();
        assert_eq!(grip.force(&LAW, 20.0, 1e-6), 100.0);
        let mut grip = Grip::default();
        let force = grip.force(&LAW, 0.1, 1e-6);
        assert!((force - 20.0).abs() < 1e-12);
        assert!((grip.force(&LAW, 0.0, 1e-6) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_spring_unloads_by_its_stiffness_after_a_slow_slip() {
        let mut grip = Grip::default();
        for _ in 0..10_000 {
            grip.force(&LAW, 1.0, 1e-6);
        }
        // At the limit, the wood's surface comes to rest at limit/k = 0.1 mm.
        assert!((grip.w - 1e-4).abs() < 1e-9, "{}", grip.w);
        for _ in 0..1000 {
            grip.force(&LAW, -0.05, 1e-6);
        }
        let force = grip.force(&LAW, 0.0, 1e-6);
        assert!((force - 50.0).abs() < 0.1, "{force}");
    }

    #[test]
    fn a_cycle_of_motion_dissipates() {
        let (mut grip, mut work, dt) = (Grip::default(), 0.0, 1e-6);
        for step in 0..20_000 {
            let v = 2.0 * (2.0 * std::f64::consts::PI * 1e3 * f64::from(step) * dt).sin();
            work += grip.force(&LAW, v, dt) * v * dt;
        }
        assert!(work > 0.0);
    }
}
