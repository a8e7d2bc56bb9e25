//! Settings of a calibration.

use super::redraw::Redrawn;

/// Treatment of readings that contradict each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Treatment {
    /// They are excluded from the posterior.
    LeaveOut,
    /// Their errors are widened until they agree.
    Widen,
}

/// Settings of a calibration.
#[derive(Debug, Clone)]
pub struct Request {
    /// Number of draws from the posterior; even.
    pub draws: usize,
    /// Largest number of moves per step of the sampler.
    pub moves: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Names of measurements that are only predicted.
    pub hold_out: Vec<String>,
    /// Treatment of conflicts.
    pub treatment: Treatment,
    /// Whether to find what to measure next.
    pub next: bool,
    /// Number of draws whose levels are computed, for measured levels and for what to measure next.
    pub levels: usize,
    /// Classes of inputs that the calibrated design draws anew.
    pub redraw: Vec<Redrawn>,
}
