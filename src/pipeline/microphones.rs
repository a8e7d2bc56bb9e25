//! Virtual microphones around the device: what EN 12549 would measure of workpiece and support, beside what they
//! radiate.

use std::f64::consts::{PI, TAU};

use nailnoise_acoustics::levels::{BandLevel, SourceSpectrum, Weighting, energy_level, energy_weights};
use nailnoise_acoustics::radiation::ModalSpectra;
use nalgebra::{Complex, DMatrix, Point3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::radiation::side_by_side;
use super::radiator::{Radiator, floor};
use crate::design::Design;
use crate::error::Error;
use crate::result::{MicrophoneBand, MicrophoneLevel, MicrophoneReport};

/// Half sides a and b of the parallelepiped, and the distance c - h of its top from the device's centre \[m\]
/// (EN 12549).
const HALF_SIDE: f64 = 1.0;

/// The positions of ISO 3744 as multiples of a, b and c.
const POSITIONS: [[f64; 3]; 9] = [
    [1.0, 0.0, 0.5],
    [0.0, 1.0, 0.5],
    [-1.0, 0.0, 0.5],
    [0.0, -1.0, 0.5],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [0.0, 0.0, 1.0],
];

/// Reference exposure (20 uPa)² s \[Pa² s\] over reference energy 1 pW s and reference area 1 m²: 400 Pa s/m, which
/// stands for the impedance of air in L_W = L_p + 10 lg S.
const REFERENCE: f64 = 400.0;

/// Samples of a file of sound \[1/s\].
pub(crate) const SAMPLE_RATE: u32 = 48_000;

/// Time after the end of the response that a file of sound goes on for \[s\]: travel, and what the range's ends ring.
const TAIL: f64 = 0.05;

/// What the microphones hear of a shot.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Microphones {
    /// Levels, and how they compare with the power radiated.
    pub report: MicrophoneReport,
    /// Pressure at 48 kHz from the trigger on, microphone by microphone \[Pa\].
    pub signals: Vec<Vec<f64>>,
}

/// Sides a, b and c of the parallelepiped: the device's centre is half the tool's height above what it nails.
fn sides(design: &Design) -> [f64; 3] {
    let tool = design.body.nose_height + design.body.barrel_height + design.body.cap_height;
    let centre = design.workpiece.thickness + 0.5 * tool - floor(design);
    [HALF_SIDE, HALF_SIDE, HALF_SIDE + centre]
}

/// The microphones' places \[m\], in the coordinates of the bodies.
pub(super) fn positions(design: &Design) -> Vec<Point3<f64>> {
    let [a, b, c] = sides(design);
    let axis = Point3::new(design.nail.offset_along, design.nail.offset_across, floor(design));
    POSITIONS
        .iter()
        .map(|[x, y, z]| axis + nalgebra::Vector3::new(a * x, b * y, c * z))
        .collect()
}

/// Levels and signals at the microphones; none where workpiece and support do not radiate by boundary elements.
///
/// # Errors
/// Those of the radiation.
pub(super) fn microphones(
    design: &Design,
    radiator: &Radiator,
    spectra: &[ModalSpectra],
    radiated: &SourceSpectrum,
    duration: f64,
) -> Result<Option<Microphones>, Error> {
    let Radiator::Bem(bem) = radiator else {
        return Ok(None);
    };
    let together = side_by_side(spectra);
    let frequency = &together.frequency;
    let pressures = bem.pressures(frequency, &together.accelerations)?;
    let [a, b, c] = sides(design);
    let area = 4.0 * (a * b + b * c + c * a);
    let [from, to] = bem.blend_hz();
    let range = [together.range_hz[0], from.min(together.range_hz[1])];
    let exposures = |row: usize| {
        pressures
            .row(row)
            .iter()
            .map(|p| 2.0 * p.norm_sqr())
            .collect::<Vec<f64>>()
    };
    let all: Vec<Vec<f64>> = (0..POSITIONS.len()).map(exposures).collect();
    let mean = |bin: usize| all.iter().map(|e| e[bin]).sum::<f64>() / all.len() as f64;
    let measured = SourceSpectrum::new(
        "microphones",
        "ISO 3744",
        frequency.clone(),
        (0..frequency.len()).map(|bin| mean(bin) * area / REFERENCE).collect(),
        range,
    )?;
    let signals = signals(frequency, &pressures, [from, to], duration + TAIL);
    let level = |row: usize, weighting: Weighting| {
        let weights = energy_weights(frequency, range, weighting);
        let exposure: f64 = weights.iter().zip(&all[row]).map(|(w, e)| w * e).sum();
        energy_level(exposure / REFERENCE)
    };
    let peak = |signal: &[f64]| signal.iter().fold(0.0f64, |peak, p| peak.max(p.abs()));
    let positions = POSITIONS.iter().enumerate().map(|(row, [x, y, z])| MicrophoneLevel {
        position_m: [a * x, b * y, c * z],
        lae_db: level(row, Weighting::A),
        le_db: level(row, Weighting::Z),
        peak_pa: peak(&signals[row]),
    });
    let positions: Vec<MicrophoneLevel> = positions.collect();
    let bands = measured.band_levels(range);
    let whole = |b: &BandLevel| b.band.low >= range[0] && b.band.high <= range[1] * (1.0 + 1e-9);
    let of_band = |(measured, radiated): (&BandLevel, &BandLevel)| MicrophoneBand {
        hz: measured.band.nominal_hz(),
        lw_db: measured.lw,
        true_lw_db: radiated.lw,
    };
    let report = MicrophoneReport {
        box_m: [a, b, c],
        area_m2: area,
        range_hz: range,
        lwa_db: measured.level(range, Weighting::A),
        true_lwa_db: energy_level(radiated.energy(range, Weighting::A)),
        bands: bands
            .iter()
            .zip(&radiated.band_levels(range))
            .filter(|(b, _)| whole(b))
            .map(of_band)
            .collect(),
        interpolation_error: bem.summary.heard,
        full_scale_pa: full_scale(positions.iter().map(|m| m.peak_pa).fold(0.0, f64::max)),
        positions,
    };
    Ok(Some(Microphones { report, signals }))
}

