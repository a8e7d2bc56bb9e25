//! Faults of a recording.

use std::path::PathBuf;

use super::{Foreign, LOWEST_RATE, RUN, SHOT};

/// Fault of the recording of a channel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The bytes are not a recording in a known format.
    #[error("the file cannot be read as a recording: {problem}")]
    Format {
        /// What is wrong.
        problem: String,
    },
    /// The file has another format.
    #[error("the file is {}", .0.name)]
    Foreign(Foreign),
    /// A WAV file has compressed samples.
    #[error("the samples are {coding}; integers and floats (PCM) are read")]
    Coding {
        /// How they are coded.
        coding: String,
    },
    /// A WAV file has samples of an unsupported width.
    #[error(
        "the samples have {bits} bits in {bytes} bytes, of the kind {kind}; integers of 2 to 64 bits and floats of 32 \
         and 64 bits are read"
    )]
    Width {
        /// Bits of a sample.
        bits: u16,
        /// Bytes of a sample.
        bytes: usize,
        /// `integer` or `float`.
        kind: &'static str,
    },
    /// The valid bits of integers are the lowest ones of their container instead of the highest, as the format
    /// requires.
    #[error(
        "the header states {bits} valid bits in containers of {container} bits, which are the highest ones by the \
         format (WAVE_FORMAT_EXTENSIBLE); the samples use the lowest {bits} bits only"
    )]
    RightAligned {
        /// Valid bits of a sample.
        bits: u32,
        /// Bits of its container.
        container: usize,
    },
    /// A WAV file has more samples than fit in memory.
    #[error(
        "{channels} channel(s) of {samples} samples need {gigabytes:.1} GB of memory; three quarters of the free \
         memory, {allowed:.1} GB, may be used"
    )]
    Memory {
        /// Number of samples per channel.
        samples: usize,
        /// Number of channels requested.
        channels: usize,
        /// Memory required \[GB\].
        gigabytes: f64,
        /// Memory that they may use \[GB\].
        allowed: f64,
    },
    /// A file ends before its header says.
    #[error("the file is cut off: its header promises {expected} samples, {found} are there")]
    CutOff {
        /// Samples by the header.
        expected: usize,
        /// Samples in the file.
        found: usize,
    },
    /// The channel number exceeds those in the file.
    #[error("there is no channel {channel}: the file has {channels}")]
    NoChannel {
        /// The channel, from 1.
        channel: usize,
        /// Channels of the file.
        channels: usize,
    },
    /// A CSV file does not have the column.
    #[error("there is no column \"{column}\"; the columns are {known}")]
    NoColumn {
        /// Its heading.
        column: String,
        /// The headings of the file.
        known: String,
    },
    /// Two columns have the same heading.
    #[error("two columns have the heading \"{column}\"")]
    TwoColumns {
        /// The heading.
        column: String,
    },
    /// A CSV file has no times.
    #[error("there is no column of times; the columns are {known}")]
    NoTime {
        /// The headings of the file.
        known: String,
    },
    /// A channel is selected by `column` in a WAV or universal file, or by `channel` in a CSV file.
    #[error("the file is {format}, whose channels are given by `{expected}`")]
    Selector {
        /// The format.
        format: &'static str,
        /// The key that selects a channel of it.
        expected: &'static str,
    },
    /// A line of a CSV file cannot be read.
    #[error("line {line}: {problem}")]
    Line {
        /// The line, from 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// Times are not evenly spaced.
    #[error("the time axis is uneven: sample {sample} is at {time} s, even steps lead to {expected} s")]
    Uneven {
        /// Index of the sample, from 1.
        sample: usize,
        /// Its time \[s\].
        time: f64,
        /// The time expected on a uniform axis \[s\].
        expected: f64,
    },
    /// Times do not increase.
    #[error("the time axis does not increase: sample {sample} is at {time} s, the one before it at {before} s")]
    NotIncreasing {
        /// Index of the sample, from 1.
        sample: usize,
        /// Its time \[s\].
        time: f64,
        /// The preceding time \[s\].
        before: f64,
    },
    /// The unit of the time axis cannot be read.
    #[error("the unit \"{unit}\" of the times cannot be used: {problem}")]
    TimeUnit {
        /// The label in the file.
        unit: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The abscissa is not time.
    #[error("dataset 58 number {channel} is not a time history: its abscissa is {abscissa}{histories}")]
    NotTime {
        /// The channel, from 1.
        channel: usize,
        /// The quantity of the abscissa.
        abscissa: String,
        /// Which datasets are time histories.
        histories: String,
    },
    /// A universal file cannot be read.
    #[error("{problem}")]
    Universal {
        /// The reason, with file and line.
        problem: String,
    },
    /// There are no samples, or too few to determine a sampling rate.
    #[error("there are {samples} samples")]
    Empty {
        /// Samples in the file.
        samples: usize,
    },
    /// A sample is not a finite number.
    #[error("sample {sample} is {value}, which is not finite")]
    NotFinite {
        /// Index of the sample, from 1.
        sample: usize,
        /// Its value.
        value: f64,
    },
    /// The sampling rate is too low for A-weighted bands up to 10 kHz.
    #[error("the sampling rate is {rate} Hz, at least {LOWEST_RATE} Hz are needed")]
    LowRate {
        /// The rate \[Hz\].
        rate: f64,
    },
    /// Channels or shots have different sampling rates.
    #[error("the sampling rate is {rate} Hz, that of {} is {other} Hz", file.display())]
    RatesDiffer {
        /// The rate \[Hz\].
        rate: f64,
        /// That of another recording \[Hz\].
        other: f64,
        /// The other recording.
        file: PathBuf,
    },
    /// Time axes start at different times.
    #[error("the time axis begins at {start} s, that of {} at {other} s", file.display())]
    StartsDiffer {
        /// The first time \[s\].
        start: f64,
        /// That of another recording \[s\].
        other: f64,
        /// The other recording.
        file: PathBuf,
    },
    /// Consecutive samples are at full scale.
    #[error(
        "clipped: {count} samples from {at:.6} s on are at full scale, {value:.6} {unit}; {RUN} in a row are an \
         overload"
    )]
    Clipped {
        /// Number of samples in the first run.
        count: usize,
        /// Time of the first one from the record's start \[s\].
        at: f64,
        /// The value in the channel's unit.
        value: f64,
        /// The channel's unit.
        unit: String,
    },
    /// Nothing states the meaning of the numbers.
    #[error("no calibration: {why}")]
    NoCalibration {
        /// What is missing.
        why: &'static str,
    },
    /// A unit cannot be parsed.
    #[error("the unit \"{unit}\" of the file cannot be used: {problem}")]
    Unit {
        /// The label in the file.
        unit: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The file's unit belongs to a different quantity.
    #[error("the channel is {expected}, and the file holds {found}")]
    OtherQuantity {
        /// The quantity according to the manifest.
        expected: &'static str,
        /// The quantity according to the file, with its label.
        found: String,
    },
    /// A channel has no signal.
    #[error(
        "the channel is dead: all {samples} samples are {value} {unit}{}",
        and_others(others)
    )]
    Dead {
        /// Samples of the record.
        samples: usize,
        /// Their value.
        value: f64,
        /// Unit of the value.
        unit: &'static str,
        /// Other channels of the shot without a signal.
        others: Vec<String>,
    },
    /// Manifest and file state different units.
    #[error("the manifest states the unit \"{manifest}\", the file \"{file}\"")]
    UnitsDiffer {
        /// That of the manifest.
        manifest: String,
        /// That of the file.
        file: String,
    },
    /// A record ends too soon after the trigger.
    #[error("the record ends {after:.4} s after the trigger, the shot needs {SHOT} s")]
    Short {
        /// Time from the trigger to the record's end \[s\].
        after: f64,
    },
    /// A signal does not cross the trigger's threshold.
    #[error("no trigger: the signal does not cross {threshold} {unit}; it runs from {least:.4} to {most:.4} {unit}")]
    NoTrigger {
        /// The threshold.
        threshold: f64,
        /// Smallest value of the signal.
        least: f64,
        /// Largest value of the signal.
        most: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A calibrator recording does not contain the tone.
    #[error(
        "no tone of {frequency} Hz in the calibrator's record: {:.1} % of its energy lie within {:.0} % of \
         it", 100.0 * share,
        100.0 * band
    )]
    NoTone {
        /// Frequency of the calibrator \[Hz\].
        frequency: f64,
        /// Share of the energy in the band.
        share: f64,
        /// Half width of the band, relative.
        band: f64,
    },
    /// A calibrator recording is too short.
    #[error("the calibrator's record lasts {duration:.3} s, at least {needed} s are needed")]
    ShortTone {
        /// Its duration \[s\].
        duration: f64,
        /// The least duration \[s\].
        needed: f64,
    },
}

