//! Realises the noise of an opening as a signal.

use super::history::Burst;
use super::noise::ExhaustNoise;
use super::receiver::{Floor, Outlet, Paths};
use crate::air::Air;
use crate::checks::{ReceiverError, positive};
use crate::random::uniform;
use crate::signals::ChirpTransform;
use nalgebra::Complex;
use rustfft::FftPlanner;
use std::f64::consts::PI;

/// Length of a frame \[s\]: short compared with a blow-down, but long enough to resolve the frequencies of a jet.
const FRAME: f64 = 5e-3;

/// Sampling and seed of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recording {
    /// Sampling rate \[1/s\].
    pub rate: f64,
    /// Number of samples, starting at t = 0 of the flow's history.
    pub samples: usize,
    /// Seed of the noise; the same seed yields the same noise.
    pub seed: u64,
}

impl ExhaustNoise {
    /// Pressure at a point over time \[Pa\]: one realisation of the noise, whose expected exposure is
    /// [`ExhaustNoise::at`].
    ///
    /// Jet noise is random. Frames of 5 ms with 50 % overlap contain sines with the amplitudes of their bursts and
    /// random phases. They are windowed so that the powers of overlapping frames add to one. Frequencies below half the
    /// resolution of a frame, about 100 Hz, contain only the unsteady outflow, which is a deterministic signal.
    ///
    /// # Errors
    /// The errors of [`ExhaustNoise::at`], or if the sampling rate is not positive.
    pub fn sound_at(
        &self,
        outlet: &Outlet,
        point: [f64; 3],
        floor: Option<&Floor>,
        air: &Air,
        recording: &Recording,
    ) -> Result<Vec<f64>, ReceiverError> {
        let Recording { rate, samples, seed } = *recording;
        positive("sampling rate [1/s]", rate)?;
        let paths = Paths::new(outlet, point, floor, air)?;
        let outflow = &self.history.monopole;
        let to_pressure = (air.impedance() / (4.0 * PI)).sqrt();
        let spectrum: Vec<Complex<f64>> = outflow
            .frequency()
            .iter()
            .zip(outflow.combined_signal())
            .map(|(&hz, x)| x * paths.point_source_pressure(hz) * to_pressure)
            .collect();
        let mut signal = ChirpTransform::new(outflow.frequency(), rate, samples).signal(&spectrum);
        self.add_jets(&paths, air, rate, seed, &mut signal);
        Ok(signal)
    }

    fn add_jets(&self, paths: &Paths, air: &Air, rate: f64, seed: u64, signal: &mut [f64]) {
        let hop = (0.5 * FRAME * rate).round().max(4.0) as usize;
        let length = 2 * hop;
        let [low, high] = self.spectrum.range_hz;
        let df = rate / length as f64;
        let bins: Vec<usize> = (1..hop).filter(|&k| (low..=high).contains(&(k as f64 * df))).collect();
        let frequency: Vec<f64> = bins.iter().map(|&k| k as f64 * df).collect();
        let (passed, jets) = (self.passed_at(&frequency), paths.jets(&frequency));
        let window: Vec<f64> = (0..length)
            .map(|n| (PI * (n as f64 + 0.5) / length as f64).sin())
            .collect();
        let inverse = FftPlanner::new().plan_fft_inverse(length);
        let dt = self.history.sample_interval;
        let delay = (paths.direct_length() / air.sound_speed * rate).round() as usize;
        // Frame i contains the flow samples from (i - 1) hop to (i + 1) hop.
        for frame in 0..=signal.len() / hop {
            let start = (frame as f64 - 1.0) * hop as f64;
            let place = |burst: &Burst| (burst.sample as f64 + 0.5) * dt * rate - start;
            let within = |bursts: &[Burst]| -> Vec<Burst> {
                // Bursts are in the order of their samples.
                let first = bursts.partition_point(|burst| place(burst) <= 0.0);
                let windowed = |burst: &Burst| Burst {
                    energy: burst.energy * (PI * place(burst) / length as f64).sin().powi(2),
                    ..*burst
                };
                let inside = |burst: &&Burst| place(burst) < length as f64;
                bursts[first..].iter().take_while(inside).map(windowed).collect()
            };
            let mixing = within(&self.history.mixing);
            let shocks = within(&self.history.shocks);
            if mixing.is_empty() && shocks.is_empty() {
                continue;
            }
            let [mixing, shock] = jets.densities(&mixing, &shocks);
            let mut spectrum = vec![Complex::default(); length];
            for (i, &k) in bins.iter().enumerate() {
                let exposure = air.impedance() / (4.0 * PI) * passed[i] * (mixing[i] + shock[i]);
                // The window transmits half of a frame's power; a sine of amplitude a has the power a²/2.
                let power = exposure * df / (0.5 * length as f64 / rate);
                spectrum[k] = Complex::from_polar((2.0 * power).sqrt(), phase(seed, frame, k));
            }
            inverse.process(&mut spectrum);
            for (n, (x, w)) in spectrum.iter().zip(&window).enumerate() {
                let Some(at) = (frame * hop + n + delay).checked_sub(hop) else {
                    continue;
                };
                if let Some(sample) = signal.get_mut(at) {
                    *sample += w * x.re;
                }
            }
        }
    }

    /// Energy transmission of a muffler at frequencies other than those of the spectrum.
    fn passed_at(&self, frequency: &[f64]) -> Vec<f64> {
        let Some(passed) = &self.history.passed else {
            return vec![1.0; frequency.len()];
        };
        let own = &self.history.frequency;
        let nearest = |hz: &f64| {
            let above = own.partition_point(|f| f < hz).min(own.len() - 1);
            passed[above]
        };
        frequency.iter().map(nearest).collect()
    }
}

/// A phase in \[0, 2 pi) for a bin of a frame.
fn phase(seed: u64, frame: usize, bin: usize) -> f64 {
    2.0 * PI * uniform(seed, frame as u64, bin as u64)
}
