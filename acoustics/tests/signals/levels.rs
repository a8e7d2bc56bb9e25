//! Bands, weightings, levels and ranking.

use nailnoise_acoustics::InputError;
use nailnoise_acoustics::signals::{
    Band, LevelsError, REFERENCE_PRESSURE, SourceSpectrum, Weighting, band_containing, bands_of, energy_level,
    exposure_level, level_energy, peak_level, rank, third_octaves,
};
use proptest::prelude::*;
use std::f64::consts::PI;

fn ripple() -> SourceSpectrum {
    let frequency: Vec<f64> = (1..4000).map(|k| f64::from(k) * 5.3).collect();
    let density = frequency
        .iter()
        .map(|f| 1e-9 * (1.0 + (f / 37.0).sin()) / (1.0 + (f / 900.0).powi(2)))
        .collect();
    SourceSpectrum::new("ripple", "given", frequency, density, [20.0, 20_000.0]).unwrap()
}

#[test]
fn band_edges_follow_iec_61260() {
    let bands = third_octaves();
    assert_eq!((bands.len(), bands[0].index, bands[26].index), (27, -13, 13));
    assert!((Band::new(0).hz - 1000.0).abs() < 1e-12);
    // IEC 61260-1, annex E: exact frequencies to five digits.
    for (k, hz) in [(-13, 50.119), (-10, 100.0), (1, 1258.9), (10, 10_000.0), (13, 19_953.0)] {
        assert!(
            (Band::new(k).hz / hz - 1.0).abs() < 4e-5,
            "band {k}: {}",
            Band::new(k).hz
        );
    }
    assert!((Band::new(0).low - 891.250_938_133_745_6).abs() < 1e-9);
    assert!((Band::new(0).high - 1_122.018_454_301_963_3).abs() < 1e-9);
    for pair in bands.windows(2) {
        assert_eq!(pair[0].high.to_bits(), pair[1].low.to_bits());
        assert!((pair[1].hz / pair[0].hz - 10f64.powf(0.1)).abs() < 1e-12);
    }
    let nominal: Vec<f64> = bands.iter().map(Band::nominal_hz).collect();
    assert_eq!(nominal[..6], [50.0, 63.0, 80.0, 100.0, 125.0, 160.0]);
    assert_eq!(
        (nominal[25], nominal[26], Band::new(-15).nominal_hz()),
        (16_000.0, 20_000.0, 31.5)
    );
}

#[test]
fn weightings_follow_iec_61672() {
    // Values of the closed form, rounded to hundredths.
    for (hz, a) in [
        (100.0, -19.14),
        (500.0, -3.25),
        (1000.0, 0.0),
        (2000.0, 1.20),
        (10_000.0, -2.49),
    ] {
        assert!(
            (Weighting::A.db(hz) - a).abs() < 0.005,
            "A({hz}) = {}",
            Weighting::A.db(hz)
        );
    }
    // IEC 61672-1, table 3: tenths of a decibel at the exact mid-band frequencies.
    let table = [
        (-17, -50.5, -6.2),
        (-15, -39.4, -3.0),
        (-10, -19.1, -0.3),
        (-5, -6.6, 0.0),
        (4, 1.3, -0.3),
        (9, -1.1, -3.0),
        (13, -9.3, -11.2),
    ];
    for (k, a, c) in table {
        let hz = Band::new(k).hz;
        assert!(
            (Weighting::A.db(hz) - a).abs() < 0.06,
            "A({hz}) = {}",
            Weighting::A.db(hz)
        );
        assert!(
            (Weighting::C.db(hz) - c).abs() < 0.06,
            "C({hz}) = {}",
            Weighting::C.db(hz)
        );
        assert_eq!(Weighting::Z.db(hz), 0.0);
    }
    assert_eq!(Weighting::A.energy_factor(0.0), 0.0);
}

#[test]
fn bands_sum_to_the_total() {
    let spectrum = ripple();
    let range = [Band::new(-13).low, Band::new(13).high];
    for range in [range, [50.0, 10_000.0], [123.4, 5678.9]] {
        let bands = spectrum.band_levels(range);
        let z: f64 = bands.iter().map(|b| b.energy).sum();
        let a: f64 = bands.iter().map(|b| b.a_energy).sum();
        assert!((z / spectrum.energy(range, Weighting::Z) - 1.0).abs() < 1e-13);
        assert!((a / spectrum.energy(range, Weighting::A) - 1.0).abs() < 1e-13);
    }
    // The 50 Hz band begins at 44.7 Hz; a range from 50 Hz includes only its upper part.
    let cut = spectrum.band_levels([50.0, 10_000.0])[0].energy;
    assert!((cut / spectrum.energy([50.0, Band::new(-13).high], Weighting::Z) - 1.0).abs() < 1e-13);
}

