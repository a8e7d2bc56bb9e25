//! VTK files for ParaView: vibration of each body in the shot, and mode shapes.

use std::path::{Path, PathBuf};

use nailnoise_acoustics::radiation::{LowRank, ModalSpectra};
use nailnoise_acoustics::signals::{Band, octaves};
use nailnoise_meshes::vtu::{self, Array, Field, Grid};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::film::Fields;
use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::stages::bodies::Body;
use crate::stages::spectra::BodyInMotion;

/// Range of levels shown below the highest of a field \[dB\]. Clamped points do not move; their levels are at this
/// floor.
const SHOWN: f64 = 60.0;

/// Reference of velocity exposure levels: (50 nm/s)^2 over 1 s \[m2/s\] (ISO 1683).
const REFERENCE: f64 = 50e-9 * 50e-9;

/// Adds `BODY.vtu`: at every point of the body's surface, the velocity exposure level of the shot in octave bands,
///
/// ```text
/// L_vE = 10 lg( 2 int |v(f)|^2 df / ((50 nm/s)^2 x 1 s) )
/// ```
///
/// with the velocity vector v from the coherent sum of all modes; no lower than 60 dB below the highest point. With
/// `film`, also adds the same as a series over the bands that ParaView steps through, `BODY-bands.pvd`.
pub(super) fn add(fields: &mut Fields, driven: &BodyInMotion, film: bool) {
    let (body, spectra) = (&driven.body, &driven.motion.spectra);
    let factor = |octave: &Band| Some((octave.nominal_hz(), factor(spectra, [octave.low, octave.high])?));
    let (nominal, factors): (Vec<f64>, Vec<LowRank>) = octaves().par_iter().filter_map(factor).unzip();
    // phi^T C phi for each component of the vector.
    let forms = LowRank::forms(&factors, &body.skin);
    let levels = |forms: Vec<f64>| {
        let energies: Vec<f64> = forms.chunks_exact(3).map(|axes| axes.iter().sum()).collect();
        let floor = energies.iter().fold(0.0, |a: f64, &b| a.max(b)) * 10f64.powf(-0.1 * SHOWN);
        let level = |e: f64| 10.0 * (e.max(floor).max(f64::MIN_POSITIVE) / REFERENCE).log10();
        energies.into_iter().map(|e| level(e) as f32).collect()
    };
    let levels: Vec<Vec<f32>> = forms.into_par_iter().map(levels).collect();
    let bands = || nominal.iter().zip(&levels);
    let of_octave = |(nominal, levels): (&f64, &Vec<f32>)| {
        let name = format!("velocity exposure level {nominal} Hz octave [dB]");
        Array::new(name, 1, levels)
    };
    fields.frame(&format!("{}.vtu", body.name), bands().map(of_octave).collect());
    if !film {
        return;
    }
    let of_band = |(nominal, levels): (&f64, &Vec<f32>)| {
        let values = Array::new("velocity exposure level [dB]", 1, levels);
        (*nominal, format!("{nominal:05.0}"), vec![values])
    };
    fields.series(&format!("{}-bands", body.name), bands().map(of_band).collect());
}

/// Factor of the covariance C of the modal velocities, so that 2 int |v|^2 df over a band is phi^T C phi \[m2/s\];
/// `None` if the analysed range does not contain the band.
fn factor(spectra: &ModalSpectra, [low, high]: [f64; 2]) -> Option<LowRank> {
    let first = spectra.frequency.iter().find(|hz| (low..high).contains(hz))?;
    if *first > low * 1.1 || spectra.range_hz[1] < high {
        return None;
    }
    Some(LowRank::of(&spectra.velocity_covariance([low, high], |_| 1.0)?))
}

/// Writes a `.vtu` for each mode and the `.pvd` that lists them by frequency; returns the `.pvd`.
pub(super) fn write_modes(
    staging: &AtomicWrite,
    folder: &Path,
    body: &Body,
    shapes: &DMatrix<f64>,
) -> Result<PathBuf, Error> {
    let grid = Grid::of_mesh(&body.mesh);
    let mode = |(index, &hz): (usize, &f64)| {
        let file = format!("mode-{:04}.vtu", index + 1);
        let shape = Field {
            name: "mode shape [kg^-1/2]",
            components: 3,
            // The columns of a matrix that owns its values are contiguous.
            values: shapes.column(index).data.into_slice(),
        };
        staging.write(&folder.join(&file), &grid.to_bytes(&[shape], &[])?)?;
        Ok((hz, file))
    };
    let series = body.basis.hz.par_iter().enumerate().map(mode);
    let series = series.collect::<Result<Vec<_>, Error>>()?;
    let list = folder.join("modes.pvd");
    staging.write(&list, vtu::series(&series).as_bytes())?;
    Ok(list)
}
