//! Boundary elements of a body on several meshes: the problem, its cost, and the radiation matrix.

use nailnoise_acoustics::bem::{Boundary, EquationSolver, Exterior, Gap, Gaps, Patterns};
use nailnoise_acoustics::radiation::Sampling;
use nailnoise_acoustics::radiation::boundary_elements::{
    MeanBands, MeanRanges, MeshRange, ModalBem, Receivers, SurfacePressures,
};
use nailnoise_acoustics::{AcousticsError, Air};
use nalgebra::Point3;
use serde::Serialize;

use super::error::SurfaceError;
use crate::error::Error;
use crate::stages::Progress;

/// Lowest frequency at which a radiation resistance is sampled \[Hz\]; below it each entry follows its own power law.
pub(super) const LOWEST_SAMPLE: f64 = 40.0;

/// Modes that radiate less than this fraction of the best radiator are interpolated only as accurately as a mode at
/// this fraction.
const FLOOR: f64 = 1e-2;

/// Maximum number of frequencies in one range. A narrow resonance, such as that of the air between a table and the
/// floor, takes about fifty.
const MOST_SAMPLES: usize = 400;

/// Maximum number of panels of a user's mesh refined at the rims of thin gaps; above it, panels at the rims are wider.
/// A compressed matrix of this size takes about a minute per frequency.
pub(super) const MOST_AT_GAPS: usize = 20_000;

/// Resolution of boundary elements in space and frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Highest frequency of boundary elements solved at single frequencies, in standard air \[Hz\].
    pub top_hz: f64,
    /// Upper end of boundary elements for means over frequency, in standard air \[Hz\]; by default half an octave above
    /// single frequencies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_top_hz: Option<f64>,
    /// Panels per wavelength.
    pub panels: f64,
    /// Solver of the equations.
    #[serde(skip_serializing_if = "EquationSolver::is_auto")]
    pub equations: EquationSolver,
    /// Tolerance of the interpolation over frequency, relative to sqrt(R_ii R_jj).
    pub tolerance: f64,
}

impl Resolution {
    /// A moving surface, meshed with this resolution up to a frequency \[Hz\].
    pub(super) fn range(
        &self,
        boundary: Boundary,
        patterns: Vec<Patterns>,
        top_hz: f64,
        air: &Air,
    ) -> Result<MeshRange, AcousticsError> {
        let problem = Exterior::new(boundary, air)
            .with_panels_per_wavelength(self.panels)?
            .with_equation_solver(self.equations);
        Ok(MeshRange {
            problem,
            top_hz,
            patterns,
        })
    }

    /// Bands of the means above the highest single frequency of a body \[Hz\].
    pub(super) fn mean_bands(&self, top_hz: f64) -> MeanBands {
        MeanBands::new(top_hz, self.mean_top_hz)
    }

    /// Highest frequency for which the user requests boundary elements \[Hz\].
    pub(super) fn highest_hz(&self) -> f64 {
        self.mean_top_hz
            .map_or(self.top_hz, |mean_top| mean_top.max(self.top_hz))
    }

    /// Finer meshes for the means above the highest single frequency of a body \[Hz\]; `mesh` makes each of them for a
    /// frequency.
    pub(super) fn mean_ranges<E>(
        &self,
        top_hz: f64,
        mesh: impl FnMut(f64) -> Result<MeshRange, E>,
    ) -> Result<MeanRanges, E> {
        let tops = self.mean_bands(top_hz).finer_meshes().into_iter().map(|(top, _)| top);
        Ok(MeanRanges {
            to_hz: self.mean_top_hz,
            finer: tops.map(mesh).collect::<Result<_, E>>()?,
        })
    }
}

/// The positions at which the pressure of every mode is computed, in the coordinates of the body \[m\].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Places {
    /// The microphones, followed by their images in the reflecting plane if the plane is not included in the equations.
    pub points: Vec<[f64; 3]>,
    /// The centre of the body.
    pub origin: [f64; 3],
}

impl Places {
    /// Microphones, with their images in a plane at this height if the plane is not included in the equations.
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

