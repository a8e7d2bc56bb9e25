use crate::bem::solve::neumann::Patterns;
use crate::bem::solve::problem::Exterior;

/// A mesh of the body, and the highest frequency at which it is used.
#[derive(Debug)]
pub struct MeshRange {
    /// The exterior problem.
    pub problem: Exterior,
    /// Highest frequency \[Hz\].
    pub top_hz: f64,
    /// Normal velocities of all modes by parity; every level has the same parities in the same order.
    pub patterns: Vec<Patterns>,
}

impl MeshRange {
    /// Number of motions.
    pub fn motions(&self) -> usize {
        self.patterns.first().map_or(0, |patterns| patterns.velocities.ncols())
    }

    /// Highest frequency resolved by its mesh \[Hz\].
    pub fn resolved_hz(&self) -> f64 {
        let problem = &self.problem;
        problem
            .boundary()
            .highest_hz(problem.air().sound_speed, problem.panels_per_wavelength())
    }
}
