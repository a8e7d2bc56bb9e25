//! From acceleration records to energy.

use crate::radiating_surfaces::{disk, flat, rectangle, references};
use nailnoise_acoustics::radiation::flush_with_sand::Rayleigh;
use nailnoise_acoustics::radiation::sound::rigid_body_far_field;
use nailnoise_acoustics::radiation::{
    Erp, LowRank, ModalRadiation, ModalSpectra, RadiatingSurface, Sampling, mode_energies, radiated_energy,
    radiated_signals, rigid_body_energy,
};
use nailnoise_acoustics::signals::fourier::{Transform, TransformSettings};
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};
use nailnoise_acoustics::{AcousticsError, Air, InputError};
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// An acceleration pulse of one sample that leaves the velocity `v` behind.
fn step(samples: usize, dt: f64, v: f64) -> Vec<f64> {
    let mut record = vec![0.0; samples];
    record[samples / 4] = v / dt;
    record
}

#[test]
fn a_sphere_set_in_motion_radiates_a_quarter_of_rho_v_squared_times_its_volume() {
    let air = Air::default();
    let (dt, volume, v) = (1e-7, 1.5e-3, 2.0);
    let high = 2e6;
    let settings = TransformSettings {
        range_hz: [4.0, high],
        taper: 0.0,
        padding: 2.0,
    };
    let spectrum = rigid_body_energy("body", &step(400_000, dt, v), dt, volume, &air, &settings).unwrap();
    let energy = spectrum.energy([4.0, high], Weighting::Z);
    // Above the range: int_X^inf x²/(4 + x⁴) dx = 1/X + ..., of pi/4 in all, with x = k a.
    let x = 2.0 * PI * high / air.sound_speed * (3.0 * volume / (4.0 * PI)).cbrt();
    let whole = energy / (1.0 - 4.0 / (PI * x));
    let exact = air.density * volume * v * v / 4.0;
    assert!((whole / exact - 1.0).abs() < 1e-5, "{whole} against {exact}");
    assert_eq!(spectrum.method, "rigid motion only");
}

#[test]
fn the_rigid_body_has_the_oscillating_spheres_efficiency() {
    let air = Air::default();
    let settings = TransformSettings {
        range_hz: [100.0, 1000.0],
        taper: 0.0,
        padding: 1.0,
    };
    for row in references()["oscillating_sphere"]["table"].as_array().unwrap() {
        let (ka, z1) = (row["ka"].as_f64().unwrap(), row["z1_re"].as_f64().unwrap());
        // 500 Hz is a bin of 8000 samples at 25 us.
        let a = ka * air.sound_speed / (2.0 * PI * 500.0);
        let (record, volume) = (step(8000, 2.5e-5, 1.0), 4.0 / 3.0 * PI * a.powi(3));
        let spectrum = rigid_body_energy("body", &record, 2.5e-5, volume, &air, &settings).unwrap();
        let velocity = 1.0 / (2.0 * PI * 500.0);
        let sigma = spectrum.density_at(500.0) / (2.0 * velocity * velocity * air.impedance() * 4.0 * PI * a * a / 3.0);
        assert!((sigma / z1 - 1.0).abs() < 1e-9, "ka = {ka}: {sigma} against {z1}");
    }
}

#[test]
fn the_rigid_bodys_far_field_carries_the_power_of_its_surface() {
    let air = Air::default();
    let settings = TransformSettings {
        range_hz: [50.0, 10_000.0],
        taper: 0.0,
        padding: 1.0,
    };
    let (record, dt, volume) = (step(4000, 2.5e-5, 2.0), 2.5e-5, 1.5e-3);
    let surface = rigid_body_energy("body", &record, dt, volume, &air, &settings).unwrap();
    let field = rigid_body_far_field("body", &record, dt, volume, &air, &settings).unwrap();
    assert_eq!(surface.frequency, field.frequency);
    for (bin, (s, f)) in surface.energy_density.iter().zip(&field.energy_density).enumerate() {
        assert!((s / f - 1.0).abs() < 1e-6, "bin {bin}: {s} against {f}");
    }
    assert!(rigid_body_far_field("body", &record, dt, 0.0, &air, &settings).is_err());
}