#[test]
fn a_linear_density_is_integrated_exactly() {
    let spectrum = SourceSpectrum::new("s", "m", vec![0.0, 400.0, 1000.0], vec![0.0, 8.0, 2.0], [0.0, 1000.0]).unwrap();
    assert!((spectrum.energy([0.0, 1000.0], Weighting::Z) - (1600.0 + 3000.0)).abs() < 1e-9);
    assert!((spectrum.energy([100.0, 200.0], Weighting::Z) - 300.0).abs() < 1e-10);
    assert!((spectrum.energy([900.0, 5000.0], Weighting::Z) - 250.0).abs() < 1e-10);
    assert_eq!(spectrum.energy([1000.0, 5000.0], Weighting::Z), 0.0);
    assert!((spectrum.density_at(700.0) - 5.0).abs() < 1e-12);
}

#[test]
fn a_tone_takes_the_weighting_of_its_frequency() {
    let line = |hz: f64| {
        SourceSpectrum::new(
            "tone",
            "m",
            vec![hz - 0.01, hz, hz + 0.01],
            vec![0.0, 1.0, 0.0],
            [20.0, 20_000.0],
        )
        .unwrap()
    };
    for hz in [63.0, 500.0, 8000.0] {
        let tone = line(hz);
        let range = [20.0, 20_000.0];
        let gain = tone.level(range, Weighting::A).unwrap() - tone.level(range, Weighting::Z).unwrap();
        assert!((gain - Weighting::A.db(hz)).abs() < 1e-4);
    }
}

#[test]
fn zero_energy_has_no_level() {
    let silent = SourceSpectrum::silent("exhaust", "given", [20.0, 20_000.0]);
    assert_eq!(silent.level([50.0, 10_000.0], Weighting::A), None);
    assert!(
        silent
            .band_levels([50.0, 10_000.0])
            .iter()
            .all(|b| b.lw.is_none() && b.lwa.is_none())
    );
    let sources = [silent.clone(), ripple()];
    let ranking = rank(&sources, [50.0, 10_000.0]);
    assert_eq!(sources[ranking.sources[0].index].source, "ripple");
    assert_eq!(ranking.sources[1].lwa, None);
    assert_eq!(ranking.total_lwa, ranking.sources[0].lwa);
    let none = rank(&[silent], [50.0, 10_000.0]);
    assert_eq!((none.total_lwa, none.sources[0].share), (None, None));
    assert_eq!((energy_level(0.0), level_energy(None)), (None, 0.0));
}

#[test]
fn a_sum_contains_its_parts() {
    let (mut one, mut two) = (ripple(), ripple());
    one.source = "one".into();
    two.source = "two".into();
    two.frequency.iter_mut().for_each(|f| *f += 1.7);
    let sum = SourceSpectrum::sum("both", "given", &[one.clone(), two.clone()]);
    // A source ends with its own grid; inside both the sum of piecewise linear functions is exact.
    let range = [50.0, 20_000.0];
    let parts = one.energy(range, Weighting::Z) + two.energy(range, Weighting::Z);
    assert!((sum.energy(range, Weighting::Z) / parts - 1.0).abs() < 1e-12);
    let energies = sum.contribution_energies(range, Weighting::A);
    assert_eq!((energies[0].0.as_str(), energies[1].0.as_str()), ("one", "two"));
    let total = sum.energy(range, Weighting::A);
    assert!(((energies[0].1 + energies[1].1) / total - 1.0).abs() < 1e-12);
}

#[test]
fn impossible_spectra_are_refused_by_name() {
    let make = |f: &[f64], e: &[f64]| SourceSpectrum::new("s", "m", f.to_vec(), e.to_vec(), [0.0, 1.0]).unwrap_err();
    assert!(matches!(
        make(&[1.0, 2.0], &[1.0]),
        LevelsError::Input(InputError::Length {
            found: 1,
            expected: 2,
            ..
        })
    ));
    assert!(matches!(
        make(&[1.0, 1.0], &[1.0, 1.0]),
        LevelsError::Frequencies { .. }
    ));
    assert!(matches!(
        make(&[1.0, 2.0], &[1.0, f64::NAN]),
        LevelsError::Input(InputError::NotFinite { index: 1, .. })
    ));
}

