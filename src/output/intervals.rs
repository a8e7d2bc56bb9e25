//! `intervals.csv`: levels of the sources between adjacent events.

use nailnoise_acoustics::signals::energy_level;

use super::sources::{in_order, titles};
use super::table::{level, table};
use super::{Output, RunView};
use crate::error::Error;
use crate::result::IntervalLevel;

/// Levels between events.
pub(super) const INTERVALS: Output = Output::of_run("intervals.csv", rows);

/// For each source and the sum of all: the energy-additive level, and the level of the signal cut at the events.
/// Silence gives an empty field.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let sources = in_order(&of.run.result);
    let header = ["from", "to", "from [s]", "to [s]"].map(str::to_owned);
    let intervals = sources.first().map_or(&[][..], |source| &source.intervals);
    let rows = intervals.iter().enumerate().map(|(index, interval)| {
        let times = [interval.from_s, interval.to_s].map(|time| format!("{time:.7}"));
        let own: Vec<&IntervalLevel> = sources
            .iter()
            .filter_map(|source| source.intervals.get(index))
            .collect();
        let sums = [0, 1].map(|cut| own.iter().map(|interval| interval.energies()[cut]).sum());
        let levels = own.iter().flat_map(|interval| [interval.lwa_db, interval.lwa_cut_db]);
        let levels: Vec<String> = levels.chain(sums.map(energy_level)).map(level).collect();
        [interval.from.clone(), interval.to.clone()]
            .into_iter()
            .chain(times)
            .chain(levels)
    });
    let titles = titles(&sources, ["L_WA [dB]", "L_WA cut [dB]"]);
    table(header.into_iter().chain(titles), rows)
}