#[test]
fn a_small_piston_radiates_the_energy_of_its_pressure_pulse() {
    // p = rho0 S a(t - r/c)/(2 pi r): E = rho0 S² / (2 pi c0) int a² dt.
    let air = Air::default();
    let radius = 1e-3;
    let (dt, s, n) = (1e-5, 4e-4, 4000);
    let wave = |i: usize| {
        let x = (i as f64 * dt - 0.02) / s;
        300.0 * (1.0 - x * x) * (-0.5 * x * x).exp()
    };
    let record: Vec<f64> = (0..n).map(wave).collect();
    let piston = Rayleigh::new(&flat(disk(radius, 4, 8), &[&|_, _| 1.0]), &air).unwrap();
    let radiation = piston
        .sampled(
            &Sampling {
                range_hz: [40.0, 8000.0],
                ..Sampling::default()
            },
            &|| (),
        )
        .unwrap();
    let settings = TransformSettings {
        range_hz: [10.0, 8000.0],
        taper: 1e-3,
        padding: 2.0,
    };
    let spectra = ModalSpectra::from_accelerations(1, n, dt, &settings, |_| record.clone()).unwrap();
    let energy = radiated_energy("piston", &radiation, &spectra)
        .unwrap()
        .energy([10.0, 8000.0], Weighting::Z);
    let area = PI * radius * radius;
    let square: f64 = record.iter().map(|a| a * a).sum::<f64>() * dt;
    let exact = air.density * area * area / (2.0 * PI * air.sound_speed) * square;
    assert!((energy / exact - 1.0).abs() < 2e-4, "{energy} against {exact}");
}

/// Two modes of a surface in two patches, driven by decaying records.
fn spectrum(factor: f64) -> SourceSpectrum {
    let air = Air::default();
    let points = rectangle([-0.2, 0.2], [-0.08, 0.08], 24, 12);
    let flat = flat(points, &[&|_, _| 0.6, &|x, _| (PI * x / 0.2).cos()]);
    let patch: Vec<usize> = flat.points().iter().map(|p| usize::from(p.x > 0.0)).collect();
    let names = vec!["left".to_owned(), "right".to_owned()];
    let (points, normals, weights) = (flat.points().to_vec(), flat.normals().to_vec(), flat.weights().to_vec());
    let surface = RadiatingSurface::new(points, normals, weights, patch, names, flat.normal_modes().clone()).unwrap();
    let radiation = Rayleigh::new(&surface, &air)
        .unwrap()
        .sampled(&Sampling::default(), &|| ())
        .unwrap();
    let record = |mode: usize| {
        let (w, dt) = (2.0 * PI * [310.0, 1480.0][mode], 1e-5);
        (0..5000)
            .map(|i| i as f64 * dt)
            .map(|t| factor * 90.0 * (-t * 150.0).exp() * (w * t).sin())
            .collect()
    };
    let spectra = ModalSpectra::from_accelerations(2, 5000, 1e-5, &TransformSettings::default(), record).unwrap();
    radiated_energy("workpiece", &radiation, &spectra).unwrap()
}

#[test]
fn doubled_forces_raise_every_band_by_20_lg_2() {
    let (one, two) = (spectrum(1.0), spectrum(2.0));
    let range = [50.0, 10_000.0];
    for (a, b) in one.band_levels(range).iter().zip(two.band_levels(range)) {
        if let (Some(a), Some(b)) = (a.lw, b.lw) {
            assert!((b - a - 20.0 * 2f64.log10()).abs() < 1e-9);
        }
    }
    let rise = two.level(range, Weighting::A).unwrap() - one.level(range, Weighting::A).unwrap();
    assert!((rise - 6.02).abs() < 0.001);
}

#[test]
fn no_motion_radiates_nothing() {
    let silent = spectrum(0.0);
    assert_eq!(silent.level([50.0, 10_000.0], Weighting::A), None);
}

#[test]
fn patches_share_the_energy() {
    let whole = spectrum(1.0);
    let parts = whole.contribution_energies([50.0, 10_000.0], Weighting::A);
    assert_eq!((parts[0].0.as_str(), parts[1].0.as_str()), ("left", "right"));
    let sum: f64 = parts.iter().map(|p| p.1).sum();
    assert!((sum / whole.energy([50.0, 10_000.0], Weighting::A) - 1.0).abs() < 1e-12);
    // Both modes are even in x, so the halves are alike.
    assert!((parts[0].1 / parts[1].1 - 1.0).abs() < 1e-9);
}

