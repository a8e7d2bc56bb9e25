//! A source: its energy over frequency and time, and its uncertainty.

use nailnoise_acoustics::exhaust::ExhaustHistory;
use nailnoise_acoustics::levels::{IntervalLevels, PowerHistory, PowerSignals, SourceSpectrum};
use nailnoise_acoustics::radiator::RadiatedSound;
use serde::{Deserialize, Serialize};

use super::intervals::EventEdges;
use crate::result::{CrossCheck, IntervalLevel, RadiationReport, Uncertainty};

/// A source with the signals that it consists of.
pub struct Sound {
    /// Energy over frequency.
    pub spectrum: SourceSpectrum,
    /// The same energy over time: parts given as signals, with their names.
    pub signals: Vec<(&'static str, PowerSignals)>,
    /// The same energy over time: parts given as flows through openings.
    pub openings: Vec<ExhaustHistory>,
    /// Uncertainty of the method.
    pub uncertainty: Uncertainty,
    /// Level by an independent method.
    pub cross_check: Option<CrossCheck>,
    /// Comparisons of the radiated power of a surface.
    pub radiation: Option<RadiationReport>,
}

impl From<RadiatedSound> for Sound {
    fn from(radiated: RadiatedSound) -> Self {
        Self {
            spectrum: radiated.spectrum,
            signals: radiated.signals,
            openings: Vec::new(),
            uncertainty: radiated.uncertainty,
            cross_check: None,
            radiation: radiated.report,
        }
    }
}

/// A source whose energy over time has been analysed, without its signals.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SoundSource {
    /// Energy over frequency.
    pub spectrum: SourceSpectrum,
    /// Histories whose sum is the power of the source.
    pub histories: Vec<PowerHistory>,
    /// Levels between the events.
    pub intervals: Vec<IntervalLevel>,
    /// Relative difference between the bins of each signal and those of the spectrum, by the signal's name.
    pub mismatches: Vec<(String, f64)>,
    /// Uncertainty of the method.
    pub uncertainty: Uncertainty,
    /// Level by an independent method.
    pub cross_check: Option<CrossCheck>,
    /// Comparisons of the radiated power of a surface.
    pub radiation: Option<RadiationReport>,
}

impl SoundSource {
    /// Analyses the energy of a source between the events, within `range_hz`.
    pub fn new(sound: Sound, edges: &EventEdges, range_hz: [f64; 2]) -> Self {
        let (mut histories, mut levels) = (Vec::new(), Vec::new());
        for (_, signals) in &sound.signals {
            let analysis = signals.analyse(edges.times(), range_hz);
            histories.push(analysis.history);
            levels.push(analysis.intervals);
        }
        for opening in &sound.openings {
            let (of_opening, intervals) = opening.analyse(edges.times(), range_hz);
            histories.extend(of_opening);
            levels.push(intervals);
        }
        let mismatch = |(part, signals): &(&str, PowerSignals)| ((*part).to_owned(), signals.mismatch());
        Self {
            histories,
            intervals: edges.named(&IntervalLevels::sum(&levels)),
            mismatches: sound.signals.iter().map(mismatch).collect(),
            spectrum: sound.spectrum,
            uncertainty: sound.uncertainty,
            cross_check: sound.cross_check,
            radiation: sound.radiation,
        }
    }
}
