//! Laws of the exhaust's noise.

use nailnoise_acoustics::jets::{
    ExhaustError, ExhaustNoise, ExhaustSettings, FlowHistory, Jet, Opening, PlenumResonance, ValveNoise, exhaust_noise,
    fine_scale_shape, mixing_power, screech_frequency, screech_track, shock_power,
};
use nailnoise_acoustics::signals::Weighting;
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::{AcousticsError, Air, GAS_CONSTANT, HEAT_RATIO, InputError};
use std::f64::consts::PI;

const HOLES: Opening = Opening {
    count: 7,
    diameter: 5e-3,
    discharge_coefficient: 0.82,
    pitch: Some(16e-3),
};

/// Isothermal blow-down of a volume through an opening with the full pressure before it.
fn blow_down(volume: f64, opening: &Opening, pressure: f64, dt: f64, seconds: f64) -> FlowHistory {
    let air = Air::default();
    let (mut p, t) = (pressure, air.temperature);
    let (mut flow, mut pressures) = (Vec::new(), Vec::new());
    for _ in 0..(seconds / dt) as usize {
        let m = |p: f64| Jet::expand(p, t, &air).map_or(0.0, |jet| jet.mass_flow(opening.effective_area()));
        flow.push(m(p));
        pressures.push(p);
        let rate = |p: f64| -m(p) * GAS_CONSTANT * t / volume;
        let k1 = rate(p);
        let k2 = rate(p + 0.5 * dt * k1);
        p += dt * k2;
    }
    FlowHistory {
        back_pressure: None,
        sample_interval: dt,
        temperature: vec![t; flow.len()],
        mass_flow: flow,
        pressure: pressures,
    }
}

fn noise(history: &FlowHistory, opening: &Opening) -> ExhaustNoise {
    exhaust_noise(
        "exhaust",
        history,
        opening,
        &Air::default(),
        &ExhaustSettings::default(),
    )
    .unwrap()
}

#[test]
fn the_jet_carries_the_isentropic_mass_flow() {
    let air = Air::default();
    // Choked: m' = A P sqrt(g/(R T)) (2/(g+1))^((g+1)/(2(g-1))).
    let (p, t, area) = (6e5, 280.0, 1e-4);
    let g: f64 = HEAT_RATIO;
    let choked = area * p * (g / (GAS_CONSTANT * t)).sqrt() * (2.0 / (g + 1.0)).powf((g + 1.0) / (2.0 * (g - 1.0)));
    let jet = Jet::expand(p, t, &air).unwrap();
    assert!((jet.mass_flow(area) / choked - 1.0).abs() < 1e-12);
    // Energy: c_p T = c_p T_j + U²/2.
    let cp = g / (g - 1.0) * GAS_CONSTANT;
    assert!((cp * (t - jet.temperature) / (0.5 * jet.velocity.powi(2)) - 1.0).abs() < 1e-12);
    // Mach 2 in the tables of isentropic flow: P_0/P = 1.8^3.5, A/A* = 1.6875.
    let mach2 = Jet::expand(air.pressure * 1.8f64.powf(3.5), t, &air).unwrap();
    assert!((mach2.mach - 2.0).abs() < 1e-12 && (mach2.area(1.0) - 1.6875).abs() < 1e-12);
    assert!(Jet::expand(air.pressure, t, &air).is_none());
    assert!(Jet::expand(0.9 * air.pressure, t, &air).is_none());
}

#[test]
fn energy_of_a_full_blow_down_does_not_depend_on_hole_area() {
    let volume = 3e-4;
    let one = Opening {
        count: 1,
        diameter: 8e-3,
        discharge_coefficient: 0.82,
        pitch: None,
    };
    let wide = Opening { diameter: 16e-3, ..one };
    let a = noise(&blow_down(volume, &one, 7e5, 4e-6, 0.2), &one);
    let b = noise(&blow_down(volume, &wide, 7e5, 1e-6, 0.05), &wide);
    let db = |x: f64, y: f64| (10.0 * (x / y).log10()).abs();
    assert!(
        db(a.mixing_energy, b.mixing_energy) < 0.005,
        "{} {}",
        a.mixing_energy,
        b.mixing_energy
    );
    assert!(
        db(a.shock_energy, b.shock_energy) < 0.005,
        "{} {}",
        a.shock_energy,
        b.shock_energy
    );
    assert!((a.mass / a.jet_mass - 1.0).abs() < 1e-12);
}