fn and_others(others: &[String]) -> String {
    if others.is_empty() {
        return String::new();
    }
    format!("; so are those of {}", others.join(", "))
}

impl Fault {
    /// How to fix it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Format { .. } => {
                "export the recording as WAV, as universal file with datasets 58, or as CSV with a time column"
            }
            Self::Foreign(foreign) => foreign.remedy,
            Self::Width { .. } | Self::Coding { .. } => "export it with integers of 24 bits, or as floats of 32 bits",
            Self::RightAligned { .. } => "export it with integers of 24 bits in 3 bytes, or as floats of 32 bits",
            Self::Memory { .. } => "cut the recording to one file a shot, of some seconds each",
            Self::CutOff { .. } => "export the recording again; a copy may have been interrupted",
            Self::NoChannel { .. } => "correct `channel`, which counts from 1, or `file`",
            Self::NoColumn { .. } | Self::TwoColumns { .. } => "correct `column`, a heading of the table, or the file",
            Self::NoTime { .. } => "give the file a column \"time [s]\"; its heading begins with time or is t",
            Self::Selector { .. } => "use that key for this channel, or name another file",
            Self::Line { .. } => "give each line a finite number for each column, with one decimal mark",
            Self::Uneven { .. } => {
                "export it at a constant sampling rate, with times of more digits; a sample may be missing or doubled"
            }
            Self::NotIncreasing { .. } => "export it with times of more digits, and each sample once",
            Self::TimeUnit { .. } => "label the times in s, ms or us; without a label they are in s",
            Self::NotTime { .. } => "name the time history of this channel by `channel`, which counts the datasets 58",
            Self::Universal { .. } => {
                "name another dataset 58 by `channel`, or export it again: 58 or 58b, real values over time"
            }
            Self::Empty { .. } => "record this shot again, or correct `file`",
            Self::NotFinite { .. } => "export the recording again, and check the converter that wrote the file",
            Self::LowRate { .. } => {
                "record at a higher rate: at least 48 kHz is usual, 160 kHz was used for the published test"
            }
            Self::RatesDiffer { .. } => "record all channels and shots at one sampling rate",
            Self::StartsDiffer { .. } => "export all channels of a shot with a common time axis",
            Self::Clipped { .. } => "repeat the shot with a larger input range",
            Self::NoCalibration { .. } => {
                "give `sensitivity` and `full_scale` (\"50 mV/Pa\", \"10 V\"), or `full_scale` in the channel's \
                 quantity (\"200 \
                 Pa\"), or `calibrator`, or `unit` where the file holds numbers in a unit"
            }
            Self::Unit { .. } => "give `unit` in the manifest: Pa, kPa, m/s2 or g; V with a `sensitivity`",
            Self::OtherQuantity { .. } => {
                "correct `channel`, `column` or `kind` in the manifest, or the label in the file"
            }
            Self::Dead { .. } => {
                "record again with this sensor connected, or remove the channel: the mean is then over the other \
                 microphones"
            }
            Self::UnitsDiffer { .. } => "remove `unit` if the file is right, else export the file with the right unit",
            Self::Short { .. } => "record longer, or correct `trigger`; the machine sounds for about 0.1 s",
            Self::NoTrigger { .. } => "correct `threshold` or the trigger's channel, or give `trigger` as a time",
            Self::NoTone { .. } => "name the calibrator's record of this microphone, or correct `frequency`",
            Self::ShortTone { .. } => "record the calibrator for some seconds",
        }
    }
}
