//! Flow of air through restrictions.

use nailnoise_penetration::{Dual, Real};

/// Air and the compressible orifice law.
///
/// ```text
/// mdot = C A K P_u N(P_d/P_u)/sqrt(T_u),   K = sqrt(gamma/R (2/(gamma+1))^((gamma+1)/(gamma-1)))
/// N(r) = 1                                                    r <= P_cr = (2/(gamma+1))^(gamma/(gamma-1))
///      = sqrt((r^(2/gamma) - r^((gamma+1)/gamma))/n2)         n2 = (gamma-1)/2 (2/(gamma+1))^((gamma+1)/(gamma-1))
///      = linear to N(1) = 0                                   1 - r < `linear` (C-28)
/// ```
/// Thesis Eq. 4.28; ISO 6358 uses the same ideal-nozzle form.
#[derive(Debug, Clone)]
pub(crate) struct Air {
    /// gamma \[-\].
    pub(crate) gamma: f64,
    /// c_p \[J/(kg K)\].
    pub(crate) cp: f64,
    /// P_cr, critical pressure ratio \[-\].
    pub(crate) critical: f64,
    /// K \[sqrt(K) s/m\].
    coefficient: f64,
    inv_n2: f64,
    inv_gamma: f64,
    linear: f64,
    linear_slope: f64,
    /// Whether N is the ellipse of ISO 6358 above the critical ratio.
    elliptic: bool,
}

impl Air {
    pub(crate) fn new(gas_constant: f64, gamma: f64, linear: f64) -> Self {
        let base = 2.0 / (gamma + 1.0);
        let power = base.powf((gamma + 1.0) / (gamma - 1.0));
        let mut air = Self {
            gamma,
            cp: gamma * gas_constant / (gamma - 1.0),
            critical: base.powf(gamma / (gamma - 1.0)),
            coefficient: (gamma / gas_constant * power).sqrt(),
            inv_n2: 1.0 / (0.5 * (gamma - 1.0) * power),
            inv_gamma: 1.0 / gamma,
            linear,
            linear_slope: 0.0,
            elliptic: false,
        };
        air.linear_slope = air.subsonic(1.0 - linear).0 / linear;
        air
    }

    /// The same air with the flow function of ISO 6358-1:2013,
    ///
    /// ```text
    /// N(r) = sqrt(1 - ((r - b)/(1 - b))^2)    r > b,   linear to N(1) = 0 as the ideal nozzle
    /// ```
    pub(crate) fn elliptic(&self, critical: f64) -> Self {
        let mut air = Self {
            critical,
            elliptic: true,
            ..self.clone()
        };
        air.linear_slope = air.subsonic(1.0 - self.linear).0 / self.linear;
        air
    }

    #[inline]
    fn subsonic(&self, r: f64) -> (f64, f64) {
        if self.elliptic {
            let x = (r - self.critical) / (1.0 - self.critical);
            let n = (1.0 - x * x).sqrt();
            return (n, -x / (n * (1.0 - self.critical)));
        }
        // r^(1/gamma), at half the cost of powf and with the same accuracy for r near 1.
        let q = (r.ln() * self.inv_gamma).exp();
        let n = ((q * q - q * r) * self.inv_n2).sqrt();
        // d(q^2 - q r)/dr with dq/dr = q/(gamma r)
        let dq = q / r * self.inv_gamma;
        (n, 0.5 * self.inv_n2 * (2.0 * q * dq - dq * r - q) / n)
    }

    /// N(r) and its derivative, for r in 0..1.
    #[inline]
    pub(crate) fn flow_function(&self, r: f64) -> (f64, f64) {
        if r <= self.critical {
            (1.0, 0.0)
        } else if 1.0 - r < self.linear {
            (self.linear_slope * (1.0 - r), -self.linear_slope)
        } else {
            self.subsonic(r)
        }
    }

    /// Mass flow from `up` to `down`, for P_u >= P_d \[kg/s\]; `area` is C A.
    #[inline]
    pub(crate) fn flow<S: Real>(&self, area: S, up: Gas<S>, down: S) -> S {
        let r = down * up.pressure.recip();
        let (n, dn) = self.flow_function(r.value());
        area * up.pressure * r.chain(n, dn) * up.temperature.recip_sqrt() * self.coefficient
    }

