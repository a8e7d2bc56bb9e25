//! The pipe fitting on the exhaust holes against tables, closed forms and laws.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{FilledFitting, OpenEnd, PipeFitting};
use nalgebra::Complex;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Evaluated by another program from Levine and Schwinger's equations: ka, |R|, l/a, r, x.
const OPEN_END: [(f64, f64, f64, f64, f64); 8] = [
    (0.1, 0.99507, 0.61099, 0.002482, 0.061175),
    (0.5, 0.89644, 0.58184, 0.059486, 0.298440),
    (1.0, 0.69510, 0.52743, 0.238279, 0.557507),
    (1.5, 0.50079, 0.47127, 0.532346, 0.702910),
    (1.8412, 0.39055, 0.43401, 0.749217, 0.690290),
    (2.5, 0.23318, 0.36361, 1.005742, 0.480917),
    (3.0, 0.15433, 0.30828, 1.039756, 0.316058),
    (3.8, 0.07777, 0.17074, 0.948419, 0.142918),
];

/// A pipe filled with the air of the tables.
fn fitting(length: f64, diameter: f64, outlet_mach: f64) -> FilledFitting {
    FilledFitting {
        pipe: PipeFitting {
            length,
            diameter,
            outlet_mach,
            temperature: None,
        },
        gas: air(),
        outside: air(),
    }
}

/// Air with the sound speed of the tables, 343.2 m/s.
fn air() -> Air {
    let air = Air::default();
    assert!((air.sound_speed - 343.2).abs() < 0.05);
    Air {
        sound_speed: 343.2,
        ..air
    }
}

/// The frequency at which the gain without outflow losses has its resonance, cos kL = x sin kL, by bisection.
fn resonance(filled: &FilledFitting) -> f64 {
    let pipe = &filled.pipe;
    let residual = |hz: f64| {
        let k = 2.0 * PI * hz / 343.2;
        let x = OpenEnd::new(0.5 * k * pipe.diameter).unwrap().impedance.im;
        (k * pipe.length).cos() - x * (k * pipe.length).sin()
    };
    let (mut low, mut high) = (10.0, 343.2 / (4.0 * pipe.length));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if residual(middle) > 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    low
}

#[test]
fn the_open_end_is_that_of_levine_and_schwinger() {
    for (ka, reflection, correction, r, x) in OPEN_END {
        let end = OpenEnd::new(ka).unwrap();
        assert!(
            (end.reflection - reflection).abs() < 6e-6,
            "|R|({ka}) = {}",
            end.reflection
        );
        assert!(
            (end.end_correction - correction).abs() < 6e-6,
            "l/a({ka}) = {}",
            end.end_correction
        );
        assert!((end.impedance.re - r).abs() < 2e-6, "r({ka}) = {}", end.impedance.re);
        assert!((end.impedance.im - x).abs() < 2e-6, "x({ka}) = {}", end.impedance.im);
    }
}

#[test]
fn the_end_correction_tends_to_its_limit_at_low_frequency() {
    assert!((OpenEnd::new(1e-3).unwrap().end_correction - 0.61270).abs() < 1e-5);
}

#[test]
fn an_open_end_beyond_the_first_axisymmetric_cross_mode_is_refused() {
    for ka in [0.0, -1.0, 3.84, f64::NAN] {
        assert!(OpenEnd::new(ka).is_err(), "{ka}");
    }
}

#[test]
fn a_pipe_without_length_keeps_the_flow() {
    let pipe = fitting(1e-12, 0.052, 0.0);
    let gain = pipe.gain(1000.0).unwrap();
    assert!((10.0 * gain.log10() + 0.208).abs() < 1e-3, "{gain}");
}

#[test]
fn a_jet_that_absorbs_everything_leaves_no_sound() {
    assert!(fitting(0.12, 0.078, 1e9).gain(600.0).unwrap() < 1e-12);
}

#[test]
fn the_default_fitting_resonates_where_the_tables_say() {
    let pipe = fitting(0.12, 0.078, 0.04);
    let f_r = resonance(&pipe);
    assert!((f_r - 600.34).abs() < 0.01, "{f_r}");
    let gain = 10.0 * pipe.gain(f_r).unwrap().log10();
    assert!((gain - 21.61).abs() < 0.005, "{gain}");
}

#[test]
fn the_gains_of_two_fittings_are_those_of_the_table() {
    let frequencies = [100.0, 200.0, 400.0, 800.0, 1250.0];
    for (pipe, f_r, limit, gains) in [
        (
            fitting(0.1, 0.052, 0.05),
            743.08,
            3868.0,
            [0.183, 0.761, 3.435, 16.392, 0.414],
        ),
        (
            fitting(0.16, 0.102, 0.02),
            451.56,
            1972.0,
            [0.501, 2.188, 14.358, -0.366, 4.488],
        ),
    ] {
        assert!((resonance(&pipe) - f_r).abs() < 0.01);
        assert!((pipe.plane_wave_limit() - limit).abs() < 0.5);
        for (hz, expected) in frequencies.into_iter().zip(gains) {
            let gain = 10.0 * pipe.gain(hz).unwrap().log10();
            assert!((gain - expected).abs() < 6e-4, "{hz} Hz: {gain}");
        }
    }
}

