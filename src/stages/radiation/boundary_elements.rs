//! Boundary elements of a body on several meshes: what is solved, what it costs, and the radiation matrix.

use nailnoise_acoustics::bem::{EquationSolver, MeshRange, ModalBem, Receivers};
use nailnoise_acoustics::radiation::Sampling;
use nalgebra::Point3;
use serde::Serialize;

use crate::error::Error;
use crate::stages::Progress;

/// Lowest frequency at which a radiation resistance is sampled \[Hz\]; below it each entry follows its own power law.
pub(super) const LOWEST_SAMPLE: f64 = 40.0;

/// A mode that radiates less than this share of the best radiator is interpolated as accurately as that share requires.
const FLOOR: f64 = 1e-2;

/// Most frequencies of one range. A narrow resonance, such as those of the air between a table and the floor, takes about
/// fifty.
const MOST_SAMPLES: usize = 400;

/// How finely boundary elements resolve space and frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Highest frequency of boundary elements in standard air \[Hz\].
    pub top_hz: f64,
    /// Panels per wavelength.
    pub panels: f64,
    /// How the equations are stored and solved.
    #[serde(skip_serializing_if = "EquationSolver::is_auto")]
    pub equations: EquationSolver,
    /// Tolerance of the interpolation over frequency, relative to sqrt(R_ii R_jj).
    pub tolerance: f64,
}

/// The places at which the pressure of every mode is wanted, in the coordinates of the body \[m\].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Places {
    /// The microphones, and behind them their images in the reflecting plane if that is not part of the equations.
    pub points: Vec<[f64; 3]>,
    /// The middle of the body.
    pub origin: [f64; 3],
}

impl Places {
    /// Microphones, with their images in a plane at a height if the plane is not part of the equations.
    pub fn new(microphones: impl Iterator<Item = Point3<f64>>, image_in: Option<f64>, middle: f64) -> Self {
        let mut points: Vec<[f64; 3]> = microphones.map(Into::into).collect();
        if let Some(plane) = image_in {
            points.extend_from_within(..);
            let images = points.len() / 2;
            points[images..].iter_mut().for_each(|[_, _, z]| *z = 2.0 * plane - *z);
        }
        Self {
            points,
            origin: [0.0, 0.0, middle],
        }
    }

    fn receivers(&self) -> Receivers {
        Receivers {
            points: self.points.iter().map(|&point| point.into()).collect(),
            origin: self.origin.into(),
        }
    }
}

/// The meshes of a body, and about how often each of them is solved.
pub(super) struct MeshRanges {
    pub(super) levels: Vec<MeshRange>,
    /// Number of frequencies that are solved on each mesh, about.
    pub(super) solves: Vec<f64>,
    /// Lowest frequency that is solved \[Hz\].
    pub(super) lowest_hz: f64,
}

impl MeshRanges {
    /// The finest mesh.
    pub(super) fn finest(&self) -> Option<&MeshRange> {
        self.levels.last()
    }

    /// Processor time \[s\], about. Operators are stored for all frequencies if there are more than `few` of them.
    fn seconds(&self, few: f64) -> f64 {
        let of_mesh = |(level, solves): (&MeshRange, &f64)| {
            let estimate = level.problem.estimate();
            let modes = level.patterns.first().map_or(0, |patterns| patterns.velocities.ncols());
            // Most modes of a symmetric body have one parity.
            let patterns = modes.div_ceil(level.problem.boundary().copies());
            let stored = if self.levels.len() == 1 || *solves > few {
                estimate.seconds_shared
            } else {
                0.0
            };
            stored + solves * estimate.seconds_with(patterns)
        };
        self.levels.iter().zip(&self.solves).map(of_mesh).sum()
    }

    /// Notes what will be computed before any time is spent.
    pub(super) fn note(&self, body: &str, few: f64, progress: &Progress) {
        let Some(finest) = self.finest() else { return };
        progress.note(&format!(
            "{body}: boundary elements up to {:.0} Hz, computed once for these bodies, about {:.0} s of processor time in \
             all; finest mesh: {}",
            finest.top_hz,
            self.seconds(few),
            finest.problem.estimate()
        ));
    }

    /// Solves the meshes and interpolates over frequency.
    ///
    /// # Errors
    /// Those of the boundary elements.
    pub(super) fn solve(
        self,
        task: &'static str,
        resolution: &Resolution,
        places: &Places,
        progress: &Progress,
    ) -> Result<ModalBem, Error> {
        let top_hz = self.levels.iter().map(|level| level.top_hz).fold(0.0, f64::max);
        let sampling = Sampling {
            range_hz: [self.lowest_hz, top_hz],
            tolerance: resolution.tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let expected = self.solves.iter().sum::<f64>() as u64;
        Ok(progress.count_each((task, "frequencies"), expected, |solved| {
            ModalBem::new(self.levels, &sampling, &places.receivers(), solved)
        })?)
    }
}
