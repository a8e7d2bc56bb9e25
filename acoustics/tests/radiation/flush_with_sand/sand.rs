//! Sand around a flush block.

use crate::radiating_surfaces::{flat, rectangle};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::flush_with_sand::{
    AbsorbingSand, FlushSound, MovingSand, Rayleigh, SoundAbovePlane, SurfaceResistances, band_sound_above_plane,
};
use nailnoise_acoustics::radiation::sound::{Directions, FieldPoints};
use nailnoise_acoustics::radiation::{
    ModalRadiation, ModalSpectra, RadiationError, Resistance, SampledRadiation, Sampling, radiated_energy,
};
use nailnoise_acoustics::signals::{Band, Weighting};
use nalgebra::{Complex, DMatrix, Point3};

const FOOTPRINT: [[f64; 2]; 2] = [[-0.2032, 0.2032], [-0.0762, 0.0762]];

fn sand() -> MovingSand {
    MovingSand {
        footprint: FOOTPRINT,
        sand: [[-0.3, 0.3], [-0.3, 0.3]],
        shear_speed: 112.0,
        poisson_ratio: 0.3,
        loss_factor: 0.1,
        to_hz: 1500.0,
    }
}

fn block() -> Rayleigh {
    let surface = flat(
        rectangle(FOOTPRINT[0], FOOTPRINT[1], 24, 16),
        &[&|_, _| 1.0, &|x, _| x / 0.2032],
    );
    Rayleigh::new(&surface, &Air::default()).unwrap()
}

fn whole(rayleigh: &Rayleigh, hz: f64) -> Resistance {
    let mut sum = Resistance::zeros(2);
    rayleigh
        .resistance(hz)
        .iter()
        .for_each(|patch| sum.add_scaled(1.0, patch));
    sum
}

#[test]
fn the_rayleigh_wave_has_its_closed_forms_of_speed() {
    // x = 3 - sqrt 5 for nu = 0, 2 - 2/sqrt 3 for 1/4; 0.9553 V_s for an incompressible half space (Viktorov 1967).
    let incompressible = 0.955_313_f64;
    let exact = [
        (0.0, (3.0 - 5.0_f64.sqrt()).sqrt()),
        (0.25, (2.0 - 2.0 / 3.0_f64.sqrt()).sqrt()),
        (0.5 - 1e-9, incompressible),
    ];
    for (poisson_ratio, exact) in exact {
        let law = MovingSand {
            poisson_ratio,
            ..sand()
        };
        let found = law.rayleigh_speed() / law.shear_speed;
        assert!((found - exact).abs() < 1e-6, "nu {poisson_ratio}: {found}, {exact}");
    }
}

#[test]
fn moving_sand_raises_the_low_bands() {
    let gains = |law: MovingSand| {
        let moving = block().with_moving_sand(law).unwrap();
        let gain = |hz| 10.0 * (whole(&moving, hz).real[(0, 0)] / whole(&block(), hz).real[(0, 0)]).log10();
        [125.0, 200.0, 315.0, 500.0, 800.0].map(gain)
    };
    let found = gains(sand());
    // The gains known from a coarser quadrature. Even grids of 30, 20 and 15 mm approach the values here from below:
    // 5.6, 6.2 and 6.25 dB at 200 Hz and -0.04, 0.8 and 1.04 dB at 800 Hz.
    for (db, coarse) in found.iter().zip([7.9, 6.0, 3.0, 1.5, 0.8]) {
        assert!((db - coarse).abs() < 0.35, "{db} against {coarse}");
    }
    // Laid out for shorter waves the quadrature is finer; the gain stays.
    for (db, fine) in found.iter().zip(gains(MovingSand {
        to_hz: 4000.0,
        ..sand()
    })) {
        assert!((db - fine).abs() < 2e-3, "{db} against {fine}");
    }
}

