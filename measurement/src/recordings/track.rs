//! Channels of a file before conversion to signals.

use nailnoise_quantities::Dimension;

use super::fault::Fault;

/// Which channel of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Selector {
    /// A channel of a WAV file or a dataset 58 of a universal file, from 1.
    Channel(usize),
    /// A column of a CSV file by its heading.
    Column(String),
}

/// Meaning of the numbers in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Integers as fractions of the largest one.
    Integers,
    /// Floats whose full scale is 1 by convention.
    Fractions,
    /// Numbers in a unit.
    InUnit,
}

/// Samples of one channel as stored in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Sampling rate \[Hz\].
    pub rate: f64,
    /// Time of the first sample \[s\], if the file states it.
    pub start: Option<f64>,
    /// The samples.
    pub samples: Vec<f64>,
    /// Their meaning.
    pub numbers: Numbers,
    /// Label of their unit in the file; empty if there is none.
    pub unit: String,
    /// The quantity that the file states they measure, without a unit.
    pub measures: Option<Dimension>,
}

/// Why a file cannot be read, with the index of the requested channel.
pub type Refusal = (usize, Fault);

/// The number of each channel, for formats that number their channels.
pub(super) fn numbers(channels: &[&Selector], format: &'static str) -> Result<Vec<usize>, Refusal> {
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
