//! The result of a transient run.

use std::ops::Range;

use nailnoise_quantities::Check;
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;

use super::added::AddedMotion;
use super::energy::EnergyHistory;
use super::error::TransientError;
use super::model::{ModalBody, ModalState, Motion};
use super::recurrence::Recurrence;
use super::system::effective_zeta;

/// Reason why the run ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The energy had decreased by the requested decay.
    Decayed {
        /// Energy level at the end, relative to its maximum \[dB\].
        level: f64,
        /// Whether the energy is the excess over the final equilibrium; otherwise there is no equilibrium and it is the
        /// kinetic energy.
        over_equilibrium: bool,
    },
    /// The maximum duration was reached.
    Duration {
        /// Energy level at the end, relative to its maximum \[dB\].
        level: f64,
        /// Same as in `Decayed`.
        over_equilibrium: bool,
    },
}

/// Work counters of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Number of recurrence steps.
    pub steps: usize,
    /// Number of steps with at least one support in contact at the end.
    pub contact_steps: usize,
    /// Number of iterations for the set of touching supports, over all steps.
    pub contact_iterations: usize,
    /// Number of supports that made or lost contact: pivots of the contact matrix.
    pub contact_changes: usize,
    /// Number of contact matrices rebuilt from scratch.
    pub factorisations: usize,
    /// Number of Newton iterations for the static start and the final equilibrium.
    pub static_iterations: usize,
    /// Number of modes with omega h >= pi, which the step cannot resolve; they respond with their static compliance,
    /// critically damped.
    pub modes_beyond_step: usize,
}

/// Response of one or two bodies.
///
/// Between samples the forces are linear and each mode follows them exactly, so the forces on the grid determine
/// everything else. Only they are stored (39 MB for 65 supports and 0.3 s at 4 us, instead of 780 MB of modal
/// histories). The motion of any mode is computed on demand by the same recurrence.
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
    /// Fraction of samples at which no unilateral support touches \[1\]; 0 without such supports.
    pub open_fraction: f64,
    /// Fraction of the static load at t = 0 (and of the final one) omitted because no support can carry it \[1\]; at
    /// most 1e-6.
    pub unsupported_load: f64,
    /// Reason why the run ended.
    pub ending: Ending,
    /// Checks of this run.
    pub checks: Vec<Check>,
    /// Work counters.
    pub work: Work,
    pub(super) bodies: Vec<ModalBody>,
    /// State at every [`MARK`]th sample, one per body; [`Self::at`] starts from these.
    pub(super) marks: Vec<Vec<ModalState>>,
    /// Motion added to that of the time integration by all methods; forces, states and energies exclude it.
    pub(super) added: Option<AddedMotion>,
}

/// Number of samples between stored states, which need a thousandth of the memory of all.
pub(super) const MARK: usize = 128;

impl ModalResponse {
    /// Number of samples, including the one at t = 0.
    pub fn samples(&self) -> usize {
        self.loads.ncols()
    }

    /// Time of the last sample \[s\].
    pub fn duration(&self) -> f64 {
        self.step * (self.samples() - 1) as f64
    }

    /// The bodies.
    pub fn bodies(&self) -> &[ModalBody] {
        &self.bodies
    }

    /// Damping ratios of a body's modes used in the time integration: at least critical for modes that its step cannot
    /// resolve.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the body does not exist.
    pub fn damping_ratios(&self, body: usize) -> Result<Vec<f64>, TransientError> {
        let body = self.body(body)?;
        let pairs = body.omega.iter().zip(&body.zeta);
        Ok(pairs
            .map(|(&omega, &zeta)| effective_zeta(omega, zeta, self.step))
            .collect())
    }

    /// The same response with additional motion; the forces do not change.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the number of bodies or modes differs.
    pub fn with_added(&self, added: AddedMotion) -> Result<Self, TransientError> {
        for (index, body) in self.bodies.iter().enumerate() {
            let found = added.modes(index);
            if found != body.modes() {
                return Err(TransientError::Size {
                    what: format!("modes of the motion added to `{}`", body.name),
                    expected: body.modes(),
                    found,
                });
            }
        }
        Ok(Self {
            added: Some(added),
            ..self.clone()
        })
    }

    /// Number of modes of a body.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the body does not exist.
    pub fn modes(&self, body: usize) -> Result<usize, TransientError> {
        Ok(self.body(body)?.modes())
    }

