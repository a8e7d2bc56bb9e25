//! The second stage of a calibration: levels of draws from the posterior of the cycle, weighted by measured levels.
//!
//! A draw of the cycle's posterior gives the shot; all other inputs of the levels are drawn from their ranges. The
//! levels of each shot are computed once, and several errors of the methods are drawn for it. These draws are weighted
//! by the likelihood of the measured levels and then drawn again by their weights. The number of effective draws is
//! stated, and a calibration with too few of them does not count as converged.

use std::collections::BTreeMap;
use std::sync::Arc;

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::conflict::{self, Conflict};
use nailnoise_calibration::likelihood::{Datum, ErrorLaw, Likelihood, Prediction};
use nailnoise_calibration::sampler::{Candidate, Particle};
use nailnoise_calibration::statistics::{effective_size, resampled, weighted_quantile};
use serde::Serialize;

use super::level_draws::{LevelDraws, level_draws};
use super::measurements::{MeasuredLevel, Measurements};
use super::posterior::{Found, Posterior, shuffle};
use super::random::standard_normal;
use super::request::{Request, Treatment};
use super::tool::errors;
use crate::decibels::energy_sum;
use crate::design::{Design, JointDraws};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::TOTAL;
use crate::stages::Progress;

/// Errors of methods drawn for each shot.
pub(super) const ERRORS: usize = 16;

/// Share of the first shots that must be effective for these to suffice, and the minimum number of effective shots.
const ENOUGH: f64 = 0.25;
pub(super) const FEWEST: f64 = 32.0;

/// Fraction of the range of a method's error next to each bound, and the share of draws there above which it is
/// pressed.
const END: f64 = 0.05;
const PRESSED: f64 = 0.25;

/// Largest number of readings excluded because of conflicts.
const MOST_CONFLICTS: usize = 8;

/// Seeds of the errors of methods, of shared errors and of resampling.
const METHODS: u64 = 0x5EED_3E70_D001;
const SHARED: u64 = 0x5EED_5A4E_D002;
const RESAMPLING: u64 = 0x5EED_2E5A_3D03;

/// Levels of a source, or of all of them, in shots of the design itself \[dB re 1 pW s\].
#[derive(Debug, Clone, Serialize)]
pub struct LevelRow {
    /// The source, or `total`.
    pub output: String,
    /// P5, P50 and P95 of the study of the design; null if there is none.
    pub ranges: Option<[f64; 3]>,
    /// P5, P50 and P95 given only the readings of the cycle.
    pub before: [f64; 3],
    /// P5, P50 and P95 given the levels as well.
    pub now: [f64; 3],
    /// Probability that it is the loudest source: given only the cycle, and given the levels as well; null for the
    /// total.
    pub first: Option<[f64; 2]>,
}

/// Work on the levels.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct LevelWork {
    /// Shots whose levels were computed.
    pub shots: usize,
    /// Errors of the methods drawn for each.
    pub errors: usize,
    /// Effective number of shots once they are weighted by the levels.
    pub effective: f64,
}

/// Draws that are weighted by measured levels.
pub(super) struct Levelled {
    /// The shots.
    draws: LevelDraws,
    /// A draw for each shot and each error of the methods, with predictions of all readings.
    particles: Vec<Particle>,
    /// Its shot, and the errors of the methods.
    pub(super) origins: Vec<Origin>,
    /// The readings; those left out do not count.
    pub(super) likelihood: Likelihood,
    /// Log weights of the draws before any level; those without a cycle reading that contradicts a level.
    base: Vec<f64>,
    /// Weights of the draws, with sum 1.
    pub(super) weights: Vec<f64>,
    /// Indices of the levels held out by the user.
    pub(super) held_out: Vec<usize>,
    pub(super) conflicts: Vec<Found>,
    /// Number of shots, and of effective ones.
    pub(super) shots: usize,
    pub(super) effective: f64,
}

/// Draws given the levels.
pub(super) struct ByLevels {
    pub(super) draws: Levelled,
    /// The weighted draw of each particle of the posterior.
    pub(super) chosen: Vec<usize>,
}

