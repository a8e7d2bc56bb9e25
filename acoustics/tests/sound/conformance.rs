//! Conformance with the standards of filters and meters: one table, checked row by row and stored in `docs/`.

use nailnoise_acoustics::levels::{
    Band, BandFilter, REFERENCE_PRESSURE, SourceSpectrum, Weighting, energy_level, exposure_level, peak_level,
    third_octaves,
};
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The requirement of a standard and the computed value.
struct Row {
    clause: &'static str,
    quantity: String,
    /// Value of the standard's table.
    expected: f64,
    computed: f64,
    /// Least and greatest value allowed; infinite if there is no limit.
    limits: [f64; 2],
    decimals: usize,
}

impl Row {
    /// Part of the tolerance used, 1 at its limit. Where the standard requires only a least attenuation, the energy
    /// that passes over the energy that may.
    fn share(&self) -> f64 {
        let [low, high] = self.limits;
        let deviation = self.computed - self.expected;
        if self.expected == low {
            10f64.powf(-deviation / 10.0)
        } else if deviation < 0.0 {
            deviation / (low - self.expected)
        } else {
            deviation / (high - self.expected)
        }
    }

    fn line(&self) -> String {
        let number = |x: f64| {
            let text = format!("{x:.0$}", self.decimals);
            let zero = text.chars().all(|c| "-0.".contains(c));
            if zero { text.replace('-', "") } else { text }
        };
        let limit = |x: f64, open: &str| if x.is_finite() { number(x) } else { open.to_owned() };
        format!(
            "| {} | {} | {} | {} | {} to {} | {:.0} % |",
            self.clause,
            self.quantity,
            number(self.expected),
            number(self.computed),
            limit(self.limits[0], "-inf"),
            limit(self.limits[1], "inf"),
            100.0 * self.share().abs()
        )
    }
}

/// Limits around a value.
fn around(expected: f64, below: f64, above: f64) -> [f64; 2] {
    [expected - below, expected + above]
}

const INF: f64 = f64::INFINITY;

/// IEC 61672-1:2013, table 3: nominal frequency, A, C, lower and upper acceptance limit of class 1.
const TABLE_3: [(f64, f64, f64, f64, f64); 34] = [
    (10.0, -70.4, -14.3, INF, 3.0),
    (12.5, -63.4, -11.2, INF, 2.5),
    (16.0, -56.7, -8.5, 4.0, 2.0),
    (20.0, -50.5, -6.2, 2.0, 2.0),
    (25.0, -44.7, -4.4, 1.5, 2.0),
    (31.5, -39.4, -3.0, 1.5, 1.5),
    (40.0, -34.6, -2.0, 1.0, 1.0),
    (50.0, -30.2, -1.3, 1.0, 1.0),
    (63.0, -26.2, -0.8, 1.0, 1.0),
    (80.0, -22.5, -0.5, 1.0, 1.0),
    (100.0, -19.1, -0.3, 1.0, 1.0),
    (125.0, -16.1, -0.2, 1.0, 1.0),
    (160.0, -13.4, -0.1, 1.0, 1.0),
    (200.0, -10.9, 0.0, 1.0, 1.0),
    (250.0, -8.6, 0.0, 1.0, 1.0),
    (315.0, -6.6, 0.0, 1.0, 1.0),
    (400.0, -4.8, 0.0, 1.0, 1.0),
    (500.0, -3.2, 0.0, 1.0, 1.0),
    (630.0, -1.9, 0.0, 1.0, 1.0),
    (800.0, -0.8, 0.0, 1.0, 1.0),
    (1000.0, 0.0, 0.0, 0.7, 0.7),
    (1250.0, 0.6, 0.0, 1.0, 1.0),
    (1600.0, 1.0, -0.1, 1.0, 1.0),
    (2000.0, 1.2, -0.2, 1.0, 1.0),
    (2500.0, 1.3, -0.3, 1.0, 1.0),
    (3150.0, 1.2, -0.5, 1.0, 1.0),
    (4000.0, 1.0, -0.8, 1.0, 1.0),
    (5000.0, 0.5, -1.3, 1.5, 1.5),
    (6300.0, -0.1, -2.0, 2.0, 1.5),
    (8000.0, -1.1, -3.0, 2.5, 1.5),
    (10_000.0, -2.5, -4.4, 3.0, 2.0),
    (12_500.0, -4.3, -6.2, 5.0, 2.0),
    (16_000.0, -6.6, -8.5, 16.0, 2.5),
    (20_000.0, -9.3, -11.2, INF, 3.0),
];

