//! Energy bookkeeping of a run.

use serde::Serialize;

/// Energies on a coarse uniform grid, all in J; the first entry is t = 0.
///
///   work of loads = change of (kinetic + strain) + dissipated in the modes + change of contact_elastic + contact_lost
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EnergyHistory {
    /// Times \[s\].
    pub time: Vec<f64>,
    /// Kinetic energy sum q'^2/2 of each body.
    pub kinetic: Vec<Vec<f64>>,
    /// Strain energy sum omega^2 q^2/2 of each body.
    pub strain: Vec<Vec<f64>>,
    /// Energy dissipated by each body's modal damping since t = 0.
    pub dissipated: Vec<Vec<f64>>,
    /// Energy stored in the support springs.
    pub contact_elastic: Vec<f64>,
    /// Energy lost in the supports since t = 0: dashpots, and springs that relax after letting go.
    pub contact_lost: Vec<f64>,
    /// Work of all applied loads since t = 0.
    pub work: Vec<f64>,
}
