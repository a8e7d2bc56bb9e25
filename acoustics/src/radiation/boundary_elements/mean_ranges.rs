use super::high_frequencies::mean_bands::{MeanBand, MeanBands};
use super::independent::Independent;
use super::mesh_range::MeshRange;
use super::range_solver::{Mean, RangeSolver};
use super::summary::Summary;
use crate::bem::error::BemError;
use crate::checks::InputError;
use crate::error::AcousticsError;

/// Relative tolerance by which the end of a band may exceed the upper limit of its mesh.
const SLACK: f64 = 1e-9;

/// Boundary elements averaged over frequency, above the range of single frequencies.
#[derive(Debug, Default)]
pub struct MeanRanges {
    /// Upper end of the averages \[Hz\]; by default half an octave above single frequencies, which needs no finer mesh.
    pub to_hz: Option<f64>,
    /// Meshes for the bands that cannot use the last mesh of single frequencies, see [`MeanBands::finer_meshes`]. They
    /// have the same modes, parities and patches as that mesh.
    pub finer: Vec<MeshRange>,
}

impl MeanRanges {
    /// Averages over the bands above the range of single frequencies, in ascending order. Each band is solved on the
    /// first mesh that reaches its upper end, or on the last mesh.
    ///
    /// # Errors
    /// Errors of the solutions.
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
            // There are too few frequencies for caching the integrals of close panels to pay off.
            let solver = RangeSolver::new(mesh, top_hz, chosen, progress)?;
            means.extend(solver.means(&own)?);
            solver.report_errors(summary);
        }
        Ok(means)
    }

    /// Checks that the meshes resolve wavelengths up to the upper end of the bands.
    ///
    /// # Errors
    /// [`InputError::Length`] if bands need meshes but there are none; [`BemError::TooCoarse`].
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
