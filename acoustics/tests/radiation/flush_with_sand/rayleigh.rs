//! Rayleigh's integral against closed forms, and the laws of a radiation resistance.

use crate::radiating_surfaces::{disk, flat, rectangle, references};
use nailnoise_acoustics::radiation::flush_with_sand::Rayleigh;
use nailnoise_acoustics::radiation::{Erp, ModalRadiation, RadiatingSurface, RadiationError, Resistance, Sampling};
use nailnoise_acoustics::{AcousticsError, Air, InputError, SamplingError};
use nalgebra::{Complex, DMatrix, SymmetricEigen};
use std::f64::consts::PI;

fn whole(rayleigh: &Rayleigh, hz: f64) -> Resistance {
    let mut sum = Resistance::zeros(rayleigh.resistance(hz)[0].real.ncols());
    rayleigh
        .resistance(hz)
        .iter()
        .for_each(|patch| sum.add_scaled(1.0, patch));
    sum
}

fn block(nx: usize, ny: usize) -> RadiatingSurface {
    let one = |_: f64, _: f64| 1.0;
    let rock = |x: f64, _: f64| x / 0.2032;
    let bend = |x: f64, y: f64| (PI * x / 0.2032).cos() * (2.0 * PI * y / 0.0762).cos() - 0.3;
    let short = |x: f64, y: f64| (5.0 * PI * x / 0.2032).cos() * (PI * y / 0.0762).sin();
    flat(
        rectangle([-0.2032, 0.2032], [-0.0762, 0.0762], nx, ny),
        &[&one, &rock, &bend, &short],
    )
}

#[test]
fn baffled_piston() {
    let air = Air::default();
    let a = 0.1;
    let piston = Rayleigh::new(&flat(disk(a, 12, 40), &[&|_, _| 1.0]), &air).unwrap();
    for row in references()["baffled_piston"]["table"].as_array().unwrap() {
        let (ka, r1) = (row["ka"].as_f64().unwrap(), row["R1"].as_f64().unwrap());
        let r = whole(&piston, ka * air.sound_speed / (2.0 * PI * a)).real[(0, 0)] / (air.impedance() * PI * a * a);
        assert!((r / r1 - 1.0).abs() < 1e-6, "ka = {ka}: {r} against {r1}");
    }
}

#[test]
fn simply_supported_plate() {
    let air = Air::default();
    let points = rectangle([0.0, 1.0], [0.0, 1.0], 24, 24);
    for row in references()["ss_plate_sigma_square"]["table"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap();
        let (m, n, gamma) = (number("m"), number("n"), number("gamma"));
        let mode = move |x: f64, y: f64| (m * PI * x).sin() * (n * PI * y).sin();
        let plate = Rayleigh::new(&flat(points.clone(), &[&mode]), &air).unwrap();
        let hz = gamma * PI * m.hypot(n) * air.sound_speed / (2.0 * PI);
        let sigma = whole(&plate, hz).real[(0, 0)] / (air.impedance() * 0.25);
        assert!(
            (sigma / number("sigma") - 1.0).abs() < 1e-6,
            "{m} {n} {gamma}: {sigma} against {}",
            number("sigma")
        );
    }
}

#[test]
fn odd_modes_follow_wallace_at_low_frequency() {
    // C. E. Wallace, J. Acoust. Soc. Am. 51, 946 (1972), odd-odd modes.
    let air = Air::default();
    let (a, b) = (0.7, 0.4);
    let points = rectangle([0.0, a], [0.0, b], 24, 24);
    for (m, n) in [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0)] {
        let mode = move |x: f64, y: f64| (m * PI * x / a).sin() * (n * PI * y / b).sin();
        let plate = Rayleigh::new(&flat(points.clone(), &[&mode]), &air).unwrap();
        let k: f64 = 0.2;
        let sigma = whole(&plate, k * air.sound_speed / (2.0 * PI)).real[(0, 0)] / (air.impedance() * a * b / 4.0);
        let bracket = |p: f64| 1.0 - 8.0 / (p * PI).powi(2);
        let series = 1.0 - k * k * a * b / 12.0 * (bracket(m) * a / b + bracket(n) * b / a);
        let wallace = 32.0 * k * k * a * b / (m * m * n * n * PI.powi(5)) * series;
        assert!(
            (sigma / wallace - 1.0).abs() < 1e-4,
            "{m} {n}: {sigma} against {wallace}"
        );
    }
}

