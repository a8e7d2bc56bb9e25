//! A source: its energy over frequency and time, and its uncertainty.

use nailnoise_acoustics::jets::ExhaustHistory;
use nailnoise_acoustics::radiation::PartOfSurface;
use nailnoise_acoustics::radiation::radiator::RadiatedSound;
use nailnoise_acoustics::signals::{
    Contribution, IntervalLevels, LevelsError, PowerHistory, PowerSignals, SourceSpectrum,
};
use serde::{Deserialize, Serialize};

use super::intervals::{EventEdges, Interval};
use crate::result::{Check, CrossCheck, RadiationReport, Uncertainty};

/// Largest difference between the two evaluations of the A-weighted level \[dB\].
const DIFFERENCE: f64 = 0.1;

/// A source with its signals.
#[derive(Clone)]
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
    pub intervals: Vec<Interval>,
    /// Names of the contributions that the wrapping convention moves from one source to another.
    pub moved: Vec<String>,
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
            moved: Vec::new(),
            mismatches: sound.signals.iter().map(mismatch).collect(),
            spectrum: sound.spectrum,
            uncertainty: sound.uncertainty,
            cross_check: sound.cross_check,
            radiation: sound.radiation,
        }
    }

    /// Analyses a part of a surface, whose energy may have either sign; `uncertainty` is its uncertainty.
    pub fn of_part(part: PartOfSurface, uncertainty: Uncertainty, edges: &EventEdges, range_hz: [f64; 2]) -> Self {
        let analysis = part.analyse(edges.times(), range_hz);
        let mismatches = vec![(part.spectrum.source.clone(), part.mismatch())];
        Self {
            spectrum: part.spectrum,
            histories: vec![analysis.history],
            intervals: edges.named(&analysis.intervals),
            moved: Vec::new(),
            mismatches,
            uncertainty,
            cross_check: None,
            radiation: None,
        }
    }

    /// The source without a part given at the same frequencies.
    ///
    /// # Errors
    /// If the part has other frequencies.
    pub fn without(&self, part: &Self) -> Result<Self, LevelsError> {
        let mut rest = self.clone();
        rest.spectrum = self.spectrum.without(&part.spectrum)?;
        rest.moved
            .extend(rest.spectrum.contributions.last().map(|taken| taken.name.clone()));
        rest.histories
            .extend(part.histories.iter().map(|history| history.scaled(-1.0)));
        rest.add_intervals(&part.intervals, -1.0);
        Ok(rest)
    }

    /// The source with a part that is assigned to it. The range of the source is unchanged, and the part becomes a
    /// contribution.
    #[must_use]
    pub fn with(&self, part: &Self) -> Self {
        let mut whole = self.clone();
        whole.spectrum = sum_with(&self.spectrum, &part.spectrum);
        whole.moved.push(part.spectrum.source.clone());
        whole.histories.extend(part.histories.iter().cloned());
        whole.mismatches.extend(part.mismatches.iter().cloned());
        whole.add_intervals(&part.intervals, 1.0);
        whole
    }

    /// Check that the power from the surface equals that from the far field, if both are known.
    pub fn surface_check(&self) -> Option<Check> {
        let difference = self.radiation.as_ref()?.surface_difference_db?;
        let source = &self.spectrum.source;
        let name = format!("{source}: power by the surface less that by the far field [dB]");
        Some(Check::at_most(name, difference, DIFFERENCE))
    }

    fn add_intervals(&mut self, others: &[Interval], factor: f64) {
        for (own, other) in self.intervals.iter_mut().zip(others) {
            let other = IntervalLevels::scaled(std::slice::from_ref(&other.levels), factor);
            own.levels = IntervalLevels::sum(&[vec![own.levels], other])[0];
        }
    }
}

/// A quantity of a source over the samples of the cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceHistory {
    /// Its name and unit, as the heading of a column.
    pub heading: String,
    /// Its values; `None` where it is undefined.
    pub values: Vec<Option<f64>>,
}

/// The sum of a spectrum and that of a part, which becomes a contribution; the range is that of the first.
pub fn sum_with(own: &SourceSpectrum, part: &SourceSpectrum) -> SourceSpectrum {
    let alone = SourceSpectrum {
        contributions: Vec::new(),
        ..own.clone()
    };
    let method = format!("{}; {}: {}", own.method, part.source, part.method);
    let mut sum = SourceSpectrum::sum(&*own.source, method, &[alone, part.clone()]);
    sum.range_hz = own.range_hz;
    let added = sum.contributions.pop();
    let on_all = |contribution: SourceSpectrum| Contribution {
        energy_density: sum.frequency.iter().map(|&hz| contribution.density_at(hz)).collect(),
        name: contribution.source,
    };
    let of_own: Vec<Contribution> = parts_of(own).into_iter().map(on_all).collect();
    sum.contributions = of_own.into_iter().chain(added).collect();
    sum
}

/// The contributions of a spectrum as separate spectra.
pub fn parts_of(spectrum: &SourceSpectrum) -> Vec<SourceSpectrum> {
    let part = |contribution: &Contribution| SourceSpectrum {
        source: contribution.name.clone(),
        method: spectrum.method.clone(),
        frequency: spectrum.frequency.clone(),
        energy_density: contribution.energy_density.clone(),
        range_hz: spectrum.range_hz,
        contributions: Vec::new(),
    };
    spectrum.contributions.iter().map(part).collect()
}
