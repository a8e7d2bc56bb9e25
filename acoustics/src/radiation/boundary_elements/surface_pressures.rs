//! Surface pressures of a body at all frequencies of its radiation matrix. They determine the pressures at any
//! receivers.

use super::mesh_range::MeshRange;
use super::packed_pressure::PackedPressure;
use super::range_solver::RangeSolver;
use super::receivers::{ModalPressures, ReceiverPressures, Receivers, receiver_pressures};
use super::shared;
use super::solution_id::SolutionId;
use crate::bem::mesh::symmetry::Parity;
use crate::bem::solve::far_field::Radiated;
use crate::bem::solve::neumann::Patterns;
use crate::bem::solve::problem::{Exterior, SurfacePressure};
use crate::checks::same_length;
use crate::error::AcousticsError;
use crate::signals::interpolation::Grid;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// Pressures on one mesh at one frequency.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct SolvedFrequency {
    hz: f64,
    /// Pressures of each parity.
    #[serde(with = "shared")]
    parities: Arc<Vec<PackedPressure>>,
}

/// Normal velocities on a mesh for the independent modes of one parity.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Velocities {
    parity: Parity,
    #[serde(with = "crate::blocks")]
    values: DMatrix<f64>,
}

/// Velocities and pressures on one mesh.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct SolvedMesh {
    /// Velocities of each parity.
    #[serde(with = "shared")]
    velocities: Arc<Vec<Velocities>>,
    pressures: Vec<SolvedFrequency>,
}

impl SolvedMesh {
    fn new(solver: &RangeSolver<'_>) -> Self {
        let of_parity = |patterns: &Patterns| Velocities {
            parity: patterns.parity,
            values: patterns.velocities.clone(),
        };
        Self {
            velocities: Arc::new(solver.patterns().map(of_parity).collect()),
            pressures: Vec::new(),
        }
    }

    /// Adds the pressures at frequencies that are not yet included.
    fn add(&mut self, frequencies: &[f64], solver: &RangeSolver<'_>) -> Result<(), AcousticsError> {
        for &hz in frequencies {
            if self.pressures.iter().all(|known| known.hz != hz) {
                let parities = solver.pressures(hz)?;
                self.pressures.push(SolvedFrequency { hz, parities });
            }
        }
        Ok(())
    }

    /// Receiver pressures of each parity at all frequencies.
    fn at(&self, receivers: &Receivers, problem: &Exterior) -> Result<Samples, AcousticsError> {
        let of_frequency = |SolvedFrequency { hz, parities }: &SolvedFrequency| {
            let solution = |(packed, velocities): (&PackedPressure, &Velocities)| SurfacePressure {
                hz: *hz,
                parity: velocities.parity,
                pressure: packed.unpack(),
            };
            let solutions: Vec<SurfacePressure> = parities.iter().zip(&*self.velocities).map(solution).collect();
            let velocities = self.velocities.iter().map(|velocities| &velocities.values);
            let all: Vec<Radiated<'_>> = velocities.zip(&solutions).collect();
            Ok((hz.to_bits(), receiver_pressures(problem, receivers, &all)?))
        };
        // One frequency per task, because all take equally long.
        self.pressures.par_iter().with_max_len(1).map(of_frequency).collect()
    }
}

/// A range of frequencies: samples on one mesh, corrected by the difference to a finer one.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct SolvedRange {
    /// The samples of the radiation matrix.
    grid: Grid,
    /// Index of the mesh that is solved at all of them.
    predictor: usize,
    /// Index of the mesh of the range, and the samples at which it corrects the other mesh.
    correction: Option<(usize, Grid)>,
}

/// Surface pressures of a body for the motion of each of its modes, at the samples of its radiation matrix
/// ([`ModalBem::solve`](super::ModalBem::solve)). Pressures at receivers follow without another solution.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SurfacePressures {
    /// Meshes in the order of the ranges.
    meshes: Vec<SolvedMesh>,
    /// Frequency ranges, ascending.
    ranges: Vec<SolvedRange>,
    /// The solution they belong to.
    solution: SolutionId,
}

impl SurfacePressures {
    /// The solution they belong to.
    pub(crate) fn solution(&self) -> SolutionId {
        self.solution
    }

    /// Adds the next range, given the solver of the mesh that predicts it and that of the range's own mesh.
    pub(crate) fn add(
        &mut self,
        grid: &Grid,
        (predictor, own): (&RangeSolver<'_>, &RangeSolver<'_>),
        correction: Option<Grid>,
    ) -> Result<(), AcousticsError> {
        let number = self.ranges.len();
        let mesh = SolvedMesh::new(own);
        self.solution.add(grid.hz());
        mesh.velocities
            .iter()
            .for_each(|of| self.solution.add(of.values.as_slice()));
        self.meshes.push(mesh);
        let below = number.saturating_sub(1);
        self.meshes[below].add(grid.hz(), predictor)?;
        if let Some(correction) = &correction {
            self.meshes[below].add(correction.hz(), predictor)?;
            self.meshes[number].add(correction.hz(), own)?;
        }
        self.ranges.push(SolvedRange {
            grid: grid.clone(),
            predictor: below,
            correction: correction.map(|grid| (number, grid)),
        });
        Ok(())
    }

    /// The pressures at receivers, from the surface integral of
    /// [`Exterior::pressure_at`](crate::bem::Exterior::pressure_at) over the meshes `levels` of the solution. The
    /// patterns of the meshes are ignored.
    ///
    /// # Errors
    /// If the meshes differ from those of the solution, or receivers are below the floor or too close to the surface.
    pub fn at(&self, receivers: &Receivers, levels: &[MeshRange]) -> Result<ModalPressures, AcousticsError> {
        let known = (levels.last(), self.meshes.last().map(|mesh| &mesh.velocities));
        let (Some(finest), Some(velocities), false) = (known.0, known.1, receivers.points.is_empty()) else {
            return Ok(ModalPressures::none(self.solution));
        };
        same_length("meshes of the boundary", levels.len(), self.meshes.len())?;
        let meshes = self.meshes.iter().zip(levels);
        let at_samples: Vec<Samples> = meshes
            .map(|(mesh, level)| mesh.at(receivers, &level.problem))
            .collect::<Result<_, _>>()?;
        let present = velocities.iter().enumerate().filter(|(_, v)| v.values.ncols() > 0);
        let present: Vec<usize> = present.map(|(parity, _)| parity).collect();
        let mut pressures = ModalPressures::new(receivers, &finest.problem, present.len(), self.solution);
        for range in &self.ranges {
            for (place, &parity) in present.iter().enumerate() {
                let known = |mesh: usize, hz: f64| &at_samples[mesh][&hz.to_bits()][parity];
                let at = |&hz: &f64| {
                    let mut pressures = known(range.predictor, hz).clone();
                    if let Some((own, grid)) = &range.correction {
                        for (node, weight) in grid.weighted(hz) {
                            let node = grid.hz()[node];
                            pressures += (known(*own, node) - known(range.predictor, node)) * Complex::from(weight);
                        }
                    }
                    pressures
                };
                pressures.push(place, &range.grid, range.grid.hz().par_iter().map(at).collect());
            }
        }
        Ok(pressures)
    }
}

/// Receiver pressures of each parity, by frequency.
type Samples = HashMap<u64, Vec<ReceiverPressures>>;