    /// Thrust of a jet through a hole divided by its effective area \[Pa\], with P_m upstream and P_a downstream of the
    /// hole.
    ///
    /// ```text
    /// F/A = rho_e U^2 + P_e - P_a,   r = max(P_a/P_m, P_cr)
    ///     = P_m [2 gamma/(gamma-1) (r^(1/gamma) - r) + r] - P_a
    /// ```
    /// This is the ideal convergent nozzle (Shapiro 1953, ch. 4). The exit pressure is P_e = r P_m.
    pub(crate) fn thrust<S: Real>(&self, before: S, behind: S) -> S {
        let r = behind * before.recip();
        let jet = |r: f64| {
            let q = r.powf(self.inv_gamma);
            let c = 2.0 * self.gamma / (self.gamma - 1.0);
            (c * (q - r) + r, c * (q / r * self.inv_gamma - 1.0) + 1.0)
        };
        let (value, slope) = if r.value() > self.critical {
            jet(r.value())
        } else {
            (jet(self.critical).0, 0.0)
        };
        before * r.chain(value, slope) - behind
    }

    /// Pressure between two restrictions in series with C A = `first`, then `second`.
    ///
    /// Solves first P_u N(P_m/P_u) = second P_m N(P_d/P_m) for P_d <= P_m <= P_u, with the same temperature in both
    /// (C-15). The residual decreases strictly with P_m, so safeguarded Newton iteration cannot fail; derivatives
    /// follow from the implicit function theorem. `near` is an initial guess, if one is known.
    pub(crate) fn intermediate_pressure<S: Real>(&self, first: S, second: S, up: S, down: S, near: Option<f64>) -> S {
        let (pu, pd, a1, a2) = (up.value(), down.value(), first.value(), second.value());
        let (mut low, mut high) = (pd, pu);
        // If both restrictions are in the linear range, the balance is linear in P_m.
        let mut pm = (a1 * pu + a2 * pd) / (a1 + a2);
        if pu - pm >= self.linear * pu || pm - pd >= self.linear * pm {
            pm = match near {
                Some(near) if near > pd && near < pu => near,
                _ => self.elliptic_pressure(a1, a2, pu, pd),
            };
            for _ in 0..80 {
                let (n1, dn1) = self.flow_function((pm / pu).min(1.0));
                let r2 = (pd / pm).min(1.0);
                let (n2, dn2) = self.flow_function(r2);
                let residual = a1 * pu * n1 - a2 * pm * n2;
                if residual > 0.0 {
                    low = pm;
                } else {
                    high = pm;
                }
                let newton = pm - residual / (a1 * dn1 - a2 * (n2 - r2 * dn2));
                let next = if (low..=high).contains(&newton) {
                    newton
                } else {
                    0.5 * (low + high)
                };
                let change = (next - pm).abs();
                pm = next;
                // With quadratic convergence, a change of 1e-8 leaves an error of 1e-13 at the largest curvature of the
                // flow function.
                if change <= 1e-8 * pm && next == newton {
                    break;
                }
            }
        }
        if !S::DIFFERENTIATED {
            return S::constant(pm);
        }
        // One Newton step in S from the constant P_m gives exact derivatives.
        let r1 = up.recip() * pm;
        let (n1, dn1) = self.flow_function(r1.value().min(1.0));
        let r2 = down * (1.0 / pm);
        let (n2, dn2) = self.flow_function(r2.value().min(1.0));
        let slope = a1 * dn1 - a2 * (n2 - r2.value() * dn2);
        if slope == 0.0 {
            return S::constant(pm);
        }
        let residual = first * up * r1.chain(n1, dn1) - second * r2.chain(n2, dn2) * pm;
        (residual - residual.value()) * (-1.0 / slope) + pm
    }
}

impl Air {
    /// P_m between two restrictions, with the flow function of ISO 6358 instead of the ideal nozzle:
    ///
    /// ```text
    /// N(r) = 1                                r <= b
    ///      = sqrt(1 - ((r - b)/(1 - b))^2)    r > b
    /// ```
    /// The balance is then a quadratic in P_m on each of four branches; the result is within 1 % of the exact pressure.
    fn elliptic_pressure(&self, first: f64, second: f64, pu: f64, pd: f64) -> f64 {
        let b = self.critical;
        let (q1, q2, width) = (first * first, second * second, (1.0 - b) * (1.0 - b));
        let mut pm = 0.5 * (pu + pd);
        for (first_choked, second_choked) in [(true, true), (false, true), (true, false), (false, false)] {
            // Balance of the squared flows, a P_m^2 - 2 h P_m - c = 0.
            let (mut a, mut h, mut c) = (0.0, 0.0, q1 * width * pu * pu);
            if !first_choked {
                a += q1;
                h += q1 * b * pu;
                c -= q1 * b * b * pu * pu;
            }
            a += q2 * width;
            if !second_choked {
                a -= q2 * b * b;
                h -= q2 * b * pd;
                c += q2 * pd * pd;
            }
            let root = (h * h + a * c).max(0.0).sqrt();
            pm = if h >= 0.0 { (h + root) / a } else { c / (root - h) };
            if first_choked == (pm <= b * pu) && second_choked == (pd <= b * pm) {
                break;
            }
        }
        pm.clamp(pd, pu)
    }

