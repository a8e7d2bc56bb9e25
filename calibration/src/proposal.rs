//! Proposals of the sampler: chains of cheap steps whose target is the posterior with emulated predictions.
//!
//! Each step is reversible with respect to the density p(z) q(z) exp(tau l~(z)), where q is the emulated probability of
//! the observed outcomes and l~ the log-likelihood of the emulated predictions; so is a chain of a fixed number of
//! steps, each of a kind drawn at random. A chain from z to z', whose outcomes are as observed, is then accepted with
//! the probability
//!
//! ```text
//! min(1, exp(tau [l(z') - l(z) - l~(z') + l~(z)]) q(z)/q(z'))
//! ```
//!
//! which makes the posterior itself invariant, whatever the error of the emulators (Liu, "Monte Carlo strategies in
//! scientific computing" (2001), section 9.4.3; Christen and Fox, "Markov chain Monte Carlo using an approximation",
//! Journal of Computational and Graphical Statistics 14, 795 (2005)).
//!
//! There are two kinds of steps. One moves all variables: in the r informed directions V, with y = V^T z,
//!
//! ```text
//! e  = L^-1 (y - m),   g = 2 Gamma((r+5)/2, 1)/(5 + |e|^2)
//! e' = sqrt(1-b^2) e + b xi/sqrt(g),   y' = m + L e'
//! w' = sqrt(1-b^2) (z - V y) + b (I - V V^T) xi,   z' = V y' + w'
//! ```
//!
//! The first is reversible for a Student t distribution with 5 degrees of freedom, mean m and scale matrix L L^T, the
//! second for the prior (Cotter, Roberts, Stuart and White, "MCMC methods for functions", Statistical Science 28, 424
//! (2013)). m and L are computed from the other half of the particles, so that no particle influences its own proposal.
//! Without this split, the evidence is biased low and directions without data become too narrow. Variables of rules
//! stay as they are.
//!
//! The other kind moves a few variables by a large step of the second form. Inputs without effect on the readings are
//! thus redrawn from the prior, and only these steps move the variables of rules.

use nalgebra::{DMatrix, DVector};

use crate::Simulator;
use crate::emulator::Emulator;
use crate::likelihood::{Likelihood, Prediction};
use crate::random::Stream;
use crate::subspace::Reference;

/// Degrees of freedom of the proposal in the informed directions.
const DEGREES: f64 = 5.0;

/// Share of the steps that move all variables.
const OF_ALL: f64 = 0.3;

/// Numbers of variables and values of b of the other steps.
const BLOCKS: [usize; 4] = [1, 2, 4, 8];
const BLOCK_SIZES: [f64; 3] = [1.0, 0.5, 0.25];

/// Data shared by the chains of one half of the particles.
pub(crate) struct Frame<'a> {
    /// V.
    pub(crate) directions: &'a DMatrix<f64>,
    /// m and L.
    pub(crate) reference: Option<Reference>,
    /// tau.
    pub(crate) temperature: f64,
    /// b of the steps that move all variables.
    pub(crate) size: f64,
    /// Number of steps.
    pub(crate) steps: u64,
}

/// The posterior with emulated predictions.
pub(crate) struct Target<'a, S> {
    pub(crate) simulator: &'a S,
    pub(crate) emulator: &'a Emulator,
    /// The errors of the emulators are part of its scales.
    pub(crate) likelihood: Likelihood,
    /// Whether each variable is constrained by a rule.
    pub(crate) ruled: &'a [bool],
}

/// The end of a chain.
pub(crate) struct Proposal {
    pub(crate) z: Vec<f64>,
    /// tau [l~(z') - l~(z)] + ln q(z') - ln q(z).
    pub(crate) rise: f64,
    /// Number of accepted steps, of either kind.
    pub(crate) accepted: u64,
    /// Accepted and tried steps that move all variables.
    pub(crate) of_all: [u64; 2],
}

/// A point of a chain.
#[derive(Clone)]
struct Place {
    z: Vec<f64>,
    /// Those of the variables, and further ones of the emulators.
    coordinates: Vec<f64>,
    /// tau l~ + ln q.
    log_density: f64,
}

