//! `loudness.csv`: loudness of each source at the operator's ear.

use super::table::{optional, table};
use super::{Output, RunView};
use crate::error::Error;

/// Loudness by ISO 532-1.
pub(super) const LOUDNESS: Output = Output::of_run("loudness.csv", rows);

/// A row for each source and for the total.
fn rows(of: &RunView<'_>) -> Result<Vec<u8>, Error> {
    let header = [
        "source",
        "station",
        "field",
        "N_max [sone]",
        "L_N of N_max [phon]",
        "time of N_max [s]",
    ];
    let rows = of.run.microphones.ear.loudness.iter().map(|own| {
        [
            own.source.clone(),
            "operator's ear".to_owned(),
            "free; frontal".to_owned(),
            optional(own.n_max_sone, 3),
            optional(own.level_phon, 2),
            optional(own.time_s, 3),
        ]
    });
    table(header, rows)
}
