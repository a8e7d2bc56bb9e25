use super::high_frequencies::composite::CompositeRadiation;
use super::solution_id::SolutionId;
use crate::bem::solve::far_field::Radiated;
use crate::bem::solve::problem::Exterior;
use crate::checks::ReceiverError;
use crate::error::AcousticsError;
use crate::signals::interpolation::Grid;
use nalgebra::{Complex, DMatrix, Point3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Points around a body at which the sound pressure is computed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Receivers {
    /// Positions \[m\].
    pub points: Vec<Point3<f64>>,
    /// Acoustic centre \[m\]: travel times from here and from its image in the floor are removed before pressures are
    /// interpolated over frequency.
    pub origin: Point3<f64>,
}

impl Receivers {
    /// Checks that the pressure at the points can be computed.
    ///
    /// # Errors
    /// If points are below the floor or too close to the surface, as in [`Exterior::pressure_at`].
    pub fn check(&self, problem: &Exterior) -> Result<(), ReceiverError> {
        problem.check_points(&self.points)
    }

    /// Distances from the origin, and from its image in the floor \[m\].
    fn distances(&self, floor: Option<f64>) -> [Vec<f64>; 2] {
        let image = |z: f64| Point3::new(self.origin.x, self.origin.y, 2.0 * z - self.origin.z);
        let origins = [self.origin, floor.map_or(self.origin, image)];
        origins.map(|from| self.points.iter().map(|p| (p - from).norm()).collect())
    }
}

/// Pressure at receivers per unit acceleration of each pattern, with travel times removed: receivers x patterns, with
/// direct sound in the first rows and floor reflection in the rows below.
pub(crate) type ReceiverPressures = DMatrix<Complex<f64>>;

/// The pressure at receivers with travel times removed, for each parity at one frequency.
pub(crate) fn receiver_pressures(
    problem: &Exterior,
    receivers: &Receivers,
    all: &[Radiated<'_>],
) -> Result<Vec<ReceiverPressures>, AcousticsError> {
    let (count, omega) = (
        receivers.points.len(),
        2.0 * PI * all.first().map_or(0.0, |(_, solution)| solution.hz),
    );
    let k = omega / problem.air().sound_speed;
    let distances = receivers.distances(problem.boundary().floor());
    let of_parity = |parts: [DMatrix<Complex<f64>>; 2]| {
        let mut pressures = ReceiverPressures::zeros(2 * count, parts[0].ncols());
        for (half, (part, distances)) in parts.iter().zip(&distances).enumerate() {
            for (i, r) in distances.iter().enumerate() {
                let turn = Complex::from_polar(1.0, k * r) / Complex::new(0.0, omega);
                pressures.row_mut(half * count + i).copy_from(&(part.row(i) * turn));
            }
        }
        pressures
    };
    let parities = problem.pressures_at(&receivers.points, all)?;
    Ok(parities.into_iter().map(of_parity).collect())
}

/// Receiver pressures of one parity at the samples of its radiation matrix, by range.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct ParityPressures(#[serde(with = "crate::blocks")] pub(crate) Vec<Vec<ReceiverPressures>>);

/// Receiver pressures of a body's modes, per unit of each mode's motion.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ModalPressures {
    receivers: usize,
    sound_speed: f64,
    distances: [Vec<f64>; 2],
    parities: Vec<ParityPressures>,
    error: f64,
    solution: SolutionId,
}

impl ModalPressures {
    /// No receivers.
    pub(crate) fn none(solution: SolutionId) -> Self {
        Self {
            solution,
            ..Self::default()
        }
    }

    /// Creates an empty set, without any range; `parities` is the number of parities.
    pub(crate) fn new(receivers: &Receivers, problem: &Exterior, parities: usize, solution: SolutionId) -> Self {
        Self {
            receivers: receivers.points.len(),
            sound_speed: problem.air().sound_speed,
            distances: receivers.distances(problem.boundary().floor()),
            parities: vec![ParityPressures::default(); parities],
            error: 0.0,
            solution,
        }
    }

    /// The solution they belong to.
    pub(crate) fn solution(&self) -> SolutionId {
        self.solution
    }

    /// Adds the next range of a parity, with the samples of its radiation matrix.
    pub(crate) fn push(&mut self, parity: usize, grid: &Grid, samples: Vec<ReceiverPressures>) {
        self.error = self.error.max(grid.error_of_fields(&samples));
        self.parities[parity].0.push(samples);
    }

    /// Estimated interpolation error over frequency, relative to the loudest mode at the receivers.
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// Pressure of one parity, receivers x bins \[Pa s\], for accelerations \[m/s\]; zero above the range of single
    /// frequencies.
    pub(crate) fn pressures(
        &self,
        parity: usize,
        radiation: &CompositeRadiation,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let mut pressures = DMatrix::zeros(self.receivers, frequency.len());
        if self.receivers == 0 {
            return pressures;
        }
        for (level, start, end) in radiation.runs(frequency) {
            let (range, samples) = (&radiation.levels()[level], &self.parities[parity].0[level]);
            let motion = accelerations.columns(start, end - start).into_owned();
            let found = range.interpolated(&frequency[start..end], samples, &motion);
            for (bin, p) in (start..end).zip(found.column_iter()) {
                let k = 2.0 * PI * frequency[bin] / self.sound_speed;
                for i in 0..self.receivers {
                    let turned = |half: usize| {
                        p[half * self.receivers + i] * Complex::from_polar(1.0, -k * self.distances[half][i])
                    };
                    pressures[(i, bin)] = turned(0) + turned(1);
                }
            }
        }
        pressures
    }

    pub(crate) fn receivers(&self) -> usize {
        self.receivers
    }
}
