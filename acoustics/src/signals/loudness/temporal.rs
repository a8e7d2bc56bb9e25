//! Temporal effects of hearing: the decay of excitation after a sound, and the build-up of short sounds.

use super::core::CRITICAL_BANDS;

/// Number of integration steps between two values.
const STEPS: usize = 24;

/// Time constants of the decay \[s\]: of excitation after a short sound, after a long one, and of the memory of the
/// sound's duration (ISO 532-1:2017, 6.3).
const SHORT: f64 = 0.005;
const LONG: f64 = 0.015;
const MEMORY: f64 = 0.075;

/// Below this difference, the input is taken to equal the output \[sone/Bark\].
const EQUAL: f64 = 1e-5;

/// The circuit of two capacitors after a diode, which makes excitation rise at once and decay slowly.
struct Decay {
    /// Weights of the two voltages over one step while both capacitors discharge: \[memory, output\] x \[output,
    /// memory\].
    memory: [f64; 2],
    output: [f64; 2],
    /// Decay factors per step if only the long decay or only the memory is active.
    long: f64,
    slow: f64,
}

/// Voltages of the circuit \[sone/Bark\].
#[derive(Clone, Copy, Default)]
struct Voltages {
    output: f64,
    memory: f64,
}

impl Decay {
    /// Coefficients for steps of `dt` \[s\].
    fn new(dt: f64) -> Self {
        let p = (MEMORY + LONG) / (MEMORY * SHORT);
        let q = 1.0 / (SHORT * MEMORY);
        let root = (0.25 * p * p - q).sqrt();
        let (fast, late) = (-0.5 * p + root, -0.5 * p - root);
        let scale = 1.0 / (MEMORY * (fast - late));
        let (e1, e2) = ((fast * dt).exp(), (late * dt).exp());
        let (a1, a2) = (MEMORY * fast + 1.0, MEMORY * late + 1.0);
        Self {
            memory: [scale * (e1 - e2), scale * (a2 * e1 - a1 * e2)],
            output: [scale * (a1 * e1 - a2 * e2), scale * a1 * a2 * (e1 - e2)],
            long: (-dt / LONG).exp(),
            slow: (-dt / MEMORY).exp(),
        }
    }

    /// The voltages one step later for the given input.
    fn step(&self, input: f64, last: Voltages) -> Voltages {
        if input < last.output {
            if last.output > last.memory {
                let pair = |[own, other]: [f64; 2]| last.output * own - last.memory * other;
                let output = pair(self.output).max(input);
                let memory = pair(self.memory).min(output);
                Voltages { output, memory }
            } else {
                let output = (last.output * self.long).max(input);
                Voltages { output, memory: output }
            }
        } else if (input - last.output).abs() < EQUAL && input <= last.memory {
            Voltages {
                output: input,
                memory: input,
            }
        } else {
            Voltages {
                output: input,
                memory: (last.memory - input) * self.slow + input,
            }
        }
    }
}

/// Applies the temporal decay of hearing to core loudness sampled at this rate \[1/s\] (6.3).
pub(super) fn decay(cores: &mut [[f64; CRITICAL_BANDS]], rate: f64) {
    let circuit = Decay::new(1.0 / (rate * STEPS as f64));
    for band in 0..CRITICAL_BANDS {
        let mut voltages = Voltages::default();
        for i in 0..cores.len() {
            let input = cores[i][band];
            let slope = cores.get(i + 1).map_or(0.0, |next| (next[band] - input) / STEPS as f64);
            for step in 0..STEPS {
                voltages = circuit.step(input + slope * step as f64, voltages);
                if step == 0 {
                    cores[i][band] = voltages.output;
                }
            }
        }
    }
}

/// First-order low-pass filter with the given time constant \[s\], for values at this rate \[1/s\] with linear
/// interpolation.
fn low_pass(values: &[f64], time_constant: f64, rate: f64) -> Vec<f64> {
    let retained = (-1.0 / (rate * STEPS as f64 * time_constant)).exp();
    let mut state = 0.0;
    let mut filtered = Vec::with_capacity(values.len());
    for (i, &value) in values.iter().enumerate() {
        let slope = values.get(i + 1).map_or(0.0, |next| (next - value) / STEPS as f64);
        for step in 0..STEPS {
            state = retained * state + (1.0 - retained) * (value + slope * step as f64);
            if step == 0 {
                filtered.push(state);
            }
        }
    }
    filtered
}

/// Loudness over time with the build-up of short sounds: a weighted sum of low-pass filters with 3.5 ms (0.47) and 70
/// ms (0.53) (6.4).
pub(super) fn weighted(loudness: &[f64], rate: f64) -> Vec<f64> {
    let (quick, slow) = (low_pass(loudness, 0.0035, rate), low_pass(loudness, 0.070, rate));
    quick.iter().zip(slow).map(|(q, s)| 0.47 * q + 0.53 * s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 2000.0;

    /// Excitation of one band that is constant for `on` values and then stops.
    fn pulse(on: usize, off: usize) -> Vec<[f64; CRITICAL_BANDS]> {
        let value = |i: usize| [if i < on { 1.0 } else { 0.0 }; CRITICAL_BANDS];
        let mut cores: Vec<_> = (0..on + off).map(value).collect();
        decay(&mut cores, RATE);
        cores
    }

    #[test]
    fn excitation_rises_at_once_and_decays_longer_after_a_longer_sound() {
        let (short, long) = (pulse(10, 40), pulse(400, 40));
        assert_eq!((short[0][3], long[399][3]), (1.0, 1.0));
        // 10 ms after its end.
        assert!(short[30][3] < 0.6 * long[420][3], "{} {}", short[30][3], long[420][3]);
        // A long sound decays with 15 ms only, starting one interval of 0.5 ms after its end.
        let decayed = long[420][3] / long[410][3];
        assert!((decayed - (-0.005_f64 / LONG).exp()).abs() < 0.02, "{decayed}");
    }

    #[test]
    fn a_constant_loudness_builds_up_to_itself() {
        let filtered = weighted(&[3.0; 2000], RATE);
        assert!((filtered[1999] - 3.0).abs() < 1e-5);
        // After 70 ms: the fast part completely, and 1 - 1/e of the slow one.
        assert!((filtered[140] / 3.0 - (0.47 + 0.53 * (1.0 - (-1f64).exp()))).abs() < 2e-3);
    }
}
