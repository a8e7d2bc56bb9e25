//! One shot: its files are read once each, scaled to SI units, checked, and truncated to a common length.

use std::path::{Path, PathBuf};

use super::calibration::{Calibration, Quantity, Scale};
use super::fault::Fault;
use super::{LOWEST_RATE, RUN, SAME_RATE, SHOT, Selector, Track, read_tracks};
use crate::error::MeasurementError;

/// Where a channel is recorded, and what its numbers mean.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Name of the channel.
    pub name: &'a str,
    /// What it measures.
    pub quantity: Quantity,
    /// Which channel of the file.
    pub selector: &'a Selector,
    /// What its numbers mean.
    pub calibration: &'a Calibration,
}

/// Signals in SI units and their rate \[Hz\], with the file of each.
pub struct Signals {
    /// Sampling rate \[Hz\].
    pub rate: f64,
    /// Samples of each channel in SI units.
    pub channels: Vec<Vec<f64>>,
    files: Vec<PathBuf>,
}

/// A fault of a channel in a file.
pub fn refuse(path: &Path, channel: &str, fault: Fault) -> MeasurementError {
    MeasurementError::Recording {
        path: path.to_owned(),
        channel: channel.to_owned(),
        fault: Box::new(fault),
    }
}

/// Reads channels of one file.
pub fn read(path: &Path, sources: &[Source<'_>]) -> Result<Vec<Track>, MeasurementError> {
    let selectors: Vec<&Selector> = sources.iter().map(|source| source.selector).collect();
    let tracks = read_tracks(path, &selectors).map_err(|error| unreadable(path, sources[0].name, &error))?;
    tracks.map_err(|(index, fault)| refuse(path, sources[index].name, fault))
}

/// A file that cannot be read.
pub fn unreadable(path: &Path, channel: &str, error: &std::io::Error) -> MeasurementError {
    MeasurementError::Unreadable {
        path: path.to_owned(),
        channel: Some(channel.to_owned()),
        cause: error.to_string(),
        help: "correct `file` of this channel ({c} is the configuration, {k} the repeat from 1), or `repeats`"
            .to_owned(),
    }
}

/// Reads the channels of one shot, each file once. `expected` is the sampling rate of the other shots \[Hz\], and a
/// file that has it.
///
/// # Errors
/// If a file cannot be read; the [`Fault`] of a channel.
pub fn read_shot(
    sources: &[(PathBuf, Source<'_>)],
    expected: Option<(f64, &Path)>,
) -> Result<Signals, MeasurementError> {
    let mut signals = Signals {
        rate: expected.map_or(0.0, |(rate, _)| rate),
        channels: vec![Vec::new(); sources.len()],
        files: sources.iter().map(|(path, _)| path.clone()).collect(),
    };
    let mut reference = expected.map(|(rate, path)| (rate, path.to_owned()));
    let mut origin: Option<(f64, PathBuf)> = None;
    let mut done: Vec<&Path> = Vec::new();
    for (path, _) in sources {
        if done.contains(&path.as_path()) {
            continue;
        }
        done.push(path);
        let indices: Vec<usize> = (0..sources.len()).filter(|&index| sources[index].0 == *path).collect();
        let own: Vec<Source<'_>> = indices.iter().map(|&index| sources[index].1).collect();
        for ((index, source), track) in indices.into_iter().zip(&own).zip(read(path, &own)?) {
            let refused = |fault| refuse(path, source.name, fault);
            match &reference {
                None => {
                    signals.rate = track.rate;
                    reference = Some((track.rate, path.clone()));
                }
                Some((rate, file)) => same_rate(track.rate, *rate, file).map_err(refused)?,
            }
            same_start(&track, &mut origin, path).map_err(refused)?;
            signals.channels[index] = si(track, source).map_err(refused)?;
        }
    }
    Ok(signals)
}

fn same_rate(rate: f64, other: f64, file: &Path) -> Result<(), Fault> {
    if (rate - other).abs() > SAME_RATE * other {
        let file = file.to_owned();
        return Err(Fault::RatesDiffer { rate, other, file });
    }
    Ok(())
}

/// Checks that time axes given in files start at the same time, within half a sample.
fn same_start(track: &Track, origin: &mut Option<(f64, PathBuf)>, path: &Path) -> Result<(), Fault> {
    let Some(start) = track.start else { return Ok(()) };
    let (other, file) = origin.get_or_insert_with(|| (start, path.to_owned()));
    if (start - *other).abs() * track.rate > 0.5 {
        let (other, file) = (*other, file.clone());
        return Err(Fault::StartsDiffer { start, other, file });
    }
    Ok(())
}

/// Converts samples to SI units and checks that none is clipped.
fn si(track: Track, source: &Source<'_>) -> Result<Vec<f64>, Fault> {
    if track.rate < LOWEST_RATE {
        return Err(Fault::LowRate { rate: track.rate });
    }
    let Scale { factor, full } = source.calibration.scale(&track, source.quantity)?;
    // A switch may reach full scale.
    let full = full.filter(|_| source.quantity != Quantity::Voltage);
    if let Some((at, count)) = full.and_then(|full| overload(&track.samples, full)) {
        return Err(Fault::Clipped {
            count,
            at: at as f64 / track.rate,
            value: factor * track.samples[at],
            unit: source.quantity.unit().to_owned(),
        });
    }
    let mut samples = track.samples;
    samples.iter_mut().for_each(|sample| *sample *= factor);
    Ok(samples)
}

/// Relative distance from full scale within which consecutive equal samples count as overload: the last step of 16
/// bits.
const LAST_STEP: f64 = 1.0 / 32_768.0;

/// The first run of [`RUN`] or more samples at full scale: its first sample and its length.
///
/// Samples of one sign are at full scale if they reach it, or if they are equal and one converter step below it.
pub(super) fn overload(samples: &[f64], full: f64) -> Option<(usize, usize)> {
    let near = (1.0 - LAST_STEP) * full;
    let continues = |a: f64, b: f64| a == b || (a.signum() == b.signum() && a.abs() >= full && b.abs() >= full);
    let mut index = 0;
    while index < samples.len() {
        if samples[index].abs() < near {
            index += 1;
            continue;
        }
        let mut end = index + 1;
        while end < samples.len() && samples[end].abs() >= near && continues(samples[end - 1], samples[end]) {
            end += 1;
        }
        if end - index >= RUN {
            return Some((index, end - index));
        }
        index = end;
    }
    None
}

impl Signals {
    /// A fault of one of the channels.
    pub fn refuse(&self, index: usize, name: &str, fault: Fault) -> MeasurementError {
        refuse(&self.files[index], name, fault)
    }

    /// Truncates all channels to the shortest one, which must extend [`SHOT`] beyond the trigger \[s\].
    ///
    /// Channels are truncated instead of padded, so that no samples are invented.
    pub fn cut(&mut self, trigger: f64, names: &[&str]) -> Result<(), MeasurementError> {
        let lengths = self.channels.iter().map(Vec::len).enumerate();
        let Some((shortest, length)) = lengths.min_by_key(|(_, length)| *length) else {
            return Ok(());
        };
        let after = length as f64 / self.rate - trigger;
        if after < SHOT {
            return Err(self.refuse(shortest, names[shortest], Fault::Short { after }));
        }
        self.channels.iter_mut().for_each(|channel| channel.truncate(length));
        Ok(())
    }
}

/// The fault of a signal that never changes: an open cable, or a channel that was not recorded.
pub fn dead(signal: &[f64], unit: &'static str) -> Option<Fault> {
    let (first, rest) = signal.split_first()?;
    rest.iter().all(|sample| sample == first).then_some(Fault::Dead {
        samples: signal.len(),
        value: *first,
        unit,
        others: Vec::new(),
    })
}

/// Time at which a signal first crosses a threshold away from zero, by linear interpolation between samples \[s\].
pub fn crossing(signal: &[f64], rate: f64, threshold: f64) -> Option<f64> {
    let beyond = |value: f64| {
        if threshold < 0.0 {
            value <= threshold
        } else {
            value >= threshold
        }
    };
    let pair = signal.windows(2).position(|pair| !beyond(pair[0]) && beyond(pair[1]))?;
    let share = (threshold - signal[pair]) / (signal[pair + 1] - signal[pair]);
    Some((pair as f64 + share) / rate)
}
