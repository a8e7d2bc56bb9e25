//! What a recording must satisfy.

/// Lowest sampling rate \[Hz\]: the highest one-third-octave band, 10 kHz, ends at 11.2 kHz.
pub const LOWEST_RATE: f64 = 25e3;

/// Least record after the trigger \[s\]: the machine sounds for about 0.1 s; the rest holds the decay of the room and
/// the way to the microphones.
pub const SHOT: f64 = 0.15;

/// Samples in a row at full scale that are an overload.
pub const RUN: usize = 3;

/// Largest deviation of a sample's time from an even axis, in intervals. A missing sample is off by one; times of few
/// digits are off by less.
pub const EVENNESS: f64 = 0.1;

/// Largest relative difference of sampling rates that are the same: the six digits of a universal file.
pub const SAME_RATE: f64 = 1e-5;
