//! Sound at the operator's ear: exposure and C-weighted peak of the emission sound pressure.

use std::f64::consts::PI;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::{Weighting, energy_level};
use nalgebra::{Point3, distance};
use realfft::RealFftPlanner;
use serde::{Deserialize, Serialize};

use super::sources::SPREAD_EVENLY;
use super::{AtMicrophones, MicrophoneArray, REFERENCE, SAMPLE_RATE};
use crate::result::EarReport;

/// Reference sound pressure \[Pa\].
const REFERENCE_PRESSURE: f64 = 20e-6;

/// Time constant of the slowest pole of the C-weighting, 1/(2 pi 20.6 Hz), times ten \[s\]: what rings on behind a record.
const RINGING: f64 = 0.077;

/// Values computed between two samples: the largest sample of a tone near 8 kHz may lie 1.2 dB below its peak.
const BETWEEN: usize = 8;

/// Sound of a source, or of a part of one, at the ear.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct AtEar {
    /// A-weighted exposure \[Pa² s\].
    pub exposure: f64,
    /// Pressure at 48 kHz from the trigger on \[Pa\].
    pub signal: Vec<f64>,
}

impl AtEar {
    /// Adds `factor` times a part.
    pub(super) fn add(&mut self, part: &Self, factor: f64) {
        self.exposure += factor * part.exposure;
        self.signal
            .iter_mut()
            .zip(&part.signal)
            .for_each(|(own, p)| *own += factor * p);
    }
}

/// Largest magnitude of a signal behind the C-weighting, the causal filter of its poles, between the samples too \[Pa\].
pub(crate) fn c_weighted_peak(signal: &[f64], rate: f64) -> f64 {
    let length = (signal.len() + (RINGING * rate).ceil() as usize).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(length),
        planner.plan_fft_inverse(BETWEEN * length),
    );
    let mut record = signal.to_vec();
    record.resize(length, 0.0);
    let mut lines = forward.make_output_vec();
    // The buffers are those of the plans, so that neither transform fails.
    let mut done = forward.process(&mut record, &mut lines).is_ok();
    for (k, line) in lines.iter_mut().enumerate() {
        let hz = k as f64 * rate / length as f64;
        *line *= if k == 0 { 0.0.into() } else { Weighting::C.response(hz) };
    }
    // Nothing above half the sampling rate; the line there stands for itself and its conjugate.
    if let Some(last) = lines.last_mut() {
        *last *= 0.5;
    }
    lines.resize(BETWEEN * length / 2 + 1, 0.0.into());
    record.resize(BETWEEN * length, 0.0);
    done &= inverse.process(&mut lines, &mut record).is_ok();
    debug_assert!(done, "buffers of the plans' own lengths");
    record.iter().fold(0.0, |peak: f64, p| peak.max(p.abs())) / length as f64
}

impl MicrophoneArray {
    /// Levels at the ear. `radiated` is the A-weighted energy of all sources over the whole range \[J\]: what lies outside the
    /// ranges over which pressures are known is spread evenly from the device's centre, with its image in the plane.
    pub(super) fn at_ear(&self, sources: &[&AtMicrophones], radiated: f64) -> EarReport {
        let known: f64 = sources.iter().map(|source| source.energies[1]).sum();
        let rest = (radiated - known).max(0.0);
        let exposure = sources.iter().map(|source| source.ear.exposure).sum::<f64>().max(0.0);
        let evenly = rest * self.spreading(&self.air);
        let mut signal: Vec<f64> = Vec::new();
        for source in sources {
            signal.resize(signal.len().max(source.ear.signal.len()), 0.0);
            signal.iter_mut().zip(&source.ear.signal).for_each(|(sum, p)| *sum += p);
        }
        let peak = c_weighted_peak(&signal, f64::from(SAMPLE_RATE));
        let peak_db = (peak > 0.0).then(|| 20.0 * (peak / REFERENCE_PRESSURE).log10());
        // A source whose pressure ends below the range lacks part of every pulse; one without phases has no pulses at all.
        let lacking = |source: &&AtMicrophones| match source.range_hz[1] < self.range_hz[1] * (1.0 - 1e-9) {
            true => Some(format!("{} known to {:.0} Hz", source.source, source.range_hz[1])),
            false if source.how.starts_with(SPREAD_EVENLY) => Some(format!("{} has no phases", source.source)),
            false => None,
        };
        let lacking: Vec<String> = sources.iter().filter_map(lacking).collect();
        EarReport {
            position_m: self.ear,
            lpa_1s_db: energy_level((exposure + evenly) / REFERENCE),
            spread_share: if exposure + evenly > 0.0 {
                evenly / (exposure + evenly)
            } else {
                0.0
            },
            lpc_peak_db: peak_db.filter(|_| lacking.is_empty()),
            lpc_peak_known_db: peak_db,
            not_stated: (!lacking.is_empty()).then(|| lacking.join(", ")),
        }
    }

    /// Exposure at the ear of 1 J that is radiated evenly from the device's centre over the reflecting plane \[Pa² s/J\].
    fn spreading(&self, air: &Air) -> f64 {
        let [x, y, foot] = self.foot;
        let height = foot + self.centre_height;
        let ear = Point3::from(self.ear);
        let paths = [height, 2.0 * self.reflecting_plane - height].map(|z| distance(&ear, &Point3::new(x, y, z)));
        air.impedance() / (4.0 * PI) * paths.iter().map(|path| 1.0 / (path * path)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels of IEC 61672-1:2013, Table 3, within its resolution of 0.1 dB.
    #[test]
    fn a_tone_has_the_c_weighting_of_the_standard() {
        for (hz, db) in [(63.0, -0.8), (1000.0, 0.0), (8000.0, -3.0)] {
            // Faded, so that its beginning adds no peak of its own.
            let tone: Vec<f64> = (0..48_000)
                .map(|n| {
                    let t = f64::from(n) / 48_000.0;
                    (PI * t).sin().powi(2) * (2.0 * PI * hz * t).sin()
                })
                .collect();
            let found = 20.0 * c_weighted_peak(&tone, 48_000.0).log10();
            assert!((found - db).abs() < 0.06, "{hz} Hz: {found} dB instead of {db}");
        }
    }

    /// A pulse of one period of a Gaussian far from both corners of the weighting passes it with its height.
    #[test]
    fn a_short_pulse_keeps_its_peak() {
        let pulse = |width: f64| -> Vec<f64> {
            let of = |n: i32| {
                let t = (f64::from(n) / 48_000.0 - 0.5) / width;
                200.0 * (-0.5 * t * t).exp() * (1.0 - t * t)
            };
            (0..48_000).map(of).collect()
        };
        let found = c_weighted_peak(&pulse(0.3e-3), 48_000.0);
        assert!((20.0 * (found / 200.0).log10()).abs() < 0.5, "{found} Pa of 200 Pa");
        // 200 Pa are 140 dB, the upper limit of many rules.
        assert!((20.0f64 * (200.0f64 / REFERENCE_PRESSURE).log10() - 140.0).abs() < 1e-9);
        // One of half a second is taken away by the poles at 20.6 Hz.
        assert!(c_weighted_peak(&pulse(50e-3), 48_000.0) < 0.5 * 200.0);
    }

    #[test]
    fn a_silent_record_has_no_peak() {
        assert_eq!(c_weighted_peak(&[0.0; 100], 48_000.0), 0.0);
    }
}
