//! Added mass and wet frequencies of thin plates, against closed forms and published and independently computed values.

use crate::boundary_meshes::{even, graded, quarter_disk, rectangle};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Parity, Patterns, Plate, WetSides};
use nailnoise_acoustics::radiation::fluid_loading::{DryModes, ImpedanceTable, WetModes, resonances};
use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};
use std::f64::consts::{PI, TAU};

const WATER: f64 = 1000.0;

fn water() -> Air {
    Air {
        density: WATER,
        sound_speed: 1480.0,
        ..Air::default()
    }
}

/// A plate in water with normal velocities that are functions of x and y.
fn plate(
    mesh: BoundaryMesh,
    mirrors: [Option<f64>; 2],
    wetted: WetSides,
    shapes: &[Box<dyn Fn(f64, f64) -> f64>],
) -> (Plate, Patterns) {
    let midplane = Boundary::flat(mesh, mirrors).unwrap();
    let velocities = midplane.project(shapes.len(), |_, _, point, values| {
        let at = point.position;
        values
            .iter_mut()
            .zip(shapes)
            .for_each(|(value, shape)| *value = shape(at.x, at.y));
    });
    let patterns = Patterns {
        parity: Parity::default(),
        velocities,
    };
    (Plate::new(midplane, &water(), wetted), patterns)
}

/// X/omega at a frequency so low that the fluid is incompressible.
fn added_mass((plate, patterns): &(Plate, Patterns)) -> DMatrix<f64> {
    let hz = 1.0;
    plate.impedance(hz, patterns).unwrap().map(|z| z.im / (TAU * hz))
}

/// 8/3 rho a³ (Lamb 1932, section 102).
#[test]
fn a_rigid_disk_in_free_fluid_carries_the_mass_of_lamb() {
    let errors = [2, 3, 6].map(|n| {
        let mesh = quarter_disk(n, |s| (0.5 * PI * s).sin());
        let disk = plate(mesh, [Some(0.0); 2], WetSides::Both, &[Box::new(|_, _| 1.0)]);
        added_mass(&disk)[(0, 0)] / (8.0 / 3.0 * WATER) - 1.0
    });
    println!("{errors:?}");
    assert!(errors[2].abs() < 1e-3, "{errors:?}");
    // Panels that become narrow as the square of the distance from the edge restore the second order.
    let order = (errors[0] / errors[1]).ln() / 1.5f64.ln();
    assert!((1.7..3.0).contains(&order), "order {order}: {errors:?}");
}

/// M_a/M = 0.668936 rho a/(rho_s h) for the clamped disk in a baffle (Lamb 1920: 0.6689), radiation 1/2 rho c k² V².
#[test]
fn a_clamped_disk_in_a_baffle() {
    let errors = [3, 6].map(|n| {
        let mesh = quarter_disk(n, |s| s);
        let disk = plate(
            mesh,
            [Some(0.0); 2],
            WetSides::OneInBaffle,
            &[Box::new(|x, y| (1.0 - x * x - y * y).powi(2))],
        );
        let of_plate = PI / 5.0;
        let hz = 5.0;
        let k = TAU * hz / 1480.0;
        let z = disk.0.impedance(hz, &disk.1).unwrap()[(0, 0)];
        let flow = PI / 3.0;
        // R = rho c k² Q² / (2 pi) of a small piston with the volume flow Q.
        let radiation = z.re / (WATER * 1480.0 * k * k * flow * flow / TAU) - 1.0;
        assert!(radiation.abs() < 5e-3, "{radiation}");
        added_mass(&disk)[(0, 0)] / (0.668_936 * WATER * of_plate) - 1.0
    });
    println!("{errors:?}");
    assert!(errors[1].abs() < 1e-3, "{errors:?}");
    assert!(errors[1].abs() < 0.35 * errors[0].abs(), "{errors:?}");
}

