//! Requirements on a recording.

/// Lowest sampling rate \[Hz\]: the highest one-third-octave band, 10 kHz, ends at 11.2 kHz.
pub const LOWEST_RATE: f64 = 25e3;

/// Minimum duration of a record after the trigger \[s\]: the machine sounds for about 0.1 s; the rest allows for the
/// decay of the room and the travel time to the microphones.
pub const SHOT: f64 = 0.15;

/// Number of consecutive samples at full scale that counts as overload.
pub const RUN: usize = 3;

/// Largest deviation of a sample's time from a uniform axis, in intervals. A missing sample causes a deviation of one;
/// times with few digits deviate by less.
pub const EVENNESS: f64 = 0.1;

/// Relative difference up to which sampling rates count as equal: the six digits of a universal file.
pub const SAME_RATE: f64 = 1e-5;
