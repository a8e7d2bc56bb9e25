//! Core loudness: the loudness of each critical band, excluding the slopes of its neighbours.

use super::error::LoudnessError;
use super::filter_bank::BANDS;
use super::sound_field::SoundField;
use crate::checks::finite;

/// Number of critical bands with a core loudness; the last one only lets slopes decay.
pub(super) const CRITICAL_BANDS: usize = 21;

/// Number of third octaves from 25 to 250 Hz, which are corrected by the equal-loudness contours.
const LOW_BANDS: usize = 11;

/// Upper ends of the level ranges of [`LOW_REDUCTION`] \[dB\] (table A.3).
const LOW_RANGES: [f64; 8] = [45.0, 55.0, 65.0, 71.0, 80.0, 90.0, 100.0, 120.0];

/// Level reduction of the bands of 25 to 250 Hz by level range \[dB\] (table A.3).
const LOW_REDUCTION: [[f64; LOW_BANDS]; 8] = [
    [-32.0, -24.0, -16.0, -10.0, -5.0, 0.0, -7.0, -3.0, 0.0, -2.0, 0.0],
    [-29.0, -22.0, -15.0, -10.0, -4.0, 0.0, -7.0, -2.0, 0.0, -2.0, 0.0],
    [-27.0, -19.0, -14.0, -9.0, -4.0, 0.0, -6.0, -2.0, 0.0, -2.0, 0.0],
    [-25.0, -17.0, -12.0, -9.0, -3.0, 0.0, -5.0, -2.0, 0.0, -2.0, 0.0],
    [-23.0, -16.0, -11.0, -7.0, -3.0, 0.0, -4.0, -1.0, 0.0, -1.0, 0.0],
    [-20.0, -14.0, -10.0, -6.0, -3.0, 0.0, -4.0, -1.0, 0.0, -1.0, 0.0],
    [-18.0, -12.0, -9.0, -6.0, -2.0, 0.0, -3.0, -1.0, 0.0, -1.0, 0.0],
    [-15.0, -10.0, -8.0, -4.0, -2.0, 0.0, -3.0, -1.0, 0.0, -1.0, 0.0],
];

/// The low third octaves in each of the three lowest critical bands: 25 to 80, 100 to 160, and 200 and 250 Hz.
const LOWEST_CRITICAL: [std::ops::Range<usize>; 3] = [0..6, 6..9, 9..11];

/// Level at threshold in each critical band, without the transmission of the ear \[dB\] (table A.6).
const THRESHOLD: [f64; 20] = [
    30.0, 18.0, 12.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0,
];

/// Transmission of the outer and middle ear \[dB\] (table A.4).
const TRANSMISSION: [f64; 20] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.5, -1.6, -3.2, -5.4, -5.6, -4.0, -1.5, 2.0, 5.0, 12.0,
];

/// Level in a diffuse field minus that in a free field of equal loudness \[dB\] (table A.5).
const DIFFUSE: [f64; 20] = [
    0.0, 0.0, 0.5, 0.9, 1.2, 1.6, 2.3, 2.8, 3.0, 2.0, 0.0, -1.4, -2.0, -1.9, -1.0, 0.5, 3.0, 4.0, 4.3, 4.0,
];

/// Level of a third octave minus that of its critical band \[dB\] (table A.7).
const BANDWIDTH: [f64; 20] = [
    -0.25, -0.6, -0.8, -0.8, -0.5, 0.0, 0.5, 1.1, 1.5, 1.7, 1.8, 1.8, 1.7, 1.6, 1.4, 1.2, 0.8, 0.5, 0.0, -0.5,
];

/// Share s of the threshold factor in the loudness function.
const THRESHOLD_SHARE: f64 = 0.25;

/// Energy of a low third octave after its reduction, relative to the reference.
fn reduced_energy(band: usize, level: f64) -> f64 {
    let range = (LOW_RANGES.iter().zip(&LOW_REDUCTION))
        .position(|(end, reduction)| level <= end - reduction[band])
        .unwrap_or(LOW_RANGES.len() - 1);
    10f64.powf(0.1 * (level + LOW_REDUCTION[range][band]))
}

/// Core loudness of the critical bands \[sone/Bark\] from third-octave levels \[dB re 20 uPa\].
///
/// ```text
/// N'_c = 0.0635 10^{0.025 L_TQ} [ (1 - s + s 10^{0.1 (L_E - L_TQ)})^{1/4} - 1 ]      s = 0.25
/// ```
///
/// ISO 532-1:2017, 5.4 to 5.6.
///
/// # Errors
/// If levels are not finite, or above 120 dB in a band up to 250 Hz.
pub(super) fn core_loudness(levels: &[f64; BANDS], field: SoundField) -> Result<[f64; CRITICAL_BANDS], LoudnessError> {
    finite("third-octave level [dB]", levels)?;
    let too_loud = levels[..LOW_BANDS].iter().position(|&level| level > 120.0);
    if let Some(band) = too_loud {
        return Err(LoudnessError::TooLoud {
            band,
            level: levels[band],
        });
    }
    let mut core = [0.0; CRITICAL_BANDS];
    for (i, own) in core.iter_mut().take(THRESHOLD.len()).enumerate() {
        let of_band = match LOWEST_CRITICAL.get(i) {
            Some(bands) => {
                let energy: f64 = bands.clone().map(|band| reduced_energy(band, levels[band])).sum();
                10.0 * energy.log10()
            }
            None => levels[LOW_BANDS - LOWEST_CRITICAL.len() + i],
        };
        let diffuse = match field {
            SoundField::Free => 0.0,
            SoundField::Diffuse => DIFFUSE[i],
        };
        let excitation = of_band - TRANSMISSION[i] + diffuse;
        if excitation > THRESHOLD[i] {
            let above = excitation - BANDWIDTH[i] - THRESHOLD[i];
            let s = THRESHOLD_SHARE;
            let sensation = (1.0 - s + s * 10f64.powf(0.1 * above)).powf(0.25) - 1.0;
            *own = (0.0635 * 10f64.powf(0.025 * THRESHOLD[i]) * sensation).max(0.0);
        }
    }
    // The threshold varies within the lowest critical band (5.6).
    core[0] *= (0.4 + 0.32 * core[0].powf(0.2)).min(1.0);
    Ok(core)
}
