//! Files of a run: every one is written whole, or not at all.

mod columns;
mod csv;
mod fields;
mod microphones;
mod motion;
mod pictures;
mod sensors;
mod shot;

use std::path::{Path, PathBuf};

use nailnoise_dynamics::{CycleRecord, Events};
use nailnoise_meshes::uff::{self, Mode};
use nailnoise_meshes::write_atomic;

use crate::error::Error;
use crate::pipeline::{Body, Run, Vibration};

pub use columns::{Column, columns};
pub use csv::EVENT_NAMES;
pub use pictures::{remove_others, write_pictures};

/// The folder of the fields in that of a run.
const FIELDS: &str = "fields";

/// Opens the fields of a run in ParaView.
const PARAVIEW: &str = include_str!("paraview.py");

/// Writes what a run leaves behind beside its [fields](write_fields) to `folder`: `result.json`, `levels.csv`,
/// `intervals.csv`, `power.csv`, `events.csv`, `log.csv`, `histories.csv`, `microphones.csv`, `microphones-bands.csv`,
/// `microphones/*.wav`, `paraview.py`, where a source's power is evaluated twice `radiation.csv` and `radiation-modes.csv`
/// (for the tool's body `radiation-body.csv`), and where the design has sensors `sensors.csv`, `sensors-spectrum.csv` and `sensors.uff`.
///
/// # Errors
/// [`Error::Write`] with the file that could not be written.
pub fn write_run(folder: &Path, run: &Run) -> Result<(), Error> {
    create(folder)?;
    let of_sound = || {
        let (sensors, microphones) = rayon::join(|| sensors::write(folder, run), || microphones::write(folder, run));
        sensors.and(microphones)
    };
    let (of_cycle, of_sound) = rayon::join(|| write_cycle(folder, &run.record), of_sound);
    of_cycle.and(of_sound)?;
    let mut json = serde_json::to_vec_pretty(&run.result).map_err(Error::Json)?;
    json.push(b'\n');
    write(&folder.join("levels.csv"), csv::levels(&run.result).as_bytes())?;
    for (source, name) in [("workpiece", "radiation"), ("body", "radiation-body")] {
        if let Some(text) = csv::radiation(&run.result, source) {
            write(&folder.join(format!("{name}.csv")), text.as_bytes())?;
        }
        if let Some(text) = csv::radiation_modes(&run.result, source) {
            write(&folder.join(format!("{name}-modes.csv")), text.as_bytes())?;
        }
    }
    write(&folder.join("intervals.csv"), csv::intervals(&run.result).as_bytes())?;
    write(&folder.join("power.csv"), csv::power(run).as_bytes())?;
    write(&folder.join("paraview.py"), PARAVIEW.as_bytes())?;
    // Last, so that a folder with a result has all the rest of it.
    write(&folder.join("result.json"), &json)
}

/// Writes what the bodies of a shot leave to `folder`: `modes.csv`, and for ParaView `fields/*`.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_fields(folder: &Path, vibration: &Vibration, events: &Events) -> Result<(), Error> {
    create(folder)?;
    write(&folder.join("modes.csv"), csv::modes(vibration).as_bytes())?;
    let fields = folder.join(FIELDS);
    fields::write(&fields, vibration)?;
    shot::write(&fields, vibration, events)
}

/// Writes `events.csv`, `log.csv` and `histories.csv` of a cycle to `folder`.
///
/// # Errors
/// [`Error::Write`] with the file that could not be written.
pub fn write_cycle(folder: &Path, record: &CycleRecord) -> Result<(), Error> {
    create(folder)?;
    write(&folder.join("events.csv"), csv::events(&record.events).as_bytes())?;
    write(&folder.join("log.csv"), csv::log(&record.log).as_bytes())?;
    write(&folder.join("histories.csv"), csv::histories(record).as_bytes())
}

/// Writes the mode shapes of a body to `folder/modes/BODY/`; returns the `.pvd` that lists them.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_modes(folder: &Path, body: &Body) -> Result<PathBuf, Error> {
    fields::write_modes(&folder.join("modes").join(body.name), body)
}

/// Writes one period of mode `mode` (from 0) of a body to `folder/modes/BODY/`; returns the `.pvd` that plays it.
///
/// # Errors
/// [`Error::NoMode`] when there are not so many; [`Error::Write`] or [`Error::Mesh`] with the file that could not be
/// written.
pub fn write_motion(folder: &Path, body: &Body, mode: usize) -> Result<PathBuf, Error> {
    let modes = body.basis.hz.len();
    if mode >= modes {
        return Err(Error::NoMode { mode: mode + 1, modes });
    }
    motion::write(&folder.join("modes").join(body.name), body, mode)
}

/// Writes the skin and the modes of a body to `folder/modes/BODY/modes.uff` for modal-test software.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_universal(folder: &Path, name: &str, body: &Body) -> Result<PathBuf, Error> {
    let folder = folder.join("modes").join(body.name);
    create(&folder)?;
    let path = folder.join("modes.uff");
    let modes: Vec<Mode<'_>> = body
        .basis
        .hz
        .iter()
        .zip(body.basis.shapes.column_iter())
        .map(|(&hz, shape)| Mode {
            hz,
            loss_factor: body.loss_factor,
            // Columns of a matrix that owns its values are contiguous.
            shape: shape.data.into_slice(),
        })
        .collect();
    uff::write(&path, &format!("{name} {}", body.name), &body.surface, &modes)?;
    Ok(path)
}

pub(crate) fn create(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_owned(),
        source,
    })
}

pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_atomic(path, bytes).map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}
