//! Channels of a file before they are signals.

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

/// The number of each channel, for the formats that count them.
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
