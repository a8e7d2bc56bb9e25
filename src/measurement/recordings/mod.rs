//! Recordings of a shot: WAV, universal files and CSV, read as signals in SI units on one time axis.

mod calibration;
mod csv;
mod fault;
mod shot;
mod signals;
mod universal;
pub mod wav;

use std::path::Path;

pub(crate) use calibration::calibrator_rms;
pub use calibration::{Calibration, Calibrator, FullScale, Quantity};
pub use fault::Fault;
pub use shot::Shot;
pub(crate) use signals::{Source, crossing, read, read_shot, refuse, unreadable};

/// Lowest sampling rate \[Hz\]: the highest one-third-octave band, 10 kHz, ends at 11.2 kHz.
pub const LOWEST_RATE: f64 = 25e3;

/// Least record after the trigger \[s\]: the machine sounds for about 0.1 s; the rest holds the decay of the room and
/// the way to the microphones.
pub const SHOT: f64 = 0.15;

/// Samples in a row at full scale that are an overload.
pub const RUN: usize = 3;

/// The largest recording that is read \[byte\]: nine channels of 32 bits at 160 kHz for 44 s.
pub const LARGEST: u64 = 1 << 28;

/// Largest deviation of a sample's time from an even axis, in intervals. A missing sample is off by one; times of few
/// digits are off by less.
pub const EVENNESS: f64 = 0.1;

/// Largest relative difference of sampling rates that are the same: the six digits of a universal file.
pub const SAME_RATE: f64 = 1e-5;

/// Which channel of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Selector {
    /// A channel of a WAV file or a dataset 58 of a universal file, from 1.
    Channel(usize),
    /// A column of a CSV file by its heading.
    Column(String),
}

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Integers as fractions of the largest one.
    Integers,
    /// Floats whose full scale is 1 by convention.
    Fractions,
    /// Numbers in a unit.
    InUnit,
}

/// Samples of one channel as the file holds them.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Sampling rate \[Hz\].
    pub rate: f64,
    /// Time of the first sample \[s\], where the file states it.
    pub start: Option<f64>,
    /// The samples.
    pub samples: Vec<f64>,
    /// What they are.
    pub numbers: Numbers,
    /// Label of their unit in the file; empty where there is none.
    pub unit: String,
}

/// Why a file cannot be read, and for which of the channels asked for.
pub type Refusal = (usize, Fault);

/// Reads channels of a recording; the format follows from the bytes. `path` is for messages.
///
/// # Errors
/// The fault, with the index of the channel in `channels`; a fault of the whole file has index 0.
pub fn decode(bytes: &[u8], path: &Path, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let first_line = bytes
        .split(|byte| *byte == b'\n')
        .find(|line| !line.trim_ascii().is_empty());
    let tracks = if bytes.starts_with(b"RIFF") {
        wav::decode(bytes, channels)
    } else if first_line.is_some_and(|line| line.trim_ascii() == b"-1") {
        universal::decode(bytes, path, channels)
    } else {
        csv::decode(bytes, channels)
    }?;
    for (index, track) in tracks.iter().enumerate() {
        let wrong = track.samples.iter().enumerate().find(|(_, value)| !value.is_finite());
        if let Some((at, value)) = wrong {
            let sample = at + 1;
            return Err((index, Fault::NotFinite { sample, value: *value }));
        }
    }
    Ok(tracks)
}

/// The number of each channel, for the formats that count them.
fn numbers(channels: &[&Selector], format: &'static str) -> Result<Vec<usize>, Refusal> {
    let number = |(index, selector): (usize, &&Selector)| match selector {
        Selector::Channel(number) => Ok(*number),
        Selector::Column(_) => Err((
            index,
            Fault::Selector {
                format,
                expected: "channel",
            },
        )),
    };
    channels.iter().enumerate().map(number).collect()
}

/// Rate and first time of an even time axis \[s\].
///
/// A rate within the six digits of a universal file of a whole number is that number.
fn even_axis(times: &[f64]) -> Result<(f64, f64), Fault> {
    let [start, .., end] = times else {
        return Err(Fault::Empty { samples: times.len() });
    };
    let step = (end - start) / (times.len() - 1) as f64;
    let uneven = |index: usize| Fault::Uneven {
        sample: index + 1,
        time: times[index],
        expected: start + step * index as f64,
    };
    if !(step > 0.0 && step.is_finite()) {
        return Err(uneven(1));
    }
    let off = |index: &usize| (times[*index] - (start + step * *index as f64)).abs() > EVENNESS * step;
    match (0..times.len()).find(off) {
        Some(_) => Err(uneven(first_jump(times))),
        None => Ok((nominal(1.0 / step), *start)),
    }
}

/// The sample behind the interval that differs most from the median one.
fn first_jump(times: &[f64]) -> usize {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let off = |step: &f64| (step - median).abs();
    let largest = steps.iter().enumerate().max_by(|a, b| off(a.1).total_cmp(&off(b.1)));
    largest.map_or(1, |(index, _)| index + 1)
}

fn nominal(rate: f64) -> f64 {
    let whole = rate.round();
    if (rate - whole).abs() <= 0.5 * SAME_RATE * rate {
        whole
    } else {
        rate
    }
}