#[test]
fn energy_grows_by_3_db_per_doubling_of_volume() {
    let a = noise(&blow_down(2e-4, &HOLES, 7e5, 4e-6, 0.06), &HOLES);
    let b = noise(&blow_down(4e-4, &HOLES, 7e5, 8e-6, 0.12), &HOLES);
    for (x, y) in [(a.mixing_energy, b.mixing_energy), (a.shock_energy, b.shock_energy)] {
        assert!((10.0 * (y / x).log10() - 10.0 * 2f64.log10()).abs() < 1e-6);
    }
}

#[test]
fn restriction_before_the_plenum_lowers_the_noise() {
    let free = blow_down(3e-4, &HOLES, 7e5, 4e-6, 0.1);
    // The same flow with half the overpressure left at the holes.
    let air = Air::default();
    let mut throttled = free.clone();
    throttled
        .pressure
        .iter_mut()
        .for_each(|p| *p = air.pressure + 0.5 * (*p - air.pressure));
    assert!(noise(&throttled, &HOLES).mixing_energy < 0.5 * noise(&free, &HOLES).mixing_energy);
}

#[test]
fn mixing_noise_grows_with_the_eighth_power_at_low_speed() {
    let air = Air::default();
    let power = |p: f64| {
        let jet = Jet::expand(air.pressure + p, air.temperature, &air).unwrap();
        (jet.velocity, mixing_power(&jet, 1e-4, &air))
    };
    let ((u1, w1), (u2, w2)) = (power(200.0), power(1200.0));
    let exponent = (w2 / w1).ln() / (u2 / u1).ln();
    // The jet is as dense as the air here, so the density exponent does not show.
    assert!((exponent - 8.0).abs() < 0.01, "{exponent}");
}

#[test]
fn shock_noise_begins_at_mach_1_and_changes_its_power_law_at_beta_1() {
    let air = Air::default();
    let at = |mach: f64| {
        let p = air.pressure * (1.0 + 0.2 * mach * mach).powf(3.5);
        shock_power(&Jet::expand(p, air.temperature, &air).unwrap(), 1e-4, &air)
    };
    let beta = |m: f64| (m * m - 1.0f64).sqrt();
    assert_eq!(at(0.999), 0.0);
    let slope = |a: f64, b: f64| (at(b) / at(a)).ln() / (beta(b) / beta(a)).ln();
    assert!((slope(1.1, 1.3) - 4.0).abs() < 1e-9);
    assert!((slope(1.5, 1.8) - 1.0).abs() < 1e-9);
}

#[test]
fn the_similarity_spectrum_joins_and_peaks_at_one() {
    for joint in [0.05, 0.15, 1.0, 10.0, 30.0] {
        let (below, above) = (
            fine_scale_shape(joint * (1.0 - 1e-12)),
            fine_scale_shape(joint * (1.0 + 1e-12)),
        );
        assert!((below - above).abs() < 2e-3, "at {joint}: {below} {above} dB");
        let h = 1e-4;
        let slope = |x: f64| (fine_scale_shape(x * (1.0 + h)) - fine_scale_shape(x * (1.0 - h))) / (2.0 * h);
        let (left, right) = (slope(joint * (1.0 - 2.0 * h)), slope(joint * (1.0 + 2.0 * h)));
        assert!(
            (left - right).abs() < 0.05,
            "slopes at {joint}: {left} {right} dB per e-fold"
        );
    }
    assert_eq!(fine_scale_shape(1.0), 0.0);
    assert!((1..4000).all(|i| fine_scale_shape(f64::from(i) * 0.01) <= 0.0));
}

