//! Exact recurrence of one mode under a piecewise-linear force.

/// Response of q'' + 2 zeta omega q' + omega^2 q = g(t) over one step h with linear g, exactly:
///
///   q1 = a11 q0 + a12 v0 + b1 g0 + c1 g1
///   v1 = a21 q0 + a22 v0 + b2 g0 + c2 g1
///
/// With the impulse response w(t) (w(0) = 0, w'(0) = 1), its integral I and its double integral J over the step, the
/// coefficients are
///
///   a12 = w, a22 = w', a21 = -omega^2 w, a11 = w' + 2 zeta omega w,
///   c1 = J/h, b1 = I - J/h, c2 = I/h, b2 = w - I/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recurrence {
    pub(super) a11: f64,
    pub(super) a12: f64,
    pub(super) a21: f64,
    pub(super) a22: f64,
    pub(super) b1: f64,
    pub(super) c1: f64,
    pub(super) b2: f64,
    pub(super) c2: f64,
}

impl Recurrence {
    pub(super) fn new(omega: f64, zeta: f64, h: f64) -> Self {
        let Impulse {
            w,
            slope,
            integral,
            double,
        } = Impulse::new(omega, zeta, h);
        Self {
            a11: slope + 2.0 * zeta * omega * w,
            a12: w,
            a21: -omega * omega * w,
            a22: slope,
            b1: integral - double / h,
            c1: double / h,
            b2: w - integral / h,
            c2: integral / h,
        }
    }
}

/// The impulse response at h: w, w', and its integral and double integral from 0 to h.
struct Impulse {
    w: f64,
    slope: f64,
    integral: f64,
    double: f64,
}

impl Impulse {
    fn new(omega: f64, zeta: f64, h: f64) -> Self {
        // Below this, the Taylor series converges in about twenty terms without cancellation in every regime; its first
        // term is the rigid mode.
        let fastest = omega * (zeta + (zeta * zeta - 1.0).max(0.0).sqrt()).max(1.0);
        if fastest * h < 1.0 {
            return Self::series(omega, zeta, h);
        }
        // (omega_d h)^2, negative if overdamped; near zero, both closed forms lose digits.
        let square = (1.0 - zeta) * (1.0 + zeta) * (omega * h).powi(2);
        if square < -0.25 {
            Self::overdamped(omega, zeta, h)
        } else {
            Self::oscillating(omega, zeta, h, square)
        }
    }

    /// w = sum_k e_k h^(k+1)/(k+1)!,  e_0 = 1, e_1 = -2 zeta omega, e_k = -2 zeta omega e_(k-1) - omega^2 e_(k-2)
    fn series(omega: f64, zeta: f64, h: f64) -> Self {
        let (damping, stiffness) = (2.0 * zeta * omega * h, (omega * h).powi(2));
        let (mut before, mut e) = (0.0, 1.0);
        let (mut w, mut slope, mut integral, mut double) = (0.0, 0.0, 0.0, 0.0);
        // 1/k!, with e_k h^k in e.
        let mut inverse_factorial = 1.0;
        for k in 0..60 {
            let k = f64::from(k);
            slope += e * inverse_factorial;
            let next = inverse_factorial / (k + 1.0);
            w += e * next;
            integral += e * next / (k + 2.0);
            let term = e * next / ((k + 2.0) * (k + 3.0));
            double += term;
            (before, e) = (e, -damping * e - stiffness * before);
            inverse_factorial = next;
            if (e.abs() + before.abs()) * next < 1e-18 * slope.abs().min(1.0) {
                break;
            }
        }
        Self {
            w: w * h,
            slope,
            integral: integral * h * h,
            double: double * h * h * h,
        }
    }

    /// Underdamped, critical and slightly overdamped, with x = (omega_d h)^2:
    ///
    ///   w = h e^(-zeta omega h) S(x),  w' = e^(-zeta omega h) (C(x) - zeta omega h S(x)),
    ///   C = cos sqrt x, S = sin(sqrt x)/sqrt x  (cosh, sinh for x < 0)
    ///   I = (1 - w' - 2 zeta omega w)/omega^2,  J = (h - w - 2 zeta omega I)/omega^2
    fn oscillating(omega: f64, zeta: f64, h: f64, x: f64) -> Self {
        let (c, s) = if x.abs() < 0.25 {
            // C = sum (-x)^k/(2k)!, S = sum (-x)^k/(2k+1)!
            let (mut c, mut s, mut term) = (0.0, 0.0, 1.0);
            for k in 0..12 {
                let k = f64::from(k);
                c += term;
                s += term / (2.0 * k + 1.0);
                term *= -x / ((2.0 * k + 1.0) * (2.0 * k + 2.0));
            }
            (c, s)
        } else {
            let root = x.sqrt();
            (root.cos(), root.sin() / root)
        };
        let decay = (-zeta * omega * h).exp();
        let w = h * decay * s;
        let slope = decay * (c - zeta * omega * h * s);
        let integral = (1.0 - slope - 2.0 * zeta * omega * w) / (omega * omega);
        let double = (h - w - 2.0 * zeta * omega * integral) / (omega * omega);
        Self {
            w,
            slope,
            integral,
            double,
        }
    }

