//! Energy over time: intervals between events sum to the source's energy, and sound falls in the interval of its
//! origin.

use crate::radiating_surfaces::{flat, rectangle};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{ExhaustSettings, FlowHistory, Opening, PlenumResonance, exhaust_noise};
use nailnoise_acoustics::radiation::flush_with_sand::{MovingSand, Rayleigh};
use nailnoise_acoustics::radiation::{
    Erp, ModalRadiation, ModalSpectra, RadiatingSurface, Resistance, Sampling, radiated_energy, radiated_signals,
    rigid_body_energy, rigid_body_signals,
};
use nailnoise_acoustics::signals::fourier::TransformSettings;
use nailnoise_acoustics::signals::{IntervalLevels, PowerHistory, PowerSignals, SourceSpectrum, Weighting};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

const SETTINGS: TransformSettings = TransformSettings {
    range_hz: [50.0, 5000.0],
    taper: 5e-3,
    padding: 2.0,
};

const DT: f64 = 5e-5;
const SAMPLES: usize = 4000;

/// Decaying oscillations of the modes, struck at 10, 60 and 110 ms with fixed amplitudes.
fn accelerations(modes: usize) -> impl Fn(usize) -> Vec<f64> + Sync {
    move |mode| {
        let omega = 2.0 * PI * (180.0 + 310.0 * (modes - mode) as f64);
        let ring = |t: f64| {
            if t < 0.0 {
                0.0
            } else {
                (-60.0 * t).exp() * (omega * t).sin()
            }
        };
        (0..SAMPLES)
            .map(|i| {
                let t = i as f64 * DT;
                let blows = [(0.01, 1.0), (0.06, 0.3), (0.11, -0.5)];
                blows
                    .iter()
                    .map(|(at, amplitude)| amplitude * ring(t - at))
                    .sum::<f64>()
                    * (1.0 + mode as f64)
            })
            .collect()
    }
}

/// A plate of 0.3 m x 0.1 m with a rigid, a tilting and two bending modes.
fn plate() -> RadiatingSurface {
    let modes: [&dyn Fn(f64, f64) -> f64; 4] = [
        &|_, _| 1.0,
        &|x, _| 10.0 * x,
        &|x, _| (PI * (x / 0.3 + 0.5)).sin(),
        &|x, y| (2.0 * PI * (x / 0.3 + 0.5)).sin() + 5.0 * y,
    ];
    flat(rectangle([-0.15, 0.15], [-0.05, 0.05], 12, 6), &modes)
}

fn spectra(modes: usize) -> ModalSpectra {
    ModalSpectra::from_accelerations(modes, SAMPLES, DT, &SETTINGS, accelerations(modes)).unwrap()
}

const EDGES: [f64; 6] = [0.0, 0.01, 0.0333, 0.06, 0.11, 0.2];

fn sum(intervals: &[IntervalLevels]) -> f64 {
    intervals.iter().map(|i| i.energy).sum()
}

/// Intervals sum to the spectrum's energy over the range, whole or cut short.
fn assert_sums(spectrum: &SourceSpectrum, signals: &PowerSignals) {
    for range in [[50.0, 5000.0], [63.7, 2222.2], [400.0, 401.0]] {
        let analysis = signals.analyse(&EDGES, range);
        let total = spectrum.energy(range, Weighting::A);
        let found = sum(&analysis.intervals);
        assert!(
            total > 0.0 && (found / total - 1.0).abs() < 1e-9,
            "{range:?}: {found:e} against {total:e}"
        );
        assert!((analysis.history.total() / total - 1.0).abs() < 1e-9);
        assert!(analysis.history.power.iter().all(|p| *p >= 0.0));
    }
}

#[test]
fn intervals_of_the_erp_sum_to_its_energy() {
    let erp = Erp::new(&plate(), &Air::default());
    let motion = spectra(4);
    let spectrum = radiated_energy("plate", &erp, &motion).unwrap();
    let signals = radiated_signals(&erp, &motion, &spectrum).unwrap();
    assert!(signals.mismatch() < 1e-6, "{}", signals.mismatch());
    assert_sums(&spectrum, &signals);
}