impl ByLevels {
    /// Draws the particles of a posterior again by their weights, in random order. The effective number of shots counts
    /// as the number of independent draws.
    pub(super) fn of(draws: Levelled, posterior: &mut Posterior, seed: u64) -> Self {
        let state = &mut posterior.state;
        let mut chosen = draws.resampled(state.particles.len(), seed);
        shuffle(&mut chosen, seed.wrapping_add(1));
        let particles = chosen.iter().map(|&draw| state.particles[draws.row(draw)].clone());
        state.particles = particles.collect();
        let effective = draws.effective.floor().max(1.0) as usize;
        posterior.diagnostics.ancestors = state.ancestors().min(effective);
        Self { draws, chosen }
    }
}

/// Origin of a weighted draw.
#[derive(Debug, Clone)]
pub(super) struct Origin {
    /// Number of its shot.
    pub(super) shot: usize,
    /// Places of the methods' errors between their bounds, by source.
    pub(super) method_shares: Vec<f64>,
    /// Level of each source in a shot of the design itself \[dB re 1 pW s\].
    pub(super) levels: Vec<f64>,
}

/// Reading of levels, before their posterior.
pub(super) struct LevelStage<'a> {
    pub(super) design: &'a Design,
    pub(super) measured: &'a Measurements,
    pub(super) request: &'a Request,
    pub(super) graph: &'a Graph,
    pub(super) progress: &'a Progress,
    pub(super) joint: JointDraws,
}

impl LevelStage<'_> {
    /// The draws of a posterior weighted by the levels; `held_out` are only predicted. With too few effective draws
    /// among the first ones, all draws are used.
    ///
    /// # Errors
    /// The errors of a study.
    pub(super) fn weighted(&self, posterior: &Posterior, held_out: &[usize]) -> Result<Levelled, Error> {
        let all = posterior.state.particles.len();
        let first = self.request.levels.min(all);
        let levelled = self.of_shots(posterior, held_out, first)?;
        if levelled.effective >= FEWEST.max(ENOUGH * levelled.shots as f64) || first == all {
            return Ok(levelled);
        }
        self.of_shots(posterior, held_out, all)
    }

    fn of_shots(&self, posterior: &Posterior, held_out: &[usize], count: usize) -> Result<Levelled, Error> {
        let joint = Arc::new(self.joint.clone());
        let draws = level_draws(
            self.graph,
            (self.design, joint),
            self.measured,
            (count, self.request.seed),
            self.progress,
        )?;
        self.progress.stage("weights of the levels");
        let families = families(&self.measured.levels);
        let (mut particles, mut origins) = (Vec::new(), Vec::new());
        for shot in 0..draws.len() {
            let own = &posterior.state.particles[draws.rows[shot]];
            for error in 0..ERRORS {
                let number = (shot * ERRORS + error) as u64;
                let method = |source: usize| uniform(self.request.seed ^ METHODS, number, source as u64);
                let method_shares: Vec<f64> = (0..draws.sources().len()).map(method).collect();
                let common = (0..families.len() as u64).map(|k| standard_normal(self.request.seed ^ SHARED, number, k));
                let predicted = self.measured.levels.iter().map(|level| {
                    let errors = draws.method_errors(level.condition, shot, &method_shares);
                    let value = level.quantity.predict(draws.sound(level.condition, shot), &errors);
                    if value.is_nan() {
                        Prediction::Missing
                    } else {
                        Prediction::Value(value)
                    }
                });
                particles.push(Particle {
                    z: own.z.iter().copied().chain(common).collect(),
                    predictions: predicted.collect(),
                    log_likelihood: 0.0,
                    ancestor: own.ancestor,
                });
                let levels = draws.of_design(shot, &method_shares);
                origins.push(Origin {
                    shot,
                    method_shares,
                    levels,
                });
            }
        }
        let count = particles.len();
        let levelled = Levelled {
            likelihood: likelihood(posterior, self.measured, held_out, &BTreeMap::new())?,
            shots: draws.len(),
            draws,
            particles,
            origins,
            base: vec![0.0; count],
            weights: vec![1.0 / count as f64; count],
            held_out: held_out.to_vec(),
            conflicts: Vec::new(),
            effective: 0.0,
        };
        levelled.conditioned(posterior, self.measured, self.request)
    }
}