    /// Overdamped with the roots l1 > l2 (both negative), phi_1(z) = (e^z - 1)/z, phi_2(z) = (phi_1(z) - 1)/z:
    ///
    ///   w = (e^(l1 h) - e^(l2 h))/(l1 - l2),  I = h (phi_1(l1 h) - phi_1(l2 h))/(l1 - l2),
    ///   J = h^2 (phi_2(l1 h) - phi_2(l2 h))/(l1 - l2)
    fn overdamped(omega: f64, zeta: f64, h: f64) -> Self {
        let root = ((zeta - 1.0) * (zeta + 1.0)).sqrt();
        let l2 = -omega * (zeta + root);
        let l1 = -omega / (zeta + root);
        let difference = l1 - l2;
        let (e1, e2) = ((l1 * h).exp(), (l2 * h).exp());
        Self {
            w: (e1 - e2) / difference,
            slope: (l1 * e1 - l2 * e2) / difference,
            integral: h * (phi_1(l1 * h) - phi_1(l2 * h)) / difference,
            double: h * h * (phi_2(l1 * h) - phi_2(l2 * h)) / difference,
        }
    }
}

fn phi_1(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { z.exp_m1() / z }
}

fn phi_2(z: f64) -> f64 {
    if z.abs() > 1.0 {
        return (phi_1(z) - 1.0) / z;
    }
    // sum_k z^k/(k+2)!
    let (mut sum, mut term) = (0.0, 0.5);
    for k in 0..20 {
        sum += term;
        term *= z / f64::from(k + 3);
    }
    sum
}

/// Dissipation of one mode over a step as a quadratic form in its initial state and load,
///
///   2 zeta omega int_0^h q'^2 dt = x^T D x,   x = (q0, v0, g0, g1),
///
/// exact to rounding. The recurrence for partial steps gives q' at the points of a Gauss rule as linear forms in x.
/// Stored as the ten entries 11 12 13 14 22 23 24 33 34 44, with the off-diagonal ones doubled.
pub(super) fn dissipation(omega: f64, zeta: f64, h: f64, rule: &(Vec<f64>, Vec<f64>)) -> [f64; 10] {
    let mut form = [0.0; 10];
    if omega == 0.0 || zeta == 0.0 {
        return form;
    }
    let fastest = omega * (zeta + (zeta * zeta - 1.0).max(0.0).sqrt()).max(1.0);
    let panels = (0.5 * fastest * h).ceil().clamp(1.0, 64.0) as usize;
    let width = h / panels as f64;
    for panel in 0..panels {
        for (x, weight) in rule.0.iter().zip(&rule.1) {
            let t = width * (panel as f64 + 0.5 * (1.0 + x));
            let r = Recurrence::new(omega, zeta, t);
            let s = t / h;
            let v = [r.a21, r.a22, r.b2 + r.c2 * (1.0 - s), r.c2 * s];
            let factor = 2.0 * zeta * omega * 0.5 * width * weight;
            let mut entry = 0;
            for i in 0..4 {
                for j in i..4 {
                    form[entry] += factor * v[i] * v[j] * if i == j { 1.0 } else { 2.0 };
                    entry += 1;
                }
            }
        }
    }
    form
}

#[cfg(test)]
mod tests {
    use super::*;
    use nailnoise_meshes::gauss_legendre;

    /// The same from series over composed sub-steps, independent of the closed forms.
    fn composed(omega: f64, zeta: f64, h: f64) -> Recurrence {
        let parts = 4096;
        let small = Recurrence::new(omega, zeta, h / parts as f64);
        let mut r = Recurrence {
            a11: 1.0,
            a12: 0.0,
            a21: 0.0,
            a22: 1.0,
            b1: 0.0,
            c1: 0.0,
            b2: 0.0,
            c2: 0.0,
        };
        for n in 0..parts {
            let (s0, s1) = (n as f64 / parts as f64, (n + 1) as f64 / parts as f64);
            let next = |q: f64, v: f64, g0: f64, g1: f64| {
                (
                    small.a11 * q + small.a12 * v + small.b1 * g0 + small.c1 * g1,
                    small.a21 * q + small.a22 * v + small.b2 * g0 + small.c2 * g1,
                )
            };
            (r.a11, r.a21) = next(r.a11, r.a21, 0.0, 0.0);
            (r.a12, r.a22) = next(r.a12, r.a22, 0.0, 0.0);
            (r.b1, r.b2) = next(r.b1, r.b2, 1.0 - s0, 1.0 - s1);
            (r.c1, r.c2) = next(r.c1, r.c2, s0, s1);
        }
        r
    }

