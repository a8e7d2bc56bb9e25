//! One shot of a test: all its channels on a common time axis.

/// Recordings of one shot of one configuration, all truncated to the length of the shortest.
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

/// Constant offsets of the signals of a shot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Offsets {
    /// Of each microphone \[Pa\].
    pub microphones: Vec<f64>,
    /// Of each accelerometer \[m/s²\].
    pub accelerations: Vec<f64>,
}

impl Shot {
    /// Removes the constant offset of microphones and accelerometers, which is due to their amplifiers: neither sound
    /// nor the vibration of a tool that is at rest before and after the shot has one. Otherwise the ends of a record
    /// would form a step, which raises the lowest bands. Gas pressures keep theirs, which is the static pressure.
    pub fn remove_offsets(&mut self) -> Offsets {
        Offsets {
            microphones: self.microphones.iter_mut().map(|record| remove_mean(record)).collect(),
            accelerations: self
                .accelerations
                .iter_mut()
                .map(|record| remove_mean(record))
                .collect(),
        }
    }
}

fn remove_mean(record: &mut [f64]) -> f64 {
    let mean = record.iter().sum::<f64>() / record.len().max(1) as f64;
    record.iter_mut().for_each(|sample| *sample -= mean);
    mean
}
