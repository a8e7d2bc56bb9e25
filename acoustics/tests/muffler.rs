//! Mufflers against closed forms and laws.
#![allow(clippy::unwrap_used)]

use nailnoise_acoustics::jets::{ExhaustSettings, FlowHistory, Opening, exhaust_noise};
use nailnoise_acoustics::muffler::{
    BandLosses, FourPole, Lining, Muffler, MufflerChain, MufflerElement, MufflerError, miki_fluid, open_end,
};
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::signals::{Weighting, energy_level};
use nailnoise_acoustics::{AcousticsError, Air, InputError};
use nalgebra::Complex;
use proptest::prelude::*;
use std::f64::consts::PI;

const FELT: Lining = Lining {
    thickness: 5e-3,
    resistivity: 2e4,
};

fn pipe(length: f64, diameter: f64, lining: Option<Lining>) -> MufflerElement {
    MufflerElement {
        length,
        diameter,
        lining,
    }
}

fn chamber(length: f64, diameter: f64, outlet_diameter: f64) -> MufflerChain {
    MufflerChain {
        elements: vec![pipe(length, diameter, None)],
        outlet_diameter,
        outlet_mach: 0.0,
    }
}

#[test]
fn an_expansion_chamber_has_its_closed_form() {
    let air = Air::default();
    for (length, wide, narrow) in [(0.1, 0.03, 0.01), (0.037, 0.025, 0.024), (0.3, 0.01, 0.03)] {
        let chain = chamber(length, wide, narrow);
        let m = (wide / narrow).powi(2);
        for i in 1..400 {
            let hz = 15.0 * f64::from(i);
            let sine = (2.0 * PI * hz / air.sound_speed * length).sin();
            let closed = 10.0 * (1.0 + 0.25 * (m - 1.0 / m).powi(2) * sine * sine).log10();
            let found = chain.transmission_loss(hz, narrow, &air).unwrap();
            assert!(
                (found - closed).abs() < 1e-10,
                "{length} {m} {hz}: {found} against {closed}"
            );
        }
    }
}

#[test]
fn a_change_of_area_transmits_what_impedances_allow() {
    let air = Air::default();
    let chain = MufflerChain {
        elements: Vec::new(),
        outlet_diameter: 0.01,
        outlet_mach: 0.0,
    };
    // TL = 10 lg((1 + m)² / 4 m).
    let m: f64 = 9.0;
    let found = chain.transmission_loss(500.0, 0.03, &air).unwrap();
    assert!((found - 10.0 * ((1.0 + m).powi(2) / (4.0 * m)).log10()).abs() < 1e-12);
}

