//! The exhaust at a point: directivity, distance and floor.

use nailnoise_acoustics::jets::{
    ExhaustNoise, ExhaustSettings, Floor, FlowHistory, Jet, MixingDirectivity, Opening, Outlet, Recording,
    exhaust_noise,
};
use nailnoise_acoustics::signals::Weighting;
use nailnoise_acoustics::{Air, InputError, ReceiverError};
use std::f64::consts::PI;

const OPENING: Opening = Opening {
    count: 1,
    diameter: 12e-3,
    discharge_coefficient: 0.82,
    pitch: None,
};

/// A burst of 20 ms out of a hole, rising and falling, choked for a part of it.
fn noise() -> ExhaustNoise {
    let air = Air::default();
    let (dt, samples) = (2e-5, 2000);
    let hump = |i: usize| (PI * i as f64 / 1000.0).sin().max(0.0).powi(2) * f64::from(u8::from(i <= 1000));
    let pressure: Vec<f64> = (0..samples).map(|i| air.pressure * (1.0 + 2.0 * hump(i))).collect();
    let flow = |&p: &f64| Jet::expand(p, 290.0, &air).map_or(0.0, |jet| jet.mass_flow(OPENING.effective_area()));
    let history = FlowHistory {
        sample_interval: dt,
        mass_flow: pressure.iter().map(flow).collect(),
        temperature: vec![290.0; samples],
        pressure,
        back_pressure: None,
    };
    exhaust_noise("exhaust", &history, &OPENING, &air, &ExhaustSettings::default()).unwrap()
}

fn upright(height: f64) -> Outlet {
    Outlet {
        position: [0.0, 0.0, height],
        directions: vec![[0.0, 0.0, 2.0]],
    }
}

/// Directions and weights for a mean over the sphere: the midpoint rule in the cosine of the angle from the jet.
fn directions(rings: usize) -> impl Iterator<Item = ([f64; 3], f64)> {
    let around = 6;
    (0..rings).flat_map(move |i| {
        let z = -1.0 + (2.0 * i as f64 + 1.0) / rings as f64;
        let rho = (1.0 - z * z).sqrt();
        (0..around).map(move |j| {
            let phi = 2.0 * PI * j as f64 / around as f64;
            let weight = 1.0 / (rings * around) as f64;
            ([rho * phi.cos(), rho * phi.sin(), z], weight)
        })
    })
}

#[test]
fn directivity_redistributes_power_and_keeps_it() {
    for i in -4..=24 {
        let lg = -0.5 + 0.0375 * f64::from(i + 4);
        let directivity = MixingDirectivity::new(lg);
        let n = 20_000;
        let mean: f64 = (0..n)
            .map(|k| {
                let theta = PI * (f64::from(k) + 0.5) / f64::from(n);
                directivity.at(theta) * 0.5 * theta.sin() * PI / f64::from(n)
            })
            .sum();
        assert!((mean - 1.0).abs() < 1e-6, "lg V* = {lg}: {mean}");
        // The error that the two decimals of the published table leave.
        assert!((10.0 * directivity.table_mean().log10()).abs() < 0.25);
        // Loudest within 50 degrees of the jet, the more so the faster; least behind it.
        let at = |k: i32| directivity.at(f64::from(10 * k).to_radians());
        let loudest = (0..=18).max_by(|&a, &b| at(a).total_cmp(&at(b)));
        assert!(loudest.is_some_and(|k| k <= 5), "{loudest:?}");
        assert!(at(18) < 0.4);
    }
}

/// rho0 c0 E_W is the mean of 4 pi r² E_p over all directions, at any distance and in every part.
#[test]
fn the_field_carries_the_energy_of_the_source() {
    let (noise, air) = (noise(), Air::default());
    let outlet = upright(0.0);
    let range = [50.0, 10_000.0];
    let source: Vec<f64> = noise
        .spectrum
        .contribution_energies(range, Weighting::Z)
        .into_iter()
        .map(|e| e.1)
        .collect();
    for r in [0.7, 3.0] {
        let mut found = [0.0; 3];
        for (unit, weight) in directions(300) {
            let at = noise.at(&outlet, unit.map(|x| r * x), None, &air).unwrap();
            let weights = nailnoise_acoustics::signals::energy_weights(&at.frequency, range, Weighting::Z);
            for (sum, part) in found.iter_mut().zip(&at.parts) {
                let exposure: f64 = weights.iter().zip(&part.energy_density).map(|(w, e)| w * e).sum();
                *sum += weight * exposure * 4.0 * PI * r * r / air.impedance();
            }
        }
        for ((found, source), part) in found.iter().zip(&source).zip(["mixing", "shock", "unsteady flow"]) {
            assert!((found / source - 1.0).abs() < 1e-4, "{part} at {r} m: {found} {source}");
        }
    }
}