proptest! {
    #[test]
    fn every_frequency_lies_in_its_band(hz in 1.0f64..50_000.0) {
        let band = band_containing(hz);
        prop_assert!(band.low <= hz && hz < band.high);
    }

    #[test]
    fn a_band_begins_at_its_edge(k in -40i32..40) {
        prop_assert_eq!(band_containing(Band::new(k).low).index, k);
    }

    #[test]
    fn doubled_amplitudes_raise_every_level_by_6_db(scale in 1e-12f64..1.0) {
        let mut spectrum = ripple();
        spectrum.energy_density.iter_mut().for_each(|e| *e *= scale);
        let before = spectrum.band_levels([20.0, 20_000.0]);
        spectrum.energy_density.iter_mut().for_each(|e| *e *= 4.0);
        for (a, b) in before.iter().zip(spectrum.band_levels([20.0, 20_000.0])) {
            prop_assert!((b.lwa.unwrap() - a.lwa.unwrap() - 20.0 * 2f64.log10()).abs() < 1e-9);
        }
    }

    #[test]
    fn splitting_a_range_keeps_its_energy(split in 60.0f64..9000.0) {
        let spectrum = ripple();
        let whole = spectrum.energy([50.0, 10_000.0], Weighting::A);
        let parts = spectrum.energy([50.0, split], Weighting::A) + spectrum.energy([split, 10_000.0], Weighting::A);
        prop_assert!((parts / whole - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_sum_keeps_the_energy_of_parts_that_end_before_the_others() {
    let grid = |to: u32| (40..=to).map(|k| 10.0 * f64::from(k)).collect::<Vec<f64>>();
    let flat = |name: &str, to: u32, level: f64| {
        let frequency = grid(to);
        let density = vec![level; frequency.len()];
        SourceSpectrum::new(name, "test", frequency, density, [400.0, 10.0 * f64::from(to)]).unwrap()
    };
    let (long, short) = (flat("long", 1000, 1e-9), flat("short", 500, 3e-9));
    let sum = SourceSpectrum::sum("both", "test", &[long.clone(), short.clone()]);
    for weighting in [Weighting::Z, Weighting::A] {
        let all = [0.0, 20_000.0];
        let expected = long.energy(all, weighting) + short.energy(all, weighting);
        assert!((sum.energy(all, weighting) / expected - 1.0).abs() < 1e-12);
    }
    let beyond = [5001.0, 5009.0];
    assert_eq!(sum.energy(beyond, Weighting::Z), long.energy(beyond, Weighting::Z));
}

#[test]
fn bands_of_every_range_sum_to_its_total() {
    // 1 Hz to 100 kHz, E = 1/f.
    let frequency: Vec<f64> = (0..=5000).map(|i| 10f64.powf(f64::from(i) * 1e-3)).collect();
    let density = frequency.iter().map(|hz| 1.0 / hz).collect();
    let spectrum = SourceSpectrum::new("s", "m", frequency, density, [1.0, 1e5]).unwrap();
    for range in [[40.0, 10_000.0], [1.0, 1e5], [50.0, 30_000.0], [3.3, 7.7], [50e3, 90e3]] {
        let bands = spectrum.band_levels(range);
        let sum: f64 = bands.iter().map(|band| band.energy).sum();
        assert!(
            (sum / spectrum.energy(range, Weighting::Z) - 1.0).abs() < 1e-12,
            "{range:?}"
        );
        // 1/f has the same energy in each whole band, that of a third octave: 0.1 ln 10.
        let whole = bands
            .iter()
            .filter(|b| b.band.low >= range[0] && b.band.high <= range[1]);
        for band in whole {
            assert!((band.energy / (0.1 * 10f64.ln()) - 1.0).abs() < 1e-3, "{:?}", band.band);
        }
    }
    // The usual bands are there in every case, and an end on an edge adds none.
    assert_eq!(bands_of([50.0, 1000.0]).len(), 27);
    assert_eq!(bands_of([Band::new(-13).low, Band::new(13).high]).len(), 27);
    assert_eq!(bands_of([40.0, 25_000.0]).len(), 29);
    assert_eq!(bands_of([0.0, f64::INFINITY]).len(), 27);
}

#[test]
fn filters_find_a_pink_spectrum_as_their_bandwidth_says() {
    let frequency: Vec<f64> = (1..60_000).map(f64::from).collect();
    let density = frequency.iter().map(|f| 1.0 / f).collect();
    let pink = SourceSpectrum::new("pink", "given", frequency, density, [1.0, 60_000.0]).unwrap();
    let (filtered, exact) = (pink.filter_levels([1.0, 60_000.0]), pink.band_levels([1.0, 60_000.0]));
    // Below 50 Hz the samples are too widely spaced; above 10 kHz the spectrum ends within the filters.
    let dense = filtered
        .iter()
        .zip(&exact)
        .filter(|(f, _)| (-13..11).contains(&f.band.index));
    for (f, e) in dense {
        let deviation = f.lw.unwrap() - e.lw.unwrap();
        assert!((0.1..0.3).contains(&deviation), "{}: {deviation}", f.band.hz);
    }
}

#[test]
fn a_peak_between_samples_is_found() {
    // Samples of a 24 kHz / 4 tone that miss its crests by an eighth of a period.
    let record: Vec<f64> = (0..4800).map(|i| (PI / 2.0 * (f64::from(i) + 0.5)).sin()).collect();
    let peak = peak_level(&record, 1.0 / 24_000.0, Weighting::Z).unwrap().unwrap();
    let sampled = 20.0 * (0.5f64.sqrt() / REFERENCE_PRESSURE).log10();
    assert!(peak > sampled + 2.9, "{peak} {sampled}");
    assert_eq!(peak_level(&[0.0; 100], 1e-4, Weighting::C).unwrap(), None);
    assert!(exposure_level(&[f64::NAN], 1e-4, Weighting::A).is_err());
}
