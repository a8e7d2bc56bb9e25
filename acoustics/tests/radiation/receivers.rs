//! Pressures at receivers: closed forms, the power they carry, and the array of the standard.

use crate::radiating_surfaces::{disk, flat, rectangle};
use nailnoise_acoustics::radiation::Sampling;
use nailnoise_acoustics::radiation::flush_with_sand::{MovingSand, Rayleigh, SoundAbovePlane};
use nailnoise_acoustics::radiation::sound::{
    Iso3744Box, background_correction, environmental_correction, omnidirectional_transfer, oscillating_sphere_pressure,
};
use nailnoise_acoustics::signals::ChirpTransform;
use nailnoise_acoustics::{Air, ReceiverError};
use nalgebra::{Complex, DMatrix, Point3, Vector3};
use std::f64::consts::{PI, TAU};

/// Directions and shares of a mean over the upper half space: the midpoint rule in the cosine of the polar angle.
fn upper(rings: usize, around: usize) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    (0..rings).flat_map(move |i| {
        let z = (i as f64 + 0.5) / rings as f64;
        let rho = (1.0 - z * z).sqrt();
        (0..around).map(move |j| {
            let phi = TAU * (j as f64 + 0.5) / around as f64;
            let share = 1.0 / (rings * around) as f64;
            (Vector3::new(rho * phi.cos(), rho * phi.sin(), z), share)
        })
    })
}

#[test]
fn a_signal_is_the_sum_of_its_bins_at_any_sampling_rate() {
    let df = 3.7;
    let frequency: Vec<f64> = (11..300).map(|k| f64::from(k) * df).collect();
    let spectrum: Vec<Complex<f64>> = (0..frequency.len())
        .map(|k| Complex::from_polar(1.0 / (1.0 + 0.01 * k as f64), 0.37 * (k * k) as f64))
        .collect();
    let signal = ChirpTransform::new(&frequency, 4801.3, 700).signal(&spectrum);
    for (n, x) in signal.iter().enumerate() {
        let t = n as f64 / 4801.3;
        let sum: f64 = frequency
            .iter()
            .zip(&spectrum)
            .map(|(hz, x)| 2.0 * df * (x * Complex::from_polar(1.0, TAU * hz * t)).re)
            .sum();
        assert!((x - sum).abs() < 1e-9 * 2.0 * df * 289.0, "{n}: {x} {sum}");
    }
    assert_eq!(ChirpTransform::new(&[], 48_000.0, 3).signal(&[]), [0.0; 3]);
    // One period, 1/df = 0.27 s, and silence.
    let long = ChirpTransform::new(&frequency, 4801.3, 1500).signal(&spectrum);
    assert!(
        long.iter()
            .zip(&signal)
            .all(|(a, b)| (a - b).abs() < 1e-9 * 2.0 * df * 289.0)
    );
    assert!(long[1298..].iter().all(|x| *x == 0.0));
}

#[test]
fn the_pressure_on_the_axis_of_a_piston_has_its_closed_form() {
    // |p| = 2 rho c v |sin(k/2 (sqrt(z² + a²) - z))|, Rayleigh 1896.
    let air = Air::default();
    let a = 0.1;
    let piston = Rayleigh::new(&flat(disk(a, 24, 48), &[&|_, _| 1.0]), &air).unwrap();
    for (hz, z) in [(300.0, 0.3), (2000.0, 0.3), (5000.0, 0.2), (5000.0, 2.0)] {
        let omega: f64 = TAU * hz;
        let half = 0.5 * omega / air.sound_speed * (a.hypot(z) - z);
        let expected = 2.0 * air.impedance() / omega * half.sin().abs();
        let found = piston.pressure_at(hz, &[Point3::new(0.0, 0.0, z)]).unwrap()[(0, 0)].norm();
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{hz} Hz, {z} m: {found} {expected}"
        );
    }
    for (z, below) in [(-0.1, true), (1e-4, false)] {
        let error = piston.pressure_at(100.0, &[Point3::new(0.0, 0.0, z)]).unwrap_err();
        assert_eq!(matches!(error, ReceiverError::BelowFloor { .. }), below, "{error}");
        assert_eq!(matches!(error, ReceiverError::NearSurface { .. }), !below, "{error}");
    }
}

