//! Sound fields for which the standard defines loudness.

/// Sound field for which the levels are given, without the listener.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SoundField {
    /// A plane wave from the front.
    Free,
    /// Sound from all directions.
    Diffuse,
}
