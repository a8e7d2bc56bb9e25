//! The sound field of a shot for ParaView: a series over the bands for each surface, plane and sphere.

use std::fs;
use std::path::Path;

use nailnoise_acoustics::sound_fields::{BandField, FieldSeries, FieldShape};
use nailnoise_meshes::vtu::{self, Field, Grid};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{FIELDS, gone};
use crate::error::Error;
use crate::stages::sound_fields::Fields;

/// Names the design of the fields, and what they show.
const INDEX: &str = "sound.json";

/// `fields/sound.json`.
#[derive(Serialize, Deserialize)]
struct Index {
    design: String,
    method: String,
    notes: Vec<String>,
    series: Vec<String>,
}

/// Writes the sound fields of a design to `folder/fields`: for each series `NAME.pvd` and the `.vtu` of each band, and
/// last `sound.json`, which names them.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_sound_fields(folder: &Path, digest: &str, found: &Fields) -> Result<(), Error> {
    let fields = folder.join(FIELDS);
    remove(&fields)?;
    super::create(&fields)?;
    found.series.iter().try_for_each(|series| write(&fields, series))?;
    let index = Index {
        design: digest.to_owned(),
        method: found.method.clone(),
        notes: found.notes.clone(),
        series: found.series.iter().map(|series| series.name.clone()).collect(),
    };
    let mut json = serde_json::to_vec_pretty(&index).map_err(Error::Json)?;
    json.push(b'\n');
    super::write(&fields.join(INDEX), &json)
}

/// Removes the sound fields in a folder unless they are those of the design with this digest.
///
/// # Errors
/// [`Error::Write`] with what could not be removed.
pub fn remove_others(folder: &Path, digest: &str) -> Result<(), Error> {
    let fields = folder.join(FIELDS);
    match index(&fields) {
        Some(index) if index.design != digest => remove(&fields),
        _ => Ok(()),
    }
}

fn index(fields: &Path) -> Option<Index> {
    serde_json::from_slice(&fs::read(fields.join(INDEX)).ok()?).ok()
}

/// Removes what the index names, and the index.
fn remove(fields: &Path) -> Result<(), Error> {
    let Some(index) = index(fields) else { return Ok(()) };
    for name in &index.series {
        let list = fields.join(format!("{name}.pvd"));
        gone(&list, fs::remove_file(&list))?;
        let own = fields.join(name);
        gone(&own, fs::remove_dir_all(&own))?;
    }
    let path = fields.join(INDEX);
    gone(&path, fs::remove_file(&path))
}

fn write(fields: &Path, series: &FieldSeries) -> Result<(), Error> {
    super::create(&fields.join(&series.name))?;
    let of_shape = |shape: &FieldShape| Grid::of_polygons(&shape.points, &shape.polygons);
    let grids: Vec<Grid> = series.shapes.par_iter().map(of_shape).collect();
    let of_band = |band: &BandField| {
        let file = format!("{}/{:05.0}.vtu", series.name, band.hz);
        let bytes = grids[band.shape].to_bytes(&named(&band.points), &named(&band.polygons))?;
        super::write(&fields.join(&file), &bytes)?;
        Ok((band.hz, file))
    };
    let files = series
        .bands
        .par_iter()
        .map(of_band)
        .collect::<Result<Vec<_>, Error>>()?;
    super::write(
        &fields.join(format!("{}.pvd", series.name)),
        vtu::series(&files).as_bytes(),
    )
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