/// Coefficients m/(rho pi b² L/4) of a rectangle L x b in broadside motion, to 3e-4 by a spectral method; .579, .757
/// and .830 in DNV-RP-C205. Panels much longer than wide lose some per cent.
#[test]
fn rigid_rectangles_in_broadside_motion() {
    for (ratio, coefficient) in [(1.0, 0.5804), (2.0, 0.7583), (3.0, 0.8333)] {
        let mesh = rectangle(&graded(ratio, 12), &graded(1.0, 8));
        let moving = plate(mesh, [None; 2], WetSides::Both, &[Box::new(|_, _| 1.0)]);
        let error = added_mass(&moving)[(0, 0)] / (WATER * PI * ratio / 4.0) / coefficient - 1.0;
        println!("{ratio}: {error:.4}");
        assert!(error.abs() < 0.01, "{ratio}: {error}");
    }
}

/// 1 x 0.8 m, 10 mm of steel, simply supported in a baffle, mode (1,1): 63.001 Hz dry, M_a/M = 4.651059, 26.508 Hz and
/// a damping ratio of 0.01061 in water.
#[test]
fn a_simply_supported_plate_in_a_baffle() {
    let [a, b, h]: [f64; 3] = [1.0, 0.8, 0.01];
    let surface_mass = 7850.0 * h;
    let stiffness = 210e9 * h * h * h / (12.0 * (1.0 - 0.3 * 0.3));
    let omega = PI * PI * (1.0 / (a * a) + 1.0 / (b * b)) * (stiffness / surface_mass).sqrt();
    assert!((omega / TAU - 63.001).abs() < 5e-3, "{}", omega / TAU);
    let amplitude = (surface_mass * a * b / 4.0).sqrt().recip();
    let moving = plate(
        rectangle(&even(a, 10), &even(b, 10)),
        [None; 2],
        WetSides::OneInBaffle,
        &[Box::new(move |x, y| {
            amplitude * (PI * x / a).sin() * (PI * y / b).sin()
        })],
    );
    let mass = added_mass(&moving)[(0, 0)];
    let table = ImpedanceTable::new([10.0, 100.0], 6, |hz| moving.0.impedance(hz, &moving.1)).unwrap();
    let modes = DryModes::new(vec![omega], vec![0.0]).unwrap();
    let wet = resonances(&modes, f64::INFINITY, |omega| table.at(omega)).unwrap()[0]
        .clone()
        .unwrap();
    println!("M_a/M {mass:.6}, {:.3} Hz, zeta {:.5}", wet.hz(), wet.zeta());
    assert!((mass / 4.651_059 - 1.0).abs() < 2e-3, "{mass}");
    assert!((wet.hz() / 26.508 - 1.0).abs() < 2e-3, "{}", wet.hz());
    assert!((wet.zeta() / 0.01061 - 1.0).abs() < 0.01, "{}", wet.zeta());
}

/// Sheets in air in a baffle, both sides wet, mode (1,1): shift of the frequency, damping ratio by radiation, and level
/// 10 lg[zeta/(zeta + zeta_r)] at resonance. Between them the wall of a housing of 0.8 mm steel.
#[test]
fn sheets_in_air() {
    for ([a, b], mass, hz, zeta, [shift, of_radiation, level]) in [
        ([0.4, 0.3], 7850.0 * 1e-3, 42.7, 0.005, [-0.021, 0.0015, -1.1]),
        ([0.4, 0.3], 7850.0 * 0.5e-3, 21.35, 0.005, [-0.041, 0.0015, -1.1]),
        ([0.4, 0.3], 7850.0 * 0.8e-3, 34.16, 0.005, [-0.026, 0.0015, -1.1]),
        ([0.4, 0.3], 2700.0 * 1e-3, 42.0, 0.005, [-0.057, 0.0043, -2.7]),
        ([0.2, 0.1], 1740.0 * 3e-3, 905.0, 0.0075, [-0.009, 0.0062, -2.6]),
    ] {
        let amplitude = (mass * a * b / 4.0f64).sqrt().recip();
        let midplane = Boundary::flat(rectangle(&even(a, 6), &even(b, 6)), [None; 2]).unwrap();
        let patterns = Patterns {
            parity: Parity::default(),
            velocities: midplane.project(1, |_, _, point, v| {
                v[0] = amplitude * (PI * point.position.x / a).sin() * (PI * point.position.y / b).sin();
            }),
        };
        let sheet = Plate::new(midplane, &Air::default(), WetSides::OneInBaffle);
        let both = |hz: f64| sheet.impedance(hz, &patterns).map(|z| z * Complex::from(2.0));
        let table = ImpedanceTable::new([0.5 * hz, 1.5 * hz], 6, both).unwrap();
        let modes = DryModes::new(vec![TAU * hz], vec![zeta]).unwrap();
        let wet = resonances(&modes, f64::INFINITY, |omega| table.at(omega)).unwrap()[0]
            .clone()
            .unwrap();
        let moved = wet.hz() / hz - 1.0;
        // At the dry resonance, as radiation damping is stated.
        let added = both(hz).unwrap()[(0, 0)].re / (2.0 * TAU * hz);
        let change = 10.0 * (zeta / (zeta + added)).log10();
        println!("{hz} Hz: {moved:.4} {shift}, {added:.5} {of_radiation}, {change:.2} dB {level}");
        assert!((moved - shift).abs() < 0.0012, "{hz} Hz: {moved}");
        assert!((added / of_radiation - 1.0).abs() < 0.1, "{hz} Hz: {added}");
        assert!((change - level).abs() < 0.2, "{hz} Hz: {change}");
    }
}

