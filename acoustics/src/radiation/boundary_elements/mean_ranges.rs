use super::high_frequencies::mean_bands::{MeanBand, MeanBands};
use super::independent::Independent;
use super::mesh_range::MeshRange;
use super::range_solver::{Mean, RangeSolver};
use super::summary::Summary;
use crate::bem::error::BemError;
use crate::checks::InputError;
use crate::error::AcousticsError;

/// By how much the end of a band may exceed the top of its mesh, relative.
const SLACK: f64 = 1e-9;

/// Boundary elements in the mean over frequency, above the meshes of single frequencies.
#[derive(Debug, Default)]
pub struct MeanRanges {
    /// Upper end of the means \[Hz\]; without it half an octave above single frequencies, which needs no finer mesh.
    pub to_hz: Option<f64>,
    /// Meshes for the bands that the last mesh of single frequencies does not serve, those of
    /// [`MeanBands::finer_meshes`]. They have the same modes, parities and patches as that mesh.
    pub finer: Vec<MeshRange>,
}

impl MeanRanges {
    /// Means over the bands above those of the mesh of single frequencies, in rising order. Each band is solved on the
    /// first mesh that reaches its upper end, or on the last.
    ///
    /// # Errors
    /// Those of the solutions.
    pub(crate) fn means(
        finer: Vec<MeshRange>,
        bands: &MeanBands,
        chosen: &[Independent],
        progress: &(dyn Fn() + Sync),
        summary: &mut Summary,
    ) -> Result<Vec<Mean>, AcousticsError> {
        let mut left = bands.all().split_off(bands.on_same_mesh());
        let (mut means, meshes) = (Vec::new(), finer.len());
        for (number, mesh) in finer.into_iter().enumerate() {
            let reached = |band: &MeanBand| number + 1 == meshes || band.upper_hz <= mesh.top_hz * (1.0 + SLACK);
            let above = left.split_off(left.partition_point(reached));
            let own = std::mem::replace(&mut left, above);
            if own.is_empty() {
                continue;
            }
            let top_hz = mesh.top_hz;
            // Too few frequencies for integrals of close panels to be worth keeping.
            let solver = RangeSolver::new(mesh, top_hz, chosen, progress)?;
            means.extend(solver.means(&own)?);
            solver.report_errors(summary);
        }
        Ok(means)
    }

    /// Checks that the meshes resolve waves up to the upper end of the bands.
    ///
    /// # Errors
    /// [`InputError::Length`] without meshes where bands need some, [`BemError::TooCoarse`].
    pub(crate) fn check(&self, bands: &MeanBands) -> Result<(), BemError> {
        let needed = bands.finer_meshes().len();
        for mesh in &self.finer {
            mesh.problem.check_resolution(mesh.top_hz)?;
        }
        match self.finer.last() {
            Some(mesh) if needed > 0 => mesh.problem.check_resolution(bands.upper_hz()),
            None if needed > 0 => Err(InputError::Length {
                what: "meshes of the averages",
                found: 0,
                expected: needed,
            }
            .into()),
            _ => Ok(()),
        }
    }
}