#[test]
fn the_spectrum_holds_the_power_of_the_jets() {
    // Large holes, so that next to nothing lies above the analysed range.
    let opening = Opening {
        count: 1,
        diameter: 0.2,
        discharge_coefficient: 0.8,
        pitch: None,
    };
    let history = FlowHistory {
        back_pressure: None,
        sample_interval: 4e-6,
        mass_flow: vec![1.0; 10_000],
        pressure: (0..10_000).map(|i| 2.5e5 + 30.0 * f64::from(i)).collect(),
        temperature: vec![290.0; 10_000],
    };
    let transform = TransformSettings {
        range_hz: [1.0, 100_000.0],
        ..TransformSettings::default()
    };
    let settings = ExhaustSettings {
        transform,
        plenum: None,
        fitting: None,
        muffler: None,
        unsteady_flow: true,
    };
    let noise = exhaust_noise("exhaust", &history, &opening, &Air::default(), &settings).unwrap();
    let energies = noise.spectrum.contribution_energies([1.0, 100_000.0], Weighting::Z);
    assert!(
        (energies[0].1 / noise.mixing_energy - 1.0).abs() < 2e-3,
        "{energies:?} {}",
        noise.mixing_energy
    );
    assert!(
        (energies[1].1 / noise.shock_energy - 1.0).abs() < 2e-2,
        "{energies:?} {}",
        noise.shock_energy
    );
    let total = noise.spectrum.energy([1.0, 100_000.0], Weighting::Z);
    assert!((energies.iter().map(|e| e.1).sum::<f64>() / total - 1.0).abs() < 1e-12);
}

#[test]
fn the_histogram_keeps_the_spectrum_of_a_steady_jet() {
    let air = Air::default();
    let (p, t) = (5e5, 270.0);
    let history = FlowHistory {
        back_pressure: None,
        sample_interval: 4e-6,
        mass_flow: vec![0.05; 20_000],
        pressure: vec![p; 20_000],
        temperature: vec![t; 20_000],
    };
    let noise = noise(&history, &HOLES);
    let jet = Jet::expand(p, t, &air).unwrap();
    let peak = 0.2 * jet.velocity / (jet.diameter_ratio * HOLES.diameter);
    let mixing = &noise.spectrum.contributions[0].energy_density;
    let reference = noise.spectrum.frequency.iter().position(|&f| f > 3000.0).unwrap();
    let shape = |i: usize| 10f64.powf(0.1 * fine_scale_shape(noise.spectrum.frequency[i] / peak));
    for i in (0..mixing.len()).step_by(37) {
        let error = mixing[i] / mixing[reference] * shape(reference) / shape(i) - 1.0;
        assert!(error.abs() < 1e-3, "{} Hz: {error}", noise.spectrum.frequency[i]);
    }
}

#[test]
fn the_monopole_matches_its_closed_form() {
    // m'(t) = m exp(-((t - t0)/s)^2/2): F{dm'/dt} = 2 pi f m s sqrt(2 pi) exp(-(2 pi f s)^2/2) in magnitude.
    let air = Air::default();
    let (dt, n, t0, s, m, t) = (4e-6, 20_000, 0.03, 1e-4, 0.05, 250.0);
    let flow = (0..n)
        .map(|i| m * (-0.5 * ((f64::from(i) * dt - t0) / s).powi(2)).exp())
        .collect();
    let history = FlowHistory {
        back_pressure: None,
        sample_interval: dt,
        mass_flow: flow,
        // So little above ambient that the jets are silent compared with the monopole.
        pressure: vec![air.pressure * (1.0 + 1e-12); n as usize],
        temperature: vec![t; n as usize],
    };
    let noise = noise(&history, &HOLES);
    assert!(
        noise.mixing_energy < 1e-30 && noise.shock_energy == 0.0,
        "{}",
        noise.mixing_energy
    );
    let scale = m * t / air.temperature * s * (2.0 * PI).sqrt();
    for (f, e) in noise
        .spectrum
        .frequency
        .iter()
        .zip(&noise.spectrum.energy_density)
        .filter(|(f, _)| **f < 6000.0)
    {
        let w = 2.0 * PI * f;
        let exact = 2.0 * (w * scale * (-0.5 * (w * s).powi(2)).exp()).powi(2) / (4.0 * PI * air.impedance());
        assert!((e / exact - 1.0).abs() < 1e-8, "{f} Hz: {e} {exact}");
    }
}