#[test]
fn the_resonances_of_two_fittings_are_those_of_the_table() {
    // |H|^2 at f_r; its maximum, and where; maximum of the gain; half-power width;
    // int |H|^2 df over f_r/2 .. 3 f_r/2 and 2 f_r/(r + M).
    for (pipe, f0, [at_resonance, maximum, maximum_hz, gain, width, integral, closed]) in [
        (
            fitting(0.1, 0.052, 0.05),
            740.00,
            [162.88, 163.30, 741.24, 21.967, 72.99, 17727.0, 18549.0],
        ),
        (
            fitting(0.16, 0.102, 0.02),
            448.56,
            [272.16, 273.24, 450.49, 24.175, 34.06, 14027.0, 14443.0],
        ),
    ] {
        let f_r = resonance(&pipe);
        let impedance = |hz: f64| OpenEnd::new(PI * hz / 343.2 * pipe.pipe.diameter).unwrap().impedance;
        let density = |hz: f64| pipe.flow_ratio(hz, impedance(hz) + pipe.pipe.outlet_mach).norm_sqr();
        let near = |found: f64, expected: f64, tolerance: f64| {
            assert!((found - expected).abs() < tolerance, "{found} for {expected}");
        };
        near(
            343.2 / (4.0 * (pipe.pipe.length + 0.306_65 * pipe.pipe.diameter)),
            f0,
            0.005,
        );
        near(density(f_r), at_resonance, 0.006);
        let df = 0.02;
        let grid: Vec<(f64, f64)> = (0..)
            .map(|i| 0.5 * f_r + (f64::from(i) + 0.5) * df)
            .take_while(|hz| *hz < 1.5 * f_r)
            .map(|hz| (hz, density(hz)))
            .collect();
        let (peak_hz, peak) = grid.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        near(peak, maximum, 0.006);
        near(peak_hz, maximum_hz, df);
        let largest = grid.iter().map(|(hz, _)| pipe.gain(*hz).unwrap()).fold(0.0, f64::max);
        near(10.0 * largest.log10(), gain, 6e-4);
        let above = grid.iter().filter(|(_, value)| *value > 0.5 * peak).count();
        near(above as f64 * df, width, 2.0 * df);
        near(grid.iter().map(|(_, value)| value * df).sum(), integral, 1.0);
        near(2.0 * f_r / (impedance(f_r).re + pipe.pipe.outlet_mach), closed, 1.0);
    }
}

#[test]
fn the_resonance_carries_the_energy_of_its_closed_form() {
    // int |H|^2 df over f/2 .. 3 f/2 against 2 f_r/(r + M), with r = 0 and x = tan(0.6133 ka).
    for (mach, expected) in [(0.02, 0.98764), (0.005, 0.99692), (0.001, 0.99938)] {
        let pipe = fitting(0.1, 0.052, mach);
        let x = |hz: f64| (0.6133 * PI * hz / 343.2 * pipe.pipe.diameter).tan();
        let f_r = 343.2 / (4.0 * (pipe.pipe.length + 0.6133 * 0.5 * pipe.pipe.diameter));
        let density = |hz: f64| pipe.flow_ratio(hz, Complex::new(mach, x(hz))).norm_sqr();
        let steps = 400_000;
        let df = f_r / f64::from(steps);
        let energy: f64 = (0..steps)
            .map(|i| density(0.5 * f_r + (f64::from(i) + 0.5) * df) * df)
            .sum();
        let ratio = energy * mach / (2.0 * f_r);
        assert!((ratio - expected).abs() < 2e-5, "M = {mach}: {ratio}");
    }
}

/// Frequency of the largest |H|^2, by steps of 0.01 Hz around `near`.
fn loudest(filled: &FilledFitting, near: f64) -> f64 {
    (-3000..=3000)
        .map(|step| near + 0.01 * f64::from(step))
        .max_by(|a, b| filled.gain(*a).unwrap().total_cmp(&filled.gain(*b).unwrap()))
        .unwrap()
}

#[test]
fn cold_gas_resonates_as_a_quarter_wave_of_its_own_sound_speed() {
    // A narrow pipe, whose end correction is 0.6133 a and which hardly radiates: f0 = c/(4 (L + 0.6133 a)).
    let pipe = PipeFitting {
        length: 0.12,
        diameter: 0.004,
        outlet_mach: 1e-4,
        temperature: None,
    };
    let cold = pipe.filled(245.0, &Air::default()).unwrap();
    let sound_speed = (1.4 * 287.052_874 * 245.0_f64).sqrt();
    let quarter = sound_speed / (4.0 * (0.12 + 0.6133 * 0.002));
    let found = loudest(&cold, quarter);
    assert!((found / quarter - 1.0).abs() < 2e-4, "{found} Hz for {quarter} Hz");
}