#[test]
fn absorbing_sand_takes_3_db_at_1_khz_over_an_infinite_plane() {
    let sand = AbsorbingSand {
        share: 1.0,
        ..AbsorbingSand::default()
    };
    let db = |hz: f64, sand: &AbsorbingSand| 10.0 * sand.factor(hz).log10();
    assert!((db(1000.0, &sand) + 3.0).abs() < 0.05, "{}", db(1000.0, &sand));
    let half = AbsorbingSand::default();
    assert!((db(1000.0, &half) - 0.5 * db(1000.0, &sand)).abs() < 1e-12);
    let (bare, covered) = (block(), block().with_absorbing_sand(half).unwrap());
    let ratio = whole(&covered, 700.0).real[(0, 0)] / whole(&bare, 700.0).real[(0, 0)];
    assert!((ratio / half.factor(700.0) - 1.0).abs() < 1e-12);
    // Hard sand absorbs nothing.
    let hard = AbsorbingSand {
        resistivity: 1e12,
        share: 1.0,
    };
    assert!(db(1000.0, &hard) > -0.05);
    assert!(
        block()
            .with_absorbing_sand(AbsorbingSand { share: 1.5, ..half })
            .is_err()
    );
}

#[test]
fn moving_sand_gives_a_hermitian_resistance() {
    let moving = block().with_moving_sand(sand()).unwrap();
    let r = whole(&moving, 600.0);
    let skew = r.imaginary.clone().unwrap();
    assert!((&skew + skew.transpose()).amax() < 1e-15 * r.real.amax());
    for phase in 0..12 {
        let v = [Complex::new(1.0, 0.0), Complex::from_polar(3.0, f64::from(phase) * 0.5)];
        assert!(r.form(&v) > 0.0);
    }
    let names = moving.patches();
    assert_eq!(names, ["top", "sand"]);
    let sampled = moving
        .sampled(
            &Sampling {
                range_hz: [40.0, 3000.0],
                ..Sampling::default()
            },
            &|| (),
        )
        .unwrap();
    let hz = [30.0, 333.0, 1400.0, 2500.0];
    let a = DMatrix::from_fn(2, 4, |i, j| Complex::from_polar(1.0 + i as f64, (i * (j + 1)) as f64));
    let forms = sampled.energy_forms(&hz, &a);
    for (bin, &f) in hz.iter().enumerate() {
        let v: Vec<Complex<f64>> = a
            .column(bin)
            .iter()
            .map(|x| x / (2.0 * std::f64::consts::PI * f))
            .collect();
        let direct = whole(&moving, f).form(&v);
        let found = forms.column(bin).sum();
        let tolerance = if f < 40.0 { 0.02 } else { 1e-3 };
        assert!((found / direct - 1.0).abs() < tolerance, "{f} Hz: {found} {direct}");
    }
}

/// A file gives the computed energies and signals to single precision, phase lags included; any other bytes are
/// refused.
#[test]
fn a_stored_resistance_radiates_the_same_power() {
    let moving = block().with_moving_sand(sand()).unwrap();
    let sampling = Sampling {
        range_hz: [60.0, 900.0],
        tolerance: 1e-3,
        ..Sampling::default()
    };
    let sampled = moving.sampled(&sampling, &|| ()).unwrap();
    let bytes = postcard::to_stdvec(&sampled.clone().with_roots()).unwrap();
    let kept: SampledRadiation = postcard::from_bytes(&bytes).unwrap();
    let hz: Vec<f64> = (1..20).map(|k| 45.0 * f64::from(k)).collect();
    let modes = sampled.modes();
    let a = DMatrix::from_fn(modes, hz.len(), |i, k| {
        Complex::new((i + k) as f64 * 0.3, 1.0 - 0.1 * (i * k) as f64)
    });
    let close = |found: DMatrix<Complex<f64>>, expected: DMatrix<Complex<f64>>| {
        assert!((&found - &expected).norm() < 1e-5 * expected.norm());
    };
    let forms = |r: &SampledRadiation| r.energy_forms(&hz, &a).map(Complex::from);
    close(forms(&kept), forms(&sampled));
    close(kept.root_signals(&hz, &a), sampled.root_signals(&hz, &a));
    assert!(whole(&moving, 300.0).imaginary.is_some());
    for end in (0..bytes.len()).step_by(1 + bytes.len() / 300) {
        assert!(postcard::from_bytes::<SampledRadiation>(&bytes[..end]).is_err());
    }
}