#[test]
fn the_plenum_filters_the_unsteady_flow_only() {
    let history = blow_down(3e-4, &HOLES, 7e5, 4e-6, 0.1);
    let plenum = PlenumResonance {
        volume: 1e-4,
        neck_length: 8e-3,
        quality: 2.0,
    };
    let settings = ExhaustSettings {
        plenum: Some(plenum),
        ..ExhaustSettings::default()
    };
    let air = Air::default();
    let filtered = exhaust_noise("exhaust", &history, &HOLES, &air, &settings)
        .unwrap()
        .spectrum;
    let free = noise(&history, &HOLES).spectrum;
    assert_eq!(filtered.contributions[0], free.contributions[0]);
    let f0 = plenum.frequency(&HOLES, air.temperature, &air);
    let at = (0..free.frequency.len()).min_by(|&i, &j| {
        (free.frequency[i] - f0)
            .abs()
            .total_cmp(&(free.frequency[j] - f0).abs())
    });
    let gain = |i: usize| filtered.contributions[2].energy_density[i] / free.contributions[2].energy_density[i];
    assert!(
        (gain(at.unwrap()) / plenum.quality.powi(2) - 1.0).abs() < 0.02,
        "Q² at the resonance"
    );
    assert!((gain(0) - 1.0).abs() < 0.01);
    assert!(gain(free.frequency.len() - 1) < 0.01);
}

#[test]
fn no_outflow_makes_no_sound() {
    let still = |flow: f64| FlowHistory {
        back_pressure: None,
        sample_interval: 4e-6,
        mass_flow: vec![flow; 5000],
        pressure: vec![3e5; 5000],
        temperature: vec![290.0; 5000],
    };
    for flow in [0.0, -0.02] {
        let noise = noise(&still(flow), &HOLES);
        assert_eq!(noise.spectrum.level([50.0, 20_000.0], Weighting::A), None);
        assert_eq!((noise.mass, noise.mixing_outside_range), (0.0, 0.0));
        assert!(
            screech_track(&still(flow), &HOLES, &Air::default())
                .iter()
                .all(Option::is_none)
        );
        assert_eq!(ValveNoise::DRILLED_PLATE.energy(&still(flow), &Air::default()), 0.0);
    }
}

#[test]
fn screech_falls_as_pressure_rises() {
    let air = Air::default();
    let at = |p: f64| {
        screech_frequency(
            &Jet::expand(p, air.temperature, &air).unwrap(),
            5e-3,
            air.temperature,
            &air,
        )
    };
    assert!(at(1.5e5).is_none());
    let track: Vec<f64> = [2.5e5, 3.5e5, 5e5, 7e5].iter().map(|&p| at(p).unwrap()).collect();
    assert!(track.windows(2).all(|pair| pair[1] < pair[0]), "{track:?}");
    // By hand for M_j = sqrt 2 of a cold jet: beta = 1, T_j = T_a/1.4.
    let p = air.pressure * 1.4f64.powf(3.5);
    let by_hand = 0.67 / (1.0 + 0.7 * 2f64.sqrt() / 1.4f64.sqrt()) * (2.0 / 1.4f64).sqrt() * air.sound_speed
        / (5e-3 * (1.4f64 / 1.2).powf(1.5) / 2f64.powf(0.25));
    assert!((at(p).unwrap() / by_hand - 1.0).abs() < 1e-12, "{by_hand}");
}

#[test]
fn the_correlations_lie_above_the_valve_standard_by_what_the_limits_state() {
    let history = blow_down(3e-4, &HOLES, 7e5, 4e-6, 0.1);
    let noise = noise(&history, &HOLES);
    let other = ValveNoise::DRILLED_PLATE.energy(&history, &Air::default());
    let difference = 10.0 * ((noise.mixing_energy + noise.shock_energy) / other).log10();
    // docs/limits.md: about 15 dB for one blow-down, 8 dB of them by the efficiency of drilled plates in pipes.
    assert!((13.0..17.0).contains(&difference), "{difference}");
}