#[test]
fn erp_over_time_is_the_impedance_times_velocity_squared() {
    // A piston that emits a tone burst. Its bandwidth is so small that A-weighting only multiplies the signal by a
    // factor.
    let surface = flat(rectangle([0.0, 0.2], [0.0, 0.1], 2, 2), &[&|_, _| 1.0]);
    let air = Air::default();
    let erp = Erp::new(&surface, &air);
    let (hz, v0) = (1000.0, 0.1);
    let envelope = |t: f64| (-(t - 0.08).powi(2) / (2.0 * 0.01f64.powi(2))).exp();
    let omega = 2.0 * PI * hz;
    let velocity = |t: f64| v0 * envelope(t) * (omega * t).sin();
    let record = |_| {
        let slope = |i: usize| {
            let (t, h) = (i as f64 * DT, 1e-7);
            (velocity(t + h) - velocity(t - h)) / (2.0 * h)
        };
        (0..SAMPLES).map(slope).collect()
    };
    let motion = ModalSpectra::from_accelerations(1, SAMPLES, DT, &SETTINGS, record).unwrap();
    let spectrum = radiated_energy("piston", &erp, &motion).unwrap();
    let signals = radiated_signals(&erp, &motion, &spectrum).unwrap();
    let edges: Vec<f64> = (0..=20).map(|i| 0.01 * f64::from(i)).collect();
    let analysis = signals.analyse(&edges, SETTINGS.range_hz);
    // The causal weighting turns the tone's phase, and delays its envelope by its group delay -d phase / d omega.
    let phase = Weighting::A.response(hz).arg();
    let turn = Weighting::A.response(hz + 1.0) / Weighting::A.response(hz - 1.0);
    let delay = -turn.arg() / (2.0 * PI * 2.0);
    assert!((1e-5..5e-4).contains(&delay), "{delay}");
    let weighted = |t: f64| v0 * envelope(t - delay) * (omega * t + phase).sin();
    let steps = 10_000;
    for pair in analysis.intervals.iter().filter(|i| i.from > 0.03 && i.to < 0.13) {
        let h = (pair.to - pair.from) / f64::from(steps);
        let integral: f64 = (0..steps)
            .map(|i| weighted(pair.from + (f64::from(i) + 0.5) * h).powi(2) * h)
            .sum();
        let exact = air.impedance() * 0.02 * integral;
        // In the tone's flanks the weighting's curvature over the tone's width shows.
        let tolerance = if (0.06..0.09).contains(&pair.from) { 2e-3 } else { 1e-2 };
        let ratio = pair.energy / exact;
        assert!((ratio - 1.0).abs() < tolerance, "from {} s: {ratio}", pair.from);
    }
}

/// An operator without its own root: the default takes one at every frequency.
struct OneByOne<'a>(&'a dyn ModalRadiation);

impl ModalRadiation for OneByOne<'_> {
    fn method(&self) -> &str {
        self.0.method()
    }
    fn modes(&self) -> usize {
        self.0.modes()
    }
    fn patches(&self) -> &[String] {
        self.0.patches()
    }
    fn highest_hz(&self) -> f64 {
        self.0.highest_hz()
    }
    fn resistance(&self, hz: f64) -> Resistance {
        self.0.resistance(hz)
    }
    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        self.0.energy_forms(frequency, accelerations)
    }
}

