//! One shot of a test: all its channels on one time axis.

/// Recordings of one shot of one configuration, all of the length of the shortest record.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shot {
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Time of the trigger from the record's start \[s\].
    pub trigger: f64,
    /// Sound pressures in the order of the manifest's microphones \[Pa\].
    pub microphones: Vec<Vec<f64>>,
    /// Accelerations in the order of the manifest's accelerometers \[m/s²\].
    pub accelerations: Vec<Vec<f64>>,
    /// Gas pressures in the order of the manifest's pressures \[Pa\].
    pub pressures: Vec<Vec<f64>>,
}
