//! One shot of a test: all its channels on one time axis.

/// Recordings of one shot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shot {
    /// Sampling rate of all channels \[1/s\].
    pub rate: f64,
    /// Instant of the trigger from the start of the record \[s\].
    pub trigger: f64,
    /// Sound pressure at each microphone \[Pa\].
    pub microphones: Vec<Vec<f64>>,
    /// Acceleration of each accelerometer \[m/s2\].
    pub accelerations: Vec<Vec<f64>>,
    /// Pressure of each transducer, without its static part \[Pa\].
    pub pressures: Vec<Vec<f64>>,
}