    /// Pressures between three restrictions in series, with areas C A in the direction of the flow.
    ///
    /// ```text
    /// A_1 P_u N(P_m/P_u) = A_2 P_m N(P_s/P_m) = A_3 P_s N(P_d/P_s)        P_d <= P_s <= P_m <= P_u
    /// ```
    ///
    /// The temperature is the same in all three, because each restriction throttles. P_s follows from P_m as in
    /// [`Self::intermediate_pressure`]. The flow through the last two increases with P_m, so safeguarded Newton
    /// iteration for P_m cannot fail.
    pub(crate) fn two_intermediate_pressures<S: Real>(&self, areas: [S; 3], up: S, down: S) -> [S; 2] {
        let [first, second, third] = areas;
        let (pu, pd, a1) = (up.value(), down.value(), first.value());
        let residual = |pm: f64| {
            let pm = Dual {
                value: pm,
                slope: [1.0],
            };
            let [a2, a3, pd] = [second.value(), third.value(), pd].map(Dual::constant);
            let before = (pm * (1.0 / pu)).value.min(1.0);
            let (n, dn) = self.flow_function(before);
            (pm * (1.0 / pu)).chain(n, dn) * (a1 * pu)
                - self.passed(a2, pm, self.intermediate_pressure(a2, a3, pm, pd, None))
        };
        let (mut low, mut high) = (pd, pu);
        // For incompressible flow, the pressure drops by 1/A^2 at each restriction.
        let drop = |a: S| (a.value() * a.value()).recip();
        let all = drop(first) + drop(second) + drop(third);
        let mut pm = pu - (pu - pd) * drop(first) / all;
        let mut slope = residual(pm).slope[0];
        for _ in 0..80 {
            let found = residual(pm);
            slope = found.slope[0];
            if found.value > 0.0 {
                low = pm;
            } else {
                high = pm;
            }
            let newton = pm - found.value / slope;
            let next = if (low..=high).contains(&newton) {
                newton
            } else {
                0.5 * (low + high)
            };
            let change = (next - pm).abs();
            pm = next;
            if change <= 1e-12 * pm {
                break;
            }
        }
        if slope == 0.0 {
            let pm = S::constant(pm);
            return [pm, self.intermediate_pressure(second, third, pm, down, None)];
        }
        // The implicit function theorem, as for one pressure.
        let fixed = S::constant(pm);
        let before = up.recip() * pm;
        let (n, dn) = self.flow_function(before.value().min(1.0));
        let behind = self.intermediate_pressure(second, third, fixed, down, None);
        let found = first * up * before.chain(n, dn) - self.passed(second, fixed, behind);
        let plenum = (found - found.value()) * (-1.0 / slope) + pm;
        [plenum, self.intermediate_pressure(second, third, plenum, down, None)]
    }

    /// A P_u N(P_d/P_u).
    fn passed<S: Real>(&self, area: S, up: S, down: S) -> S {
        let r = down * up.recip();
        let (n, dn) = self.flow_function(r.value().min(1.0));
        area * up * r.chain(n, dn)
    }
}

/// State of a flowing gas.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gas<S> {
    /// P \[Pa\].
    pub(crate) pressure: S,
    /// T \[K\].
    pub(crate) temperature: S,
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test may panic
mod tests {
    use super::*;

    fn air() -> Air {
        Air::new(287.05, 1.4, 1e-3)
    }

    #[test]
    fn flow_function_is_continuous_and_choked_below_the_critical_ratio() {
        let air = air();
        assert!((air.critical - 0.5283).abs() < 1e-4);
        for r in [air.critical, 1.0 - 1e-3, 1.0] {
            let step = air.flow_function(r - 1e-12).0 - air.flow_function((r + 1e-12).min(1.0)).0;
            assert!(step.abs() < 1e-9, "{r} {step}");
        }
        assert_eq!(air.flow_function(0.2).0, 1.0);
        assert_eq!(air.flow_function(1.0).0, 0.0);
    }

    #[test]
    fn flow_function_derivative_equals_a_difference() {
        let air = air();
        for r in [0.6, 0.8, 0.95, 0.998, 0.9995] {
            let h = 1e-7;
            let slope = (air.flow_function(r + h).0 - air.flow_function(r - h).0) / (2.0 * h);
            assert!((air.flow_function(r).1 / slope - 1.0).abs() < 1e-6, "{r}");
        }
    }