/// The smallest of 1, 2, 5, 10 ... Pa above a peak, from 1 mPa on.
fn full_scale(peak: f64) -> f64 {
    let steps = (-3..6).flat_map(|decade| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(decade)));
    steps.into_iter().find(|scale| *scale > peak).unwrap_or(peak.max(1.0))
}

/// The pressures over time from t = 0 on, at [`SAMPLE_RATE`], microphone by microphone \[Pa\].
///
/// ```text
/// p(t) = 2 df Re sum_k P(f_k) e^{j 2 pi f_k t}
/// ```
///
/// with the upper end of the range faded out as boundary elements give way to their limit, which knows no phase.
fn signals(frequency: &[f64], pressures: &DMatrix<Complex<f64>>, fade: [f64; 2], duration: f64) -> Vec<Vec<f64>> {
    let bins = frequency.len();
    if bins < 2 {
        return vec![Vec::new(); pressures.nrows()];
    }
    let df = (frequency[bins - 1] - frequency[0]) / (bins - 1) as f64;
    let samples = (duration.min(1.0 / df) * f64::from(SAMPLE_RATE)).ceil() as usize;
    let share = |hz: f64| {
        let t = ((hz / fade[0]).ln() / (fade[1] / fade[0]).ln()).clamp(0.0, 1.0);
        (0.5 * PI * t).cos()
    };
    let of_row = |row: usize| {
        let mut signal = vec![0.0; samples];
        for (bin, &hz) in frequency.iter().enumerate() {
            let amplitude = pressures[(row, bin)] * (2.0 * df * share(hz));
            if amplitude.norm_sqr() == 0.0 {
                continue;
            }
            let step = TAU * hz / f64::from(SAMPLE_RATE);
            // The phasor is turned step by step, and set anew before rounding adds up.
            for (block, samples) in signal.chunks_mut(256).enumerate() {
                let mut phasor = amplitude * Complex::from_polar(1.0, step * (256 * block) as f64);
                let turn = Complex::from_polar(1.0, step);
                for sample in samples {
                    *sample += phasor.re;
                    phasor *= turn;
                }
            }
        }
        signal
    };
    (0..pressures.nrows()).into_par_iter().map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_holds_the_exposure_of_its_spectrum() {
        // Parseval over one whole period of the transform.
        let frequency: Vec<f64> = (10..400).map(|k| f64::from(k) * 5.0).collect();
        let spectrum = DMatrix::from_fn(1, frequency.len(), |_, k| {
            Complex::from_polar(1e-3, 0.37 * k as f64) / (1.0 + 0.01 * k as f64)
        });
        let signal = &signals(&frequency, &spectrum, [3000.0, 4000.0], 1.0)[0];
        assert_eq!(signal.len(), (SAMPLE_RATE / 5) as usize);
        let over_time: f64 = signal.iter().map(|p| p * p).sum::<f64>() / f64::from(SAMPLE_RATE);
        let over_frequency: f64 = spectrum.iter().map(|p| 2.0 * p.norm_sqr() * 5.0).sum();
        assert!(
            (over_time / over_frequency - 1.0).abs() < 1e-9,
            "{over_time} {over_frequency}"
        );
    }

    #[test]
    fn full_scale_is_a_round_pressure_above_the_peak() {
        for (peak, scale) in [(0.0, 1e-3), (0.7, 1.0), (1.0, 2.0), (3.3, 5.0), (12.0, 20.0)] {
            assert!((full_scale(peak) / scale - 1.0).abs() < 1e-12, "{peak}");
        }
    }
}