#[test]
fn the_default_fitting_moves_with_the_root_of_the_temperature() {
    let pipe = fitting(0.12, 0.078, 0.04).pipe;
    let air = Air::default();
    let (warm, cold) = (pipe.filled(293.15, &air).unwrap(), pipe.filled(245.0, &air).unwrap());
    let ratio = loudest(&cold, 546.0) / loudest(&warm, 597.0);
    assert!((ratio - (245.0_f64 / 293.15).sqrt()).abs() < 1e-3, "{ratio}");
}

#[test]
fn a_given_temperature_of_the_gas_replaces_that_of_the_outflow() {
    let air = Air::default();
    let pipe = PipeFitting {
        temperature: Some(293.15),
        ..fitting(0.12, 0.078, 0.04).pipe
    };
    let free = fitting(0.12, 0.078, 0.04).pipe;
    assert_eq!(
        pipe.filled(245.0, &air).unwrap().gas,
        free.filled(293.15, &air).unwrap().gas
    );
}

#[test]
fn a_short_pipe_of_cold_gas_radiates_as_the_monopole_in_the_air_outside() {
    let cold = PipeFitting {
        length: 1e-12,
        diameter: 0.01,
        outlet_mach: 0.0,
        temperature: None,
    }
    .filled(245.0, &Air::default())
    .unwrap();
    assert!((cold.gain(100.0).unwrap() - 1.0).abs() < 1e-3);
}

#[test]
fn what_enters_a_cold_pipe_is_radiated_into_the_air_or_absorbed_by_its_jet() {
    // Re z_in = |H|^2 (r rho0 c0/rho c + M); the share r radiates, which G counts.
    let filled = PipeFitting {
        length: 0.12,
        diameter: 0.078,
        outlet_mach: 0.04,
        temperature: None,
    }
    .filled(245.0, &Air::default())
    .unwrap();
    let (gas, air) = (filled.gas, filled.outside);
    for hz in [150.0, 400.0, 546.0, 900.0, 1800.0] {
        let (k, k0) = (2.0 * PI * hz / gas.sound_speed, 2.0 * PI * hz / air.sound_speed);
        let r = OpenEnd::new(0.039 * k0).unwrap().impedance.re;
        let x = OpenEnd::new(0.039 * k).unwrap().impedance.im;
        let z = Complex::new(r * air.impedance() / gas.impedance() + 0.04, x);
        let (sine, cosine) = (k * 0.12).sin_cos();
        let j = Complex::<f64>::i();
        let inlet = (z * cosine + j * sine) / (cosine + j * z * sine);
        let radiated = filled.gain(hz).unwrap() * (0.039 * k0).powi(2) / 4.0 * air.impedance() / gas.impedance();
        let absorbed = 0.04 * filled.flow_ratio(hz, z).norm_sqr();
        assert!((inlet.re / (radiated + absorbed) - 1.0).abs() < 1e-12, "{hz} Hz");
    }
}

#[test]
fn gain_and_response_go_over_to_the_open_holes_at_the_cross_mode() {
    let pipe = fitting(0.12, 0.078, 0.04);
    let limit = pipe.plane_wave_limit();
    assert_eq!(pipe.gain(limit * 1.0001).unwrap(), 1.0);
    assert!((pipe.gain(limit * 0.9999).unwrap() - 1.0).abs() < 5e-3);
    let start = limit * 2f64.powf(-1.0 / 6.0);
    let (before, after) = (pipe.gain(start * 0.9999).unwrap(), pipe.gain(start * 1.0001).unwrap());
    assert!((before / after - 1.0).abs() < 5e-3);
}

proptest! {
    /// What enters the pipe leaves by the open end or is absorbed by its jet.
    #[test]
    fn energy_is_conserved(length in 0.02..0.5_f64, diameter in 0.02..0.15_f64, mach in 0.0..0.3_f64,
        ka in 0.01..1.8_f64) {
        let pipe = fitting(length, diameter, mach);
        let hz = ka * 343.2 / (PI * diameter);
        let z = OpenEnd::new(ka).unwrap().impedance + mach;
        let (sine, cosine) = (2.0 * PI * hz / 343.2 * length).sin_cos();
        let j = Complex::<f64>::i();
        let inlet = (z * cosine + j * sine) / (cosine + j * z * sine);
        let flow = pipe.flow_ratio(hz, z);
        prop_assert!((inlet.re - flow.norm_sqr() * z.re).abs() <= 1e-12 * inlet.re.max(1e-6));
    }
}
