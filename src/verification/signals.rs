//! Bands, weightings and levels compared with the tables of IEC 61672-1 and IEC 61260-1.

use std::f64::consts::PI;

use nailnoise_acoustics::signals::{
    Band, BandFilter, REFERENCE_PRESSURE, SourceSpectrum, Weighting, energy_level, exposure_level, peak_level,
    third_octaves,
};

use super::row::{Case, Row};
use crate::error::Error;

const WEIGHTINGS: Case = Case {
    name: "IEC 61672-1, table 3",
    source: "IEC 61672-1:2013; as transcribed in open-source libraries",
};
const BURSTS: Case = Case {
    name: "IEC 61672-1, table 4",
    source: "IEC 61672-1:2013; not compared with the printed table",
};
const PEAKS: Case = Case {
    name: "IEC 61672-1, table 5",
    source: "IEC 61672-1:2013; not compared with the printed table",
};
const REFERENCE: Case = Case {
    name: "ISO 1683",
    source: "ISO 1683",
};
const MIDBANDS: Case = Case {
    name: "IEC 61260-1, annex E",
    source: "IEC 61260-1:2014",
};
const EDGES: Case = Case {
    name: "IEC 61260-1, 5.5 and table F.1",
    source: "IEC 61260-1:2014",
};
const MASK: Case = Case {
    name: "IEC 61260-1, table 1, class 1",
    source: "IEC 61260-1:2014; as transcribed in open-source libraries",
};
const BREAKPOINTS: Case = Case {
    name: "IEC 61260-1, table F.1",
    source: "IEC 61260-1:2014; as transcribed in open-source libraries",
};
const BANDWIDTH: Case = Case {
    name: "IEC 61260-1, 5.12, class 1",
    source: "IEC 61260-1:2014; not compared with the printed limit",
};

const INF: f64 = f64::INFINITY;

/// IEC 61672-1:2013, table 3: nominal frequency, A, C, lower and upper acceptance limit of class 1.
const TABLE_3: [[f64; 5]; 34] = [
    [10.0, -70.4, -14.3, INF, 3.0],
    [12.5, -63.4, -11.2, INF, 2.5],
    [16.0, -56.7, -8.5, 4.0, 2.0],
    [20.0, -50.5, -6.2, 2.0, 2.0],
    [25.0, -44.7, -4.4, 1.5, 2.0],
    [31.5, -39.4, -3.0, 1.5, 1.5],
    [40.0, -34.6, -2.0, 1.0, 1.0],
    [50.0, -30.2, -1.3, 1.0, 1.0],
    [63.0, -26.2, -0.8, 1.0, 1.0],
    [80.0, -22.5, -0.5, 1.0, 1.0],
    [100.0, -19.1, -0.3, 1.0, 1.0],
    [125.0, -16.1, -0.2, 1.0, 1.0],
    [160.0, -13.4, -0.1, 1.0, 1.0],
    [200.0, -10.9, 0.0, 1.0, 1.0],
    [250.0, -8.6, 0.0, 1.0, 1.0],
    [315.0, -6.6, 0.0, 1.0, 1.0],
    [400.0, -4.8, 0.0, 1.0, 1.0],
    [500.0, -3.2, 0.0, 1.0, 1.0],
    [630.0, -1.9, 0.0, 1.0, 1.0],
    [800.0, -0.8, 0.0, 1.0, 1.0],
    [1000.0, 0.0, 0.0, 0.7, 0.7],
    [1250.0, 0.6, 0.0, 1.0, 1.0],
    [1600.0, 1.0, -0.1, 1.0, 1.0],
    [2000.0, 1.2, -0.2, 1.0, 1.0],
    [2500.0, 1.3, -0.3, 1.0, 1.0],
    [3150.0, 1.2, -0.5, 1.0, 1.0],
    [4000.0, 1.0, -0.8, 1.0, 1.0],
    [5000.0, 0.5, -1.3, 1.5, 1.5],
    [6300.0, -0.1, -2.0, 2.0, 1.5],
    [8000.0, -1.1, -3.0, 2.5, 1.5],
    [10_000.0, -2.5, -4.4, 3.0, 2.0],
    [12_500.0, -4.3, -6.2, 5.0, 2.0],
    [16_000.0, -6.6, -8.5, 16.0, 2.5],
    [20_000.0, -9.3, -11.2, INF, 3.0],
];

/// The table applies to the exact frequencies 1000 x 10^{k/10}, not to the nominal ones.
fn weightings() -> Vec<Row> {
    let mut rows = Vec::new();
    for (i, [nominal, a, c, lower, upper]) in TABLE_3.into_iter().enumerate() {
        let hz = 1000.0 * 10f64.powf((i as f64 - 20.0) / 10.0);
        for (name, weighting, expected) in [("A", Weighting::A, a), ("C", Weighting::C, c), ("Z", Weighting::Z, 0.0)] {
            // Z is the same at every frequency.
            if name != "Z" || [10.0, 1000.0, 20_000.0].contains(&nominal) {
                rows.push(
                    WEIGHTINGS
                        .row(format!("{name} at {nominal} Hz, dB"), expected, weighting.db(hz))
                        .limits([expected - lower, expected + upper]),
                );
            }
        }
    }
    rows
}

