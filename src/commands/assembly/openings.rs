//! Figures of the flow through each opening of a cycle.

use nailnoise_dynamics::network::{Assembly, FlowHistory, Record};
use serde::Serialize;

use crate::stages::cycle::discharged_masses;

/// Figures of the flow through an opening to the atmosphere.
#[derive(Debug, Serialize)]
pub(super) struct OpeningFigures<'a> {
    /// Name of the opening.
    name: &'a str,
    /// Mass that leaves through it, less what enters \[kg\]; null if the record does not balance it.
    mass: Option<f64>,
    /// Largest mass flow out \[kg/s\].
    peak_mass_flow: f64,
    /// Time of the largest mass flow \[s\].
    peak_time: f64,
    /// First and last sample with choked flow \[s\]; null if the flow is never choked.
    choked: Option<[f64; 2]>,
}

impl<'a> OpeningFigures<'a> {
    /// The openings of a record, in the order of the assembly; none without samples.
    pub(super) fn of(assembly: &Assembly, record: &'a Record) -> Vec<Self> {
        let flows = record.openings.iter().zip(discharged_masses(assembly, record));
        flows.filter_map(|(flow, mass)| Self::new(flow, record, mass)).collect()
    }

    fn new(flow: &'a FlowHistory, record: &Record, mass: Option<f64>) -> Option<Self> {
        let samples = flow.mass_flow.iter().copied().enumerate();
        let (peak, peak_mass_flow) = samples.reduce(|first, next| if next.1 > first.1 { next } else { first })?;
        let first = flow.choked.iter().position(|choked| *choked);
        let last = flow.choked.iter().rposition(|choked| *choked);
        Some(Self {
            name: &flow.name,
            mass,
            peak_mass_flow,
            peak_time: record.time(peak),
            choked: first
                .zip(last)
                .map(|(first, last)| [first, last].map(|at| record.time(at))),
        })
    }

    /// Name, mass, largest flow and its time, first and last time of choked flow.
    pub(super) fn row(&self) -> Vec<String> {
        let milli = |value: f64| format!("{:.3}", 1e3 * value);
        let choked = |[from, to]: [f64; 2]| format!("{} to {}", milli(from), milli(to));
        vec![
            self.name.to_owned(),
            self.mass.map_or_else(|| "-".to_owned(), milli),
            milli(self.peak_mass_flow),
            milli(self.peak_time),
            self.choked.map_or_else(|| "never".to_owned(), choked),
        ]
    }
}

/// Headings of [`OpeningFigures::row`].
pub(super) const HEADINGS: [&str; 5] = ["opening", "mass g", "largest flow g/s", "at ms", "choked ms"];