    /// Motion of a range of one body's modes: samples x modes, so that the history of one mode is contiguous.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the body or a mode does not exist.
    pub fn modal(&self, body: usize, modes: Range<usize>, motion: Motion) -> Result<DMatrix<f64>, TransientError> {
        let chosen = self.body(body)?;
        if modes.end > chosen.modes() || modes.start > modes.end {
            let what = format!("modes of `{}`", chosen.name);
            return Err(TransientError::Size {
                what,
                expected: chosen.modes(),
                found: modes.end,
            });
        }
        let samples = self.samples();
        let mut history = DMatrix::zeros(samples, modes.len());
        history
            .as_mut_slice()
            .par_chunks_mut(BLOCK * samples)
            .enumerate()
            .for_each(|(block, out)| {
                let first = modes.start + block * BLOCK;
                let range = first..modes.end.min(first + BLOCK);
                Replay::new(self, body, range).each(motion, |first, piece| {
                    for (own, column) in out.chunks_mut(samples).zip(piece.column_iter()) {
                        own[first..first + column.len()].copy_from_slice(column.as_slice());
                    }
                });
                if let Some(added) = &self.added {
                    let added = added.records(body, first..first + out.len() / samples, samples, motion);
                    out.iter_mut().zip(added.as_slice()).for_each(|(x, d)| *x += d);
                }
            });
        Ok(history)
    }

    /// Motion of points of one body, given the mode shapes at the points (modes x points): samples x points.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the body does not exist or the shapes have a different number of modes.
    pub fn points(&self, body: usize, shapes: &DMatrix<f64>, motion: Motion) -> Result<DMatrix<f64>, TransientError> {
        let chosen = self.body(body)?;
        if shapes.nrows() != chosen.modes() {
            let what = format!("rows of the shapes at points of `{}`", chosen.name);
            return Err(TransientError::Size {
                what,
                expected: chosen.modes(),
                found: shapes.nrows(),
            });
        }
        let modes = chosen.modes();
        let moves = |range: &Range<usize>| shapes.rows(range.start, range.len()).iter().any(|x| *x != 0.0);
        let blocks: Vec<Range<usize>> = (0..modes)
            .step_by(BLOCK)
            .map(|first| first..modes.min(first + BLOCK))
            .filter(moves)
            .collect();
        let of_group = |group: &[Range<usize>]| {
            let mut sum = DMatrix::zeros(self.samples(), shapes.ncols());
            for range in group {
                let rows = shapes.rows(range.start, range.len());
                Replay::new(self, body, range.clone()).each(motion, |first, piece| {
                    sum.rows_mut(first, piece.nrows()).gemm(1.0, piece, &rows, 1.0);
                });
            }
            sum
        };
        // Groups determine the order of summation, independently of the number of threads.
        let sums: Vec<DMatrix<f64>> = blocks.par_chunks(GROUP).map(of_group).collect();
        let mut points = DMatrix::zeros(self.samples(), shapes.ncols());
        sums.into_iter().for_each(|sum| points += sum);
        if let Some(added) = &self.added {
            points += added.of_points(body, shapes, self.samples(), motion);
        }
        Ok(points)
    }

    /// Motion of all modes of one body at some samples: modes x samples.
    ///
    /// # Errors
    /// [`TransientError::Size`] if the body or a sample does not exist.
    pub fn at(&self, body: usize, samples: &[usize], motion: Motion) -> Result<DMatrix<f64>, TransientError> {
        let modes = self.body(body)?.modes();
        if let Some(&found) = samples.iter().find(|&&sample| sample >= self.samples()) {
            return Err(TransientError::Size {
                what: "a sample of a response (samples exist up to)".to_owned(),
                expected: self.samples() - 1,
                found,
            });
        }
        let of_sample = |&sample: &usize| {
            let mark = sample / MARK;
            let mut found = Vec::new();
            let replay = Replay::from(self, body, 0..modes, &self.marks[mark][body]);
            replay.over(mark * MARK..sample + 1, motion, |_, piece| {
                found = piece.row(piece.nrows() - 1).iter().copied().collect();
            });
            if let Some(added) = &self.added {
                let added = added.at(body, sample, motion);
                found.iter_mut().zip(added).for_each(|(x, d)| *x += d);
            }
            found
        };
        let columns: Vec<Vec<f64>> = samples.par_iter().map(of_sample).collect();
        Ok(DMatrix::from_iterator(
            modes,
            samples.len(),
            columns.into_iter().flatten(),
        ))
    }