/// Shared parts of the model's error, without duplicates.
fn families(levels: &[MeasuredLevel]) -> Vec<String> {
    let mut families: Vec<String> = levels.iter().filter_map(|own| own.quantity.family()).collect();
    families.sort_unstable();
    families.dedup();
    families
}

/// The likelihood of the levels. Those in `left_out` are only predicted; `factors` widen the independent errors. Half
/// of the variance of the model's error is common to all levels of a source.
fn likelihood(
    posterior: &Posterior,
    measured: &Measurements,
    left_out: &[usize],
    factors: &BTreeMap<usize, f64>,
) -> Result<Likelihood, Error> {
    let (keys, families) = (posterior.tool.keys(), families(&measured.levels));
    let variables = keys + posterior.tool.shared.len();
    let datum = |(number, own): (usize, &MeasuredLevel)| {
        let family = own.quantity.family();
        let family = families.iter().position(|known| Some(known) == family.as_ref());
        let of_model = family.map(|place| variables + place);
        let (scale, shared) = errors([own.error, own.discrepancy], of_model, (keys, own.instrument.as_ref()));
        Datum {
            name: own.name.clone(),
            condition: own.condition,
            reading: own.reading,
            scale: scale * factors.get(&number).copied().unwrap_or(1.0),
            shared,
            counts: !left_out.contains(&number),
        }
    };
    let data = measured.levels.iter().enumerate().map(datum).collect();
    let likelihood = Likelihood::new(data, measured.conditions.len(), &[], ErrorLaw::Student);
    likelihood.map_err(|error| super::CalibrationError::from(error).into())
}

impl Levelled {
    /// Draws weighted by all levels that agree with each other and with the readings of the cycle.
    fn conditioned(mut self, posterior: &Posterior, measured: &Measurements, request: &Request) -> Result<Self, Error> {
        let mut left_out = self.held_out.clone();
        for datum in self.unreached() {
            left_out.push(datum.datum);
            self.conflicts.push(datum);
        }
        let mut of_cycle = Vec::new();
        while self.conflicts.len() < MOST_CONFLICTS {
            self.likelihood = likelihood(posterior, measured, &left_out, &BTreeMap::new())?;
            let among = conflict::worst_of_weighted(&self.likelihood, &self.particles, |without| {
                self.weights_without(without)
            });
            if let Some(Conflict {
                datum,
                partner,
                probability,
            }) = among
            {
                left_out.push(datum);
                left_out.extend(partner);
                self.conflicts.push(found(datum, partner, probability));
                continue;
            }
            self.weights = self.weights_without(&[]);
            let Some((datum, reading, probability)) = self.conflict_with_cycle(posterior) else {
                break;
            };
            left_out.push(datum);
            of_cycle.push(reading);
            let rows = conflict::weights_without(&posterior.likelihood, &posterior.state.particles, &of_cycle);
            self.base = self
                .origins
                .iter()
                .map(|own| rows[self.draws.rows[own.shot]].ln())
                .collect();
            self.conflicts.push(Found {
                of_cycle: Some(reading),
                ..found(datum, None, probability)
            });
        }
        self.likelihood = likelihood(posterior, measured, &left_out, &BTreeMap::new())?;
        if request.treatment == Treatment::Widen && !self.conflicts.is_empty() {
            self.widen(posterior, measured)?;
        }
        self.weights = self.weights_without(&[]);
        self.effective = effective_size(&self.by_shot());
        Ok(self)
    }

    /// Multiplies the errors of conflicting levels by the factor with which they agree with the others.
    fn widen(&mut self, posterior: &Posterior, measured: &Measurements) -> Result<(), Error> {
        let mut factors = BTreeMap::new();
        let others = self.log_weights(&[]);
        for own in &mut self.conflicts {
            let factor =
                conflict::widening_of_weighted(&self.likelihood, &self.particles, &others, own.datum, own.partner);
            own.factor = Some(factor);
            factors.extend(
                [Some(own.datum), own.partner]
                    .into_iter()
                    .flatten()
                    .map(|k| (k, factor)),
            );
        }
        self.likelihood = likelihood(posterior, measured, &self.held_out, &factors)?;
        Ok(())
    }

