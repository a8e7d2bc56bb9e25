//! Outputs of a run: each has a name, a condition and a writer, and [`OUTPUTS`] lists them all.

mod blow;
mod body_fields;
mod columns;
mod dataset;
mod events;
mod fields;
mod figures;
mod file;
mod film;
mod histories;
mod intervals;
mod levels;
mod list;
mod log;
mod loudness;
pub mod measurement;
mod microphones;
mod modal_shapes;
mod modes;
mod motion;
mod motion_bands;
mod paraview;
mod power;
mod radiation;
mod ranking;
mod result;
mod sensors;
mod shot;
mod sound_fields;
mod sources;
mod table;
mod transducers;
pub mod virtual_test;

use nailnoise_dynamics::network::Record;
use nailnoise_dynamics::{CycleRecord, NailerFigures};
use serde::Serialize;

use crate::design::Design;
use crate::error::Error;
use crate::run::Run;
use crate::stages::cycle::ShotRecord;
use crate::units::Units;

pub use body_fields::BodyFields;
pub use columns::{Column, columns};
pub(crate) use dataset::table_hdf5;
pub use file::File;
pub use film::Fields;
pub(crate) use list::fixed_names;
pub use list::{OUTPUTS, of_cycle, of_run, of_study};
pub use microphones::sounds;
pub use modal_shapes::{write_modes, write_motion, write_universal};
pub use result::LAST;
pub use sound_fields::{outdated_fields, write_sound_fields};
pub(crate) use table::table;

/// Files that a run writes on request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Exports {
    /// Charts as SVG.
    pub figures: bool,
    /// Films of the bodies for ParaView, next to the sound fields.
    pub films: bool,
    /// All samples of histories.
    pub histories: bool,
    /// Units of the report and of charts.
    pub units: Units,
    /// How many times slower than the shot its film plays.
    pub slow_motion: u32,
}

/// An output of a run: a file, or the files of a folder.
#[derive(Clone, Copy)]
pub struct Output {
    /// Its path in the folder of a run; `*` stands for a part that depends on the run.
    pub name: &'static str,
    /// Whether a run has it. An output of the cycle or of the bodies has no condition.
    pub condition: fn(&RunView<'_>) -> bool,
    /// How its files are made.
    pub writer: Writer,
}

/// Makes a file of a cycle.
type OfCycle = fn(CycleView<'_>, Exports) -> Result<Option<Vec<u8>>, Error>;

/// How the files of an output are made.
#[derive(Clone, Copy)]
pub enum Writer {
    /// One file of the cycle, made while the sources are computed; none for a cycle without its content.
    Cycle(OfCycle),
    /// One file of a run that no study affects.
    Run(fn(&RunView<'_>) -> Result<Vec<u8>, Error>),
    /// Several files of a run that no study affects.
    Files(fn(&RunView<'_>) -> Result<Vec<File>, Error>),
    /// One file of a run that shows its study; made again when the study is known.
    Study(fn(&RunView<'_>) -> Result<Vec<u8>, Error>),
    /// Files of the stage [`BodyFields`], which are stored once for all runs with the same motion of the bodies.
    Bodies,
}

/// A cycle whose files are written.
#[derive(Clone, Copy)]
pub struct CycleView<'a> {
    /// Histories, events and log of its blocks.
    pub record: &'a Record,
    /// The shot in terms of the nailer, for the tool described by keys.
    pub nailer: Option<&'a NailerFigures>,
}

impl<'a> From<&'a ShotRecord> for CycleView<'a> {
    fn from(shot: &'a ShotRecord) -> Self {
        Self {
            record: &shot.record,
            nailer: shot.nailer.as_deref(),
        }
    }
}

impl<'a> From<&'a CycleRecord> for CycleView<'a> {
    fn from(cycle: &'a CycleRecord) -> Self {
        Self {
            record: &cycle.record,
            nailer: Some(&cycle.figures),
        }
    }
}

/// The data of a run from which its outputs are made.
pub struct RunView<'a> {
    /// The design.
    pub design: &'a Design,
    /// The run.
    pub run: &'a Run,
    /// The files on request.
    pub exports: Exports,
    /// Makes the report, which also contains pictures of the bodies.
    pub report: &'a (dyn Fn() -> String + Sync),
}

impl Output {
    const fn new(name: &'static str, writer: Writer) -> Self {
        Self {
            name,
            condition: |_| true,
            writer,
        }
    }

    const fn of_cycle(name: &'static str, write: OfCycle) -> Self {
        Self::new(name, Writer::Cycle(write))
    }

    const fn of_run(name: &'static str, write: fn(&RunView<'_>) -> Result<Vec<u8>, Error>) -> Self {
        Self::new(name, Writer::Run(write))
    }

    const fn files(name: &'static str, write: fn(&RunView<'_>) -> Result<Vec<File>, Error>) -> Self {
        Self::new(name, Writer::Files(write))
    }

    const fn of_study(name: &'static str, write: fn(&RunView<'_>) -> Result<Vec<u8>, Error>) -> Self {
        Self::new(name, Writer::Study(write))
    }

    const fn of_bodies(name: &'static str) -> Self {
        Self::new(name, Writer::Bodies)
    }

    /// The same output, only for runs that meet a condition.
    const fn only_if(self, condition: fn(&RunView<'_>) -> bool) -> Self {
        Self { condition, ..self }
    }
}