/// The table applies to the exact frequencies 1000 x 10^{k/10} behind the nominal ones.
fn weightings() -> Vec<Row> {
    let mut rows = Vec::new();
    for (i, (nominal, a, c, lower, upper)) in TABLE_3.into_iter().enumerate() {
        let hz = 1000.0 * 10f64.powf((i as f64 - 20.0) / 10.0);
        for (name, weighting, expected) in [("A", Weighting::A, a), ("C", Weighting::C, c), ("Z", Weighting::Z, 0.0)] {
            // Z is the same at every frequency.
            if name != "Z" || [10.0, 1000.0, 20_000.0].contains(&nominal) {
                rows.push(Row {
                    clause: "IEC 61672-1, table 3",
                    quantity: format!("{name} at {nominal} Hz, dB"),
                    expected,
                    computed: weighting.db(hz),
                    limits: around(expected, lower, upper),
                    decimals: 2,
                });
            }
        }
    }
    rows
}

/// IEC 61672-1:2013, table 4: duration of a 4 kHz burst in ms, L_AE - L_A, limits of class 1.
const TABLE_4: [(f64, f64, f64, f64); 12] = [
    (1000.0, 0.0, 0.5, 0.5),
    (500.0, -3.0, 0.5, 0.5),
    (200.0, -7.0, 0.5, 0.5),
    (100.0, -10.0, 1.0, 1.0),
    (50.0, -13.0, 1.0, 1.0),
    (20.0, -17.0, 1.0, 1.0),
    (10.0, -20.0, 1.0, 1.0),
    (5.0, -23.0, 1.0, 1.0),
    (2.0, -27.0, 1.5, 1.0),
    (1.0, -30.0, 2.0, 1.0),
    (0.5, -33.0, 2.5, 1.0),
    (0.25, -36.0, 3.0, 1.0),
];

const DT: f64 = 1.0 / 96_000.0;

/// A sine of amplitude 1 Pa that starts and ends at zero crossings.
fn burst(hz: f64, seconds: f64) -> Vec<f64> {
    (0..(seconds / DT).round() as usize)
        .map(|i| (2.0 * PI * hz * i as f64 * DT).sin())
        .collect()
}

/// Level of the steady sine of amplitude 1 Pa.
fn steady(hz: f64, weighting: Weighting) -> f64 {
    10.0 * (0.5 / REFERENCE_PRESSURE.powi(2)).log10() + weighting.db(hz)
}

fn events() -> Vec<Row> {
    let exposure = |(ms, expected, lower, upper): (f64, f64, f64, f64)| Row {
        clause: "IEC 61672-1, table 4",
        quantity: format!("L_AE - L_A of a 4 kHz burst of {ms} ms, dB"),
        expected,
        computed: exposure_level(&burst(4000.0, 1e-3 * ms), DT, Weighting::A)
            .unwrap()
            .unwrap()
            - steady(4000.0, Weighting::A),
        limits: around(expected, lower, upper),
        decimals: 2,
    };
    let mut rows: Vec<Row> = TABLE_4.into_iter().map(exposure).collect();
    // Table 5: cycles, frequency, L_Cpeak - L_C, limit of class 1.
    for (cycles, hz, expected, limit) in [
        (1.0, 31.5, 2.5, 2.0),
        (1.0, 500.0, 3.5, 1.0),
        (1.0, 8000.0, 3.4, 2.0),
        (0.5, 500.0, 2.4, 1.0),
    ] {
        for sign in [1.0, -1.0] {
            let record: Vec<f64> = burst(hz, cycles / hz).iter().map(|p| sign * p).collect();
            let half = match (cycles < 1.0, sign > 0.0) {
                (false, true) => "one cycle",
                (false, false) => continue,
                (true, true) => "positive half cycle",
                (true, false) => "negative half cycle",
            };
            rows.push(Row {
                clause: "IEC 61672-1, table 5",
                quantity: format!("L_Cpeak - L_C of {half} of {hz} Hz, dB"),
                expected,
                computed: peak_level(&record, DT, Weighting::C).unwrap().unwrap() - steady(hz, Weighting::C),
                limits: around(expected, limit, limit),
                decimals: 2,
            });
        }
    }
    for (energy, expected) in [(1.0, 120.0), (1e-12, 0.0)] {
        rows.push(Row {
            clause: "ISO 1683",
            quantity: format!("L_W,1s of {energy:e} J, dB"),
            expected,
            computed: energy_level(energy).unwrap(),
            limits: around(expected, 1e-9, 1e-9),
            decimals: 10,
        });
    }
    rows
}