impl<S: Simulator> Target<'_, S> {
    fn log_density(&self, place: &mut Place, temperature: f64, predictions: &mut [Prediction]) -> f64 {
        let log_probability = self
            .emulator
            .predict(&mut place.coordinates, place.z.len(), predictions);
        temperature * self.likelihood.total(&place.z, predictions) + log_probability
    }

    /// The end of a chain from a point. `stream` supplies the random numbers of a step.
    pub(crate) fn chain(&self, frame: &Frame<'_>, z: &[f64], stream: impl Fn(u64, u64) -> Stream) -> Proposal {
        let mut predictions = vec![Prediction::Missing; self.likelihood.data().len()];
        let coordinates: Vec<f64> = (0..z.len()).map(|k| self.simulator.coordinate(k, z[k])).collect();
        let mut place = Place {
            z: z.to_vec(),
            coordinates,
            log_density: 0.0,
        };
        place.log_density = self.log_density(&mut place, frame.temperature, &mut predictions);
        let log_density = place.log_density;
        let mut next = place.clone();
        let (mut accepted, mut of_all) = (0, [0, 0]);
        for step in 0..frame.steps {
            let kind = stream(step, 0);
            let is_of_all = kind.uniform(0) < OF_ALL;
            let log_ratio = if is_of_all {
                self.move_all(frame, &place, &mut next, |own| stream(step, own))
            } else {
                self.move_block(&place, &mut next, kind);
                0.0
            };
            next.log_density = self.log_density(&mut next, frame.temperature, &mut predictions);
            let is_accepted = kind.uniform(1).ln() < log_ratio + next.log_density - place.log_density;
            if is_accepted {
                std::mem::swap(&mut place, &mut next);
            }
            accepted += u64::from(is_accepted);
            if is_of_all {
                of_all[0] += u64::from(is_accepted);
                of_all[1] += 1;
            }
        }
        Proposal {
            z: place.z,
            rise: place.log_density - log_density,
            accepted,
            of_all,
        }
    }

    /// Moves all variables but those of rules; returns the logarithm of the ratio of the reference densities.
    fn move_all(&self, frame: &Frame<'_>, from: &Place, to: &mut Place, stream: impl Fn(u64) -> Stream) -> f64 {
        let (d, r) = frame.directions.shape();
        let (b, kept) = (frame.size, (1.0 - frame.size * frame.size).sqrt());
        let z = DVector::from_column_slice(&from.z);
        let y = frame.directions.tr_mul(&z);
        let within = frame.directions * &y;
        let mut log_ratio = 0.0;
        let mut moved_within = within.clone();
        if let Some(reference) = &frame.reference {
            let e = reference.standardised(&y);
            let shape = 0.5 * (r as f64 + DEGREES);
            let g = 2.0 * stream(1).gamma(shape, 0) / (DEGREES + e.norm_squared());
            let xi = DVector::from_fn(r, |k, _| stream(2).normal(k as u64));
            let e1 = &e * kept + xi * (b / g.sqrt());
            let y1 = reference.point(&e1);
            let student = |e: &DVector<f64>| shape * (e.norm_squared() / DEGREES).ln_1p();
            log_ratio = student(&e1) - student(&e) - 0.5 * (y1.norm_squared() - y.norm_squared());
            moved_within = frame.directions * y1;
        }
        let xi = DVector::from_fn(d, |k, _| if self.ruled[k] { 0.0 } else { stream(3).normal(k as u64) });
        let xi = &xi - frame.directions * frame.directions.tr_mul(&xi);
        let proposed = moved_within + (z - within) * kept + xi * b;
        for (k, value) in proposed.iter().enumerate() {
            to.z[k] = if self.ruled[k] { from.z[k] } else { *value };
            to.coordinates[k] = self.simulator.coordinate(k, to.z[k]);
        }
        log_ratio
    }

    /// Moves a few variables; a rule that the step violates keeps its variables as they were.
    fn move_block(&self, from: &Place, to: &mut Place, stream: Stream) {
        let d = from.z.len();
        let pick = |counter: u64, count: usize| ((stream.uniform(counter) * count as f64) as usize).min(count - 1);
        let (count, b) = (BLOCKS[pick(2, BLOCKS.len())], BLOCK_SIZES[pick(3, BLOCK_SIZES.len())]);
        to.z.copy_from_slice(&from.z);
        to.coordinates.clone_from(&from.coordinates);
        let members = (0..count as u64).map(|k| pick(4 + 2 * k, d));
        let mut meets_rule = false;
        for (k, member) in (0..).zip(members.clone()) {
            let xi = stream.normal(5 + 2 * k);
            // From the point before the step, so that a variable drawn twice moves once.
            to.z[member] = (1.0 - b * b).sqrt() * from.z[member] + b * xi;
            meets_rule |= self.ruled[member];
        }
        if meets_rule {
            self.simulator.restore(&mut to.z, &from.z);
        }
        for member in members {
            to.coordinates[member] = self.simulator.coordinate(member, to.z[member]);
        }
    }
}
