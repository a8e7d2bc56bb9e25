//! Sound at the operator's ear: exposure, C-weighted peak and loudness of the emission sound pressure.

use nailnoise_acoustics::AcousticsError;
use nailnoise_acoustics::signals::loudness::{
    LoudnessError, LoudnessHistory, SoundField, loudness_level, time_varying,
};
use nailnoise_acoustics::signals::{Weighting, energy_level, peak_level};
use rayon::prelude::*;

use super::bands::{Spectra, density, integrals};
use super::{AtMicrophones, MicrophoneArray, REFERENCE, SAMPLE_RATE, over_bands};
use crate::error::Error;
use crate::result::{EarReport, SourceLoudness, TOTAL};

impl MicrophoneArray {
    /// Levels at the ear, which is the last receiver, from sources whose signals are complete.
    ///
    /// # Errors
    /// If pressures are not finite.
    pub(super) fn at_ear(&self, sources: &[AtMicrophones]) -> Result<EarReport, Error> {
        let ears = || {
            sources
                .iter()
                .filter_map(|source| Some((source, source.exposures.last()?, source.signals.last()?)))
        };
        let exposure: f64 = ears().map(|(_, bands, _)| over_bands(bands)[0]).sum();
        let synthetic: f64 = ears()
            .map(|(source, _, signal)| self.exposure_above(source.phases_to_hz, signal))
            .sum();
        let mut signal: Vec<f64> = Vec::new();
        for (_, _, own) in ears() {
            signal.resize(signal.len().max(own.len()), 0.0);
            signal.iter_mut().zip(own).for_each(|(sum, p)| *sum += p);
        }
        let sounds = ears().map(|(source, _, own)| (source.source.as_str(), own));
        let sounds: Vec<(&str, &Vec<f64>)> = sounds.chain([(TOTAL, &signal)]).collect();
        let loudness = sounds.into_par_iter().map(|(source, own)| loudness(source, own));
        let peak_db = peak_level(&signal, 1.0 / f64::from(SAMPLE_RATE), Weighting::C)?;
        // The peak of a pulse requires the phases over the complete range.
        let lacking = |source: &AtMicrophones| {
            let [low, high] = self.range_hz;
            match source.phases_to_hz {
                known if known >= high * (1.0 - 1e-9) => None,
                known if known <= low * (1.0 + 1e-9) => Some(format!("{} has no phases", source.source)),
                known => Some(format!("{} known to {known:.0} Hz", source.source)),
            }
        };
        let lacking: Vec<String> = sources.iter().filter_map(lacking).collect();
        Ok(EarReport {
            position_m: self.ear,
            lpa_1s_db: energy_level(exposure.max(0.0) / REFERENCE),
            synthetic_share: if exposure > 0.0 {
                (synthetic / exposure).min(1.0)
            } else {
                0.0
            },
            lpc_peak_db: peak_db.filter(|_| lacking.is_empty()),
            lpc_peak_signal_db: peak_db,
            not_stated: (!lacking.is_empty()).then(|| lacking.join(", ")),
            loudness: loudness.collect::<Result<_, Error>>()?,
        })
    }

    /// A-weighted exposure of a signal between a frequency and the end of the range \[Pa² s\].
    fn exposure_above(&self, hz: f64, signal: &[f64]) -> f64 {
        let spectra = Spectra::new(signal.len(), f64::from(SAMPLE_RATE));
        let energies = integrals(
            &spectra.frequency,
            &density(&spectra.lines(signal)),
            &[[hz, self.range_hz[1]]],
        );
        over_bands(&energies)[0]
    }
}

/// Loudness of a pressure signal; unknown above the levels that the standard covers.
fn loudness(source: &str, signal: &[f64]) -> Result<SourceLoudness, Error> {
    let history = match time_varying(signal, SoundField::Free) {
        Ok(history) => Some(history),
        Err(LoudnessError::TooLoud { .. }) => None,
        Err(error) => return Err(AcousticsError::from(error).into()),
    };
    let n_max = history.as_ref().map(LoudnessHistory::maximum);
    let time_of = |of: &LoudnessHistory| {
        let at = of.sone.iter().position(|n| Some(*n) == n_max)?;
        Some(at as f64 * LoudnessHistory::INTERVAL)
    };
    Ok(SourceLoudness {
        source: source.to_owned(),
        n_max_sone: n_max,
        level_phon: n_max.map(loudness_level),
        time_s: history.as_ref().and_then(time_of),
    })
}