#[test]
fn sand_that_no_longer_moves_radiates_nothing() {
    let moving = block().with_moving_sand(sand()).unwrap();
    let (with, without) = (whole(&moving, 1600.0), whole(&block(), 1600.0));
    assert!((with.real - &without.real).amax() < 1e-12 * without.real.amax());
}

#[test]
fn moving_sand_is_resolved_over_the_whole_range() {
    let moving = block().with_moving_sand(sand()).unwrap();
    let sampled = moving.sampled(&Sampling::default(), &|| ()).unwrap();
    assert!(sampled.interpolation_error() <= 1e-3);
    println!("{} samples", sampled.sampled_hz().len());
    for hz in [77.0, 640.0, 1111.0, 1300.0, 1450.0, 5000.0] {
        let (found, exact) = (sampled.resistance(hz), whole(&moving, hz));
        let error = (found.real - &exact.real).amax() / exact.real.amax();
        assert!(error < 1e-3, "{hz} Hz: {error:e}");
    }
}

#[test]
fn a_footprint_outside_the_box_is_refused() {
    let small = MovingSand {
        sand: [[-0.1, 0.1], [-0.3, 0.3]],
        ..sand()
    };
    assert!(matches!(
        block().with_moving_sand(small),
        Err(RadiationError::SandBox { .. })
    ));
}

fn lossy() -> Rayleigh {
    let sand = AbsorbingSand {
        resistivity: 2.5e5,
        share: 0.5,
    };
    block()
        .with_moving_sand(self::sand())
        .unwrap()
        .with_absorbing_sand(sand)
        .unwrap()
}

/// The intensity on block and sand, pair by pair of their points, equals the power that the waves carry away in all
/// directions.
#[test]
fn surface_and_far_field_agree_with_sand_that_moves_and_absorbs() {
    let surface = lossy();
    for hz in [60.0, 500.0, 1300.0, 2500.0] {
        let (waves, pairs) = (whole(&surface, hz), surface.surface_resistance(hz));
        let off = (&waves.real - &pairs.real).amax() / waves.real.amax();
        assert!(off < 1e-9, "{hz} Hz: {off:e}");
        assert_eq!(waves.imaginary.is_some(), hz < 1500.0);
        if let (Some(a), Some(b)) = (waves.imaginary, pairs.imaginary) {
            assert!((a - b).amax() < 1e-9 * waves.real.amax());
        }
    }
}

/// Modal accelerations of a shot between 100 Hz and 2 kHz.
fn shot() -> ModalSpectra {
    let frequency: Vec<f64> = (0..191).map(|i| 100.0 + 10.0 * f64::from(i)).collect();
    ModalSpectra {
        range_hz: [100.0, 2000.0],
        accelerations: DMatrix::from_fn(2, frequency.len(), |i, j| {
            Complex::from_polar(1.0 + i as f64, (0.3 * i as f64 + 0.2) * j as f64)
        }),
        frequency,
    }
}

#[test]
fn a_shot_has_the_same_power_by_surface_and_by_far_field() {
    let (surface, spectra) = (lossy(), shot());
    let sampling = Sampling {
        range_hz: [80.0, 2000.0],
        ..Sampling::default()
    };
    let waves = surface.sampled(&sampling, &|| ()).unwrap();
    let twice = SurfaceResistances::new(&surface, 2000.0);
    assert_eq!(twice.bands().last().unwrap().nominal_hz(), 2000.0);
    for (band, ratio) in twice.bands().iter().zip(twice.ratios(&waves, &spectra).unwrap()) {
        if band.low > 100.0 {
            let off = ratio.unwrap() - 1.0;
            assert!(off.abs() < 1e-3, "{:.0} Hz: {off:e}", band.hz);
        }
    }
    let bytes = postcard::to_stdvec(&twice).unwrap();
    assert_eq!(postcard::from_bytes::<SurfaceResistances>(&bytes).unwrap(), twice);
    assert!(postcard::from_bytes::<SurfaceResistances>(&bytes[..bytes.len() - 9]).is_err());
    // A surface that sends out half of it is found out.
    let half = AbsorbingSand {
        resistivity: 2.5e5,
        share: 1.0,
    };
    let other = SurfaceResistances::new(&lossy().with_absorbing_sand(half).unwrap(), 2000.0);
    let worst = other
        .ratios(&waves, &spectra)
        .unwrap()
        .into_iter()
        .flatten()
        .fold(1.0, f64::min);
    assert!(worst < 0.85, "{worst}");
}

