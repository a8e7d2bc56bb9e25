//! Loudness against the test signals of ISO 532-1:2017, annex B, as far as their description defines them.

use std::f64::consts::{PI, TAU};

use nailnoise_acoustics::AcousticsError;
use nailnoise_acoustics::signals::REFERENCE_PRESSURE;
use nailnoise_acoustics::signals::loudness::{
    BANDS, LoudnessError, SAMPLE_RATE, SoundField, stationary, steady_levels, time_varying,
};

use super::row::{Case, Row};
use crate::error::Error;

const SPECTRUM: Case = Case {
    name: "ISO 532-1, annex B.2",
    source: "ISO 532-1:2017, electronic attachment, as transcribed in jmrplens/phonometry",
};
const STEADY: Case = Case {
    name: "ISO 532-1, annex B.3",
    source: "ISO 532-1:2017, electronic attachment, as transcribed in jmrplens/phonometry; tones made from their \
        titles",
};
const VARYING: Case = Case {
    name: "ISO 532-1, annex B.4",
    source: "ISO 532-1:2017, electronic attachment, as transcribed in jmrplens/phonometry; tones made from their \
             description there",
};

/// Test signal 1: levels in the third octaves of 25 Hz to 12.5 kHz \[dB\].
const LEVELS: [f64; BANDS] = [
    -60.0, -60.0, 78.0, 79.0, 89.0, 72.0, 80.0, 89.0, 75.0, 87.0, 85.0, 79.0, 86.0, 80.0, 71.0, 70.0, 72.0, 71.0, 72.0,
    74.0, 69.0, 65.0, 67.0, 77.0, 68.0, 58.0, 45.0, 30.0,
];

/// Test signals 2 to 4: tones \[Hz\] with a level \[dB\] and their loudness \[sone\].
const TONES: [[f64; 3]; 3] = [[250.0, 80.0, 14.6545], [1000.0, 60.0, 4.0192], [4000.0, 40.0, 1.5494]];

/// Test signals 6 to 8: tones \[Hz\] that rise from 30 to 80 dB in 10 s; N_max and N_5 \[sone\].
const RAMPS: [[f64; 3]; 3] = [
    [250.0, 14.3592, 11.857_56],
    [1000.0, 15.9534, 13.378_87],
    [4000.0, 23.9501, 20.261_87],
];

/// Test signal 12: N_max \[sone\] of a 1 kHz pulse of 500 ms and 70 dB.
const PULSE: f64 = 8.0772;

/// Time over which a tone fades out, and the pulse also fades in \[s\]. A tone that is cut off would excite all bands.
const FADE: f64 = 0.005;

/// Silence before and after a varying tone \[s\].
const BEFORE: f64 = 0.1;
const AFTER: f64 = 0.5;

/// Tolerance of the standard: 5 %, at least 0.1 sone.
fn allowed(case: Case, quantity: String, reference: f64, computed: f64) -> Row {
    let row = case.row(quantity, reference, computed);
    row.within((0.05 * reference).max(0.1)).decimals(4)
}

/// A tone \[Pa\] with this frequency \[Hz\] and duration \[s\], whose level \[dB\] and envelope depend on time.
fn tone(hz: f64, seconds: f64, level: impl Fn(f64) -> f64, envelope: impl Fn(f64) -> f64) -> Vec<f64> {
    let sample = |i: usize| {
        let time = i as f64 / SAMPLE_RATE;
        let amplitude = 2f64.sqrt() * REFERENCE_PRESSURE * 10f64.powf(level(time) / 20.0);
        envelope(time) * amplitude * (TAU * hz * time).sin()
    };
    (0..(seconds * SAMPLE_RATE) as usize).map(sample).collect()
}

/// Raised cosine from 0 at 0 to 1 at [`FADE`] and after it.
fn rise(time: f64) -> f64 {
    0.5 * (1.0 - (PI * (time / FADE).clamp(0.0, 1.0)).cos())
}

/// A signal with silence before and after it.
fn framed(signal: Vec<f64>) -> Vec<f64> {
    let silence = |seconds: f64| vec![0.0; (seconds * SAMPLE_RATE) as usize];
    [silence(BEFORE), signal, silence(AFTER)].concat()
}

fn of(error: LoudnessError) -> Error {
    AcousticsError::from(error).into()
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let free = SoundField::Free;
    let loudness = stationary(&LEVELS, free).map_err(of)?;
    let mut rows = vec![allowed(SPECTRUM, "test signal 1, N, sone".into(), 83.2957, loudness)];
    for (number, [hz, level, reference]) in (2..).zip(TONES) {
        let levels = steady_levels(&tone(hz, 2.0, |_| level, |_| 1.0), 0.2).map_err(of)?;
        let quantity = format!("test signal {number}, {hz} Hz, {level} dB: N, sone");
        let computed = stationary(&levels, free).map_err(of)?;
        rows.push(allowed(STEADY, quantity, reference, computed));
    }
    for (number, [hz, n_max, n_5]) in (6..).zip(RAMPS) {
        let signal = tone(hz, 10.0, |t| 30.0 + 5.0 * t, |t| rise(10.0 - t));
        let history = time_varying(&framed(signal), free).map_err(of)?;
        for (name, reference, computed) in [("max", n_max, history.maximum()), ("5", n_5, history.exceeded(0.05))] {
            let quantity = format!("test signal {number}, {hz} Hz, 30 to 80 dB: N_{name}, sone");
            rows.push(allowed(VARYING, quantity, reference, computed));
        }
    }
    let pulse = tone(1000.0, 0.5 + FADE, |_| 70.0, |t| rise(t) * rise(0.5 + FADE - t));
    let history = time_varying(&framed(pulse), free).map_err(of)?;
    let quantity = "test signal 12, pulse of 500 ms: N_max, sone".into();
    rows.push(allowed(VARYING, quantity, PULSE, history.maximum()));
    Ok(rows)
}