    /// Checks that they keep the required distance from the surfaces of meshes.
    ///
    /// # Errors
    /// [`SurfaceError::MicrophoneNearSurface`].
    pub(super) fn check(&self, meshes: &[MeshRange]) -> Result<(), Error> {
        let receivers = self.receivers();
        let checked = meshes.iter().try_for_each(|mesh| receivers.check(&mesh.problem));
        checked.map_err(|cause| SurfaceError::MicrophoneNearSurface { cause }.into())
    }

    pub(super) fn receivers(&self) -> Receivers {
        Receivers {
            points: self.points.iter().map(|&point| point.into()).collect(),
            origin: self.origin.into(),
        }
    }
}

/// Results of boundary elements for a surface.
pub struct Solution {
    /// Its radiation matrix.
    pub matrix: ModalBem,
    /// The pressures on it.
    pub surface: SurfacePressures,
}

/// The meshes of a body, and the approximate number of solutions on each.
pub(super) struct MeshRanges {
    pub(super) levels: Vec<MeshRange>,
    /// Approximate number of frequencies that are solved on each mesh.
    pub(super) solves: Vec<f64>,
    /// Means above single frequencies, and their meshes.
    pub(super) means: MeanRanges,
    /// Lowest frequency that is solved \[Hz\].
    pub(super) lowest_hz: f64,
}

impl MeshRanges {
    /// The finest mesh.
    pub(super) fn finest(&self) -> Option<&MeshRange> {
        self.levels.last()
    }

    /// Number of frequencies of each finer mesh of the means.
    fn mean_solves(&self) -> Vec<f64> {
        let Some(finest) = self.finest() else { return Vec::new() };
        let meshes = MeanBands::new(finest.top_hz, self.means.to_hz)
            .finer_meshes()
            .into_iter();
        meshes.map(|(_, bands)| MeanBands::samples(bands) as f64).collect()
    }

    /// Every mesh with the number of its frequencies, and whether operators are stored for all of them, which is done
    /// only for more than `few`.
    fn all(&self, few: f64) -> impl Iterator<Item = (&MeshRange, f64, bool)> {
        let alone = self.levels.len() == 1;
        let single = self.levels.iter().zip(&self.solves);
        let single = single.map(move |(level, solves)| (level, *solves, alone || *solves > few));
        let means = self.means.finer.iter().zip(self.mean_solves());
        single.chain(means.map(|(mesh, solves)| (mesh, solves, false)))
    }

    /// Approximate processor time \[s\].
    fn seconds(&self, few: f64) -> f64 {
        let of_mesh = |(mesh, solves, stored): (&MeshRange, f64, bool)| {
            let estimate = mesh.problem.estimate();
            let shared = if stored { estimate.seconds_shared } else { 0.0 };
            shared + solves * estimate.seconds_with(patterns(mesh))
        };
        self.all(few).map(of_mesh).sum()
    }

    /// Approximate peak memory \[GB\]: one frequency per thread on the most expensive mesh, plus the stored integrals
    /// and the velocities of all modes on all meshes.
    fn gigabytes(&self, few: f64) -> f64 {
        let threads = rayon::current_num_threads() as f64;
        let of_mesh =
            |(mesh, ..): (&MeshRange, f64, bool)| threads * mesh.problem.estimate().bytes_with(patterns(mesh));
        let stored = self.all(few).filter(|(.., stored)| *stored);
        let shared: f64 = stored.map(|(mesh, ..)| mesh.problem.estimate().bytes_shared).sum();
        let velocities = |(mesh, ..): (&MeshRange, f64, bool)| {
            let values = |patterns: &Patterns| 8.0 * patterns.velocities.len() as f64;
            mesh.patterns.iter().map(values).sum::<f64>()
        };
        // Pressures on the surface are stored in single precision.
        let pressures = |(mesh, solves): (&MeshRange, &f64)| {
            let modes = mesh.motions();
            4.0 * solves * mesh.problem.estimate().unknowns as f64 * modes as f64
        };
        let kept = self.levels.iter().zip(&self.solves).map(pressures).sum::<f64>();
        // Two adjacent meshes store equations at the same time; the last of several stores none.
        let sampled = self.levels.iter().take(self.levels.len().max(2) - 1);
        let equations = sampled.map(|mesh| mesh.problem.bytes_of_kept_equations(patterns(mesh)));
        let (both, _) = equations.fold((0.0, 0.0), |(most, last): (f64, f64), own| (most.max(last + own), own));
        let kept = kept + both + shared;
        1e-9 * (self.all(few).map(of_mesh).fold(0.0, f64::max) + self.all(few).map(velocities).sum::<f64>() + kept)
    }

