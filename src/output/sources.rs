//! Sources in the columns of tables.

use crate::result::{RankedSource, RunResult};

/// Sources with dedicated places in tables.
const SOURCES: [&str; 3] = ["workpiece", "exhaust", "body"];

/// Name of the sum of all sources.
pub(super) const TOTAL: &str = "total";

/// The sources in an order that no level changes: workpiece, exhaust, body, then others by name.
pub(super) fn in_order(result: &RunResult) -> Vec<&RankedSource> {
    let place = |source: &&RankedSource| {
        let known = SOURCES.iter().position(|known| *known == source.source);
        (known.unwrap_or(SOURCES.len()), source.source.clone())
    };
    let mut sources: Vec<&RankedSource> = result.ranking.iter().collect();
    sources.sort_by_key(place);
    sources
}

/// Titles of a column of each quantity for each source and the total.
pub(super) fn titles<const N: usize>(sources: &[&RankedSource], quantities: [&str; N]) -> Vec<String> {
    let names = sources.iter().map(|source| source.source.as_str()).chain([TOTAL]);
    names
        .flat_map(|name| quantities.map(|quantity| format!("{name} {quantity}")))
        .collect()
}