/// IEC 61260-1:2014, table F.1: exponent x of the breakpoint G^x of an octave filter, and its place for a third octave.
const TABLE_F1: [(f64, f64); 8] = [
    (0.125, 1.02667),
    (0.25, 1.05575),
    (0.375, 1.08746),
    (0.5, 1.12202),
    (1.0, 1.29437),
    (2.0, 1.88173),
    (3.0, 3.05365),
    (4.0, 5.39195),
];

/// IEC 61260-1:2014, table 1: the same exponents with the least and greatest relative attenuation of class 1.
const TABLE_1: [(f64, f64, f64); 9] = [
    (0.0, -0.4, 0.4),
    (0.125, -0.4, 0.5),
    (0.25, -0.4, 0.7),
    (0.375, -0.4, 1.4),
    (0.5, 1.2, 5.3),
    (1.0, 16.6, INF),
    (2.0, 40.5, INF),
    (3.0, 60.0, INF),
    (4.0, 70.0, INF),
];

/// Place of the breakpoint G^x for a third-octave filter (formula 9).
fn breakpoint(x: f64) -> f64 {
    let g = 10f64.powf(0.3);
    1.0 + (g.powf(1.0 / 6.0) - 1.0) / (g.powf(0.5) - 1.0) * (g.powf(x) - 1.0)
}

fn bands() -> Vec<Row> {
    let mut rows = Vec::new();
    for (k, hz) in [
        (-13, 50.119),
        (-10, 100.0),
        (-7, 199.53),
        (0, 1000.0),
        (7, 5011.9),
        (10, 10_000.0),
        (13, 19_953.0),
    ] {
        rows.push(Row {
            clause: "IEC 61260-1, annex E",
            quantity: format!("mid-band frequency, k = {k}, over its five digits"),
            expected: 1.0,
            computed: Band::new(k).hz / hz,
            limits: around(1.0, 5e-5, 5e-5),
            decimals: 6,
        });
    }
    for band in third_octaves()
        .into_iter()
        .filter(|band| [-13, 0, 13].contains(&band.index))
    {
        for (name, ratio) in [("f_2/f_m", band.high / band.hz), ("f_m/f_1", band.hz / band.low)] {
            rows.push(Row {
                clause: "IEC 61260-1, 5.5 and table F.1",
                quantity: format!("{name}, band of {} Hz", band.nominal_hz()),
                expected: 1.12202,
                computed: ratio,
                limits: around(1.12202, 5e-6, 5e-6),
                decimals: 6,
            });
        }
    }
    rows
}

/// Every band's attenuation at the breakpoints, the worst of both sides and all bands.
fn filters() -> Vec<Row> {
    let mut rows = Vec::new();
    for (x, least, greatest) in TABLE_1 {
        let omega = breakpoint(x);
        let attenuations: Vec<f64> = third_octaves()
            .into_iter()
            .flat_map(|band| [omega, 1.0 / omega].map(|o| BandFilter { band }.attenuation_db(o * band.hz)))
            .collect();
        let (low, high) = attenuations.iter().fold((INF, -INF), |(l, h), &a| (a.min(l), a.max(h)));
        // Inside the band no attenuation is aimed at; at its edge the aim is the middle between the limits.
        let expected = match x {
            x if x < 0.5 => 0.0,
            0.5 => 0.5 * (least + greatest),
            _ => least,
        };
        for (name, a) in [("least", low), ("greatest", high)] {
            if name == "greatest" && high - low < 1e-9 {
                continue;
            }
            rows.push(Row {
                clause: "IEC 61260-1, table 1, class 1",
                quantity: format!("filter, {name} attenuation of 27 bands at G^{x}, dB"),
                expected,
                computed: a,
                limits: [least, greatest],
                decimals: 2,
            });
        }
    }
    for (x, expected) in TABLE_F1 {
        rows.push(Row {
            clause: "IEC 61260-1, table F.1",
            quantity: format!("place of the breakpoint G^{x} for a third octave, f/f_m"),
            expected,
            computed: breakpoint(x),
            limits: around(expected, 5e-6, 5e-6),
            decimals: 6,
        });
    }
    // Effective bandwidth over ln(f_2/f_1), which white noise per octave passes through.
    let band = Band::new(0);
    let filter = BandFilter { band };
    let steps = 400_000;
    let h = 16.0 / f64::from(steps);
    let passed: f64 = (0..steps)
        .map(|i| filter.energy_factor(band.hz * (-8.0 + (f64::from(i) + 0.5) * h).exp()) * h)
        .sum();
    rows.push(Row {
        clause: "IEC 61260-1, 5.12, class 1",
        quantity: "filter, effective bandwidth deviation, dB".to_owned(),
        expected: 0.0,
        computed: 10.0 * (passed / (band.high / band.low).ln()).log10(),
        limits: around(0.0, 0.4, 0.4),
        decimals: 2,
    });
    rows
}

