//! `blow.csv`: forces of elastic blows, as waves in driver and fastener.

use nailnoise_dynamics::blow::{Blow, BlowInput, Course, elastic_blow};

use super::table::numbers;
use super::{Output, RunView};
use crate::chain::engine;
use crate::design::inputs::response::blows;
use crate::error::Error;

/// Forces of the blows.
pub(super) const BLOWS: Output = Output::of_run("blow.csv", rows).only_if(exist);

fn exist(of: &RunView<'_>) -> bool {
    engine(of.design)
        .and_then(|engine| blows(of.design, &engine))
        .is_ok_and(|blows| !blows.is_empty())
}

/// Time, and for each fastener the forces on the wood and between driver and fastener. Those in the bars are means over
/// the interval around each sample; those in the cycle are both the force of a rigid fastener. The samples are at the
/// interval of the cycle, from the first strike to the end of the last blow.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let blows = blows(of.design, &engine(of.design)?)?;
    let blows = blows.iter().filter_map(|input| {
        let course = Course::of_record(input, &of.run.record.record)?;
        Some((input, elastic_blow(input, &course)?, course.resistance))
    });
    let blows: Vec<(&BlowInput, Blow, &[f64])> = blows.collect();
    let first = blows.iter().map(|(_, blow, _)| blow.samples[0]).min().unwrap_or(0);
    let end = blows.iter().map(|(_, blow, _)| blow.samples[1] + 1).max().unwrap_or(0);
    let titles = blows.iter().flat_map(|(input, ..)| {
        let name = &input.fastener.name;
        ["on the wood", "on the wood (rigid)", "of the driver"].map(|force| format!("{name}: force {force} [N]"))
    });
    let columns: Vec<&[f64]> = blows
        .iter()
        .flat_map(|(_, blow, rigid)| {
            [
                &blow.on_wood[first..end],
                &rigid[first..end],
                &blow.rod_on_nail[first..end],
            ]
        })
        .collect();
    let interval = of.run.record.sample_interval;
    numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|index| (first + index) as f64 * interval, 7),
        (&columns, 6),
        1,
    )
}