/// Moving sand combined with a surface matrix computed in other air agrees with both computed together in that air.
#[test]
fn moving_sand_in_another_air_agrees_with_the_surface_alone() {
    let (standard, cold) = (Air::default(), Air::at(258.15, 85_000.0).unwrap());
    let on_block = |air: &Air| {
        let surface = flat(
            rectangle(FOOTPRINT[0], FOOTPRINT[1], 24, 16),
            &[&|_, _| 1.0, &|x, _| x / 0.2032],
        );
        Rayleigh::new(&surface, air).unwrap()
    };
    let absorbing = AbsorbingSand::default();
    let exact = on_block(&cold)
        .with_moving_sand(sand())
        .unwrap()
        .with_absorbing_sand(absorbing)
        .unwrap();
    let places = [Point3::new(0.5, 0.3, 0.4), Point3::new(0.0, -1.0, 0.6)];
    let sampled = |surface: &Rayleigh, top: f64| {
        let sampling = Sampling {
            range_hz: [40.0, top],
            ..Sampling::default()
        };
        let found = FlushSound::new(surface, &sampling, &places, Point3::origin(), &|| ()).unwrap();
        postcard::from_bytes::<FlushSound>(&postcard::to_stdvec(&found).unwrap()).unwrap()
    };
    let alone = sampled(&on_block(&standard), 4000.0 * FlushSound::WIDEST);
    let found = sampled(&exact, sand().to_hz).continued(alone.in_air(&standard, &cold, Some(absorbing)));
    assert!(found.waves.highest_hz() > 4000.0);
    assert!(found.waves.interpolation_error() < 2e-4);
    let hz = [30.0, 90.0, 433.0, 1290.0, 1499.0, 1501.0, 1650.0, 2870.0, 3990.0];
    let a = DMatrix::from_fn(2, hz.len(), |i, j| {
        Complex::from_polar(1.0 + i as f64, (i * (j + 1)) as f64)
    });
    let forms = found.waves.energy_forms(&hz, &a);
    let signals = found.waves.root_signals(&hz, &a);
    let interpolated = found.pressures.pressures(&found.waves, &hz, &a);
    for (bin, &f) in hz.iter().enumerate() {
        let motion: Vec<Complex<f64>> = a
            .column(bin)
            .iter()
            .map(|x| x / (2.0 * std::f64::consts::PI * f))
            .collect();
        let direct = whole(&exact, f).form(&motion);
        let tolerance = if f < 40.0 { 0.04 } else { 3e-4 };
        for energy in [forms.column(bin).sum(), signals.column(bin).norm_squared()] {
            assert!((energy / direct - 1.0).abs() < tolerance, "{f} Hz: {energy} {direct}");
        }
        let pressures = exact.pressure_at(f, &places).unwrap() * a.column(bin);
        let off = (interpolated.column(bin) - &pressures).norm() / pressures.norm();
        assert!(off < 10.0 * tolerance, "{f} Hz: {off:e}");
    }
    let frequency: Vec<f64> = (0..391).map(|i| 100.0 + 10.0 * f64::from(i)).collect();
    let spectra = ModalSpectra {
        range_hz: [100.0, 4000.0],
        accelerations: DMatrix::from_fn(2, frequency.len(), |i, j| {
            Complex::from_polar(1.0 + i as f64, (0.3 * i as f64 + 0.2) * j as f64)
        }),
        frequency,
    };
    let ratios = found.surface.ratios(&found.waves, &spectra).unwrap();
    assert_eq!(ratios.len(), found.surface.bands().len());
    assert!(ratios.iter().flatten().count() > 15);
    for (ratio, band) in ratios.iter().zip(found.surface.bands()) {
        assert!(
            ratio.is_none_or(|ratio| (ratio - 1.0).abs() < 1e-3),
            "{:.0} Hz: {ratio:?}",
            band.hz
        );
    }
}

