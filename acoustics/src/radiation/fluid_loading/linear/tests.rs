#![allow(clippy::unwrap_used)]

use super::{FrozenModes, ImpedanceCorrection, impedance_correction};
use crate::radiation::fluid_loading::{DryModes, FluidLoadingError, Impedance, WetModes};
use crate::signals::fourier::RealTransform;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::{PI, TAU};

const STEP: f64 = 1e-5;
const SAMPLES: usize = 20_000;

/// A dense Z(s), and the highest frequency at which it is taken as known.
struct Closed<F>(usize, f64, F);

impl<F: Fn(Complex<f64>) -> DMatrix<Complex<f64>> + Sync> Impedance for Closed<F> {
    fn modes(&self) -> usize {
        self.0
    }

    fn top_hz(&self) -> f64 {
        self.1
    }

    fn product(&self, hz: &[f64], velocities: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut force = velocities.clone();
        for (column, hz) in hz.iter().enumerate() {
            let z = (self.2)(Complex::new(0.0, TAU * hz));
            force.set_column(column, &(z * velocities.column(column)));
        }
        force
    }
}

/// A structure in fluid with a spherical source in each mode: Z = B s tau/(1 + s tau).
///
/// With r' = (v - r)/tau, the pressure force is B (v - r), so the motion follows from one additional state per mode.
struct Spheres {
    omega: Vec<f64>,
    zeta: f64,
    /// B \[1/s\].
    limit: DMatrix<f64>,
    /// a/c \[s\].
    tau: f64,
    /// Support of all modes with equal amplitude: k, c.
    support: [f64; 2],
}

impl Spheres {
    fn count(&self) -> usize {
        self.omega.len()
    }

    fn impedance(&self) -> Closed<impl Fn(Complex<f64>) -> DMatrix<Complex<f64>> + Sync + '_> {
        Closed(self.count(), 12_000.0, |s: Complex<f64>| {
            let x = s * self.tau;
            self.limit.map(|b| x / (x + 1.0) * b)
        })
    }

    fn dry(&self) -> DryModes {
        DryModes::new(self.omega.clone(), vec![self.zeta; self.count()]).unwrap()
    }

    fn wet(&self) -> WetModes {
        let z = |w: f64| (self.impedance().2)(Complex::new(0.0, w));
        let mass = |column: usize, w: f64| z(w).column(column).map(|z| z.im / w);
        WetModes::new(&self.dry(), 1.0, mass, |w, v| v.dot(&(z(w).map(|z| z.re) * v))).unwrap()
    }

    fn frozen(&self, wet: &WetModes) -> FrozenModes {
        let n = self.count();
        let damping = |k: usize| 2.0 * (wet.of_structure[k] + wet.of_radiation[k]) * wet.omega[k];
        FrozenModes {
            omega: wet.omega.clone(),
            damping: (0..n).map(damping).collect(),
            numerical_damping: vec![0.0; n],
            coordinates: wet.shapes.clone(),
            structure: self.omega.iter().map(|w| 2.0 * self.zeta * w).collect(),
            mass: wet.mass.clone(),
            supports: wet.shapes.tr_mul(&DMatrix::from_element(n, 1, 1.0)),
            stiffness: vec![self.support[0]],
            dashpots: vec![self.support[1]],
        }
    }

    /// Displacements and velocities of the modes in vacuum for the same force on each, samples x modes.
    fn exact(&self, force: &[f64]) -> [DMatrix<f64>; 2] {
        let n = self.count();
        let mut a = DMatrix::zeros(3 * n, 3 * n);
        for i in 0..n {
            a[(i, n + i)] = 1.0;
            a[(n + i, i)] -= self.omega[i].powi(2);
            a[(n + i, n + i)] -= 2.0 * self.zeta * self.omega[i];
            a[(2 * n + i, n + i)] = 1.0 / self.tau;
            a[(2 * n + i, 2 * n + i)] = -1.0 / self.tau;
            for j in 0..n {
                a[(n + i, j)] -= self.support[0];
                a[(n + i, n + j)] -= self.support[1] + self.limit[(i, j)];
                a[(n + i, 2 * n + j)] += self.limit[(i, j)];
            }
        }
        let by_force = DVector::from_fn(3 * n, |i, _| if (n..2 * n).contains(&i) { 1.0 } else { 0.0 });
        march(&a, &by_force, force, n)
    }

    /// The same with frozen impedance, in its coordinates.
    fn with_frozen(&self, wet: &WetModes, force: &[f64]) -> [DMatrix<f64>; 2] {
        let (n, frozen) = (self.count(), self.frozen(wet));
        let p = frozen.supports.column(0);
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        for i in 0..n {
            a[(i, n + i)] = 1.0;
            a[(n + i, i)] -= frozen.omega[i].powi(2);
            a[(n + i, n + i)] -= frozen.damping[i];
            for j in 0..n {
                a[(n + i, j)] -= self.support[0] * p[i] * p[j];
                a[(n + i, n + j)] -= self.support[1] * p[i] * p[j];
            }
        }
        let by_force = DVector::from_fn(2 * n, |i, _| if i < n { 0.0 } else { p[i - n] });
        march(&a, &by_force, force, n)
    }

    /// Displacement and velocity from the correction, and the correction itself.
    fn corrected(&self, force: &[f64]) -> ([DMatrix<f64>; 2], DMatrix<f64>, ImpedanceCorrection) {
        let wet = self.wet();
        let [u, v] = self.with_frozen(&wet, force);
        let found = impedance_correction(&self.frozen(&wet), &self.impedance(), (SAMPLES, STEP), |range| {
            Ok::<_, FluidLoadingError>(u.columns(range.start, range.len()).into_owned())
        })
        .unwrap();
        let added = |power: i32| {
            let n = self.count();
            let records = (0..n).flat_map(|row| {
                let lines =
                    (0..found.transform.bins()).map(|k| found.motion[(row, k)] * found.transform.s(k).powi(power));
                found.transform.record(&lines.collect::<Vec<_>>())
            });
            DMatrix::from_iterator(SAMPLES, n, records)
        };
        let both = [&u + added(0), &v + added(1)].map(|own| own * wet.shapes.transpose());
        (both, u * wet.shapes.transpose(), found)
    }
}