#[test]
fn pressures_far_above_a_plane_carry_the_resistance() {
    let air = Air::default();
    let rock = |x: f64, _: f64| x / 0.2;
    let block = flat(rectangle([-0.2, 0.2], [-0.08, 0.08], 20, 10), &[&|_, _| 1.0, &rock]);
    let sand = MovingSand {
        footprint: [[-0.2, 0.2], [-0.08, 0.08]],
        sand: [[-0.4, 0.4], [-0.3, 0.3]],
        shear_speed: 112.0,
        poisson_ratio: 0.3,
        loss_factor: 0.1,
        to_hz: 900.0,
    };
    let bare = Rayleigh::new(&block, &air).unwrap();
    let moving = bare.clone().with_moving_sand(sand).unwrap();
    let motion = [Complex::new(0.7, 0.2), Complex::new(-0.3, 0.5)];
    let radius = 400.0;
    for (surface, hz) in [(&bare, 300.0), (&bare, 1500.0), (&moving, 500.0)] {
        let omega2 = (TAU * hz).powi(2);
        let power: f64 = surface
            .resistance(hz)
            .iter()
            .map(|r| 0.5 * r.form(&motion) / omega2)
            .sum();
        let (places, shares): (Vec<_>, Vec<_>) = upper(120, 40)
            .map(|(s, share)| (Point3::from(s * radius), share))
            .unzip();
        let p = surface.pressure_at(hz, &places).unwrap();
        let mean: f64 = (0..places.len())
            .map(|i| shares[i] * (p[(i, 0)] * motion[0] + p[(i, 1)] * motion[1]).norm_sqr())
            .sum();
        let heard = mean * TAU * radius * radius / (2.0 * air.impedance());
        assert!((heard / power - 1.0).abs() < 2e-3, "{hz} Hz: {heard} {power}");
    }
}

#[test]
fn pressures_between_samples_are_interpolated_like_the_resistance() {
    let air = Air::default();
    let rock = |x: f64, _: f64| x / 0.2;
    let block = flat(rectangle([-0.2, 0.2], [-0.08, 0.08], 12, 6), &[&|_, _| 1.0, &rock]);
    let surface = Rayleigh::new(&block, &air).unwrap();
    let sampling = Sampling {
        range_hz: [50.0, 2000.0],
        ..Sampling::default()
    };
    let sampled = surface.sampled(&sampling, &|| ()).unwrap();
    let places = [Point3::new(1.0, 0.3, 0.6), Point3::new(0.0, 0.0, 1.2)];
    let heard = SoundAbovePlane::new(&surface, &sampled, &places, Point3::origin()).unwrap();
    assert!(heard.error() < 1e-3, "{}", heard.error());
    let frequency = [73.0, 411.0, 1234.5, 1999.0];
    let motion = DMatrix::from_fn(2, frequency.len(), |i, j| Complex::new(1.0 + i as f64, j as f64));
    let found = heard.pressures(&sampled, &frequency, &motion);
    for (bin, &hz) in frequency.iter().enumerate() {
        let expected = surface.pressure_at(hz, &places).unwrap() * motion.column(bin);
        for (found, expected) in found.column(bin).iter().zip(expected.iter()) {
            assert!((found - expected).norm() < 1e-3 * expected.norm(), "{hz} Hz");
        }
    }
}

