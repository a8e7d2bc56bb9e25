//! `transducers*`: histories of the pressure transducers.

use nailnoise_meshes::uff::{History, Ordinate};

use super::sensors::title;
use super::table::{numbers, stride};
use super::{Output, RunView};
use crate::error::Error;

/// Pressures over time.
pub(super) const HISTORIES: Output = Output::of_run("transducers.csv", histories).only_if(exist);

/// All samples in binary form, for modal-test software.
pub(super) const UNIVERSAL: Output = Output::of_run("transducers.uff", universal).only_if(exist);

fn exist(of: &RunView<'_>) -> bool {
    !of.run.transducers.is_empty()
}

fn histories(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let transducers = &of.run.transducers;
    let interval = transducers.first().map_or(1.0, |first| first.interval);
    let titles = transducers
        .iter()
        .map(|own| title(&own.name, own.chamber.as_str()) + " [Pa]");
    let columns: Vec<&[f64]> = transducers.iter().map(|own| own.values.as_slice()).collect();
    numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|sample| sample as f64 * interval, 7),
        (&columns, 6),
        stride(interval, of.exports),
    )
}

fn universal(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let mut uff = Vec::new();
    for (index, own) in of.run.transducers.iter().enumerate() {
        History {
            title: &title(&own.name, own.chamber.as_str()),
            origin: &format!("nailnoise design {}", of.run.result.design.digest),
            sensor: &own.name,
            node: index + 1,
            ordinate: Ordinate::Pressure,
            interval: own.interval,
            values: &own.values,
        }
        .write_binary(&mut uff);
    }
    Ok(uff)
}
