//! Figures as SVG, for print: 180 mm wide, 8 pt type, colours that colour-blind readers can tell apart.
//!
//! [`cycle`] draws a nailing cycle, [`sound`] the levels of a run, [`penetration`] compares penetration laws. Time runs in ms from the trigger on; the
//! events t0..t18 stand over each figure of a cycle. A line is thinned to what can be seen of it and keeps every peak.

mod bands;
mod canvas;
mod decibels;
mod decimate;
mod energy;
mod forces;
mod intervals;
mod motion;
mod penetration;
mod power;
mod pressures;
mod ratios;
mod scale;
mod sheet;
mod spread;
mod style;

pub(crate) use decibels::in_palette;
pub(crate) use style::PALETTE;

use std::path::{Path, PathBuf};

use nailnoise_dynamics::CycleRecord;

pub(crate) use penetration::MOST as MOST_LAWS;
pub use penetration::penetration;

use crate::design::Values;
use crate::error::Error;
use crate::output;
use crate::run::Run;

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file, without extension.
    pub name: &'static str,
    /// The drawing.
    pub svg: String,
}

/// The figures of a nailing cycle: pressures, motion, pressure ratios, forces and energy flow. `subject` says what it is of.
pub fn cycle(subject: &str, design: &Values, record: &CycleRecord) -> Vec<Figure> {
    let shot = Shot::new(subject, design, record);
    vec![
        pressures::figure(&shot),
        motion::figure(&shot),
        ratios::figure(&shot),
        forces::figure(&shot),
        energy::figure(&shot),
    ]
}

/// The energy flow of a nailing cycle alone.
pub fn energy(subject: &str, design: &Values, record: &CycleRecord) -> Figure {
    energy::figure(&Shot::new(subject, design, record))
}

/// The figures of a run: third-octave levels of each source and of the exhaust's parts, levels between events, and sound
/// power over time. `subject` says what it is of.
pub fn sound(subject: &str, design: &Values, run: &Run) -> Vec<Figure> {
    let shot = Shot::new(subject, design, &run.record);
    let mut figures = vec![bands::sources(subject, &run.result)];
    figures.extend(bands::exhaust(subject, &run.result));
    figures.push(intervals::figure(subject, &run.result));
    figures.push(power::figure(&shot, &run.powers));
    figures
}

/// Writes figures to `folder` and returns their files.
///
/// # Errors
/// [`Error::Write`] with the file that could not be written.
pub fn write(folder: &Path, figures: &[Figure]) -> Result<Vec<PathBuf>, Error> {
    std::fs::create_dir_all(folder).map_err(|source| Error::Write {
        path: folder.to_owned(),
        source,
    })?;
    figures
        .iter()
        .map(|figure| {
            let path = folder.join(figure.name).with_extension("svg");
            output::write(&path, figure.svg.as_bytes())?;
            Ok(path)
        })
        .collect()
}

/// What the figures of a cycle share.
struct Shot<'a> {
    subject: &'a str,
    design: &'a Values,
    record: &'a CycleRecord,
    /// Times of the samples \[ms\].
    time: Vec<f64>,
}

impl<'a> Shot<'a> {
    fn new(subject: &'a str, design: &'a Values, record: &'a CycleRecord) -> Self {
        let time = (0..record.len()).map(|index| 1e3 * record.time(index)).collect();
        Self {
            subject,
            design,
            record,
            time,
        }
    }

    /// A figure of the whole shot.
    fn sheet<'s>(&'s self, title: &'static str, panels: Vec<sheet::Panel<'s>>) -> sheet::Sheet<'s> {
        let events = self.record.events.to_array();
        let marked = events
            .iter()
            .enumerate()
            .filter_map(|(index, time)| Some((1e3 * (*time)?, symbol(index))));
        let mut events: Vec<(f64, String)> = marked.collect();
        // In a published form t2 may come before t1.
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        sheet::Sheet {
            title,
            subject: self.subject.to_owned(),
            x_label: "Time (ms)",
            x_range: [0.0, self.time.last().copied().unwrap_or(1.0)],
            events,
            panels,
        }
    }

    /// A curve over time in colour `colour` of the palette.
    fn curve<'s>(&'s self, label: &str, colour: usize, y: impl Iterator<Item = f64>) -> sheet::Curve<'s> {
        let (label, colour) = (label.to_owned(), style::PALETTE[colour]);
        sheet::Curve {
            label,
            colour,
            x: &self.time,
            y: y.collect(),
            band: Vec::new(),
        }
    }
}

/// t with its number as subscript.
fn symbol(index: usize) -> String {
    let digit = |digit: char| char::from_u32(0x2080 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit);
    std::iter::once('t')
        .chain(index.to_string().chars().map(digit))
        .collect()
}