/// x' = A x + b f with f constant over each step, from rest; returns the first `count` states and the next `count`.
fn march(a: &DMatrix<f64>, b: &DVector<f64>, force: &[f64], count: usize) -> [DMatrix<f64>; 2] {
    let n = a.nrows();
    let mut joined = DMatrix::zeros(n + 1, n + 1);
    joined.view_mut((0, 0), (n, n)).copy_from(&(a * STEP));
    joined.view_mut((0, n), (n, 1)).copy_from(&(b * STEP));
    let over = joined.exp();
    let (own, by_force) = (
        over.view((0, 0), (n, n)).into_owned(),
        over.view((0, n), (n, 1)).into_owned(),
    );
    let mut x = DVector::zeros(n);
    let [mut q, mut v] = [DMatrix::zeros(SAMPLES, count), DMatrix::zeros(SAMPLES, count)];
    for sample in 0..SAMPLES {
        for i in 0..count {
            q[(sample, i)] = x[i];
            v[(sample, i)] = x[count + i];
        }
        x = &own * x + by_force.column(0) * force[sample];
    }
    [q, v]
}

/// Largest difference, relative to the largest value.
fn off(found: &DMatrix<f64>, exact: &DMatrix<f64>) -> f64 {
    (found - exact).amax() / exact.amax()
}

fn step_force() -> Vec<f64> {
    vec![1.0; SAMPLES]
}

fn sphere() -> Spheres {
    Spheres {
        omega: vec![TAU * 200.0],
        zeta: 0.002,
        limit: DMatrix::from_element(1, 1, 300.0),
        tau: 3e-4,
        support: [0.0; 2],
    }
}

#[test]
fn a_pulsating_sphere_on_a_spring_moves_as_its_exact_equation_says() {
    let sphere = sphere();
    let exact = sphere.exact(&step_force());
    let (found, frozen, correction) = sphere.corrected(&step_force());
    let (before, after) = (off(&frozen, &exact[0]), off(&found[0], &exact[0]));
    assert!(after < 1e-4, "{after:.1e}, frozen {before:.1e}");
    assert!(before > 3e-3, "frozen {before:.1e}");
    assert!(correction.residual < 1e-7, "{:e}", correction.residual);
}

#[test]
fn a_free_sphere_on_a_support_with_a_dashpot_moves_as_its_exact_equation_says() {
    let sphere = Spheres {
        omega: vec![0.0],
        support: [(TAU * 150.0_f64).powi(2), 20.0],
        ..sphere()
    };
    let exact = sphere.exact(&step_force());
    let (found, frozen, _) = sphere.corrected(&step_force());
    let (before, after) = (off(&frozen, &exact[0]), off(&found[0], &exact[0]));
    assert!(after < 1e-4 && before > 0.01, "{after:.1e}, frozen {before:.1e}");
}

#[test]
fn a_free_sphere_that_a_force_sets_in_flight_is_no_exception() {
    let sphere = Spheres {
        omega: vec![0.0],
        ..sphere()
    };
    let exact = sphere.exact(&step_force());
    let (found, frozen, _) = sphere.corrected(&step_force());
    let (before, after) = (off(&frozen, &exact[0]), off(&found[0], &exact[0]));
    assert!(
        after < 1e-4 && before > 10.0 * after,
        "{after:.1e}, frozen {before:.1e}"
    );
}

#[test]
fn close_modes_exchange_energy_through_the_resistance_between_them() {
    let spheres = Spheres {
        omega: vec![TAU * 200.0, TAU * 203.0],
        limit: DMatrix::from_row_slice(2, 2, &[300.0, 280.0, 280.0, 300.0]),
        ..sphere()
    };
    let exact = spheres.exact(&step_force());
    let (found, frozen, _) = spheres.corrected(&step_force());
    let (before, after) = (off(&frozen, &exact[0]), off(&found[0], &exact[0]));
    assert!(after < 1e-4 && before > 0.02, "{after:.1e}, frozen {before:.1e}");
}

