//! Anomalies of individual channels: a level far from those of the other microphones, a constant offset.

use nailnoise_acoustics::signals::REFERENCE_PRESSURE;

use crate::arrangement::Arrangement;
use crate::recordings::Shot;
use crate::wrapping::Configuration;
use nailnoise_quantities::rounded;

/// Largest difference of a microphone's level from the median of all \[dB\]. Distances of 1 to 1.73 m from the centre
/// explain 5 dB, the directivity of a tool with an exhaust 5 to 8 dB; a sensor with a broken cable or a wrong
/// sensitivity differs by more.
const SPREAD: f64 = 15.0;

/// Smallest constant offset of a record, relative to its peak, that is reported. It is removed in any case.
const OFFSET: f64 = 0.01;

/// A finding about a channel in one configuration, and the number of repeats in which it occurs.
struct Finding {
    configuration: Configuration,
    channel: String,
    kind: Kind,
    /// The largest value found: a difference in dB, or an offset in the unit of the channel.
    value: f64,
    repeats: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Level,
    /// All microphones.
    Silent,
    Pressure,
    Acceleration,
}

/// Findings about the channels of all shots.
pub(super) struct ChannelChecks<'a> {
    arrangement: &'a Arrangement,
    found: Vec<Finding>,
}

impl<'a> ChannelChecks<'a> {
    pub(super) fn new(arrangement: &'a Arrangement) -> Self {
        Self {
            arrangement,
            found: Vec::new(),
        }
    }

    /// Removes constant offsets from a shot, and records anomalies of its channels.
    pub(super) fn see(&mut self, configuration: Configuration, shot: &mut Shot) {
        let peaks = |records: &[Vec<f64>]| records.iter().map(|record| peak(record)).collect::<Vec<f64>>();
        let (pressures, accelerations) = (peaks(&shot.microphones), peaks(&shot.accelerations));
        let offsets = shot.remove_offsets();
        let places = self
            .arrangement
            .microphone_names
            .iter()
            .zip(&offsets.microphones)
            .zip(pressures);
        let pressures = places.map(|((name, offset), peak)| (name, *offset, peak, Kind::Pressure));
        let places = self
            .arrangement
            .accelerometers
            .iter()
            .zip(&offsets.accelerations)
            .zip(accelerations);
        let accelerations = places.map(|((name, offset), peak)| (name, *offset, peak, Kind::Acceleration));
        for (name, offset, peak, kind) in pressures.chain(accelerations) {
            if offset.abs() > OFFSET * peak {
                add(&mut self.found, configuration, name, kind, offset);
            }
        }
        if !shot.microphones.is_empty() && shot.microphones.iter().all(|record| peak(record) == 0.0) {
            add(&mut self.found, configuration, "", Kind::Silent, 0.0);
            return;
        }
        let levels: Vec<f64> = shot.microphones.iter().map(|record| level(record)).collect();
        let mut sorted = levels.clone();
        sorted.sort_by(f64::total_cmp);
        let Some(median) = sorted.get(sorted.len() / 2) else {
            return;
        };
        for (name, level) in self.arrangement.microphone_names.iter().zip(&levels) {
            let difference = level - median;
            // With two microphones, it is unknown which one is wrong; the first is named.
            if difference.abs() > SPREAD {
                add(&mut self.found, configuration, name, Kind::Level, difference);
            }
        }
    }

    /// Describes the findings: levels by channel, and the offsets of all channels of a configuration together.
    pub(super) fn notes(&self) -> Vec<String> {
        let name = |own: &Finding| self.arrangement.setup.configuration(own.configuration.number());
        let levels = self.found.iter().filter(|own| own.kind == Kind::Level).map(|own| {
            format!(
                "{}: {} reads {:.0} dB {} than the median of the microphones in {}; check its cable, gain and \
                 calibration, because \
                 the mean includes it",
                name(own),
                own.channel,
                own.value.abs(),
                if own.value < 0.0 { "less" } else { "more" },
                if own.repeats == 1 {
                    "1 repeat".to_owned()
                } else {
                    format!("{} repeats", own.repeats)
                },
            )
        });
        let silent = self.found.iter().filter(|own| own.kind == Kind::Silent);
        let silent = silent.map(|own| {
            format!(
                "{}: all microphones are silent, so that nothing is subtracted",
                name(own)
            )
        });
        let mut notes: Vec<String> = levels.chain(silent).collect();
        for (kind, unit) in [(Kind::Pressure, "Pa"), (Kind::Acceleration, "m/s2")] {
            let all: Vec<&Finding> = self.found.iter().filter(|own| own.kind == kind).collect();
            for group in all.chunk_by(|a, b| a.configuration == b.configuration) {
                let channels: Vec<&str> = group.iter().map(|own| own.channel.as_str()).collect();
                let largest = group.iter().map(|own| own.value.abs()).fold(0.0, f64::max);
                notes.push(format!(
                    "{}: constant part of up to {} {unit} removed from {}",
                    name(group[0]),
                    rounded(largest, 3, 1e6),
                    channels.join(", ")
                ));
            }
        }
        notes
    }
}

fn add(found: &mut Vec<Finding>, configuration: Configuration, channel: &str, kind: Kind, value: f64) {
    let same = |own: &&mut Finding| own.configuration == configuration && own.kind == kind && own.channel == channel;
    match found.iter_mut().find(same) {
        Some(own) => {
            own.repeats += 1;
            if value.abs() > own.value.abs() {
                own.value = value;
            }
        }
        None => found.push(Finding {
            configuration,
            channel: channel.to_owned(),
            kind,
            value,
            repeats: 1,
        }),
    }
}

fn peak(record: &[f64]) -> f64 {
    record.iter().fold(0.0, |peak: f64, sample| peak.max(sample.abs()))
}

/// Level of the mean square, re 20 uPa \[dB\].
fn level(record: &[f64]) -> f64 {
    let mean = record.iter().map(|p| p * p).sum::<f64>() / record.len().max(1) as f64;
    10.0 * (mean.max(f64::MIN_POSITIVE) / REFERENCE_PRESSURE.powi(2)).log10()
}