#[test]
fn gauss_points_converge_spectrally() {
    let air = Air::default();
    let at = |n: usize| whole(&Rayleigh::new(&block(2 * n, n), &air).unwrap(), 6000.0).real;
    let exact = at(40);
    let errors: Vec<f64> = [8, 12, 16, 20]
        .iter()
        .map(|&n| (at(n) - &exact).amax() / exact.amax())
        .collect();
    assert!(
        errors.windows(2).all(|e| e[1] < 0.02 * e[0] || e[1] < 1e-12),
        "{errors:?}"
    );
    assert!(errors[2] < 1e-8, "{errors:?}");
}

#[test]
fn resistance_is_symmetric_and_positive_semidefinite() {
    let rayleigh = Rayleigh::new(&block(24, 16), &Air::default()).unwrap();
    for hz in [20.0, 300.0, 2000.0, 9000.0] {
        let r = whole(&rayleigh, hz);
        assert!(r.imaginary.is_none());
        assert!((&r.real - r.real.transpose()).amax() <= 1e-15 * r.real.amax());
        let least = SymmetricEigen::new(r.real.clone()).eigenvalues.min();
        assert!(least > -1e-15 * r.real.amax(), "{hz} Hz: {least}");
    }
}

/// Largest |A_ij - B_ij| / sqrt(A_ii A_jj) of spherical waves and pairs of points, over modes that radiate.
fn difference(rayleigh: &Rayleigh, hz: f64) -> f64 {
    let far = whole(rayleigh, hz).real;
    let near = rayleigh.surface_resistance(hz).real;
    let floor = 1e-12 * far.diagonal().amax();
    let scale = |i: usize| far[(i, i)].max(floor).sqrt();
    let of_entry = |i: usize, j: usize| (far[(i, j)] - near[(i, j)]).abs() / (scale(i) * scale(j));
    DMatrix::from_fn(far.nrows(), far.ncols(), of_entry).amax()
}

#[test]
fn far_field_and_surface_agree() {
    let rayleigh = Rayleigh::new(&block(30, 20), &Air::default()).unwrap();
    // The pairwise sum loses digits where short bending waves cancel: kD = 0.2 at 30 Hz.
    for (hz, limit) in [(30.0, 1e-6), (500.0, 1e-10), (3000.0, 1e-11), (10_000.0, 1e-11)] {
        let difference = difference(&rayleigh, hz);
        assert!(difference < limit, "{hz} Hz: {difference:.1e}");
    }
}

#[test]
fn patches_sum_to_the_whole() {
    let surface = block(24, 16);
    let patch: Vec<usize> = surface.points().iter().map(|p| usize::from(p.x > 0.05)).collect();
    let split = RadiatingSurface::new(
        surface.points().to_vec(),
        surface.normals().to_vec(),
        surface.weights().to_vec(),
        patch,
        vec!["left".into(), "right".into()],
        surface.normal_modes().clone(),
    )
    .unwrap();
    let air = Air::default();
    for hz in [100.0, 4000.0] {
        let one = whole(&Rayleigh::new(&surface, &air).unwrap(), hz);
        let two = whole(&Rayleigh::new(&split, &air).unwrap(), hz);
        assert!((one.real - two.real).amax() < 1e-13 * whole(&Rayleigh::new(&surface, &air).unwrap(), hz).real.amax());
    }
}

#[test]
fn high_frequencies_approach_plane_waves() {
    let air = Air::default();
    let surface = flat(rectangle([-0.5, 0.5], [-0.5, 0.5], 100, 100), &[&|_, _| 1.0]);
    let erp = Erp::new(&surface, &air).resistance(1.0).real[(0, 0)];
    assert!((erp / (air.impedance() * 1.0) - 1.0).abs() < 1e-12);
    let rayleigh = whole(&Rayleigh::new(&surface, &air).unwrap(), 5000.0).real[(0, 0)];
    assert!((rayleigh / erp - 1.0).abs() < 0.02, "{}", rayleigh / erp);
}

#[test]
fn sampling_keeps_its_tolerance() {
    let rayleigh = Rayleigh::new(&block(40, 24), &Air::default()).unwrap();
    // The samples are stored in single precision, which the interpolation amplifies to 2e-7.
    for (tolerance, samples) in [(1e-2, 93), (1e-4, 129), (2e-7, 153)] {
        let sampled = rayleigh
            .sampled(
                &Sampling {
                    tolerance,
                    ..Sampling::default()
                },
                &|| (),
            )
            .unwrap();
        assert!(sampled.interpolation_error() <= tolerance);
        let mut worst: f64 = 0.0;
        for i in 0..60 {
            let hz = 41.7 * (9900.0f64 / 41.7).powf(f64::from(i) / 59.0);
            let (exact, found) = (whole(&rayleigh, hz).real, sampled.resistance(hz).real);
            // Modes that hardly radiate are judged against a millionth of the best radiator.
            let size = |i: usize| exact[(i, i)].max(1e-6 * exact.diagonal().max());
            for i in 0..4 {
                for j in 0..4 {
                    let scale = (size(i) * size(j)).sqrt();
                    worst = worst.max((exact[(i, j)] - found[(i, j)]).abs() / scale);
                }
            }
        }
        assert!(worst <= tolerance, "{worst:e} against {tolerance:e}");
        assert!(sampled.sampled_hz().len() <= samples, "work at {tolerance:e}");
    }
}