#[test]
fn parts_add_up_and_levels_are_those_of_the_exposure() {
    let (noise, air) = (noise(), Air::default());
    let floor = Floor {
        height: 0.0,
        coherence: 0.3,
    };
    let at = noise.at(&upright(0.8), [0.6, -0.4, 1.2], Some(&floor), &air).unwrap();
    for (k, total) in at.exposure_density.iter().enumerate() {
        let sum: f64 = at.parts.iter().map(|part| part.energy_density[k]).sum();
        assert!((sum / total - 1.0).abs() < 1e-14);
    }
    let range = [50.0, 10_000.0];
    let exposure = at.exposure(range, Weighting::A);
    let level = at.level(range, Weighting::A).unwrap();
    assert!((10f64.powf(0.1 * level) * 4e-10 / exposure - 1.0).abs() < 1e-12);
    // Twice the distance in free space: 6.02 dB.
    let far = |r: f64| {
        noise
            .at(&upright(0.0), [r, 0.0, 0.0], None, &air)
            .unwrap()
            .level(range, Weighting::A)
            .unwrap()
    };
    assert!((far(1.0) - far(2.0) - 20.0 * 2f64.log10()).abs() < 1e-9);
}

/// |e^{-jkr}/r + e^{-jkr'}/r'|² for the point source, the sum of energies for jets without coherence.
#[test]
fn the_floor_is_an_image_source() {
    let (noise, air) = (noise(), Air::default());
    let (outlet, point): (Outlet, [f64; 3]) = (upright(0.6), [0.9, 0.5, 0.3]);
    let across2 = 0.9f64.powi(2) + 0.5f64.powi(2);
    let (r, image) = ((across2 + 0.3f64.powi(2)).sqrt(), (across2 + 0.9f64.powi(2)).sqrt());
    let floor = |coherence: f64| Floor { height: 0.0, coherence };
    let free = noise.at(&outlet, point, None, &air).unwrap();
    let mirrored = noise.at(&outlet, [point[0], point[1], -point[2]], None, &air).unwrap();
    let both = noise.at(&outlet, point, Some(&floor(0.0)), &air).unwrap();
    let coherent = noise.at(&outlet, point, Some(&floor(1.0)), &air).unwrap();
    let mut swing = (f64::INFINITY, 0.0f64);
    for (k, hz) in both.frequency.iter().enumerate() {
        let phase = 2.0 * PI * hz / air.sound_speed * (image - r);
        let closed = 1.0 / (r * r) + 1.0 / (image * image) + 2.0 * phase.cos() / (r * image);
        let outflow = both.parts[2].energy_density[k] / free.parts[2].energy_density[k];
        assert!(
            (outflow - closed * r * r).abs() < 1e-9 * closed * r * r + 1e-12,
            "{hz} Hz"
        );
        for part in 0..2 {
            let of = |x: &nailnoise_acoustics::jets::ReceivedNoise| x.parts[part].energy_density[k];
            let (sum, cross) = (of(&free) + of(&mirrored), 2.0 * (of(&free) * of(&mirrored)).sqrt());
            assert!((of(&both) / sum - 1.0).abs() < 1e-9, "{hz} Hz");
            // Bursts differ in directivity, so that the mean of products lies below the product of means.
            let ratio = (of(&coherent) - sum) / cross;
            assert!(ratio.abs() <= 1.0 + 1e-9, "{hz} Hz: {ratio}");
            if part == 1 {
                // Shock noise has no directivity: the closed form again.
                assert!((of(&coherent) / of(&free) - closed * r * r).abs() < 1e-6, "{hz} Hz");
                swing = (swing.0.min(ratio), swing.1.max(ratio));
            }
        }
    }
    assert!(swing.0 < -0.99 && swing.1 > 0.99, "{swing:?}");
    // On the floor itself both ways are one: four times the energy of a point source.
    let lying = noise.at(&outlet, [0.9, 0.5, 0.0], Some(&floor(1.0)), &air).unwrap();
    let alone = noise.at(&outlet, [0.9, 0.5, 0.0], None, &air).unwrap();
    for part in 0..3 {
        let ratio = lying.parts[part].energy_density[700] / alone.parts[part].energy_density[700];
        assert!((ratio - 4.0).abs() < 1e-9, "{part}: {ratio}");
    }
}

