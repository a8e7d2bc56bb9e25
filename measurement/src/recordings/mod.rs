//! Recordings of a shot: WAV, universal files and tables, read as signals in SI units on one time axis.

mod axis;
mod calibration;
mod csv;
mod fault;
mod format;
mod riff;
mod shot;
mod signals;
mod universal;
pub mod wav;

use std::io::{self, Cursor, Read as _};
use std::path::Path;

use nailnoise_documents::{open_regular, read_regular};
use nailnoise_meshes::uff::is_universal;
use nailnoise_quantities::Dimension;

use axis::even_axis;
pub use calibration::calibrator_rms;
pub use calibration::{Calibration, Calibrator, FullScale, Quantity};
pub use fault::Fault;
pub use nailnoise_documents::tables::Foreign;
pub use shot::{Offsets, Shot};
pub use signals::{Signals, Source, crossing, dead, read, read_shot, refuse, unreadable};

/// Lowest sampling rate \[Hz\]: the highest one-third-octave band, 10 kHz, ends at 11.2 kHz.
pub const LOWEST_RATE: f64 = 25e3;

/// Least record after the trigger \[s\]: the machine sounds for about 0.1 s; the rest holds the decay of the room and
/// the way to the microphones.
pub const SHOT: f64 = 0.15;

/// Samples in a row at full scale that are an overload.
pub const RUN: usize = 3;

/// The largest universal file or table that is read \[byte\]; WAV files may have any length.
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
    /// What the file states that they measure, without a unit.
    pub measures: Option<Dimension>,
}

/// Why a file cannot be read, and for which of the channels asked for.
pub type Refusal = (usize, Fault);

/// Reads channels of a recording; the format follows from the bytes. `path` is for messages.
///
/// # Errors
/// The fault, with the index of the channel in `channels`; a fault of the whole file has index 0.
pub fn decode(bytes: &[u8], path: &Path, channels: &[&Selector]) -> Result<Vec<Track>, Refusal> {
    let tracks = if riff::is_riff(bytes) {
        wav::decode(Cursor::new(bytes), bytes.len() as u64, channels)
    } else if is_universal(bytes) {
        universal::decode(bytes, path, channels)
    } else {
        csv::decode(bytes, channels)
    }?;
    finite(tracks)
}

/// Reads channels of the recording in a file, as [`decode`] does; a WAV file is read a block at a time.
///
/// # Errors
/// Those of the file system, of a file that is not a regular one or, except for WAV, longer than [`LARGEST`]. The inner error
/// is that of [`decode`].
pub fn read_tracks(path: &Path, channels: &[&Selector]) -> io::Result<Result<Vec<Track>, Refusal>> {
    let (mut file, length) = open_regular(path)?;
    let mut mark = Vec::new();
    file.by_ref().take(4).read_to_end(&mut mark)?;
    if riff::is_riff(&mark) {
        return Ok(wav::decode(file, length, channels).and_then(finite));
    }
    let bytes = read_regular(path, LARGEST).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidInput => io::Error::new(error.kind(), format!("{error}; only WAV files may be larger")),
        _ => error,
    })?;
    Ok(decode(&bytes, path, channels))
}

/// Refuses samples that are not finite.
fn finite(tracks: Vec<Track>) -> Result<Vec<Track>, Refusal> {
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