/// IEC 61672-1:2013, table 4: duration of a 4 kHz burst in ms, L_AE - L_A, limits of class 1.
const TABLE_4: [[f64; 4]; 12] = [
    [1000.0, 0.0, 0.5, 0.5],
    [500.0, -3.0, 0.5, 0.5],
    [200.0, -7.0, 0.5, 0.5],
    [100.0, -10.0, 1.0, 1.0],
    [50.0, -13.0, 1.0, 1.0],
    [20.0, -17.0, 1.0, 1.0],
    [10.0, -20.0, 1.0, 1.0],
    [5.0, -23.0, 1.0, 1.0],
    [2.0, -27.0, 1.5, 1.0],
    [1.0, -30.0, 2.0, 1.0],
    [0.5, -33.0, 2.5, 1.0],
    [0.25, -36.0, 3.0, 1.0],
];

const DT: f64 = 1.0 / 96_000.0;

/// A sine with an amplitude of 1 Pa that starts and ends at zero crossings.
fn burst(hz: f64, seconds: f64) -> Vec<f64> {
    (0..(seconds / DT).round() as usize)
        .map(|i| (2.0 * PI * hz * i as f64 * DT).sin())
        .collect()
}

/// Level of a steady sine with an amplitude of 1 Pa.
fn steady(hz: f64, weighting: Weighting) -> f64 {
    10.0 * (0.5 / REFERENCE_PRESSURE.powi(2)).log10() + weighting.db(hz)
}

fn events() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for [ms, expected, lower, upper] in TABLE_4 {
        let exposure = exposure_level(&burst(4000.0, 1e-3 * ms), DT, Weighting::A)?.unwrap_or(f64::NAN);
        let computed = exposure - steady(4000.0, Weighting::A);
        let row = BURSTS.row(
            format!("L_AE - L_A of a 4 kHz burst of {ms} ms, dB"),
            expected,
            computed,
        );
        rows.push(row.limits([expected - lower, expected + upper]));
    }
    let peak = |what: &str, hz: f64, record: &[f64], expected: f64, limit: f64| -> Result<Row, Error> {
        let computed = peak_level(record, DT, Weighting::C)?.unwrap_or(f64::NAN) - steady(hz, Weighting::C);
        let row = PEAKS.row(format!("L_Cpeak - L_C of {what} of {hz} Hz, dB"), expected, computed);
        Ok(row.within(limit))
    };
    for [hz, expected, limit] in [[31.5, 2.5, 2.0], [500.0, 3.5, 1.0], [8000.0, 3.4, 2.0]] {
        rows.push(peak("one cycle", hz, &burst(hz, 1.0 / hz), expected, limit)?);
    }
    let half = burst(500.0, 1e-3);
    let negative: Vec<f64> = half.iter().map(|p| -p).collect();
    rows.push(peak("positive half cycle", 500.0, &half, 2.4, 1.0)?);
    rows.push(peak("negative half cycle", 500.0, &negative, 2.4, 1.0)?);
    for [energy, expected] in [[1.0, 120.0], [1e-12, 0.0]] {
        let computed = energy_level(energy).unwrap_or(f64::NAN);
        let row = REFERENCE.row(format!("L_W,1s of {energy:e} J, dB"), expected, computed);
        rows.push(row.within(1e-9).decimals(10));
    }
    Ok(rows)
}

/// IEC 61260-1:2014, table F.1: exponent x of the breakpoint G^x of an octave filter, and the position of this
/// breakpoint for a third-octave filter.
const TABLE_F1: [[f64; 2]; 8] = [
    [0.125, 1.02667],
    [0.25, 1.05575],
    [0.375, 1.08746],
    [0.5, 1.12202],
    [1.0, 1.29437],
    [2.0, 1.88173],
    [3.0, 3.05365],
    [4.0, 5.39195],
];

/// IEC 61260-1:2014, table 1: the same exponents with the minimum and maximum relative attenuation of class 1.
const TABLE_1: [[f64; 3]; 9] = [
    [0.0, -0.4, 0.4],
    [0.125, -0.4, 0.5],
    [0.25, -0.4, 0.7],
    [0.375, -0.4, 1.4],
    [0.5, 1.2, 5.3],
    [1.0, 16.6, INF],
    [2.0, 40.5, INF],
    [3.0, 60.0, INF],
    [4.0, 70.0, INF],
];

/// Position of the breakpoint G^x for a third-octave filter (formula 9).
fn breakpoint(x: f64) -> f64 {
    let g = 10f64.powf(0.3);
    1.0 + (g.powf(1.0 / 6.0) - 1.0) / (g.powf(0.5) - 1.0) * (g.powf(x) - 1.0)
}