#[test]
fn jets_that_fan_out_share_the_energy() {
    let (noise, air) = (noise(), Air::default());
    let point = [1.0, 0.2, 0.4];
    let outlet = |directions: Vec<[f64; 3]>| Outlet {
        position: [0.0; 3],
        directions,
    };
    let ways = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];
    let fan = noise.at(&outlet(ways.to_vec()), point, None, &air).unwrap();
    let single = ways.map(|way| noise.at(&outlet(vec![way]), point, None, &air).unwrap());
    for k in (0..fan.frequency.len()).step_by(53) {
        let mean = single.iter().map(|s| s.exposure_density[k]).sum::<f64>() / 3.0;
        assert!((fan.exposure_density[k] / mean - 1.0).abs() < 1e-12);
    }
    // Downstream is louder than upstream.
    let level = |s: &nailnoise_acoustics::jets::ReceivedNoise| s.level([1000.0, 10_000.0], Weighting::Z).unwrap();
    assert!(level(&single[0]) > level(&single[2]) + 3.0);
}

#[test]
fn impossible_places_are_refused_by_name() {
    let (noise, air) = (noise(), Air::default());
    let floor = Floor {
        height: 0.0,
        coherence: 0.0,
    };
    let run = |outlet: &Outlet, point: [f64; 3], floor: &Floor| noise.at(outlet, point, Some(floor), &air).unwrap_err();
    assert!(matches!(
        run(&upright(0.5), [0.0, 0.0, 0.5], &floor),
        ReceiverError::Input(InputError::NotPositive { .. })
    ));
    let error = run(&upright(0.5), [1.0, 0.0, -0.1], &floor);
    assert!(
        matches!(error, ReceiverError::BelowFloor { .. }) && error.to_string().contains("-0.1 m"),
        "{error}"
    );
    assert!(matches!(
        run(&upright(-0.5), [1.0, 0.0, 0.1], &floor),
        ReceiverError::BelowFloor { .. }
    ));
    assert!(matches!(
        run(
            &upright(0.5),
            [1.0, 0.0, 0.1],
            &Floor {
                coherence: 1.5,
                ..floor
            }
        ),
        ReceiverError::Input(InputError::OutsideRange { .. })
    ));
    for directions in [vec![], vec![[0.0; 3]]] {
        let outlet = Outlet {
            position: [0.0, 0.0, 1.0],
            directions,
        };
        assert!(matches!(
            run(&outlet, [1.0, 0.0, 0.1], &floor),
            ReceiverError::Input(InputError::NotPositive { .. })
        ));
    }
}

#[test]
fn a_signal_of_a_blow_down_has_the_expected_exposure() {
    let (air, noise) = (Air::default(), noise());
    let outlet = Outlet {
        position: [0.0, 0.0, 1.0],
        directions: vec![[1.0, 0.0, 0.0]],
    };
    let floor = Floor {
        height: 0.0,
        coherence: 0.0,
    };
    let point = [0.8, 1.1, 0.7];
    let expected = noise.at(&outlet, point, Some(&floor), &air).unwrap();
    let record = |seed: u64| {
        let recording = Recording {
            rate: 48_000.0,
            samples: 9600,
            seed,
        };
        noise.sound_at(&outlet, point, Some(&floor), &air, &recording).unwrap()
    };
    let seeds = 20;
    let mean: f64 = (0..seeds)
        .map(|seed| record(seed).iter().map(|p| p * p).sum::<f64>() / 48_000.0)
        .sum::<f64>()
        / seeds as f64;
    let difference = 10.0 * (mean / expected.exposure([20.0, 20_000.0], Weighting::Z)).log10();
    assert!(difference.abs() < 0.2, "{difference} dB");
    assert_eq!(record(3), record(3));
    assert_ne!(record(3), record(4));
    // Nothing of the jets is heard before the sound has travelled, but the window's foot and the outflow's band limit.
    let first = record(3);
    let travel = (point[0].hypot(point[1]).hypot(0.3) / air.sound_speed * 48_000.0) as usize;
    let peak = |part: &[f64]| part.iter().fold(0.0f64, |peak, p| peak.max(p.abs()));
    assert!(
        peak(&first[..travel - 130]) < 0.05 * peak(&first),
        "{}",
        peak(&first[..travel - 130])
    );
}