/// Modes of a thin cantilever of the span `a` and the width `b` by Ritz's method: products of polynomials.
struct Cantilever {
    a: f64,
    b: f64,
    omega: Vec<f64>,
    /// Coefficients of the products, x fastest.
    shapes: Vec<DVector<f64>>,
}

/// Polynomials along an axis.
const ALONG: usize = 8;
const ACROSS: usize = 7;

/// Coefficients of the shifted Legendre polynomial of a degree, lowest power first.
fn legendre(degree: usize) -> Vec<f64> {
    let (mut last, mut now) = (vec![0.0], vec![1.0]);
    for n in 0..degree {
        let n = n as f64;
        // (n + 1) P_{n+1} = (2n + 1)(2x - 1) P_n - n P_{n-1}
        let mut next = vec![0.0; now.len() + 1];
        for (power, c) in now.iter().enumerate() {
            next[power] -= (2.0 * n + 1.0) * c / (n + 1.0);
            next[power + 1] += 2.0 * (2.0 * n + 1.0) * c / (n + 1.0);
        }
        for (power, c) in last.iter().enumerate() {
            next[power] -= n * c / (n + 1.0);
        }
        (last, now) = (now, next);
    }
    now
}

fn derivative(p: &[f64]) -> Vec<f64> {
    p.iter().enumerate().skip(1).map(|(n, c)| n as f64 * c).collect()
}