#[test]
fn the_pressures_around_an_oscillating_sphere_carry_the_power_of_its_resistance() {
    let air = Air::default();
    let volume = 4e-3;
    let a: f64 = (3.0 * volume / (4.0 * PI)).cbrt();
    let radius = 500.0;
    for hz in [100.0, 500.0, 3000.0] {
        let ka4 = (TAU * hz / air.sound_speed * a).powi(4);
        let resistance = air.impedance() * 4.0 * PI * a * a / 3.0 * ka4 / (4.0 + ka4);
        let power = 0.5 * resistance / (TAU * hz).powi(2);
        let down = Vector3::new(0.0, 0.0, -2.0);
        let at = |s: Vector3<f64>| {
            let place = Point3::from(s * radius);
            oscillating_sphere_pressure(hz, volume, Point3::origin(), down, place, None, &air).unwrap()
        };
        // The dipole is even about its equator.
        let mean: f64 = upper(400, 1).map(|(s, share)| share * at(s).norm_sqr()).sum();
        let heard = mean * 4.0 * PI * radius * radius / (2.0 * air.impedance());
        assert!((heard / power - 1.0).abs() < 1e-4, "{hz} Hz: {heard} {power}");
    }
    // On the floor nothing moves the air across it: the normal derivative of the pressure vanishes.
    let centre = Point3::new(0.0, 0.0, 0.9);
    let slope = |floor: Option<f64>| {
        let at = |z: f64| {
            let place = Point3::new(0.7, 0.1, z);
            oscillating_sphere_pressure(400.0, volume, centre, Vector3::z(), place, floor, &air).unwrap()
        };
        (at(1e-4) - at(0.0)).norm()
    };
    assert!(slope(Some(0.0)) < 1e-3 * slope(None));
    let inside = oscillating_sphere_pressure(400.0, volume, centre, Vector3::z(), centre, None, &air);
    assert!(matches!(inside, Err(ReceiverError::NearSurface { .. })));
}

#[test]
fn an_evenly_spread_source_keeps_its_energy_above_a_floor() {
    let air = Air::default();
    let (centre, radius) = (Point3::new(0.0, 0.0, 1.0), 2000.0);
    let exposure: f64 = upper(50, 1)
        .map(|(s, share)| {
            share
                * omnidirectional_transfer(centre, Point3::from(s * radius), 0.0, &air)
                    .unwrap()
                    .exposure_per_energy
        })
        .sum();
    let energy = exposure / air.impedance() * TAU * radius * radius;
    assert!((energy - 1.0).abs() < 1e-3, "{energy}");
    let below = omnidirectional_transfer(centre, Point3::new(1.0, 0.0, -0.1), 0.0, &air);
    assert!(matches!(below, Err(ReceiverError::BelowFloor { .. })));
}

#[test]
fn the_array_is_that_of_the_standard() {
    let around = Iso3744Box::around(0.5);
    assert_eq!(around.sides, [1.0, 1.0, 1.5]);
    assert!((around.area() - 16.0).abs() < 1e-12);
    // The corner microphones are sqrt(3) m from the device's centre.
    let centre = Vector3::new(0.0, 0.0, 0.5);
    for corner in &around.positions()[4..8] {
        assert!(((corner - centre).norm() - 3f64.sqrt()).abs() < 1e-12);
    }
    // ISO 3744: 10 dB above the background cost 0.46 dB, 6 dB 1.26 dB.
    assert!((background_correction(10.0).unwrap() - 0.458).abs() < 1e-3);
    assert!((background_correction(6.0).unwrap() - 1.256).abs() < 1e-3);
    assert_eq!(
        (background_correction(15.1), background_correction(5.9)),
        (Some(0.0), None)
    );
    // A = 4 S doubles the energy at the microphones.
    assert!((environmental_correction(16.0, 64.0).unwrap() - 10.0 * 2f64.log10()).abs() < 1e-12);
    assert!(environmental_correction(16.0, 0.0).is_err());
}

/// L_W = L_p + 10 lg S counts waves that cross the box obliquely in full: a point source at its centre, with its image
/// in the reflecting plane, reads too much.
#[test]
fn the_array_reads_more_than_the_power_of_a_point_source() {
    for (height, excess) in [(0.938, 1.23), (0.2, 0.69)] {
        let around = Iso3744Box::around(height);
        let [source, image] = [height, -height].map(|z| Vector3::new(0.0, 0.0, z));
        // Intensity over power.
        let at = |microphone: &Vector3<f64>| {
            let of = |from: Vector3<f64>| 1.0 / (4.0 * PI * (microphone - from).norm_squared());
            of(source) + of(image)
        };
        let mean = around.positions().iter().map(at).sum::<f64>() / 9.0;
        let found = 10.0 * (mean * around.area()).log10();
        assert!((found - excess).abs() < 0.005, "{found} dB for a centre at {height} m");
    }
}
