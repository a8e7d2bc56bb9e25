//! `power.csv`: sound power of the sources over time.

use super::sources::{in_order, titles};
use super::table::{optional, table};
use super::{Output, RunView};
use crate::error::Error;
use crate::result::RankedSource;
use crate::stages::sound::SourceHistory;

/// Power over time.
pub(super) const POWER: Output = Output::of_run("power.csv", rows);

/// A-weighted sound power of every source and of the sum over time, averaged over the cell around each time, and
/// time-dependent quantities of the sources, such as the screech frequency of the exhaust jets.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let run = of.run;
    let sources = in_order(&run.result);
    let named = |source: &&RankedSource| run.powers.iter().find(|power| power.source == source.source);
    let powers: Vec<_> = sources.iter().filter_map(named).collect();
    let cells = powers.first().map_or(0, |power| power.history.power.len());
    let rows = (0..cells).map(|cell| {
        let first = &powers[0].history;
        let time = first.start + cell as f64 * first.sample_interval;
        let own = powers.iter().map(move |power| power.history.power[cell]);
        let total: f64 = own.clone().sum();
        let sample = (time >= 0.0).then(|| (time / run.record.sample_interval).round() as usize);
        let at_sample = move |own: &SourceHistory| sample.and_then(|sample| own.values.get(sample).copied().flatten());
        [format!("{time:.7}")]
            .into_iter()
            .chain(own.chain([total]).map(|power| format!("{power:.6e}")))
            .chain(run.histories.iter().map(move |own| optional(at_sample(own), 1)))
    });
    let titles = titles(&sources, ["W_A [W]"]);
    let header = ["time [s]".to_owned()].into_iter().chain(titles);
    let of_sources = run.histories.iter().map(|own| own.heading.clone());
    table(header.chain(of_sources), rows)
}