    #[test]
    fn series_restriction_equals_bisection() {
        let air = air();
        let pd = 101_325.0;
        for ratio in [1.0002, 1.005, 1.1, 1.5, 1.9, 3.0, 7.5] {
            for a1 in [1e-7, 3e-5, 1e-4, 1.4e-4, 5e-4] {
                let (pu, a2) = (ratio * pd, 1.4e-4);
                let g = |pm: f64| a1 * pu * air.flow_function(pm / pu).0 - a2 * pm * air.flow_function(pd / pm).0;
                let (mut low, mut high) = (pd, pu);
                for _ in 0..200 {
                    let mid = 0.5 * (low + high);
                    if g(mid) > 0.0 { low = mid } else { high = mid }
                }
                let pm = air.intermediate_pressure(a1, a2, pu, pd, None);
                assert!((pm - low).abs() < 1e-7 * low, "{ratio} {a1}: {pm} {low}");
            }
        }
    }

    #[test]
    fn three_restrictions_pass_one_flow() {
        let air = air();
        let pd = 101_325.0;
        for ratio in [1.0002, 1.01, 1.5, 2.5, 7.5] {
            for areas in [
                [1e-4, 1.4e-4, 1.5e-4],
                [5e-4, 1.4e-4, 3e-5],
                [2e-6, 1.4e-4, 6e-4],
                [4e-4, 1e-5, 1e-3],
            ] {
                let pu = ratio * pd;
                let [pm, ps] = air.two_intermediate_pressures(areas, pu, pd);
                let flows =
                    [(areas[0], pu, pm), (areas[1], pm, ps), (areas[2], ps, pd)].map(|(a, u, d)| air.passed(a, u, d));
                assert!(pd <= ps && ps <= pm && pm <= pu, "{pu} {pm} {ps}");
                assert!((flows[1] / flows[0] - 1.0).abs() < 1e-9, "{ratio} {areas:?}: {flows:?}");
                // The inner solution is that of two restrictions, with its own tolerance if the pressure drop is small.
                assert!((flows[2] / flows[0] - 1.0).abs() < 1e-5, "{ratio} {areas:?}: {flows:?}");
            }
        }
        // A wide muffler has no effect.
        let [pm, ps] = air.two_intermediate_pressures([1e-4, 1.4e-4, 10.0], 3e5, pd);
        assert!((pm / air.intermediate_pressure(1e-4, 1.4e-4, 3e5, pd, None) - 1.0).abs() < 1e-6);
        assert!((ps / pd - 1.0).abs() < 1e-6);
    }

    #[test]
    fn three_restrictions_have_exact_derivatives() {
        let air = air();
        let solve = |a1: f64, pu: f64| air.two_intermediate_pressures([a1, 1.4e-4, 1.6e-4], pu, 101_325.0);
        for (a1, pu) in [(1e-4, 3e5), (4e-4, 1.3e5), (2e-5, 6e5)] {
            let along = |value: f64, slope: [f64; 2]| Dual { value, slope };
            let [holes, muffler, ambient] = [1.4e-4, 1.6e-4, 101_325.0].map(Dual::constant);
            let dual =
                air.two_intermediate_pressures([along(a1, [1.0, 0.0]), holes, muffler], along(pu, [0.0, 1.0]), ambient);
            let (ha, hp) = (1e-5 * a1, 1e-5 * pu);
            for (i, dual) in dual.iter().enumerate() {
                let da = (solve(a1 + ha, pu)[i] - solve(a1 - ha, pu)[i]) / (2.0 * ha);
                let dp = (solve(a1, pu + hp)[i] - solve(a1, pu - hp)[i]) / (2.0 * hp);
                for (slope, difference) in dual.slope.into_iter().zip([da, dp]) {
                    assert!((slope / difference - 1.0).abs() < 1e-4, "{i} {slope} {difference}");
                }
            }
        }
    }

    #[test]
    fn series_restriction_has_exact_derivatives() {
        let air = air();
        let solve = |a1: f64, pu: f64| air.intermediate_pressure(a1, 1.4e-4, pu, 101_325.0, None);
        for (a1, pu) in [(1e-4, 3e5), (4e-4, 1.3e5), (2e-5, 6e5)] {
            let dual = air.intermediate_pressure(
                Dual {
                    value: a1,
                    slope: [1.0, 0.0],
                },
                Dual::constant(1.4e-4),
                Dual {
                    value: pu,
                    slope: [0.0, 1.0],
                },
                Dual::constant(101_325.0),
                None,
            );
            let (ha, hp) = (1e-5 * a1, 1e-5 * pu);
            let da = (solve(a1 + ha, pu) - solve(a1 - ha, pu)) / (2.0 * ha);
            let dp = (solve(a1, pu + hp) - solve(a1, pu - hp)) / (2.0 * hp);
            assert!((dual.slope[0] / da - 1.0).abs() < 1e-5, "{} {da}", dual.slope[0]);
            assert!((dual.slope[1] / dp - 1.0).abs() < 1e-5, "{} {dp}", dual.slope[1]);
        }
    }
}