/// In any air the sound of block and sand, which few sources make below the sand's limit, is that of all points of the
/// block, mode by mode. Modes that bend are tested as well as those that do not, in two parities and mixed.
#[test]
fn moving_sand_in_cold_and_hot_air_agrees_with_all_points_of_the_block() {
    let bend = |x: f64, y: f64| (7.0 * x).cos() * (20.0 * y).cos() - 0.2;
    let twist = |x: f64, y: f64| (11.0 * x).sin() * (15.0 * y).sin();
    let mixed = |x: f64, y: f64| (23.0 * x + 0.4).cos() * (31.0 * y - 0.2).cos();
    let surface = flat(
        rectangle(FOOTPRINT[0], FOOTPRINT[1], 54, 36),
        &[&|_, _| 1.0, &|x, _| x / 0.2032, &bend, &twist, &mixed],
    );
    let law = MovingSand {
        to_hz: 1000.0,
        ..sand()
    };
    let places = [
        Point3::new(0.9, 0.3, 0.5),
        Point3::new(-0.2, -1.0, 0.3),
        Point3::new(0.0, 0.1, 0.8),
    ];
    let modes = 5;
    let frequency: Vec<f64> = (0..96).map(|i| 45.0 + 10.0 * f64::from(i)).collect();
    let spectra = ModalSpectra {
        range_hz: [45.0, 995.0],
        accelerations: DMatrix::from_fn(modes, frequency.len(), |i, j| {
            Complex::from_polar(1.0 + i as f64, (0.3 * i as f64 + 0.2) * j as f64)
        }),
        frequency,
    };
    for (temperature, pressure) in [(253.15, 80e3), (288.9, 101e3), (313.15, 105e3)] {
        let air = Air::at(temperature, pressure).unwrap();
        let all = Rayleigh::new(&surface, &air).unwrap();
        let all = all
            .with_absorbing_sand(AbsorbingSand::default())
            .unwrap()
            .with_moving_sand(law)
            .unwrap();
        let sampling = Sampling {
            range_hz: [40.0, 1000.0],
            ..Sampling::default()
        };
        let found = FlushSound::new(&all, &sampling, &places, Point3::origin(), &|| ()).unwrap();
        let exact = |hz: f64| {
            let mut sum = Resistance::zeros(modes);
            all.resistance(hz).iter().for_each(|patch| sum.add_scaled(1.0, patch));
            sum
        };
        let signals = found.waves.root_signals(&spectra.frequency, &spectra.accelerations);
        let interpolated = found
            .pressures
            .pressures(&found.waves, &spectra.frequency, &spectra.accelerations);
        for (bin, &hz) in spectra.frequency.iter().enumerate().step_by(7) {
            let (direct, sampled) = (exact(hz), found.waves.resistance(hz));
            let size = |i: usize| direct.real[(i, i)].sqrt();
            for (i, j) in (0..modes).flat_map(|i| (0..modes).map(move |j| (i, j))) {
                let part = |m: &Option<DMatrix<f64>>| m.as_ref().unwrap()[(i, j)];
                let off = (sampled.real[(i, j)] - direct.real[(i, j)])
                    .hypot(part(&sampled.imaginary) - part(&direct.imaginary));
                assert!(
                    off < 1e-4 * size(i) * size(j),
                    "{temperature} K, {hz} Hz, {i} {j}: {off:e}"
                );
            }
            let motion: Vec<Complex<f64>> = spectra.accelerations.column(bin).iter().copied().collect();
            let energy = direct.form(&motion) / (2.0 * std::f64::consts::PI * hz).powi(2);
            let off = signals.column(bin).norm_squared() / energy - 1.0;
            assert!(off.abs() < 3e-4, "{temperature} K, {hz} Hz: signals {off:e}");
            let pressures = all.pressure_at(hz, &places).unwrap() * spectra.accelerations.column(bin);
            let off = (interpolated.column(bin) - &pressures).norm() / pressures.norm();
            assert!(off < 1e-4, "{temperature} K, {hz} Hz: pressure {off:e}");
        }
        // Pair by pair of all points of the block, in the bands' own frequencies.
        for ratio in found
            .surface
            .ratios(&found.waves, &spectra)
            .unwrap()
            .into_iter()
            .flatten()
        {
            assert!((ratio - 1.0).abs() < 1e-4, "{temperature} K: {ratio}");
        }
        let few = found.surface.bands()[9];
        let ratios = SurfaceResistances::new(&all, few.hz)
            .ratios(&found.waves, &spectra)
            .unwrap();
        let off =
            ratios.last().unwrap().unwrap() / found.surface.ratios(&found.waves, &spectra).unwrap()[9].unwrap() - 1.0;
        assert!(off.abs() < 1e-6, "{temperature} K: {off:e}");
        // The radiated energy of a shot.
        let radiated: f64 = found
            .waves
            .energy_forms(&spectra.frequency, &spectra.accelerations)
            .sum();
        let direct: f64 = (0..spectra.frequency.len())
            .map(|bin| {
                let hz = spectra.frequency[bin];
                let motion: Vec<Complex<f64>> = spectra.accelerations.column(bin).iter().copied().collect();
                exact(hz).form(&motion) / (2.0 * std::f64::consts::PI * hz).powi(2)
            })
            .sum();
        assert!(
            (radiated / direct - 1.0).abs() < 2e-5,
            "{temperature} K: {:e}",
            radiated / direct - 1.0
        );
    }
}