#[test]
fn impossible_openings_are_refused_by_name() {
    let history = blow_down(3e-4, &HOLES, 7e5, 4e-6, 0.01);
    let run = |opening: Opening| {
        exhaust_noise("e", &history, &opening, &Air::default(), &ExhaustSettings::default()).unwrap_err()
    };
    assert!(matches!(
        run(Opening { count: 0, ..HOLES }),
        AcousticsError::Exhaust(ExhaustError::Input(InputError::NotPositive { .. }))
    ));
    assert!(matches!(
        run(Opening {
            diameter: -1.0,
            ..HOLES
        }),
        AcousticsError::Exhaust(ExhaustError::Input(InputError::NotPositive { .. }))
    ));
    assert!(matches!(
        run(Opening {
            pitch: Some(0.012),
            ..HOLES
        }),
        AcousticsError::Exhaust(ExhaustError::MergingJets { count: 7, .. })
    ));
    let mut short = history.clone();
    short.pressure.pop();
    let result = exhaust_noise("e", &short, &HOLES, &Air::default(), &ExhaustSettings::default());
    assert!(matches!(
        result,
        Err(AcousticsError::Exhaust(ExhaustError::Input(InputError::Length { .. })))
    ));
}

/// Only R T enters density and speed of sound: the same flow of a gas of twice the gas constant at half the temperature
/// makes the same noise.
#[test]
fn a_gas_of_twice_the_constant_at_half_the_temperature_sounds_the_same() {
    let air = Air::default();
    let light = air.of_gas(2.0 * air.gas_constant, air.heat_ratio).unwrap();
    let light = light.in_state(0.5 * air.temperature, air.pressure).unwrap();
    let history = blow_down(1e-3, &HOLES, 7e5, 1e-5, 0.05);
    let mut cold = history.clone();
    cold.temperature.iter_mut().for_each(|temperature| *temperature *= 0.5);
    let behind = |history: &FlowHistory| FlowHistory {
        back_pressure: Some(vec![1.1e5; history.pressure.len()]),
        ..history.clone()
    };
    let settings = ExhaustSettings {
        plenum: Some(PlenumResonance {
            volume: 5e-5,
            neck_length: 8e-3,
            quality: 5.0,
        }),
        ..ExhaustSettings::default()
    };
    for (history, cold) in [(history.clone(), cold.clone()), (behind(&history), behind(&cold))] {
        let noise = |history, air| exhaust_noise("exhaust", history, &HOLES, air, &settings);
        let (one, two) = (noise(&history, &air), noise(&cold, &light));
        match (one, two) {
            (Ok(one), Ok(two)) => {
                for (a, b) in one.spectrum.contributions.iter().zip(&two.spectrum.contributions) {
                    let largest = a.energy_density.iter().copied().fold(0.0, f64::max);
                    for (x, y) in a.energy_density.iter().zip(&b.energy_density) {
                        assert!((x - y).abs() < 1e-9 * largest, "{}", a.name);
                    }
                }
            }
            (one, two) => assert!(one.is_err() && two.is_err()),
        }
        let valve = |history, air| ValveNoise::DRILLED_PLATE.energy(history, air);
        assert!((valve(&history, &air) / valve(&cold, &light) - 1.0).abs() < 1e-12);
        let (one, two) = (
            screech_track(&history, &HOLES, &air),
            screech_track(&cold, &HOLES, &light),
        );
        for (one, two) in one.iter().zip(&two).filter_map(|(a, b)| a.zip(*b)) {
            assert!((one / two - 1.0).abs() < 1e-12);
        }
    }
}

/// The mass flow of choked holes in closed form, P A sqrt(g/(R T)) (2/(g+1))^((g+1)/(2(g-1))), for helium, air, CO2.
#[test]
fn jets_of_any_gas_carry_the_choked_mass_flow() {
    for (gas_constant, g) in [(2077.1, 1.667), (GAS_CONSTANT, HEAT_RATIO), (188.9, 1.289)] {
        let air = Air::default().of_gas(gas_constant, g).unwrap();
        let (p, t, area) = (6e5, 290.0, 1e-4);
        let closed = p * area * (g / (gas_constant * t)).sqrt() * (2.0 / (g + 1.0)).powf((g + 1.0) / (2.0 * (g - 1.0)));
        let found = Jet::expand(p, t, &air).unwrap().mass_flow(area);
        assert!((found / closed - 1.0).abs() < 1e-12, "{gas_constant}: {found} {closed}");
        assert!((air.sound_speed / (g * gas_constant * air.temperature).sqrt() - 1.0).abs() < 1e-15);
    }
    assert!(Air::default().of_gas(287.0, 1.0).is_err() && Air::default().of_gas(0.0, 1.4).is_err());
}
