//! Sources in the columns of tables.

use crate::model::sources;
use crate::result::{RankedSource, RunResult, TOTAL};

/// The sources in an order independent of their levels: the order of their list, then others by name.
pub(super) fn in_order(result: &RunResult) -> Vec<&RankedSource> {
    let place = |source: &&RankedSource| {
        let known = sources::names().position(|known| known == source.source);
        (known.unwrap_or(usize::MAX), source.source.clone())
    };
    let mut ordered: Vec<&RankedSource> = result.ranking.iter().collect();
    ordered.sort_by_key(place);
    ordered
}

/// Column titles for each quantity of each source and of the total.
pub(super) fn titles<const N: usize>(sources: &[&RankedSource], quantities: [&str; N]) -> Vec<String> {
    let names = sources.iter().map(|source| source.source.as_str()).chain([TOTAL]);
    names
        .flat_map(|name| quantities.map(|quantity| format!("{name} {quantity}")))
        .collect()
}