    /// Levels that no draw comes near.
    fn unreached(&self) -> Vec<Found> {
        let candidate = |own: &Particle| Candidate {
            z: own.z.clone(),
            predictions: own.predictions.clone(),
        };
        let candidates: Vec<Candidate> = self.particles.iter().map(candidate).collect();
        let data = self.likelihood.data();
        let counting = (0..data.len()).filter(|&k| data[k].counts);
        let found = counting.filter_map(|datum| {
            let unreached = conflict::unreached(&self.likelihood, datum, &candidates)?;
            Some(Found {
                unreached: Some(unreached),
                ..found(datum, None, 0.0)
            })
        });
        found.collect()
    }

    /// A level that makes a reading of the cycle improbable, that reading, and its probability. The reading is most
    /// probable if this level is left out.
    fn conflict_with_cycle(&self, posterior: &Posterior) -> Option<(usize, usize, f64)> {
        let likelihood = &posterior.likelihood;
        let particles: Vec<Particle> = (self.draws.rows.iter())
            .map(|&row| posterior.state.particles[row].clone())
            .collect();
        let probability = |reading: usize, by_shot: &[f64]| {
            let without = conflict::weights_without(likelihood, &particles, &[reading]);
            let product: Vec<f64> = without.iter().zip(by_shot).map(|(a, b)| a * b).collect();
            let sum: f64 = product.iter().sum();
            let weights: Vec<f64> = product.iter().map(|own| own / sum).collect();
            conflict::probability(likelihood, reading, &particles, &weights, 1.0)
        };
        let by_shot = self.by_shot();
        let counting = (0..likelihood.data().len()).filter(|&k| likelihood.data()[k].counts);
        let all = counting.map(|k| (k, probability(k, &by_shot)));
        let (reading, least) = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if least >= conflict::CONFLICT {
            return None;
        }
        let data = self.likelihood.data();
        let levels = (0..data.len()).filter(|&k| data[k].counts);
        let without = levels.map(|k| (k, probability(reading, &self.summed(&self.weights_without(&[k])))));
        let (level, _) = without.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((level, reading, least))
    }

    /// Log weights of the draws given all levels that count, without some.
    fn log_weights(&self, without: &[usize]) -> Vec<f64> {
        let data = self.likelihood.data();
        let counting: Vec<usize> = (0..data.len())
            .filter(|k| data[*k].counts && !without.contains(k))
            .collect();
        let log = |(own, base): (&Particle, &f64)| -> f64 {
            let terms = counting.iter();
            base + terms
                .map(|&k| self.likelihood.of_datum(k, &own.z, own.predictions[k]))
                .sum::<f64>()
        };
        self.particles.iter().zip(&self.base).map(log).collect()
    }

    fn weights_without(&self, without: &[usize]) -> Vec<f64> {
        let log = self.log_weights(without);
        // If no draw has all levels, no weight is a number.
        if log.iter().all(|own| *own == f64::NEG_INFINITY) {
            return vec![1.0 / log.len() as f64; log.len()];
        }
        conflict::normalised(&log)
    }

    /// Weights of the shots.
    fn by_shot(&self) -> Vec<f64> {
        self.summed(&self.weights)
    }

