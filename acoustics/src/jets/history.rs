use super::histogram::PeakWeights;
use super::{shock, similarity};
use crate::signals::{IntervalLevels, PowerHistory, PowerSignals, SignalAnalysis, Weighting, energy_weights};

/// Sound energy of one sample, and the peak frequency of its spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Burst {
    pub(super) sample: usize,
    pub(super) peak_hz: f64,
    pub(super) energy: f64,
    /// lg(U_j/c0).
    pub(super) lg_velocity: f64,
}

/// Noise of an opening over time.
///
/// Jet noise is random: the energy of a sample is radiated within that sample, and its share within a frequency range
/// follows from its spectrum. The monopole of the outflow is a deterministic signal.
#[derive(Debug, Clone)]
pub struct ExhaustHistory {
    pub(super) sample_interval: f64,
    pub(super) samples: usize,
    pub(super) frequency: Vec<f64>,
    /// Energy transmission factor of the muffler.
    pub(super) passed: Option<Vec<f64>>,
    pub(super) mixing: Vec<Burst>,
    pub(super) shocks: Vec<Burst>,
    pub(super) monopole: PowerSignals,
}

impl ExhaustHistory {
    /// A-weighted power of the jets' mixing and shock noise within `range_hz`.
    pub fn jets(&self, range_hz: [f64; 2]) -> PowerHistory {
        let mut weights = energy_weights(&self.frequency, range_hz, Weighting::A);
        if let Some(passed) = &self.passed {
            weights.iter_mut().zip(passed).for_each(|(w, factor)| *w *= factor);
        }
        let normal = similarity::total();
        let mut power = vec![0.0; self.samples];
        let mut add = |bursts: &[Burst], shape: &dyn Fn(f64) -> f64| {
            let counted = PeakWeights::new(shape, &self.frequency, &weights, bursts.iter().map(|b| b.peak_hz));
            for burst in bursts {
                power[burst.sample] += burst.energy * counted.of(burst.peak_hz) / self.sample_interval;
            }
        };
        add(&self.mixing, &|x| similarity::shape(x) / normal);
        add(&self.shocks, &shock::shape);
        PowerHistory {
            start: 0.0,
            sample_interval: self.sample_interval,
            power,
        }
    }

    /// A-weighted power of jets and monopole within `range_hz`, and the levels between adjacent `edges` \[s\].
    ///
    /// Windowing random noise does not change its expected energy if its spectrum is smooth on the scale of the
    /// window's spectrum. The level that a measurement would give therefore differs only for the monopole.
    pub fn analyse(&self, edges: &[f64], range_hz: [f64; 2]) -> (Vec<PowerHistory>, Vec<IntervalLevels>) {
        let jets = self.jets(range_hz);
        let between = jets.energies_between(edges);
        let jet_levels = edges
            .windows(2)
            .zip(between)
            .map(|(pair, energy)| IntervalLevels::new(pair[0], pair[1], energy, energy))
            .collect();
        let SignalAnalysis { history, intervals } = self.monopole.analyse(edges, range_hz);
        (vec![jets, history], IntervalLevels::sum(&[jet_levels, intervals]))
    }
}
