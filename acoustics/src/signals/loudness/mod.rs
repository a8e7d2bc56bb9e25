//! Loudness by Zwicker's method (ISO 532-1:2017) for stationary and time-varying sounds.
//!
//! ```text
//! pressure -> third-octave levels -> core loudness -> (decay over time) -> specific loudness -> N -> (weighting)
//! ```
//!
//! The loudness N is in sone. A 1 kHz tone at 40 dB in a free field, from the front, has a loudness of 1 sone. The
//! method assumes the same sound at both ears and the equal-loudness contours of ISO 226:1987. Coefficients are those
//! of annex A of the standard, as transcribed in open-source libraries (MoSQITo 1.2, phonometry); they have not been
//! compared with the printed tables.

mod core;
pub(crate) mod error;
mod filter_bank;
mod pattern;
mod sound_field;
mod temporal;

pub use error::LoudnessError;
pub use filter_bank::{BANDS, SAMPLE_RATE, steady_levels};
pub use sound_field::SoundField;

use self::core::core_loudness;
use filter_bank::{LEVEL_RATE, levels_over_time};
use pattern::total_loudness;

/// Loudness of a sound over time.
#[derive(Debug, Clone, PartialEq)]
pub struct LoudnessHistory {
    /// Loudness at intervals of [`LoudnessHistory::INTERVAL`], starting at the first sample \[sone\].
    pub sone: Vec<f64>,
}

impl LoudnessHistory {
    /// Interval between the values \[s\].
    pub const INTERVAL: f64 = 0.002;

    /// Number of loudness values, at the rate of the levels, per value of the history.
    const DECIMATION: usize = 4;

    /// Greatest loudness N_max \[sone\]; zero for an empty history.
    pub fn maximum(&self) -> f64 {
        self.sone.iter().copied().fold(0.0, f64::max)
    }

    /// Loudness exceeded during this fraction of the time \[sone\], for example N_5 for 0.05; zero for an empty
    /// history.
    ///
    /// The fraction refers to the complete record. For a single event it therefore depends on the length of the record,
    /// unlike N_max.
    pub fn exceeded(&self, share: f64) -> f64 {
        let mut falling = self.sone.clone();
        falling.sort_by(|a, b| b.total_cmp(a));
        let index = (share * falling.len() as f64) as usize;
        falling.get(index).or(falling.last()).copied().unwrap_or(0.0)
    }
}

/// Loudness N of a stationary sound from its levels in the third octaves of 25 Hz to 12.5 kHz \[dB re 20 uPa\], in sone
/// (ISO 532-1:2017, clause 5).
///
/// # Errors
/// If levels are not finite, or above 120 dB in a band up to 250 Hz, which exceeds the range of the standard.
pub fn stationary(levels: &[f64; BANDS], field: SoundField) -> Result<f64, LoudnessError> {
    Ok(total_loudness(&core_loudness(levels, field)?))
}

/// Loudness of a time-varying sound from its pressure \[Pa\] at 48 kHz (ISO 532-1:2017, clause 6).
///
/// # Errors
/// If pressures are not finite or levels exceed 120 dB in a band up to 250 Hz.
pub fn time_varying(pressure: &[f64], field: SoundField) -> Result<LoudnessHistory, LoudnessError> {
    let levels = levels_over_time(pressure)?;
    let mut cores = levels
        .iter()
        .map(|levels| core_loudness(levels, field))
        .collect::<Result<Vec<_>, _>>()?;
    temporal::decay(&mut cores, LEVEL_RATE);
    let loudness: Vec<f64> = cores.iter().map(total_loudness).collect();
    let weighted = temporal::weighted(&loudness, LEVEL_RATE);
    Ok(LoudnessHistory {
        sone: weighted.into_iter().step_by(LoudnessHistory::DECIMATION).collect(),
    })
}

/// Loudness level L_N \[phon\] of a loudness \[sone\] (ISO 532-1:2017, 5.8).
///
/// ```text
/// L_N = 40 + 10 log2(N)   for N >= 1,   40 (N + 0.0005)^0.35 and at least 3   below
/// ```
pub fn loudness_level(sone: f64) -> f64 {
    if sone >= 1.0 {
        40.0 + 10.0 * sone.log2()
    } else {
        (40.0 * (sone + 0.0005).powf(0.35)).max(3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_phons_double_the_loudness() {
        assert!((loudness_level(1.0) - 40.0).abs() < 1e-12);
        assert!((loudness_level(8.0) - 70.0).abs() < 1e-12);
        assert!(loudness_level(0.999) < 40.01 && loudness_level(0.0) >= 2.7);
    }

    #[test]
    fn silence_has_no_loudness() {
        assert_eq!(stationary(&[-60.0; BANDS], SoundField::Free).ok(), Some(0.0));
        let history = time_varying(&[0.0; 4800], SoundField::Free).ok();
        assert_eq!(history.map(|h| (h.maximum(), h.sone.len())), Some((0.0, 50)));
    }

    #[test]
    fn a_share_of_the_record_exceeds_the_percentile() {
        let history = LoudnessHistory {
            sone: (0..100).map(f64::from).collect(),
        };
        assert_eq!((history.exceeded(0.05), history.maximum()), (94.0, 99.0));
    }

    #[test]
    fn levels_above_the_standard_are_refused() {
        let mut levels = [60.0; BANDS];
        levels[10] = 120.5;
        assert!(matches!(
            stationary(&levels, SoundField::Free),
            Err(LoudnessError::TooLoud { .. })
        ));
    }
}
