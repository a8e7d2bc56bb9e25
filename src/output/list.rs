//! The outputs of a run.

use std::path::Path;

use rayon::prelude::*;

use super::{CycleView, Exports, File, Output, RunView, Writer};
use super::{blow, body_fields, paraview, transducers};
use super::{
    events, figures, histories, intervals, levels, log, loudness, microphones, motion_bands, power, radiation, ranking,
    result, sensors,
};
use crate::error::Error;

/// Every output of a run.
pub const OUTPUTS: [Output; 28] = [
    result::RESULT,
    result::REPORT,
    ranking::RANKING,
    levels::LEVELS,
    intervals::INTERVALS,
    power::POWER,
    events::EVENTS,
    log::LOG,
    histories::HISTORIES,
    histories::OPENINGS,
    blow::BLOWS,
    body_fields::MODES,
    body_fields::FIELDS,
    paraview::SCRIPT,
    paraview::FILM,
    radiation::TABLES,
    sensors::HISTORIES,
    sensors::SPECTRA,
    sensors::UNIVERSAL,
    motion_bands::BANDS,
    transducers::HISTORIES,
    transducers::UNIVERSAL,
    microphones::LEVELS,
    microphones::BANDS,
    microphones::NOTE,
    microphones::SOUNDS,
    loudness::LOUDNESS,
    figures::FIGURES,
];

/// Paths of the outputs that are single files with the same name in every run.
pub(crate) fn fixed_names() -> impl Iterator<Item = &'static Path> {
    let files = OUTPUTS.iter().filter(|output| !matches!(output.writer, Writer::Bodies));
    let names = files.map(|output| output.name).filter(|name| !name.contains('*'));
    names.map(Path::new)
}

/// Files of a cycle, for which no source is needed.
///
/// # Errors
/// [`Error::Table`] if a table is not rectangular.
pub fn of_cycle(cycle: CycleView<'_>, exports: Exports) -> Result<Vec<File>, Error> {
    let files = OUTPUTS.par_iter().filter_map(|output| match output.writer {
        Writer::Cycle(write) => {
            let content = write(cycle, exports).transpose()?;
            Some(content.map(|content| File::new(output.name, content)))
        }
        _ => None,
    });
    files.collect()
}

/// Files of a run that no study affects, other than those of its cycle and bodies.
///
/// # Errors
/// The errors of the sensors' spectra and of sound files.
pub fn of_run(view: &RunView<'_>) -> Result<Vec<File>, Error> {
    let own = |output: &&Output| (output.condition)(view);
    let files = OUTPUTS.par_iter().filter(own).map(|output| match output.writer {
        Writer::Run(write) => Ok(vec![File::new(output.name, write(view)?)]),
        Writer::Files(write) => write(view),
        Writer::Cycle(_) | Writer::Study(_) | Writer::Bodies => Ok(Vec::new()),
    });
    Ok(files.collect::<Result<Vec<_>, _>>()?.concat())
}

/// Files of a run that show its study.
///
/// # Errors
/// [`Error::Json`], [`Error::Table`].
pub fn of_study(view: &RunView<'_>) -> Result<Vec<File>, Error> {
    let own = |output: &&Output| (output.condition)(view);
    let files = OUTPUTS.par_iter().filter(own).filter_map(|output| match output.writer {
        Writer::Study(write) => Some(write(view).map(|bytes| File::new(output.name, bytes))),
        _ => None,
    });
    files.collect()
}