#[test]
fn intervals_of_a_sampled_resistance_sum_to_its_energy() {
    let air = Air::default();
    let sand = MovingSand {
        footprint: [[-0.15, 0.15], [-0.05, 0.05]],
        sand: [[-0.45, 0.45], [-0.35, 0.35]],
        shear_speed: 112.0,
        poisson_ratio: 0.3,
        loss_factor: 0.1,
        to_hz: 1000.0,
    };
    let real = Rayleigh::new(&plate(), &air).unwrap();
    let complex = real.clone().with_moving_sand(sand).unwrap();
    let motion = spectra(4);
    for rayleigh in [real, complex] {
        // From 100 Hz on: bins below it use the power laws of the lowest sample.
        let sampling = Sampling {
            range_hz: [100.0, 5000.0],
            ..Sampling::default()
        };
        let sampled = rayleigh.sampled(&sampling, &|| ()).unwrap();
        let spectrum = radiated_energy("plate", &sampled, &motion).unwrap();
        let signals = radiated_signals(&sampled, &motion, &spectrum).unwrap();
        assert!(signals.mismatch() < 1e-4, "{}", signals.mismatch());
        assert_sums(&spectrum, &signals);
        let exact = radiated_signals(&OneByOne(&sampled), &motion, &spectrum).unwrap();
        assert!(exact.mismatch() < 1e-5, "{}", exact.mismatch());
        let range = [50.0, 5000.0];
        let (a, b) = (signals.analyse(&EDGES, range), exact.analyse(&EDGES, range));
        for (a, b) in a.intervals.iter().zip(&b.intervals).filter(|(a, _)| a.lwa.is_some()) {
            let difference = (a.energy - b.energy).abs();
            assert!(
                difference < 1e-4 * sum(&[*b]) + 1e-7 * spectrum.energy(range, Weighting::A),
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn intervals_of_the_sphere_sum_to_its_energy() {
    let air = Air::default();
    let record = accelerations(1)(0);
    let spectrum = rigid_body_energy("body", &record, DT, 1.5e-3, &air, &SETTINGS).unwrap();
    let signals = rigid_body_signals(&record, DT, 1.5e-3, &air, &SETTINGS).unwrap();
    assert_sums(&spectrum, &signals);
}

#[test]
fn sound_belongs_to_the_interval_in_which_it_arises() {
    let erp = Erp::new(&plate(), &Air::default());
    let motion = spectra(4);
    let spectrum = radiated_energy("plate", &erp, &motion).unwrap();
    let analysis = radiated_signals(&erp, &motion, &spectrum)
        .unwrap()
        .analyse(&EDGES, SETTINGS.range_hz);
    let energy: Vec<f64> = analysis.intervals.iter().map(|i| i.energy).collect();
    // Nothing has moved before the first blow, which is ten times the second in energy.
    assert!(energy[0] < 2e-3 * energy[1], "{energy:?}");
    assert!(energy[1] > 0.9 * (energy[1] + energy[2]), "{energy:?}");
    let second = energy[3] / (energy[1] + energy[2]);
    // What still rings of the first blow, 5 % in amplitude, interferes with the second's 30 %.
    assert!((second / 0.09 - 1.0).abs() < 2.0 * 0.05 / 0.3, "{second}");
}

#[test]
fn a_cut_adds_energy_and_the_whole_does_not() {
    let air = Air::default();
    let record = accelerations(1)(0);
    let signals = rigid_body_signals(&record, DT, 1.5e-3, &air, &SETTINGS).unwrap();
    let range = SETTINGS.range_hz;
    let whole = signals.analyse(&[0.0, 0.2], range).intervals[0];
    assert!((whole.cut_energy / whole.energy - 1.0).abs() < 1e-3, "{whole:?}");
    // Where the mode rings through the edges, every cut leaves a step.
    let parts = signals.analyse(&[0.0, 0.013, 0.016, 0.019, 0.2], range).intervals;
    let cut: f64 = parts.iter().map(|p| p.cut_energy).sum();
    assert!(cut > 1.001 * sum(&parts), "{cut:e} against {:e}", sum(&parts));
}

/// Outflow that sets in, falls from choked to subsonic, and stops.
fn outflow() -> FlowHistory {
    let dt = 1e-5;
    let pressure = |i: usize| 1.01325e5 + 4e5 * (-(i as f64) * dt / 0.01).exp();
    let flow = |i: usize| {
        if (500..6000).contains(&i) {
            0.02 * (pressure(i) / 5e5 - 0.15)
        } else {
            0.0
        }
    };
    FlowHistory {
        back_pressure: None,
        sample_interval: dt,
        mass_flow: (0..8000).map(flow).collect(),
        pressure: (0..8000).map(pressure).collect(),
        temperature: vec![270.0; 8000],
    }
}

#[test]
fn intervals_of_the_exhaust_sum_to_its_energy() {
    let opening = Opening {
        count: 7,
        diameter: 5e-3,
        discharge_coefficient: 0.82,
        pitch: None,
    };
    let plenum = PlenumResonance {
        volume: 2e-5,
        neck_length: 8e-3,
        quality: 5.0,
    };
    let settings = ExhaustSettings {
        plenum: Some(plenum),
        ..ExhaustSettings::default()
    };
    let noise = exhaust_noise("exhaust", &outflow(), &opening, &Air::default(), &settings).unwrap();
    let edges = [0.0, 0.005, 0.02, 0.06, 0.08];
    for range in [[20.0, 20_000.0], [50.0, 10_000.0], [55.5, 777.7]] {
        let (histories, intervals) = noise.history.analyse(&edges, range);
        let total = noise.spectrum.energy(range, Weighting::A);
        assert!(
            (sum(&intervals) / total - 1.0).abs() < 1e-9,
            "{range:?}: {intervals:?} {total:e}"
        );
        let over_time: f64 = histories.iter().map(PowerHistory::total).sum();
        assert!((over_time / total - 1.0).abs() < 1e-9);
    }
    // The jets sound while they blow, and only then.
    let jets = noise.history.jets([50.0, 10_000.0]);
    assert!(
        jets.power
            .iter()
            .enumerate()
            .all(|(i, p)| (*p > 0.0) == (500..6000).contains(&i))
    );
}

#[test]
fn a_history_is_divided_by_time_and_loses_nothing() {
    let history = PowerHistory {
        start: -0.5,
        sample_interval: 1.0,
        power: vec![4.0, 2.0, 8.0, 1.0],
    };
    // Cells -1..0, 0..1, 1..2, 2..3.
    assert_eq!(
        history.energies_between(&[0.0, 0.25, 0.75, 1.5, 9.0]),
        [4.5, 1.0, 4.5, 5.0]
    );
    assert_eq!(history.energies_between(&[0.5, 0.5, 0.5, 2.0]), [5.0, 0.0, 10.0]);
    assert_eq!(history.energies_between(&[10.0, 11.0]), [15.0]);
    assert!(history.energies_between(&[1.0]).is_empty());
    let sum = PowerHistory::sum(&[history.clone(), history], -0.75, 0.5, 8);
    assert_eq!(sum.power, [8.0, 8.0, 4.0, 4.0, 16.0, 16.0, 2.0, 2.0]);
}
