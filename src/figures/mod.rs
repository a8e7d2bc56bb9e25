//! Charts of a run: [`cycle`] shows a nailing cycle, [`sound`] the levels of a run, [`penetration()`] compares
//! penetration laws. Curves, bars and ticks are the same on a page and in a file: [`Chart::svg`] lays them out in
//! millimetres for print, the report on its page.
//!
//! Time is in ms from the trigger; every chart over time shows the events t0 to t18.

mod calibration;
mod chart;
mod cycle;
mod energy;
mod fitted;
mod levels;
mod measurement;
mod network;
mod optimisation;
mod palette;
pub(crate) mod path;
mod penetration;
mod study;
mod svg;
pub(crate) mod ticks;
mod units;

use std::path::{Path, PathBuf};

use crate::atomic_write::AtomicWrite;
use crate::design::Values;
use crate::error::Error;
use crate::run::Run;
use crate::stages::cycle::ShotRecord;

pub use calibration::calibration;
pub use chart::{Axis, Chart, Event, Panel, Series, Shape};
pub(crate) use chart::{subscripts, symbol};
pub use cycle::cycle;
pub use energy::energy;
pub use fitted::{fit, residuals};
pub(crate) use levels::{from_event, in_palette, motion};
pub use levels::{levels, power};
pub use measurement::measurement;
pub use network::network;
pub use optimisation::optimisation;
pub(crate) use palette::{BLACK, PALETTE, hexadecimal, of_design};
pub(crate) use penetration::MOST as MOST_LAWS;
pub use penetration::penetration;
pub use study::{scatter, study, sweep};
pub use units::in_units;

/// The charts of a shot's cycle; those of the tool of the keys end with [`energy()`].
pub fn shot(subject: &str, design: &Values, shot: &ShotRecord) -> Vec<Chart> {
    match shot.of_nailer() {
        Some(own) => cycle(subject, design, own),
        None => network(subject, &shot.record),
    }
}

/// The charts of a run: [`levels`] and [`power`]. `subject` names the design.
pub fn sound(subject: &str, run: &Run) -> Vec<Chart> {
    let mut charts = levels(subject, &run.result);
    charts.push(power(subject, &run.record, &run.powers));
    charts
}

/// Writes charts as SVG to the folder `folder` of an [`AtomicWrite`] and returns their files.
///
/// # Errors
/// [`Error::Write`] with the file that could not be written.
pub fn write(staging: &AtomicWrite, folder: &Path, charts: &[Chart]) -> Result<Vec<PathBuf>, Error> {
    let file = |chart: &Chart| {
        let path = folder.join(&chart.name).with_extension("svg");
        staging.write(&path, chart.svg().as_bytes())?;
        Ok(path)
    };
    charts.iter().map(file).collect()
}
