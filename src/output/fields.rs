//! VTK files for ParaView: vibration of each body in the shot, and mode shapes.

use std::path::{Path, PathBuf};

use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_meshes::vtu::{Field, write_mesh, write_series, write_surface};
use nalgebra::DMatrix;

use crate::error::Error;
use crate::pipeline::{Body, Driven, Run};

/// Octave bands of the velocity fields: k of the mid-band frequencies 1000 G^k Hz, G = 10^0.3 (IEC 61260-1, base ten), and
/// their nominal values \[Hz\].
const OCTAVES: [(i32, u32); 8] = [
    (-4, 63),
    (-3, 125),
    (-2, 250),
    (-1, 500),
    (0, 1000),
    (1, 2000),
    (2, 4000),
    (3, 8000),
];

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
pub(super) fn write(folder: &Path, run: &Run) -> Result<(), Error> {
    super::create(folder)?;
    for Driven { body, spectra, .. } in run.driven() {
        let bands: Vec<(u32, Vec<f64>)> = OCTAVES
            .iter()
            .filter_map(|&(k, nominal)| {
                let centre = 1000.0 * 10f64.powf(0.3 * f64::from(k));
                let edges = [centre * 10f64.powf(-0.15), centre * 10f64.powf(0.15)];
                let energies = exposure(body, spectra, edges)?;
                let floor = energies.iter().fold(0.0, |a: f64, &b| a.max(b)) * 10f64.powf(-0.1 * SHOWN);
                let level = |e: &f64| 10.0 * (e.max(floor).max(f64::MIN_POSITIVE) / REFERENCE).log10();
                Some((nominal, energies.iter().map(level).collect()))
            })
            .collect();
        let name = |nominal: u32| format!("velocity exposure level {nominal} Hz octave [dB]");
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
fn write_bands(folder: &Path, body: &Body, bands: &[(u32, Vec<f64>)]) -> Result<(), Error> {
    let name = format!("{}-bands", body.name);
    super::create(&folder.join(&name))?;
    let mut series = Vec::with_capacity(bands.len());
    for (nominal, values) in bands {
        let file = format!("{name}/{nominal:05}.vtu");
        let field = Field {
            name: "velocity exposure level [dB]",
            components: 1,
            values,
        };
        write_surface(&folder.join(&file), &body.surface, &[field], &[])?;
        series.push((f64::from(*nominal), file));
    }
    Ok(write_series(&folder.join(format!("{name}.pvd")), &series)?)
}

/// 2 int |v|^2 df over a band at every point of the surface \[m2/s\]; nothing when the band holds no analysed frequency.
///
/// With v = Phi a/(j omega) and C = sum over bins of Re(a a^H)/omega^2 this is phi^T C phi for each component.
fn exposure(body: &Body, spectra: &ModalSpectra, [low, high]: [f64; 2]) -> Option<Vec<f64>> {
    let bins: Vec<usize> = (0..spectra.frequency.len())
        .filter(|&k| (low..high).contains(&spectra.frequency[k]))
        .collect();
    if bins.len() < 2 || spectra.frequency[bins[0]] > low * 1.1 || spectra.range_hz[1] < high {
        return None;
    }
    let step = spectra.frequency[1] - spectra.frequency[0];
    let modes = body.omega.len();
    let mut rows = DMatrix::zeros(modes, 2 * bins.len());
    for (column, &bin) in bins.iter().enumerate() {
        let scale = (2.0 * step).sqrt() / (std::f64::consts::TAU * spectra.frequency[bin]);
        for mode in 0..modes {
            let a = spectra.accelerations[(mode, bin)];
            rows[(mode, 2 * column)] = a.re * scale;
            rows[(mode, 2 * column + 1)] = a.im * scale;
        }
    }
    let covariance = &rows * rows.transpose();
    let dofs: Vec<usize> = body
        .surface
        .volume_nodes
        .iter()
        .flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2])
        .collect();
    let shapes = body.shapes.select_rows(&dofs);
    let moved = &shapes * covariance;
    let of_point = |point: usize| {
        (0..3)
            .map(|axis| shapes.row(3 * point + axis).dot(&moved.row(3 * point + axis)))
            .sum()
    };
    Some((0..body.surface.points.len()).map(of_point).collect())
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
