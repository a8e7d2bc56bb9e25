//! Intervals of the levels of designs that studies serve, side by side.

use super::Comparison;
use crate::result::Ends;
use crate::study::legend;
use crate::table::Table;

impl Comparison {
    /// Interval and P(first) of each source in each design; none if no study serves any of them.
    pub(crate) fn intervals(&self) -> Option<Table> {
        self.studies.iter().flatten().next()?;
        let named = || self.designs.iter().zip(&self.studies);
        let headings = named().flat_map(|(name, study)| {
            let first = study.as_ref().map_or_else(String::new, |study| {
                let [_, first] = legend::headings(study);
                first
            });
            [format!("{name} dB"), first]
        });
        let sources = self.sources.iter().map(|row| row.source.as_str()).chain(["total"]);
        let row = |source: &str| {
            let cells = self.studies.iter().flat_map(|study| match study {
                Some(study) => legend::cells(study, source),
                None => ["-".to_owned(), String::new()],
            });
            std::iter::once(source.to_owned()).chain(cells).collect()
        };
        let basis = named().map(|(name, study)| match study {
            None => format!("{name}: no study serves it, or its result states none"),
            Some(study) => {
                let ends = match study.ends {
                    Ends::Percentiles => "P5 to P95",
                    Ends::Extremes => "lowest to highest level",
                };
                format!("{name}: {ends} of {} draws", study.draws)
            }
        });
        let sharing = "designs share most of their errors, so that a change is more certain than the levels: \
                       `--draws` states its interval";
        Some(Table {
            headings: std::iter::once("source".to_owned()).chain(headings).collect(),
            rows: sources.map(row).collect(),
            legend: basis.chain([sharing.to_owned()]).collect(),
        })
    }
}
