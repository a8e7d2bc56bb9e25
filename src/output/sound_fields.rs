//! The sound field of a shot for ParaView: a series over the bands for each surface, plane and sphere.

use std::fs;
use std::path::{Path, PathBuf};

use nailnoise_acoustics::radiation::sound_fields::{BandField, FieldSeries, FieldShape};
use nailnoise_meshes::vtu::{self, Field, Grid};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::file::FIELDS;
use crate::atomic_write::{AtomicWrite, is_file_name};
use crate::error::Error;
use crate::stages::bodies::BodyKind;
use crate::stages::sound_fields::Fields;

/// Name of the file that identifies the design of the fields and lists their content.
const INDEX: &str = "sound.json";

/// `fields/sound.json`.
#[derive(Serialize, Deserialize)]
struct Index {
    design: String,
    method: String,
    notes: Vec<String>,
    series: Vec<String>,
}

/// Writes the sound fields of a design to `folder/fields`, replacing any that are there. Each series has `NAME.pvd` and
/// a `.vtu` for each band; `sound.json` lists the series.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written; the folder is then unchanged.
pub fn write_sound_fields(folder: &Path, digest: &str, found: &Fields) -> Result<(), Error> {
    let staging = AtomicWrite::within(folder)?;
    found.series.iter().try_for_each(|series| write(&staging, series))?;
    let index = Index {
        design: digest.to_owned(),
        method: found.method.clone(),
        notes: found.notes.clone(),
        series: found.series.iter().map(|series| series.name.clone()).collect(),
    };
    let mut json = serde_json::to_vec_pretty(&index).map_err(Error::Json)?;
    json.push(b'\n');
    let last = Path::new(FIELDS).join(INDEX);
    staging.write(&last, &json)?;
    let outdated = index_in(folder).map(|index| index.paths()).unwrap_or_default();
    staging.place(&outdated, &last)
}

/// Files and folders of outdated fields, relative to the folder. Sound fields are outdated unless they belong to the
/// design with this digest; films, unless they belong to these fields or `films` are written anew. Files from an
/// earlier run would belong to another shot.
pub fn outdated_fields(folder: &Path, digest: &str, films: bool) -> Vec<PathBuf> {
    let index = index_in(folder);
    if index.as_ref().is_some_and(|index| index.design == digest) {
        return Vec::new();
    }
    let mut outdated = index.map(|index| index.paths()).unwrap_or_default();
    if !films {
        outdated.extend(films_in(folder));
    }
    outdated
}

/// Films of bodies in a folder, relative to it: a list, a folder of frames, and one file with all of them for each.
fn films_in(folder: &Path) -> Vec<PathBuf> {
    let fields = Path::new(FIELDS);
    let bodies = BodyKind::ALL.into_iter().map(BodyKind::name);
    let films = bodies.flat_map(|body| ["shot", "film", "bands"].map(|film| format!("{body}-{film}")));
    let paths = films.flat_map(|film| {
        let files = ["pvd", "vtkhdf"].map(|end| fields.join(format!("{film}.{end}")));
        files.into_iter().chain([fields.join(film)])
    });
    paths.filter(|path| folder.join(path).exists()).collect()
}

fn index_in(folder: &Path) -> Option<Index> {
    serde_json::from_slice(&fs::read(folder.join(FIELDS).join(INDEX)).ok()?).ok()
}

impl Index {
    /// The files that it lists, and itself.
    fn paths(&self) -> Vec<PathBuf> {
        let fields = Path::new(FIELDS);
        // Because anyone may have changed the file, only file names in this folder are accepted.
        let series = self.series.iter().filter(|name| is_file_name(name));
        let of_series = series.flat_map(|name| [fields.join(format!("{name}.pvd")), fields.join(name)]);
        of_series.chain([fields.join(INDEX)]).collect()
    }
}

fn write(staging: &AtomicWrite, series: &FieldSeries) -> Result<(), Error> {
    let fields = Path::new(FIELDS);
    let of_shape = |shape: &FieldShape| Grid::of_polygons(&shape.points, &shape.polygons);
    let grids: Vec<Grid> = series.shapes.par_iter().map(of_shape).collect();
    let of_band = |band: &BandField| {
        let file = format!("{}/{:05.0}.vtu", series.name, band.hz);
        let bytes = grids[band.shape].to_bytes(&named(&band.points), &named(&band.polygons))?;
        staging.write(&fields.join(&file), &bytes)?;
        Ok((band.hz, file))
    };
    let files = series
        .bands
        .par_iter()
        .map(of_band)
        .collect::<Result<Vec<_>, Error>>()?;
    let list = fields.join(format!("{}.pvd", series.name));
    staging.write(&list, vtu::series(&files).as_bytes())
}

fn named(fields: &[(String, Vec<f64>)]) -> Vec<Field<'_>> {
    fields
        .iter()
        .map(|(name, values)| Field {
            name,
            components: 1,
            values,
        })
        .collect()
}