/// More bins than are evaluated together; the plate's records are transformed in memory that other records used before.
#[test]
fn many_bins_and_modes_give_the_energies_of_each_alone() {
    let plate = flat(
        rectangle([-0.15, 0.15], [-0.05, 0.05], 12, 6),
        &[&|_, _| 1.0, &|x, _| x, &|x, y| x * y],
    );
    let erp = Erp::new(&plate, &Air::default());
    let (samples, dt) = (4000, 5e-5);
    let settings = TransformSettings::default();
    let record = |mode: usize| -> Vec<f64> {
        let rate = 900.0 + 700.0 * mode as f64;
        (0..samples)
            .map(|i| (rate * i as f64 * dt).sin() * (-30.0 * i as f64 * dt).exp())
            .collect()
    };
    let motion = ModalSpectra::from_accelerations(3, samples, dt, &settings, record).unwrap();
    let bins = motion.frequency.len();
    assert!(bins > 1000);
    let transform = Transform::new(samples, dt, &settings).unwrap();
    for mode in 0..3 {
        let alone = transform.apply(&record(mode)).unwrap();
        assert!(motion.accelerations.row(mode).iter().eq(alone.iter()), "mode {mode}");
    }
    let spectrum = radiated_energy("plate", &erp, &motion).unwrap();
    let form = |bin: usize| {
        let omega2 = (2.0 * PI * motion.frequency[bin]).powi(2);
        let a: Vec<_> = motion.accelerations.column(bin).iter().copied().collect();
        2.0 * erp.resistance(motion.frequency[bin]).form(&a) / omega2
    };
    let exact: Vec<f64> = (0..bins).map(form).collect();
    for (bin, (found, exact)) in spectrum.energy_density.iter().zip(&exact).enumerate() {
        assert!((found / exact - 1.0).abs() < 1e-5, "bin {bin}: {found:e} {exact:e}");
    }
    let weights: Vec<f64> = (0..bins).map(|bin| 1.0 + (bin % 3) as f64).collect();
    let modes = mode_energies(&erp, &motion, &weights).unwrap();
    let whole: f64 = exact.iter().zip(&weights).map(|(e, w)| e * w).sum();
    assert!((modes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-9);
    let signals = radiated_signals(&erp, &motion, &spectrum).unwrap();
    assert!(signals.mismatch() < 1e-6, "{}", signals.mismatch());

    let band = [100.0, 9000.0];
    let covariance = motion.velocity_covariance(band, |hz| 1.0 + hz).unwrap();
    let step = motion.frequency[1] - motion.frequency[0];
    for i in 0..3 {
        for j in 0..3 {
            let of_bin = |(hz, a): (&f64, nalgebra::DVectorView<'_, nalgebra::Complex<f64>>)| {
                let inside = (band[0]..band[1]).contains(hz);
                let density = (a[i].conj() * a[j]).re * (1.0 + hz) / (2.0 * PI * hz).powi(2);
                if inside { 2.0 * step * density } else { 0.0 }
            };
            let exact: f64 = motion
                .frequency
                .iter()
                .zip(motion.accelerations.column_iter())
                .map(of_bin)
                .sum();
            let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
            assert!((covariance[(i, j)] - exact).abs() < 1e-12 * size, "{i} {j}");
        }
    }
}

#[test]
fn inconsistent_inputs_are_refused_by_name() {
    let air = Air::default();
    let surface = flat(rectangle([0.0, 0.3], [0.0, 0.3], 8, 8), &[&|_, _| 1.0]);
    let radiation = Rayleigh::new(&surface, &air).unwrap().sampled(
        &Sampling {
            range_hz: [40.0, 2000.0],
            ..Sampling::default()
        },
        &|| (),
    );
    let radiation = radiation.unwrap();
    let spectra = |modes: usize| {
        let settings = TransformSettings::default();
        ModalSpectra::from_accelerations(modes, 100, 1e-5, &settings, |_| vec![1.0; 100]).unwrap()
    };
    let error = radiated_energy("s", &radiation, &spectra(1)).unwrap_err();
    assert!(matches!(error, AcousticsError::Input(InputError::OutsideRange { high, .. }) if high == 2000.0));
    let error = radiated_energy("s", &Erp::new(&surface, &air), &spectra(2)).unwrap_err();
    assert!(matches!(
        error,
        AcousticsError::Input(InputError::Length {
            found: 2,
            expected: 1,
            ..
        })
    ));
}

/// Against phi^T C phi summed in double precision, for a covariance of full rank, one of low rank and none.
#[test]
fn forms_of_low_rank_are_those_of_their_covariance() {
    let (modes, points) = (40, 700);
    let wave = |i: usize, j: usize, k: f64| ((i as f64 + 0.3) * (j as f64 + 0.7) * k).sin();
    let shapes = DMatrix::from_fn(points, modes, |i, j| wave(i, j, 0.37) as f32);
    let covariance = |rank: usize, size: f64| {
        let rows = DMatrix::from_fn(modes, rank, |i, j| size * wave(i, j, 1.13) / (1.0 + j as f64));
        &rows * rows.transpose()
    };
    let all = [covariance(90, 1.0), covariance(3, 1e-9), covariance(0, 1.0)];
    let factors = all.each_ref().map(LowRank::of);
    let forms = LowRank::forms(&factors, &shapes);
    let exact = shapes.map(f64::from);
    for (covariance, forms) in all.iter().zip(&forms) {
        let expected = (&exact * covariance).component_mul(&exact).column_sum();
        let largest = expected.max();
        assert_eq!(forms.len(), points);
        for (form, expected) in forms.iter().zip(&expected) {
            assert!((form - expected).abs() <= 2e-6 * largest, "{form} against {expected}");
        }
    }
    assert!(forms[2].iter().all(|form| *form == 0.0));
    assert!(LowRank::forms(&[], &shapes).is_empty());
}
