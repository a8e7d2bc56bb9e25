//! Files of a run.

mod columns;
mod csv;
mod fields;
mod film;
pub mod measurement;
mod microphones;
mod motion;
mod sensors;
mod shot;
mod sound_fields;
mod table;
pub mod virtual_test;

use std::path::{Path, PathBuf};

use nailnoise_dynamics::{CycleRecord, Events};
use nailnoise_meshes::uff::{self, Mode};
use nailnoise_meshes::vtu::{Frames, Grid};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::model::sources;
use crate::run::Run;
use crate::stages::bodies::Body;
use crate::stages::spectra::{Driven, MovingBody};
use crate::stages::{Code, Input, Postcard, Progress, Stage, Stored, code};
use crate::staging::Staging;

pub use columns::{Column, columns};
pub use csv::{EVENT_NAMES, event_name};
pub use film::Fields;
pub(crate) use microphones::sound;
pub use sound_fields::{outdated_fields, write_sound_fields};
pub(crate) use table::table;

/// The folder of the fields in that of a run.
const FIELDS: &str = "fields";

/// Opens the fields of a run in ParaView.
const PARAVIEW: &str = include_str!("paraview.py");

/// A file by its path in the folder of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct File {
    /// The path.
    pub path: PathBuf,
    /// The bytes of the file.
    #[serde(with = "serde_bytes")]
    pub content: Vec<u8>,
}

impl File {
    pub(crate) fn new(path: impl Into<PathBuf>, content: impl Into<Vec<u8>>) -> Self {
        Self {
            path: path.into(),
            content: content.into(),
        }
    }
}

/// Files that a run writes on request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Exports {
    /// Charts as SVG.
    pub figures: bool,
    /// Films of the bodies for ParaView, next to the sound fields.
    pub films: bool,
    /// All samples of histories.
    pub histories: bool,
}

/// Files of a run in addition to its [fields](BodyFields), [`of_cycle`] and [`of_microphones`]: `ranking.csv`,
/// `levels.csv`, `intervals.csv`, `power.csv` and `paraview.py`. If a source's power is evaluated twice,
/// `radiation.csv` and `radiation-modes.csv` (for the tool's body `radiation-body.csv`) follow. If the design has
/// sensors, `sensors.csv`, `sensors-spectrum.csv` and `sensors.uff` follow, if it has pressure transducers,
/// `transducers.csv` and `transducers.uff`, and last `result.json`.
///
/// # Errors
/// [`Error::Json`] and those of the sensors' spectra.
pub fn files(run: &Run, exports: Exports) -> Result<Vec<File>, Error> {
    let mut files = sensors::files(run, exports.histories)?;
    files.push(File::new("ranking.csv", csv::ranking(&run.result)?));
    files.push(File::new("levels.csv", csv::levels(&run.result)?));
    for (source, name) in sources::ALL.map(|source| (source.name(), source.radiation_table())) {
        let tables = [
            (format!("{name}.csv"), csv::radiation(&run.result, source)),
            (format!("{name}-modes.csv"), csv::radiation_modes(&run.result, source)),
        ];
        for (path, table) in tables {
            files.extend(table.transpose()?.map(|table| File::new(path, table)));
        }
    }
    files.push(File::new("intervals.csv", csv::intervals(&run.result)?));
    files.push(File::new("power.csv", csv::power(run)?));
    files.push(File::new("paraview.py", PARAVIEW));
    let mut json = serde_json::to_vec_pretty(&run.result).map_err(Error::Json)?;
    json.push(b'\n');
    files.push(File::new("result.json", json));
    Ok(files)
}

/// Files of the bodies of a shot: `modes.csv`, and for ParaView `fields/*`, with the films on request.
///
/// # Errors
/// Those of the bodies' response.
fn fields(moving: &[Driven], events: &Events, films: bool) -> Result<Fields, Error> {
    let mut fields = Fields::default();
    fields.text("modes.csv", csv::modes(moving)?);
    for driven in moving {
        fields.show(Frames::of(&Grid::of_surface(&driven.body.surface))?);
        fields::add(&mut fields, driven, films);
        if films {
            shot::add(&mut fields, driven, events)?;
        }
    }
    Ok(fields)
}