fn value(p: &[f64], x: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Integrals over (0, length) of the products of derivatives of polynomials of x/length.
fn integrals(polynomials: &[Vec<f64>], orders: [usize; 2], length: f64) -> DMatrix<f64> {
    let order = |p: &Vec<f64>, times: usize| (0..times).fold(p.clone(), |p, _| derivative(&p));
    let n = polynomials.len();
    DMatrix::from_fn(n, n, |i, j| {
        let (p, q) = (order(&polynomials[i], orders[0]), order(&polynomials[j], orders[1]));
        let mut sum = 0.0;
        for (m, a) in p.iter().enumerate() {
            for (n, b) in q.iter().enumerate() {
                sum += a * b / (m + n + 1) as f64;
            }
        }
        sum * length.powi(1 - orders[0] as i32 - orders[1] as i32)
    })
}

fn along() -> Vec<Vec<f64>> {
    let clamped = |n| [vec![0.0, 0.0], legendre(n)].concat();
    (0..ALONG).map(clamped).collect()
}

fn across() -> Vec<Vec<f64>> {
    (0..ACROSS).map(legendre).collect()
}

impl Cantilever {
    fn new([a, b, h]: [f64; 3], [young, poisson, density]: [f64; 3]) -> Self {
        let stiffness = young * h * h * h / (12.0 * (1.0 - poisson * poisson));
        let x = |orders| integrals(&along(), orders, a);
        let y = |orders| integrals(&across(), orders, b);
        // D/2 int [w_xx² + w_yy² + 2 nu w_xx w_yy + 2 (1 - nu) w_xy²]
        let mixed = y([0, 2]).kronecker(&x([2, 0]));
        let k = (y([0, 0]).kronecker(&x([2, 2]))
            + y([2, 2]).kronecker(&x([0, 0]))
            + (&mixed + mixed.transpose()) * poisson
            + y([1, 1]).kronecker(&x([1, 1])) * (2.0 * (1.0 - poisson)))
            * stiffness;
        let m = y([0, 0]).kronecker(&x([0, 0])) * (density * h);
        let lower = m.cholesky().unwrap().l();
        let mut half = k;
        lower.solve_lower_triangular_mut(&mut half);
        let mut both = half.transpose();
        lower.solve_lower_triangular_mut(&mut both);
        let eigen = SymmetricEigen::new((&both + both.transpose()) * 0.5);
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        order.truncate(12);
        let shape = |&k: &usize| {
            let mut shape = eigen.eigenvectors.column(k).into_owned();
            lower.tr_solve_lower_triangular_mut(&mut shape);
            shape
        };
        Self {
            a,
            b,
            omega: order.iter().map(|&k| eigen.eigenvalues[k].sqrt()).collect(),
            shapes: order.iter().map(shape).collect(),
        }
    }

    fn functions(&self) -> Vec<Box<dyn Fn(f64, f64) -> f64>> {
        let (a, b) = (self.a, self.b);
        self.shapes
            .iter()
            .map(|shape| {
                let (shape, along, across) = (shape.clone(), along(), across());
                Box::new(move |x: f64, y: f64| {
                    let px: Vec<f64> = along.iter().map(|p| value(p, x / a)).collect();
                    let py = across.iter().map(|p| value(p, y / b));
                    py.enumerate()
                        .map(|(j, py)| (0..ALONG).map(|i| shape[j * ALONG + i] * px[i] * py).sum::<f64>())
                        .sum::<f64>()
                }) as Box<dyn Fn(f64, f64) -> f64>
            })
            .collect()
    }
}

/// Cantilevers of 207 GPa, 0.3, 7850 kg/m³ and 5 mm in water, both sides wet: dry frequencies and wet over dry, to 3e-4
/// by a spectral Galerkin method.
#[test]
fn cantilevers_in_water() {
    let cases = [
        (
            [0.5, 0.5],
            [17.170, 42.08, 105.29, 134.54, 153.13],
            [0.4228, 0.5096, 0.4757, 0.5497, 0.5420],
        ),
        (
            [0.5, 0.25],
            [17.013, 73.22, 106.03, 238.3, 297.5],
            [0.4887, 0.6121, 0.5169, 0.6272, 0.5603],
        ),
    ];
    for ([a, b], dry, ratio) in cases {
        let beam = Cantilever::new([a, b, 0.005], [207e9, 0.3, 7850.0]);
        let mesh = rectangle(&graded(a, 10), &graded(b, 10));
        let (plate, patterns) = plate(mesh, [None; 2], WetSides::Both, &beam.functions());
        let table = ImpedanceTable::new([3.0, 700.0], 6, |hz| plate.impedance(hz, &patterns)).unwrap();
        let at = |w: f64| table.at(Complex::from(w));
        let modes = DryModes::new(beam.omega.clone(), vec![0.0; beam.omega.len()]).unwrap();
        let wet = WetModes::new(
            &modes,
            TAU,
            |i, w| at(w).column(i).map(|z| z.im / w),
            |w, v| v.dot(&(at(w).map(|z| z.re) * v)),
        )
        .unwrap();
        let exact = resonances(&modes, f64::INFINITY, |omega| table.at(omega)).unwrap();
        for n in 0..5 {
            let (f, frozen) = (beam.omega[n] / TAU, wet.omega[n] / TAU);
            let full = exact[n].as_ref().unwrap().hz();
            println!(
                "{f:8.3} Hz {:8.3}, wet/dry {:.4} frozen {:.4}, {}",
                dry[n],
                full / f,
                frozen / f,
                ratio[n]
            );
            assert!((f / dry[n] - 1.0).abs() < 2e-3, "dry {n}: {f}");
            assert!((full / f / ratio[n] - 1.0).abs() < 0.01, "wet {n}: {}", full / f);
            assert!((frozen / full - 1.0).abs() < 0.01, "frozen {n}: {frozen} {full}");
        }
    }
}