    fn summed(&self, weights: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.draws.len()];
        (self.origins.iter().zip(weights)).for_each(|(own, weight)| sums[own.shot] += weight);
        sums
    }

    /// Number of the posterior's draw that a weighted draw repeats.
    pub(super) fn row(&self, draw: usize) -> usize {
        self.draws.rows[self.origins[draw].shot]
    }

    /// Names of the further inputs, and their values in a weighted draw.
    pub(super) fn further(&self, draw: usize) -> Vec<f64> {
        let own = &self.origins[draw];
        self.draws.further(own.shot, &own.method_shares)
    }

    /// Names of the inputs of [`further`](Self::further).
    pub(super) fn further_names(&self) -> Vec<String> {
        self.draws.further_names()
    }

    /// Names of the sources.
    pub(super) fn sources(&self) -> &[String] {
        self.draws.sources()
    }

    /// `count` draws by their weights.
    pub(super) fn resampled(&self, count: usize, seed: u64) -> Vec<usize> {
        resampled(&self.weights, count, uniform(seed ^ RESAMPLING, 0, 0))
    }

    /// P5, P50 and P95 of an output of the weighted draws, without the levels and with them.
    pub(super) fn percentiles(&self, of: impl Fn(usize) -> f64) -> [[f64; 3]; 2] {
        let values: Vec<f64> = (0..self.origins.len()).map(of).collect();
        let before = conflict::normalised(&self.base);
        [&before, &self.weights].map(|weights| {
            let known: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_finite()).collect();
            let values: Vec<f64> = known.iter().map(|&k| values[k]).collect();
            let weights: Vec<f64> = known.iter().map(|&k| weights[k]).collect();
            [0.05, 0.5, 0.95].map(|p| weighted_quantile(&values, &weights, p))
        })
    }

    /// The prediction of a level in a weighted draw \[dB\].
    pub(super) fn prediction(&self, level: usize, draw: usize) -> f64 {
        self.particles[draw].predictions[level].value()
    }

    /// Predictive probability of a level, given the others that count.
    pub(super) fn probability(&self, level: usize) -> f64 {
        let weights = self.weights_without(&[level]);
        conflict::probability(&self.likelihood, level, &self.particles, &weights, 1.0)
    }

    /// Ends of the methods' errors against which a level, together with all others that count, presses the draws:
    /// source, whether it is the upper end, and the share of the draws there.
    pub(super) fn pressed(&self, level: usize) -> Vec<(&str, bool, f64)> {
        let terms = self.log_weights(&[level]).into_iter().zip(&self.particles);
        let log: Vec<f64> = terms
            .map(|(log, own)| log + self.likelihood.of_datum(level, &own.z, own.predictions[level]))
            .collect();
        let weights = conflict::normalised(&log);
        let mut found = Vec::new();
        for (source, name) in self.sources().iter().enumerate() {
            for is_upper in [false, true] {
                let is_beyond = |own: &Origin| match is_upper {
                    true => own.method_shares[source] > 1.0 - END,
                    false => own.method_shares[source] < END,
                };
                let beyond = self.origins.iter().zip(&weights).filter(|(own, _)| is_beyond(own));
                let share: f64 = beyond.map(|(_, weight)| weight).sum();
                if share > PRESSED {
                    found.push((name.as_str(), is_upper, share));
                }
            }
        }
        found
    }

    /// Reading of a level less its mean prediction, in combined standard deviations.
    pub(super) fn left_over(&self, level: usize) -> f64 {
        let own = &self.likelihood.data()[level];
        let value = |draw: usize| self.prediction(level, draw) + self.likelihood.shared(level, &self.particles[draw].z);
        let draws = (0..self.particles.len()).filter(|&draw| self.prediction(level, draw).is_finite());
        let pairs: Vec<(f64, f64)> = draws.map(|draw| (value(draw), self.weights[draw])).collect();
        let total: f64 = pairs.iter().map(|(_, weight)| weight).sum();
        let mean = pairs.iter().map(|(value, weight)| value * weight).sum::<f64>() / total;
        let variance = pairs
            .iter()
            .map(|(value, weight)| (value - mean).powi(2) * weight)
            .sum::<f64>()
            / total;
        (own.reading.nearest(mean) - mean) / own.scale.hypot(variance.sqrt())
    }

    /// Level of a source or of all of them in a weighted draw, in a shot of the design itself \[dB re 1 pW s\].
    pub(super) fn level(&self, output: &str, draw: usize) -> f64 {
        let levels = &self.origins[draw].levels;
        match self.sources().iter().position(|own| own == output) {
            Some(place) if output != TOTAL => levels[place],
            _ => energy_sum(levels.iter().copied()),
        }
    }

    /// Probability that a source is the loudest, without the levels and with them.
    pub(super) fn first(&self, source: usize) -> [f64; 2] {
        let is_first = |levels: &[f64]| levels.iter().all(|other| *other <= levels[source]);
        let before = conflict::normalised(&self.base);
        [&before, &self.weights].map(|weights| {
            let own = self.origins.iter().zip(weights);
            own.filter(|(own, _)| is_first(&own.levels))
                .fold(0.0, |sum, (_, weight)| sum + weight)
        })
    }
}

fn found(datum: usize, partner: Option<usize>, probability: f64) -> Found {
    Found {
        datum,
        partner,
        probability,
        ..Found::default()
    }
}