    fn distance(a: Recurrence, b: Recurrence, omega: f64, h: f64) -> f64 {
        // Each coefficient has its own scale.
        [
            (a.a11 - b.a11),
            (a.a12 - b.a12) / h,
            (a.a21 - b.a21) / omega.max(1.0 / h).powi(2) / h,
            (a.a22 - b.a22),
            (a.b1 - b.b1) / (b.b1.abs() + b.c1.abs()),
            (a.c1 - b.c1) / (b.b1.abs() + b.c1.abs()),
            (a.b2 - b.b2) / (b.b2.abs() + b.c2.abs()),
            (a.c2 - b.c2) / (b.b2.abs() + b.c2.abs()),
        ]
        .iter()
        .fold(0.0, |m: f64, e| m.max(e.abs()))
    }

    #[test]
    fn closed_forms_agree_with_composed_series_in_every_regime() {
        let h = 1e-3;
        for omega_h in [0.0, 1e-9, 1e-4, 0.03, 0.5, 0.99, 1.01, 3.0, 9.0] {
            for zeta in [0.0, 0.01, 0.7, 0.999_999, 1.0, 1.000_001, 1.02, 1.5, 4.0, 40.0] {
                let (exact, parts) = (Recurrence::new(omega_h / h, zeta, h), composed(omega_h / h, zeta, h));
                let error = distance(exact, parts, omega_h / h, h);
                assert!(
                    error < 2e-11,
                    "omega h {omega_h}, zeta {zeta}: {error:e} {exact:?} {parts:?}"
                );
            }
        }
    }

    #[test]
    fn a_rigid_mode_integrates_its_force_twice() {
        let h = 4e-6;
        let r = Recurrence::new(0.0, 0.3, h);
        let expected = Recurrence {
            a11: 1.0,
            a12: h,
            a21: 0.0,
            a22: 1.0,
            b1: h * h / 3.0,
            c1: h * h / 6.0,
            b2: h / 2.0,
            c2: h / 2.0,
        };
        assert!(distance(r, expected, 0.0, h) < 4.0 * f64::EPSILON, "{r:?}");
        assert_eq!(r.a21, 0.0);
    }

    #[test]
    fn dissipation_closes_the_energy_balance_of_one_step() {
        let rule = gauss_legendre(10).into_iter().unzip();
        let h = 1e-3;
        for omega_h in [0.01, 0.3, 1.0, 2.5, 6.0] {
            for zeta in [0.005, 0.2, 1.0, 3.0] {
                let omega: f64 = omega_h / h;
                let (q0, v0, g0, g1) = (1e-3, -2e-3 * omega, 3e-4 * omega * omega, -5e-4 * omega * omega);
                let r = Recurrence::new(omega, zeta, h);
                let q1 = r.a11 * q0 + r.a12 * v0 + r.b1 * g0 + r.c1 * g1;
                let v1 = r.a21 * q0 + r.a22 * v0 + r.b2 * g0 + r.c2 * g1;
                let energy = |q: f64, v: f64| 0.5 * (v * v + omega * omega * q * q);
                // int q dt from the equation of motion: omega^2 int q = int g - change of v - 2 zeta omega change of q.
                let mean = (0.5 * h * (g0 + g1) - (v1 - v0) - 2.0 * zeta * omega * (q1 - q0)) / (omega * omega);
                let work = g1 * q1 - g0 * q0 - (g1 - g0) / h * mean;
                let d = dissipation(omega, zeta, h, &rule);
                let x = [q0, v0, g0, g1];
                let mut lost = 0.0;
                let mut entry = 0;
                for i in 0..4 {
                    for j in i..4 {
                        lost += d[entry] * x[i] * x[j];
                        entry += 1;
                    }
                }
                let residual = work - (energy(q1, v1) - energy(q0, v0)) - lost;
                let scale = energy(q0, v0) + work.abs();
                assert!(
                    residual.abs() < 1e-11 * scale / omega_h.min(1.0),
                    "{omega_h} {zeta}: {:e}",
                    residual / scale
                );
                assert!(lost > 0.0);
            }
        }
    }
}
