//! `ranking.csv`: the sources with their levels and intervals.

use super::table::{level, optional, table};
use super::{Output, RunView};
use crate::error::Error;
use crate::result::TOTAL;

/// The ranking of the sources.
pub(super) const RANKING: Output = Output::of_study("ranking.csv", rows);

/// The sources, loudest first, and the total; without a study, its columns are empty.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let result = &of.run.result;
    let over_draws = |source: &str| {
        let study = result.study.known();
        let spread = study.map(|study| study.spread(source));
        [
            level(spread.and_then(|own| own.low_db)),
            level(spread.and_then(|own| own.high_db)),
            optional(spread.and_then(|own| own.first), 4),
            study.map_or_else(String::new, |study| study.draws.to_string()),
            level(spread.and_then(|own| own.silencing_db).map(|ends| ends[0])),
            level(spread.and_then(|own| own.silencing_db).map(|ends| ends[1])),
            result.declaration.k_db.map_or_else(String::new, |k| k.to_string()),
            result.outcome.clone(),
        ]
    };
    let sources = result.ranking.iter().map(|source| {
        let own = [
            source.source.clone(),
            level(source.lwa_db),
            level(source.lw_db),
            format!("{:.6}", source.share),
            source.method.replace(", ", "; ").replace(',', ";"),
        ];
        own.into_iter().chain(over_draws(&source.source))
    });
    let total = [
        TOTAL.to_owned(),
        level(result.total.lwa_db),
        level(result.total.lw_db),
        String::new(),
        String::new(),
    ];
    let header = [
        "source",
        "L_WA [dB]",
        "L_W [dB]",
        "share of A-weighted energy [-]",
        "method",
        "interval low L_WA [dB]",
        "interval high L_WA [dB]",
        "P(first) [-]",
        "draws",
        "fall of the total without it low [dB]",
        "fall of the total without it high [dB]",
        "K [dB]",
        "outcome",
    ];
    table(header, sources.chain([total.into_iter().chain(over_draws(TOTAL))]))
}