#[test]
fn band_fields_have_the_power_and_the_pressures_at_microphones() {
    let (surface, spectra) = (lossy(), shot());
    let sampling = Sampling {
        range_hz: [80.0, 2000.0],
        ..Sampling::default()
    };
    let waves = surface.sampled(&sampling, &|| ()).unwrap();
    let radiated = radiated_energy("block", &waves, &spectra).unwrap();
    let bands: Vec<Band> = (-9..=2).map(Band::new).collect();
    let directions = Directions::new(16, 48, true);
    let points = [Point3::new(0.5, 0.3, 0.4), Point3::new(0.0, -1.0, 0.05)];
    let around = FieldPoints {
        points: &points,
        directions: &directions.vectors,
    };
    let found = band_sound_above_plane(&surface, &bands, &spectra, &around).unwrap();
    assert!(found.error < 1e-2, "{:e}", found.error);
    let pressures = SoundAbovePlane::new(&surface, &waves, &points, Point3::origin()).unwrap();
    let pressures = pressures.pressures(&waves, &spectra.frequency, &spectra.accelerations);
    for (number, band) in bands.iter().enumerate() {
        let range = [band.low, band.high];
        let energy: f64 = found
            .directivity
            .column(number)
            .iter()
            .zip(&directions.weights)
            .map(|(e, w)| e * w)
            .sum();
        let off = 10.0 * (energy / radiated.energy(range, Weighting::Z)).log10();
        assert!(off.abs() < 0.01, "{:.0} Hz: {off} dB", band.hz);
        let weights = nailnoise_acoustics::signals::energy_weights(&spectra.frequency, range, Weighting::Z);
        for point in 0..points.len() {
            let exact: f64 = weights
                .iter()
                .zip(pressures.row(point).iter())
                .map(|(w, p)| 2.0 * w * p.norm_sqr())
                .sum();
            let off = 10.0 * (found.exposure[(point, number)] / exact).log10();
            assert!(off.abs() < 0.01, "{:.0} Hz, at a point: {off} dB", band.hz);
        }
    }
}