/// Integration between the exact edges, through tones a hundredth of a band inside and outside them.
fn integration() -> Vec<Row> {
    let band = Band::new(0);
    let tone = |hz: f64| {
        let (frequency, density) = (vec![hz - 0.01, hz, hz + 0.01], vec![0.0, 100.0, 0.0]);
        let spectrum = SourceSpectrum::new("tone", "given", frequency, density, [20.0, 20_000.0]).unwrap();
        let levels = spectrum.band_levels([20.0, 20_000.0]);
        let own = levels.iter().find(|level| level.band == band).unwrap();
        (own.energy, spectrum.energy([20.0, 20_000.0], Weighting::Z))
    };
    let inside = [0.0, 0.125, 0.25, 0.375, 0.499];
    let mut rows: Vec<Row> = Vec::new();
    for x in inside {
        let omega = breakpoint(x);
        for hz in [omega * band.hz, band.hz / omega] {
            let (found, total) = tone(hz);
            rows.push(Row {
                clause: "IEC 61260-1, table 1, class 1",
                quantity: format!("bands by integration, attenuation of a tone at {hz:.2} Hz, dB"),
                expected: 0.0,
                computed: 10.0 * (total / found).log10(),
                limits: around(0.0, 0.4, 0.4),
                decimals: 2,
            });
            if x == 0.0 {
                break;
            }
        }
    }
    for x in [0.501, 1.0] {
        for hz in [breakpoint(x) * band.hz, band.hz / breakpoint(x)] {
            let (found, total) = tone(hz);
            rows.push(Row {
                clause: "IEC 61260-1, table 1, class 1",
                quantity: format!("bands by integration, energy that passes of a tone at {hz:.2} Hz"),
                expected: 0.0,
                computed: found / total,
                limits: around(0.0, 1e-7, 1e-7),
                decimals: 7,
            });
        }
    }
    rows
}

const INTRODUCTION: &str = "# Conformance of bands, weightings and levels

`acoustics/tests/sound/conformance.rs` computes every row with the library and checks it against the limits of the standard. It
also writes this page (`NAILNOISE_UPDATE_DOCS=1 cargo test --release -p nailnoise-acoustics --test sound conformance`) and fails
when the page is out of date. The last column is the share of the tolerance used, on the side of the deviation; 100 % is the
limit. Where a standard sets a minimum attenuation, the share is the transmitted energy divided by the permitted energy. A
table of a standard that is rounded to 0.1 dB uses up to 0.05 dB of the tolerance.

The editions are IEC 61672-1:2013 and IEC 61260-1:2014. Their tables 3, 1 and F.1 agree with transcriptions published in
open-source libraries. Tables 4 and 5 of IEC 61672-1 and the bandwidth limit of IEC 61260-1 are quoted from memory, not read
from the standard. One-sided limits are marked `inf`.

| clause | quantity | expected | computed | limits | used |
|---|---|---|---|---|---|
";

#[test]
fn every_row_conforms_and_the_table_in_docs_is_generated() {
    let mut text = INTRODUCTION.to_owned();
    for row in [weightings(), events(), bands(), integration(), filters()]
        .into_iter()
        .flatten()
    {
        let share = row.share();
        assert!(
            share <= 1.0,
            "{}: {} is {} of its tolerance",
            row.clause,
            row.quantity,
            share
        );
        writeln!(text, "{}", row.line()).unwrap();
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/conformance-acoustics.md");
    if std::env::var_os("NAILNOISE_UPDATE_DOCS").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == text,
        "docs/conformance-acoustics.md is old: run this test with NAILNOISE_UPDATE_DOCS=1"
    );
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