/// Makes the files of the bodies in motion: their modes, and their vibration for ParaView.
#[derive(Serialize)]
pub struct BodyFields {
    /// The bodies.
    pub moving: Vec<MovingBody>,
    /// The cycle, whose events the films show.
    pub cycle: Stored<CycleRecord>,
    /// Whether films of the shot and series over the bands are among the files.
    pub films: bool,
}

impl Stage for BodyFields {
    type Output = Fields;
    type Codec = Postcard;
    const NAME: &'static str = "fields of the bodies";
    const CODE: Code = code!(
        dynamics,
        meshes,
        fem,
        acoustics,
        stages_apart,
        stages_bodies,
        stages_intervals,
        stages_microphones,
        stages_radiation,
        stages_response,
        stages_sensors,
        stages_sound,
        stages_sound_fields,
        stages_spectra,
        output
    );

    fn inputs(&self) -> Vec<&dyn Input> {
        let moving = self.moving.iter().flat_map(MovingBody::inputs);
        moving.chain([&self.cycle as &dyn Input]).collect()
    }

    fn compute(&self, _: &Progress) -> Result<Fields, Error> {
        let moving: Vec<Driven> = self.moving.iter().map(MovingBody::get).collect::<Result<_, _>>()?;
        fields(&moving, &self.cycle.get()?.events, self.films)
    }
}

/// `events.csv`, `log.csv` and `histories.csv` of a cycle, the latter with `all` samples or every so many.
///
/// # Errors
/// [`Error::Table`] where a table is not rectangular.
pub fn of_cycle(record: &CycleRecord, all: bool) -> Result<Vec<File>, Error> {
    Ok(vec![
        File::new("events.csv", csv::events(&record.events)?),
        File::new("log.csv", csv::log(&record.log)?),
        File::new("histories.csv", csv::histories(record, all)?),
    ])
}

/// `microphones.csv`, `microphones-bands.csv` and `microphones/*.wav` of a run.
///
/// # Errors
/// Those of sound files.
pub fn of_microphones(run: &Run) -> Result<Vec<File>, Error> {
    microphones::files(run)
}

/// The folder of the modes of a body in that of a run.
fn of_modes(body: &Body) -> PathBuf {
    Path::new("modes").join(body.name)
}

/// Writes the mode shapes of a body, [`Body::shapes`], to `modes/BODY/`; returns the `.pvd` that lists them.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_modes(staging: &Staging, body: &Body, shapes: &DMatrix<f64>) -> Result<PathBuf, Error> {
    fields::write_modes(staging, &of_modes(body), body, shapes)
}

/// Writes one period of mode `mode` (from 0) of a body to `modes/BODY/`; returns the `.pvd` that plays it.
///
/// # Errors
/// [`Error::NoMode`] when there are not so many; [`Error::Write`] or [`Error::Mesh`] with the file that could not be
/// written.
pub fn write_motion(staging: &Staging, body: &Body, mode: usize) -> Result<PathBuf, Error> {
    let modes = body.basis.hz.len();
    if mode >= modes {
        return Err(Error::NoMode { mode: mode + 1, modes });
    }
    motion::write(staging, &of_modes(body), body, mode)
}

/// Writes the skin and the modes of a body, [`Body::shapes`], to `modes/BODY/modes.uff` for modal-test software.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_universal(
    staging: &Staging,
    name: &str,
    (body, loss_factor): (&Body, f64),
    shapes: &DMatrix<f64>,
) -> Result<PathBuf, Error> {
    let path = of_modes(body).join("modes.uff");
    let modes: Vec<Mode<'_>> = body
        .basis
        .hz
        .iter()
        .zip(shapes.column_iter())
        .map(|(&hz, shape)| Mode {
            hz,
            loss_factor,
            // Columns of a matrix that owns its values are contiguous.
            shape: shape.data.into_slice(),
        })
        .collect();
    let text = uff::text(&format!("{name} {}", body.name), &body.surface, &modes)?;
    staging.write(&path, text.as_bytes())?;
    Ok(path)
}
