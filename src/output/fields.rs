//! VTK files for ParaView: vibration of each body in the shot, and mode shapes.

use std::path::{Path, PathBuf};

use nailnoise_acoustics::levels::octaves;
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::radiation::quadratic_forms;
use nailnoise_meshes::vtu::{Field, write_mesh, write_series, write_surface};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::error::Error;
use crate::pipeline::{Body, Driven, Vibration};

/// Levels shown below the highest of a field \[dB\]; clamped points, which do not move, stand at this floor.
const SHOWN: f64 = 60.0;

/// Reference of velocity exposure levels: (50 nm/s)^2 over 1 s \[m2/s\] (ISO 1683).
const REFERENCE: f64 = 50e-9 * 50e-9;

/// Writes `BODY.vtu`: on every point of the body's surface the velocity exposure level of the shot in octave bands,
///
/// ```text
/// L_vE = 10 lg( 2 int |v(f)|^2 df / ((50 nm/s)^2 x 1 s) )
/// ```
///
/// with v the velocity vector, from the coherent sum of all modes; no lower than 60 dB below the highest point. And the
/// same as a series of the bands, `BODY-bands.pvd`.
pub(super) fn write(folder: &Path, vibration: &Vibration) -> Result<(), Error> {
    super::create(folder)?;
    for Driven { body, spectra, .. } in vibration.driven() {
        let shapes = on_surface(body);
        let bands: Vec<(f64, Vec<f64>)> = octaves()
            .par_iter()
            .filter_map(|octave| {
                let energies = exposure(&shapes, spectra, [octave.low, octave.high])?;
                let floor = energies.iter().fold(0.0, |a: f64, &b| a.max(b)) * 10f64.powf(-0.1 * SHOWN);
                let level = |e: &f64| 10.0 * (e.max(floor).max(f64::MIN_POSITIVE) / REFERENCE).log10();
                Some((octave.nominal_hz(), energies.iter().map(level).collect()))
            })
            .collect();
        let name = |nominal: f64| format!("velocity exposure level {nominal} Hz octave [dB]");
        let names: Vec<String> = bands.iter().map(|&(nominal, _)| name(nominal)).collect();
        let fields: Vec<Field<'_>> = names
            .iter()
            .zip(&bands)
            .map(|(name, (_, values))| Field {
                name,
                components: 1,
                values,
            })
            .collect();
        write_surface(&folder.join(format!("{}.vtu", body.name)), &body.surface, &fields, &[])?;
        write_bands(folder, body, &bands)?;
    }
    Ok(())
}

/// Writes the same as a series over frequency, `BODY-bands.pvd` and a `.vtu` a band: one field that ParaView steps through.
fn write_bands(folder: &Path, body: &Body, bands: &[(f64, Vec<f64>)]) -> Result<(), Error> {
    let name = format!("{}-bands", body.name);
    super::create(&folder.join(&name))?;
    let of_band = |(nominal, values): &(f64, Vec<f64>)| {
        let file = format!("{name}/{nominal:05.0}.vtu");
        let field = Field {
            name: "velocity exposure level [dB]",
            components: 1,
            values,
        };
        write_surface(&folder.join(&file), &body.surface, &[field], &[])?;
        Ok((*nominal, file))
    };
    let series: Vec<(f64, String)> = bands.par_iter().map(of_band).collect::<Result<_, Error>>()?;
    Ok(write_series(&folder.join(format!("{name}.pvd")), &series)?)
}

/// Displacements of the modes on the points of the surface: 3 points x modes.
pub(super) fn on_surface(body: &Body) -> DMatrix<f64> {
    let dofs = body
        .surface
        .volume_nodes
        .iter()
        .flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2]);
    body.basis.shapes.select_rows(&dofs.collect::<Vec<usize>>())
}

/// 2 int |v|^2 df over a band at every point of the surface \[m2/s\]; nothing when the band holds no analysed frequency.
///
/// With the covariance C of the modal velocities this is phi^T C phi for each component.
fn exposure(shapes: &DMatrix<f64>, spectra: &ModalSpectra, [low, high]: [f64; 2]) -> Option<Vec<f64>> {
    let first = spectra.frequency.iter().find(|hz| (low..high).contains(hz))?;
    if *first > low * 1.1 || spectra.range_hz[1] < high {
        return None;
    }
    let covariance = spectra.velocity_covariance([low, high], |_| 1.0)?;
    let forms = quadratic_forms(shapes, &covariance);
    Some(forms.chunks_exact(3).map(|axes| axes.iter().sum()).collect())
}

/// Writes one `.vtu` a mode and the `.pvd` that lists them by frequency; returns the `.pvd`.
pub(super) fn write_modes(folder: &Path, body: &Body) -> Result<PathBuf, Error> {
    super::create(folder)?;
    let mut series = Vec::with_capacity(body.basis.hz.len());
    for (index, (&hz, shape)) in body.basis.hz.iter().zip(body.basis.shapes.column_iter()).enumerate() {
        let file = format!("mode-{:04}.vtu", index + 1);
        let field = Field {
            name: "mode shape [kg^-1/2]",
            components: 3,
            values: shape.as_slice(),
        };
        write_mesh(&folder.join(&file), &body.mesh, &[field], &[])?;
        series.push((hz, file));
    }
    let list = folder.join("modes.pvd");
    write_series(&list, &series)?;
    Ok(list)
}
