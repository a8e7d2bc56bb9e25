//! Sound fields for which the standard defines loudness.

/// Sound field of the levels, which are those without the listener.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SoundField {
    /// A plane wave from the front.
    Free,
    /// Sound from all directions.
    Diffuse,
}