#[test]
fn a_dense_fluid_heavier_than_the_structure_is_no_exception() {
    let spheres = Spheres {
        omega: vec![TAU * 200.0, TAU * 500.0, TAU * 520.0],
        limit: DMatrix::from_row_slice(3, 3, &[9e3, 4e3, -3e3, 4e3, 6e3, 2e3, -3e3, 2e3, 7e3]),
        ..sphere()
    };
    let exact = spheres.exact(&step_force());
    let (found, frozen, _) = spheres.corrected(&step_force());
    let (before, after) = (off(&frozen, &exact[0]), off(&found[0], &exact[0]));
    assert!(after < 3e-4 && before > 0.05, "{after:.1e}, frozen {before:.1e}");
}

#[test]
fn nothing_is_added_where_the_complete_impedance_is_the_frozen_one() {
    let mass = DMatrix::from_row_slice(2, 2, &[0.4, 0.1, 0.1, 0.3]);
    let impedance = Closed(2, 5000.0, |s: Complex<f64>| mass.map(|m| s * m));
    let dry = DryModes::new(vec![TAU * 200.0, TAU * 300.0], vec![0.0; 2]).unwrap();
    let wet = WetModes::new(&dry, 1.0, |i, _| mass.column(i).into_owned(), |_, _| 0.0).unwrap();
    let frozen = FrozenModes {
        omega: wet.omega.clone(),
        damping: vec![0.0; 2],
        numerical_damping: vec![0.0; 2],
        coordinates: wet.shapes,
        structure: vec![0.0; 2],
        mass: wet.mass,
        supports: DMatrix::zeros(2, 0),
        stiffness: Vec::new(),
        dashpots: Vec::new(),
    };
    let u = DMatrix::from_fn(SAMPLES, 2, |n, i| 1.0 - (wet.omega[i] * STEP * n as f64).cos());
    let found = impedance_correction(&frozen, &impedance, (SAMPLES, STEP), |range| {
        Ok::<_, FluidLoadingError>(u.columns(range.start, range.len()).into_owned())
    })
    .unwrap();
    for row in 0..2 {
        let lines: Vec<Complex<f64>> = found.motion.row(row).iter().copied().collect();
        let added = found.transform.record(&lines);
        assert!(added.iter().all(|d| d.abs() < 1e-9), "mode {row}");
    }
}

/// Once the motion has ended, the work of the force equals the losses in the structure and support plus the energy
/// radiated.
#[test]
fn what_the_force_does_is_dissipated_or_radiated() {
    let spheres = Spheres {
        omega: vec![TAU * 200.0, TAU * 215.0],
        zeta: 0.01,
        limit: DMatrix::from_row_slice(2, 2, &[600.0, 400.0, 400.0, 500.0]),
        support: [1e5, 15.0],
        ..sphere()
    };
    let pulse = |n: usize| {
        if n < 300 {
            (PI * n as f64 / 300.0).sin().powi(2)
        } else {
            0.0
        }
    };
    let force: Vec<f64> = (0..SAMPLES).map(pulse).collect();
    let ([_, v], ..) = spheres.corrected(&force);
    let work: f64 = (0..SAMPLES - 1)
        .map(|n| 0.5 * force[n] * (v.row(n).sum() + v.row(n + 1).sum()) * STEP)
        .sum();
    let rate = |of: &dyn Fn(usize) -> f64| (0..SAMPLES).map(of).sum::<f64>() * STEP;
    let structure = rate(&|n| {
        (0..2)
            .map(|i| 2.0 * spheres.zeta * spheres.omega[i] * v[(n, i)].powi(2))
            .sum()
    });
    let support = rate(&|n| spheres.support[1] * v.row(n).sum().powi(2));
    let fft = RealTransform::new(2 * SAMPLES);
    let lines: Vec<Vec<Complex<f64>>> = v
        .column_iter()
        .map(|v| fft.lines(&v.iter().copied().collect::<Vec<_>>()))
        .collect();
    let spacing = TAU / (2.0 * SAMPLES as f64 * STEP);
    let radiated: f64 = (1..SAMPLES)
        .map(|k| {
            let z = (spheres.impedance().2)(Complex::new(0.0, spacing * k as f64));
            let v = DVector::from_fn(2, |i, _| lines[i][k] * STEP);
            (v.adjoint() * z.map(|z| Complex::from(z.re)) * &v)[(0, 0)].re * spacing / PI
        })
        .sum();
    let left = (work - structure - support - radiated) / work;
    assert!(radiated > 0.2 * work && structure > 0.05 * work && support > 0.05 * work);
    assert!(left.abs() < 1e-3, "{left:.1e} of the work is missing");
}