    fn body(&self, body: usize) -> Result<&ModalBody, TransientError> {
        let what = || "index of the body (bodies exist up to)".to_owned();
        let missing = || TransientError::Size {
            what: what(),
            expected: self.bodies.len() - 1,
            found: body,
        };
        self.bodies.get(body).ok_or_else(missing)
    }
}

/// Number of modes replayed together.
const BLOCK: usize = 32;

/// Number of blocks whose motion one thread sums.
const GROUP: usize = 4;

/// Number of samples whose modal forces are computed at once.
const CHUNK: usize = 512;

/// Reruns the recurrence for some modes from the stored forces.
struct Replay<'a> {
    response: &'a ModalResponse,
    body: &'a ModalBody,
    modes: Range<usize>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl<'a> Replay<'a> {
    fn new(response: &'a ModalResponse, body: usize, modes: Range<usize>) -> Self {
        Self::from(response, body, modes, &response.start[body])
    }

    /// Starts from a state of the body.
    fn from(response: &'a ModalResponse, body: usize, modes: Range<usize>, state: &ModalState) -> Self {
        let q = state.displacement[modes.clone()].to_vec();
        let v = state.velocity[modes.clone()].to_vec();
        Self {
            response,
            body: &response.bodies[body],
            modes,
            q,
            v,
        }
    }

    /// Modal forces of `count` samples starting at `first`, modes x samples.
    fn forces(&self, first: usize, count: usize) -> DMatrix<f64> {
        let rows = |matrix: &DMatrix<f64>| matrix.rows(self.modes.start, self.modes.len()).into_owned();
        let mut g = DMatrix::zeros(self.modes.len(), count);
        g.gemm(
            1.0,
            &rows(&self.body.loads),
            &self.response.loads.columns(first, count),
            0.0,
        );
        let contact = self.response.contact_forces.columns(first, count);
        // Contacts that have separated remain open for a while.
        if contact.iter().any(|force| *force != 0.0) {
            g.gemm(-1.0, &rows(&self.body.supports), &contact, 1.0);
        }
        g
    }

    /// Computes the motion piece by piece; `take` receives the first sample of a piece and its motion (samples x
    /// modes).
    fn each(self, motion: Motion, take: impl FnMut(usize, &DMatrix<f64>)) {
        let samples = self.response.samples();
        self.over(0..samples, motion, take);
    }

    /// Same as `each` for a range of samples; the modes start in the given state at its first sample.
    fn over(mut self, samples: Range<usize>, motion: Motion, mut take: impl FnMut(usize, &DMatrix<f64>)) {
        let h = self.response.step;
        let count = self.modes.len();
        let omega = self.body.omega[self.modes.clone()].to_vec();
        let given = self.body.zeta[self.modes.clone()].iter();
        let zeta: Vec<f64> = omega
            .iter()
            .zip(given)
            .map(|(&w, &z)| effective_zeta(w, z, h))
            .collect();
        let steps: Vec<Recurrence> = omega
            .iter()
            .zip(&zeta)
            .map(|(&w, &z)| Recurrence::new(w, z, h))
            .collect();
        let mut before = vec![0.0; count];
        let mut piece = DMatrix::zeros(CHUNK.min(samples.len()), count);
        for first in samples.clone().step_by(CHUNK) {
            let length = CHUNK.min(samples.end - first);
            if length < piece.nrows() {
                piece = DMatrix::zeros(length, count);
            }
            let forces = self.forces(first, length);
            for (j, mut history) in piece.column_iter_mut().enumerate() {
                let r = steps[j];
                let (mut q, mut v, mut g0) = (self.q[j], self.v[j], before[j]);
                let (damping, stiffness) = (2.0 * zeta[j] * omega[j], omega[j] * omega[j]);
                for (n, sample) in history.iter_mut().enumerate() {
                    let g1 = forces[(j, n)];
                    if first + n > samples.start {
                        (q, v) = (
                            (r.a11 * q + r.a12 * v) + (r.b1 * g0 + r.c1 * g1),
                            (r.a21 * q + r.a22 * v) + (r.b2 * g0 + r.c2 * g1),
                        );
                    }
                    *sample = match motion {
                        Motion::Displacement => q,
                        Motion::Velocity => v,
                        Motion::Acceleration => g1 - damping * v - stiffness * q,
                    };
                    g0 = g1;
                }
                (self.q[j], self.v[j], before[j]) = (q, v, g0);
            }
            take(first, &piece);
        }
    }
}