/// IEC 61260-1:2014, annex E: five digits of the mid-band frequencies k = -13, -10, -7, 0, 7, 10, 13.
const MID_BANDS: [f64; 7] = [50.119, 100.0, 199.53, 1000.0, 5011.9, 10_000.0, 19_953.0];

fn bands() -> Vec<Row> {
    let mut rows = Vec::new();
    for (k, hz) in [-13, -10, -7, 0, 7, 10, 13].into_iter().zip(MID_BANDS) {
        rows.push(
            MIDBANDS
                .row(
                    format!("mid-band frequency, k = {k}, over its five digits"),
                    1.0,
                    Band::new(k).hz / hz,
                )
                .within(5e-5)
                .decimals(6),
        );
    }
    for band in third_octaves()
        .into_iter()
        .filter(|band| [-13, 0, 13].contains(&band.index))
    {
        for (name, ratio) in [("f_2/f_m", band.high / band.hz), ("f_m/f_1", band.hz / band.low)] {
            rows.push(
                EDGES
                    .row(format!("{name}, band of {} Hz", band.nominal_hz()), 1.12202, ratio)
                    .within(5e-6)
                    .decimals(6),
            );
        }
    }
    rows
}

/// Every band's attenuation at the breakpoints; the worst of both sides and all bands.
fn filters() -> Vec<Row> {
    let mut rows = Vec::new();
    for [x, least, greatest] in TABLE_1 {
        let omega = breakpoint(x);
        let attenuations: Vec<f64> = third_octaves()
            .into_iter()
            .flat_map(|band| [omega, 1.0 / omega].map(|o| BandFilter { band }.attenuation_db(o * band.hz)))
            .collect();
        let (low, high) = attenuations.iter().fold((INF, -INF), |(l, h), &a| (a.min(l), a.max(h)));
        // Inside the band, the expected attenuation is zero; at its edge, it is the mean of the limits.
        let expected = match x {
            x if x < 0.5 => 0.0,
            0.5 => 0.5 * (least + greatest),
            _ => least,
        };
        for (name, a) in [("least", low), ("greatest", high)] {
            if name == "greatest" && high - low < 1e-9 {
                continue;
            }
            rows.push(
                MASK.row(
                    format!("filter, {name} attenuation of 27 bands at G^{x}, dB"),
                    expected,
                    a,
                )
                .limits([least, greatest]),
            );
        }
    }
    for [x, expected] in TABLE_F1 {
        rows.push(
            BREAKPOINTS
                .row(
                    format!("place of the breakpoint G^{x} for a third octave, f/f_m"),
                    expected,
                    breakpoint(x),
                )
                .within(5e-6)
                .decimals(6),
        );
    }
    // Effective bandwidth divided by ln(f_2/f_1), for white noise per octave.
    let band = Band::new(0);
    let filter = BandFilter { band };
    let steps = 400_000;
    let h = 16.0 / f64::from(steps);
    let passed: f64 = (0..steps)
        .map(|i| filter.energy_factor(band.hz * (-8.0 + (f64::from(i) + 0.5) * h).exp()) * h)
        .sum();
    rows.push(
        BANDWIDTH
            .row(
                "filter, effective bandwidth deviation, dB",
                0.0,
                10.0 * (passed / (band.high / band.low).ln()).log10(),
            )
            .within(0.4),
    );
    rows
}

/// Integration between the exact band edges, tested with tones a hundredth of a band inside and outside them.
fn integration() -> Result<Vec<Row>, Error> {
    const RANGE_HZ: [f64; 2] = [20.0, 20_000.0];
    let band = Band::new(0);
    // Fraction of a tone's energy in the band.
    let passed = |hz: f64| -> Result<f64, Error> {
        let (frequency, density) = (vec![hz - 0.01, hz, hz + 0.01], vec![0.0, 100.0, 0.0]);
        let spectrum = SourceSpectrum::new("tone", "given", frequency, density, RANGE_HZ)?;
        let levels = spectrum.band_levels(RANGE_HZ);
        let own = levels.iter().find(|level| level.band == band);
        Ok(own.map_or(f64::NAN, |level| level.energy) / spectrum.energy(RANGE_HZ, Weighting::Z))
    };
    let mut rows = Vec::new();
    for x in [0.0, 0.125, 0.25, 0.375, 0.499] {
        let omega = breakpoint(x);
        for hz in [omega * band.hz, band.hz / omega] {
            let attenuation = -10.0 * passed(hz)?.log10();
            let quantity = format!("bands by integration, attenuation of a tone at {hz:.2} Hz, dB");
            rows.push(MASK.row(quantity, 0.0, attenuation).within(0.4));
            if x == 0.0 {
                break;
            }
        }
    }
    for x in [0.501, 1.0] {
        for hz in [breakpoint(x) * band.hz, band.hz / breakpoint(x)] {
            let quantity = format!("bands by integration, energy that passes of a tone at {hz:.2} Hz");
            rows.push(MASK.row(quantity, 0.0, passed(hz)?).within(1e-7).decimals(7));
        }
    }
    Ok(rows)
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    Ok([weightings(), events()?, bands(), integration()?, filters()].concat())
}
