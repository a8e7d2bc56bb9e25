//! Samples the posterior of the inputs by sequential Monte Carlo with tempering (Del Moral, Doucet and Jasra,
//! "Sequential Monte Carlo samplers", Journal of the Royal Statistical Society B 68, 411 (2006)).
//!
//! N particles start as draws from the prior and pass through the densities p(z) exp(tau l(z)) while tau increases from
//! 0 to 1. Each step raises tau until the effective sample size is N/2, resamples, and moves the particles until they
//! have decorrelated. In the r directions V informed by the readings, with y = V^T z, a move proposes
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
//! Without this split, the evidence is biased low and directions without data become too narrow.
//!
//! All random numbers are functions of seed, step, move and particle, so results depend neither on threads nor on
//! interruptions between moves.

mod diagnostics;
mod moves;
mod state;
mod steps;
mod target;

pub use diagnostics::{Diagnostics, NotConverged};
pub use moves::{Proposal, Simulated};
pub use state::{Candidate, Particle, Settings, State, Step};
pub use target::Sampler;
