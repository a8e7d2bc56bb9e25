//! A source as the ranking sees it: how much it radiates, when, and how sure that is.

use nailnoise_acoustics::exhaust::ExhaustHistory;
use nailnoise_acoustics::levels::{IntervalLevels, PowerHistory, PowerSignals, SourceSpectrum};
use serde::{Deserialize, Serialize};

use crate::result::{CrossCheck, RadiationReport, Uncertainty};

/// One source of the shot.
pub(super) struct Sound {
    /// Its energy over frequency.
    pub(super) spectrum: SourceSpectrum,
    /// The same energy over time: the parts that are signals, with their names.
    pub(super) signals: Vec<(&'static str, PowerSignals)>,
    /// The same energy over time: the parts that are flows.
    pub(super) openings: Vec<ExhaustHistory>,
    /// How far its method may be off.
    pub(super) uncertainty: Uncertainty,
    /// Another method's word on it.
    pub(super) cross_check: Option<CrossCheck>,
    /// What stands beside the power of a surface by boundary elements.
    pub(super) radiation: Option<RadiationReport>,
}

/// A source whose energy over time has been taken, without the signals behind it.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Source {
    /// Its energy over frequency.
    pub(super) spectrum: SourceSpectrum,
    /// Histories whose sum is its power.
    pub(super) histories: Vec<PowerHistory>,
    /// Its levels between the events.
    pub(super) intervals: Vec<IntervalLevels>,
    /// How far the bins of each signal were from the spectrum's, by the signal's name.
    pub(super) mismatches: Vec<(String, f64)>,
    /// How far its method may be off.
    pub(super) uncertainty: Uncertainty,
    /// Another method's word on it.
    pub(super) cross_check: Option<CrossCheck>,
    /// What stands beside the power of a surface by boundary elements.
    pub(super) radiation: Option<RadiationReport>,
}

impl Source {
    /// The source with its energy between the edges \[s\] within `range_hz`.
    pub(super) fn new(sound: Sound, edges: &[f64], range_hz: [f64; 2]) -> Self {
        let (histories, intervals) = sound.over_time(edges, range_hz);
        let mismatch = |(part, signals): &(&str, PowerSignals)| ((*part).to_owned(), signals.mismatch());
        Self {
            histories,
            intervals,
            mismatches: sound.signals.iter().map(mismatch).collect(),
            spectrum: sound.spectrum,
            uncertainty: sound.uncertainty,
            cross_check: sound.cross_check,
            radiation: sound.radiation,
        }
    }
}

impl Sound {
    /// Energy over time within `range_hz`: histories whose sum is the source's, and the levels between the edges \[s\].
    fn over_time(&self, edges: &[f64], range_hz: [f64; 2]) -> (Vec<PowerHistory>, Vec<IntervalLevels>) {
        let (mut histories, mut levels) = (Vec::new(), Vec::new());
        for (_, signals) in &self.signals {
            let analysis = signals.analyse(edges, range_hz);
            histories.push(analysis.history);
            levels.push(analysis.intervals);
        }
        for opening in &self.openings {
            let (of_opening, intervals) = opening.analyse(edges, range_hz);
            histories.extend(of_opening);
            levels.push(intervals);
        }
        (histories, IntervalLevels::sum(&levels))
    }
}