/// A chamber, a lined pipe and a narrow pipe.
fn chain() -> MufflerChain {
    MufflerChain {
        elements: vec![
            pipe(0.05, 0.03, None),
            pipe(0.04, 0.012, Some(FELT)),
            pipe(0.02, 0.008, None),
        ],
        outlet_diameter: 0.008,
        outlet_mach: 0.0,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn products_of_four_poles_are_reciprocal(hz in 20.0f64..6000.0, l in 0.005f64..0.2, t in 1e-3f64..2e-2) {
        let air = Air::default();
        let mut chain = chain();
        chain.elements[0].length = l;
        chain.elements.push(pipe(l, 0.02, Some(Lining { thickness: t, resistivity: 1e4 })));
        let product = chain.four_pole(hz, &air).unwrap();
        // The entries grow with the attenuation, and round-off with them.
        let size = (product.a * product.d).norm().max(1.0);
        prop_assert!((product.determinant() - Complex::ONE).norm() < 1e-11 * size);
    }

    #[test]
    fn transmission_loss_is_the_same_both_ways(hz in 20.0f64..6000.0) {
        let air = Air::default();
        let forward = chain();
        let mut backward = chain();
        backward.elements.reverse();
        backward.outlet_diameter = 0.03;
        let (there, back) =
            (forward.transmission_loss(hz, 0.03, &air).unwrap(), backward.transmission_loss(hz, 0.008, &air).unwrap());
        prop_assert!((there - back).abs() < 1e-8, "{} {}", there, back);
        prop_assert!(there >= 0.0);
    }
}

#[test]
fn a_lined_pipe_attenuates_by_its_length() {
    let air = Air::default();
    let hz = 2000.0;
    let loss = |length: f64| {
        let chain = MufflerChain {
            elements: vec![pipe(length, 0.02, Some(FELT))],
            outlet_diameter: 0.02,
            outlet_mach: 0.0,
        };
        chain.transmission_loss(hz, 0.02, &air).unwrap()
    };
    // k_z² = k² - j k beta P/S: a long pipe loses 8.686 |Im k_z| dB per metre.
    let k = 2.0 * PI * hz / air.sound_speed;
    let beta = FELT.admittance(hz, &air).unwrap();
    let along = (Complex::from(k * k) - Complex::<f64>::i() * k * beta * 200.0).sqrt();
    let per_metre = 20.0 / 10f64.ln() * -along.im;
    assert!(per_metre > 10.0, "{per_metre}");
    assert!(
        ((loss(1.3) - loss(1.2)) / 0.1 - per_metre).abs() < 1e-3 * per_metre,
        "{} {per_metre}",
        loss(1.3)
    );
    // Without a lining nothing is lost.
    let bare = MufflerChain {
        elements: vec![pipe(1.0, 0.02, None)],
        outlet_diameter: 0.02,
        outlet_mach: 0.0,
    };
    assert!(bare.transmission_loss(hz, 0.02, &air).unwrap().abs() < 1e-10);
}

#[test]
fn a_thin_lining_is_a_compliance_and_absorbs() {
    let air = Air::default();
    let lining = Lining {
        thickness: 1e-5,
        resistivity: 1e4,
    };
    // tan(k t) -> k t: beta -> j k t rho c / Z.
    let (z, k) = miki_fluid(500.0, 1e4, &air);
    let expected = Complex::<f64>::i() * k * 1e-5 / z;
    assert!((lining.admittance(500.0, &air).unwrap() - expected).norm() < 1e-6 * expected.norm());
    for hz in [50.0, 300.0, 1000.0, 8000.0] {
        assert!(FELT.admittance(hz, &air).unwrap().re > 0.0);
    }
}

#[test]
fn insertion_loss_follows_the_volume_flow() {
    let air = Air::default();
    let chain = MufflerChain {
        elements: vec![pipe(0.05, 0.03, None), pipe(0.05, 0.01, None)],
        outlet_diameter: 0.01,
        outlet_mach: 0.0,
    };
    // At low frequency the chamber is a compliance before the pipe's mass: a low-pass with a resonance.
    let losses = (5..800).map(|i| (f64::from(i), chain.insertion_loss(f64::from(i), &air).unwrap()));
    let (hz, loss) = losses.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let volume = 0.05 * 0.25 * PI * 0.03 * 0.03;
    // The pipe with the mass of its open end, l' = l + 0.6133 a.
    let f0 = air.sound_speed / (2.0 * PI) * (0.25 * PI * 1e-4 / (volume * (0.05 + 0.6133 * 0.005))).sqrt();
    assert!((hz / f0 - 1.0).abs() < 0.05, "{hz} {f0}");
    assert!(loss < 0.0);
    assert!(chain.insertion_loss(1.0, &air).unwrap().abs() < 1e-3);
    let load = open_end(100.0, 0.01, &air);
    assert!((FourPole::IDENTITY.flow_loss(load)).abs() < 1e-12);
}

#[test]
fn the_outlets_jet_damps_the_resonance() {
    let air = Air::default();
    let chain = |outlet_mach: f64| MufflerChain {
        elements: vec![pipe(0.06, 0.03, None), pipe(0.02, 0.0146, None)],
        outlet_diameter: 0.0146,
        outlet_mach,
    };
    let least = |mach: f64| {
        let losses = (50..2000).map(|hz| chain(mach).insertion_loss(f64::from(hz), &air).unwrap());
        losses.fold(f64::INFINITY, f64::min)
    };
    let machs = [0.0, 0.05, 0.2, 0.8];
    let losses = machs.map(least);
    assert!(losses.windows(2).all(|pair| pair[1] > pair[0]), "{losses:?}");
    // A Helmholtz resonator: peak |U_outlet/U_source| = 1/(omega_0 V/(S c) M) once the jet's resistance rules.
    let (area, volume) = (0.25 * PI * 0.0146 * 0.0146, 0.06 * 0.25 * PI * 0.03 * 0.03);
    let length = 0.02 + 0.6133 * 0.0073;
    let quality = area / (0.2 * (area * volume / length).sqrt());
    let found = -least(0.2) / 20.0;
    assert!(
        (found - 0.5 * (quality * quality).log10()).abs() < 0.2,
        "{found} {quality}"
    );
}

#[test]
fn mufflers_outside_their_range_are_refused_by_name() {
    let air = Air::default();
    let chain = chamber(0.1, 0.03, 0.01);
    let highest = chain.elements[0].highest_hz(&air);
    assert!((highest - 6705.0).abs() < 20.0, "{highest}");
    let error = chain.transmission_loss(1.01 * highest, 0.01, &air).unwrap_err();
    assert!(matches!(error, MufflerError::NotPlaneWaves { .. }), "{error}");
    assert!(
        error.to_string().contains("0.03 m") && error.to_string().contains("670"),
        "{error}"
    );
    let lined = pipe(
        0.1,
        0.01,
        Some(Lining {
            resistivity: 1000.0,
            ..FELT
        }),
    );
    assert!(matches!(
        lined.four_pole(1500.0, &air),
        Err(MufflerError::Input(InputError::OutsideRange { .. }))
    ));
    assert!(matches!(
        pipe(0.0, 0.01, None).four_pole(100.0, &air),
        Err(MufflerError::Input(InputError::NotPositive { .. }))
    ));
    for bad in [
        &[(100.0, 3.0), (160.0, 4.0)][..],
        &[][..],
        &[(200.0, 1.0), (160.0, 1.0)][..],
    ] {
        assert!(
            matches!(BandLosses::new(bad), Err(MufflerError::Bands { .. })),
            "{bad:?}"
        );
    }
    let losses = BandLosses::new(&[(100.0, 3.0), (125.0, 4.0)]).unwrap();
    assert_eq!(losses.decibels(130.0).unwrap(), 4.0);
    assert!(losses.decibels(60.0).is_err() && losses.decibels(150.0).is_err());
    assert!(losses.range_hz()[0] < 90.0 && losses.range_hz()[1] > 140.0);
}

#[test]
fn a_muffler_lowers_every_component_and_every_interval() {
    let air = Air::default();
    let samples = 4000;
    let flow = FlowHistory {
        back_pressure: None,
        sample_interval: 2e-5,
        mass_flow: (0..samples)
            .map(|i| {
                if i > 400 {
                    0.02 * (-f64::from(i) * 2e-3).exp()
                } else {
                    0.0
                }
            })
            .collect(),
        pressure: vec![2.5e5; samples as usize],
        temperature: vec![290.0; samples as usize],
    };
    let opening = Opening {
        count: 7,
        diameter: 5e-3,
        discharge_coefficient: 0.82,
        pitch: None,
    };
    let nominal = [
        50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0, 500.0, 630.0, 800.0, 1000.0, 1250.0, 1600.0,
        2000.0, 2500.0, 3150.0, 4000.0, 5000.0,
    ];
    let bands: Vec<(f64, f64)> = nominal.iter().map(|&hz| (hz, 10.0)).collect();
    let with = |muffler: Option<Muffler>, low: f64| {
        let settings = ExhaustSettings {
            transform: TransformSettings {
                range_hz: [low, 5000.0],
                ..TransformSettings::default()
            },
            muffler,
            ..ExhaustSettings::default()
        };
        exhaust_noise("exhaust", &flow, &opening, &air, &settings)
    };
    let range = [60.0, 5000.0];
    let (open, muffled) = (
        with(None, 50.0).unwrap(),
        with(Some(Muffler::InsertionLoss(BandLosses::new(&bands).unwrap())), 50.0).unwrap(),
    );
    let parts = |n: &nailnoise_acoustics::jets::ExhaustNoise| n.spectrum.contribution_energies(range, Weighting::Z);
    for ((name, before), (_, after)) in parts(&open).into_iter().zip(parts(&muffled)) {
        assert!((before / after / 10.0 - 1.0).abs() < 1e-12, "{name}");
    }
    let (_, before) = open.history.analyse(&[0.0, 0.02, 0.05], range);
    let (_, after) = muffled.history.analyse(&[0.0, 0.02, 0.05], range);
    for (before, after) in before.iter().zip(&after) {
        assert!((before.energy / after.energy / 10.0 - 1.0).abs() < 1e-9);
    }
    let total: f64 = after.iter().map(|i| i.energy).sum();
    assert!((total / muffled.spectrum.energy(range, Weighting::A) - 1.0).abs() < 1e-9);
    assert!(energy_level(total) < energy_level(before.iter().map(|i| i.energy).sum()));
    // Bands that do not reach down to the analysed range.
    let short = Muffler::InsertionLoss(BandLosses::new(&bands[3..]).unwrap());
    assert!(matches!(
        with(Some(short), 50.0),
        Err(AcousticsError::Muffler(MufflerError::Bands { .. }))
    ));
    let wide = Muffler::Chain(chamber(0.1, 0.06, 0.02));
    assert!(matches!(
        with(Some(wide), 50.0),
        Err(AcousticsError::Muffler(MufflerError::NotPlaneWaves { .. }))
    ));
}

/// The noise of a burst of a length \[samples\] behind a muffler, over the range \[Hz\].
fn behind(muffler: Muffler, samples: usize, range_hz: [f64; 2]) -> Result<f64, AcousticsError> {
    let flow = FlowHistory {
        back_pressure: None,
        sample_interval: 1e-5,
        mass_flow: (0..samples).map(|i| 0.02 * (-(i as f64) * 1e-3).exp()).collect(),
        pressure: vec![2.5e5; samples],
        temperature: vec![290.0; samples],
    };
    let opening = Opening {
        count: 7,
        diameter: 5e-3,
        discharge_coefficient: 0.82,
        pitch: None,
    };
    let settings = ExhaustSettings {
        transform: TransformSettings {
            range_hz,
            ..TransformSettings::default()
        },
        muffler: Some(muffler),
        ..ExhaustSettings::default()
    };
    let noise = exhaust_noise("exhaust", &flow, &opening, &Air::default(), &settings)?;
    Ok(noise.spectrum.energy(range_hz, Weighting::Z))
}

/// Whatever the length of a record, its bins reach beyond a range that begins or ends where the muffler is last known.
#[test]
fn a_muffler_is_asked_for_no_frequency_outside_the_range() {
    let bands: Vec<(f64, f64)> = (-13..=13)
        .map(|k| (1000.0 * 10f64.powf(0.1 * f64::from(k)), 10.0))
        .collect();
    let losses = BandLosses::new(&bands).unwrap();
    let [low, high] = losses.range_hz();
    let lined = Lining {
        resistivity: 5000.0,
        ..FELT
    };
    let chain = |elements| {
        Muffler::Chain(MufflerChain {
            elements,
            outlet_diameter: 0.01,
            outlet_mach: 0.3,
        })
    };
    let highest = pipe(0.1, 0.03, None).highest_hz(&Air::default());
    for samples in (3000..9000).step_by(371) {
        for (muffler, range) in [
            (Muffler::InsertionLoss(losses.clone()), [low, high.next_down()]),
            (chain(vec![pipe(0.1, 0.03, None)]), [50.0, highest]),
            (chain(vec![pipe(0.1, 0.01, Some(lined))]), [50.0, 5000.0]),
        ] {
            let found = behind(muffler, samples, range);
            assert!(found.as_ref().is_ok_and(|energy| *energy > 0.0), "{samples}: {found:?}");
        }
    }
}