    /// The thin gap with the largest error on any of the meshes.
    fn worst_gap(&self) -> Option<Gap> {
        let meshes = self.levels.iter().chain(&self.means.finer);
        let gaps = meshes.filter_map(|mesh| Gaps::of(mesh.problem.boundary()).worst());
        gaps.max_by(|a, b| a.mass_error().total_cmp(&b.mass_error()))
    }

    /// Announces the computation before it starts.
    pub(super) fn note(&self, body: &str, few: f64, progress: &Progress) {
        let Some(finest) = self.finest() else { return };
        let bands = MeanBands::new(finest.top_hz, self.means.to_hz);
        let mean = match self.means.finer.last() {
            Some(mesh) => {
                let (estimate, patterns) = (mesh.problem.estimate(), patterns(mesh));
                format!(
                    "; finest of {} meshes of the mean: {} panels, {} unknowns{}, about {:.1} s and {:.0} MB a \
                     frequency with {patterns} modes",
                    self.means.finer.len(),
                    estimate.panels,
                    estimate.unknowns,
                    if estimate.compressed {
                        " (compressed matrix)"
                    } else {
                        ""
                    },
                    estimate.seconds_with(patterns),
                    1e-6 * estimate.bytes_with(patterns),
                )
            }
            None => String::new(),
        };
        progress.note(&format!(
            "{body}: boundary elements up to {:.0} Hz and in the mean up to {:.0} Hz, computed once for these bodies, \
             about \
             {:.0} s of processor time and {:.1} GB in all; finest mesh: {}{mean}",
            finest.top_hz,
            bands.upper_hz(),
            self.seconds(few),
            self.gigabytes(few),
            finest.problem.estimate()
        ));
        if let Some(gap) = self.worst_gap() {
            progress.note(&format!("{body}: {}", describe_gap(&gap)));
        }
    }

    /// Solves the meshes and interpolates over frequency.
    ///
    /// # Errors
    /// The errors of the boundary elements.
    pub(super) fn solve(
        self,
        task: &'static str,
        resolution: &Resolution,
        progress: &Progress,
    ) -> Result<Solution, Error> {
        let top_hz = self.levels.iter().map(|level| level.top_hz).fold(0.0, f64::max);
        let sampling = Sampling {
            range_hz: [self.lowest_hz, top_hz],
            tolerance: resolution.tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let expected = self.solves.iter().chain(&self.mean_solves()).sum::<f64>() as u64;
        let (matrix, surface) = progress.count_each((task, "frequencies"), expected, |solved| {
            ModalBem::solve(self.levels, self.means, &sampling, solved)
        })?;
        Ok(Solution { matrix, surface })
    }
}

/// Text for a thin gap and the error of its panels.
pub(crate) fn describe_gap(gap: &Gap) -> String {
    format!(
        "a gap {:.1} mm high, panels at its rim up to {:.1} mm wide ({:.2} of its height): error at most {:.1} % in \
         the mass of its air and {:.2} dB in its power in third octaves; friction of the air is not modelled",
        1e3 * gap.height,
        1e3 * gap.panel_width,
        gap.panel_width / gap.height,
        100.0 * gap.mass_error(),
        gap.band_error_db()
    )
}

/// Approximate number of velocity patterns that are solved together: most modes of a symmetric body have one parity.
fn patterns(mesh: &MeshRange) -> usize {
    let modes = mesh.motions();
    modes.div_ceil(mesh.problem.boundary().copies())
}