#[test]
fn entries_keep_their_slope_below_the_lowest_sample() {
    let rayleigh = Rayleigh::new(&block(40, 24), &Air::default()).unwrap();
    let sampled = rayleigh
        .sampled(
            &Sampling {
                range_hz: [40.0, 500.0],
                ..Sampling::default()
            },
            &|| (),
        )
        .unwrap();
    let (exact, found) = (whole(&rayleigh, 10.0).real, sampled.resistance(10.0).real);
    // A monopole f², a dipole f⁴: the block is small against the wave, kL = 0.3 at 40 Hz.
    for (mode, error) in [(0, 0.02), (1, 0.02), (2, 0.02), (3, 0.02)] {
        let ratio = found[(mode, mode)] / exact[(mode, mode)];
        assert!((ratio - 1.0).abs() < error, "mode {mode}: {ratio}");
    }
    let least = SymmetricEigen::new(found.clone()).eigenvalues.min();
    assert!(least > -1e-12 * found.amax());
}

#[test]
fn energy_forms_equal_the_resistance() {
    let air = Air::default();
    let surface = block(40, 24);
    let sampled = Rayleigh::new(&surface, &air)
        .unwrap()
        .sampled(&Sampling::default(), &|| ())
        .unwrap();
    let erp = Erp::new(&surface, &air);
    let hz: Vec<f64> = (0..700).map(|i| 12.0 + 14.0 * f64::from(i)).collect();
    let a = DMatrix::from_fn(4, hz.len(), |i, j| {
        let phase = (i * j) as f64 * 0.37;
        Complex::new(1.0 / (1.0 + i as f64), 0.0) * Complex::new(phase.cos(), phase.sin())
    });
    for radiation in [&sampled as &dyn ModalRadiation, &erp] {
        let forms = radiation.energy_forms(&hz, &a);
        for bin in (0..hz.len()).step_by(23) {
            let v: Vec<Complex<f64>> = a.column(bin).iter().map(|x| x / (2.0 * PI * hz[bin])).collect();
            let form = radiation.resistance(hz[bin]).form(&v);
            assert!(
                (forms[(0, bin)] / form - 1.0).abs() < 1e-6,
                "{} Hz: {} {form}",
                hz[bin],
                forms[(0, bin)]
            );
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let rayleigh = Rayleigh::new(&block(40, 24), &Air::default()).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            rayleigh
                .sampled(&Sampling::default(), &|| ())
                .unwrap()
                .resistance(777.0)
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn surfaces_that_are_not_plane_are_refused() {
    let mut points = rectangle([0.0, 1.0], [0.0, 1.0], 3, 3);
    let flat_one = flat(points.clone(), &[&|_, _| 1.0]);
    let tilted = RadiatingSurface::new(
        flat_one
            .points()
            .iter()
            .map(|p| nalgebra::Point3::new(p.x, p.y, 0.1 * p.x))
            .collect(),
        flat_one.normals().to_vec(),
        flat_one.weights().to_vec(),
        flat_one.patch().to_vec(),
        vec!["top".into()],
        flat_one.normal_modes().clone(),
    );
    assert!(matches!(
        Rayleigh::new(&tilted.unwrap(), &Air::default()),
        Err(RadiationError::NotPlanar { .. })
    ));
    points.iter_mut().for_each(|p| p.1 = 0.0);
    assert!(matches!(
        Rayleigh::new(&flat(points, &[&|_, _| 1.0]), &Air::default()),
        Err(RadiationError::Input(InputError::NotPositive { .. }))
    ));
    let narrow = Sampling {
        most_samples: 20,
        tolerance: 1e-12,
        ..Sampling::default()
    };
    let error = Rayleigh::new(&block(24, 16), &Air::default())
        .unwrap()
        .sampled(&narrow, &|| ())
        .unwrap_err();
    assert!(matches!(
        error,
        AcousticsError::Sampling(SamplingError::Unresolved { .. })
    ));
}
