//! The shot of a design: figures of its cycle, and its levels.

use serde::{Serialize, Serializer};

use crate::chain;
use crate::design::Design;
use crate::error::Error;
use crate::result::TOTAL;
use crate::stages::levels::Levels;

/// The work that nail and wood take up \[J\], beside the figures of the cycle's summary.
pub(super) const DRIVE_ENERGY: &str = "drive_energy";

/// Figures of a shot that show what quieting costs: depth, work on nail and wood, air a shot.
pub(crate) const COSTS: [&str; 3] = ["penetration", DRIVE_ENERGY, "supply_mass"];

/// The shot of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shot {
    /// Name of the outcome.
    pub outcome: String,
    /// Name and value of each figure of the cycle \[SI\]; none for a phase that does not occur.
    #[serde(serialize_with = "as_object")]
    pub figures: Vec<(String, Option<f64>)>,
    /// Levels of the sources; none if the shot breaks a constraint.
    pub levels: Option<Levels>,
    /// Level of all sources together \[dB re 1 pW s\].
    pub total_db: Option<f64>,
}

fn as_object<S: Serializer>(figures: &[(String, Option<f64>)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(figures.iter().map(|(name, value)| (name, value)))
}

impl Shot {
    /// The cycle of a design, without levels.
    ///
    /// # Errors
    /// Those of the cycle.
    pub(super) fn of(design: &Design) -> Result<Self, Error> {
        let record = chain::cycle(design)?;
        let summary = serde_json::to_value(&record.summary).map_err(Error::Json)?;
        let figures = summary.as_object().into_iter().flatten();
        let figures = figures.map(|(name, value)| (name.clone(), value.as_f64()));
        let work = (DRIVE_ENERGY.to_owned(), Some(record.energy.penetration));
        Ok(Self {
            outcome: record.outcome.name().to_owned(),
            figures: figures.chain([work]).collect(),
            levels: None,
            total_db: None,
        })
    }

    /// A figure of the cycle \[SI\] or a level \[dB re 1 pW s\] by its name; none where it does not occur or is silent,
    /// or was not computed.
    pub fn figure(&self, name: &str) -> Option<f64> {
        if name == TOTAL {
            return self.total_db;
        }
        let of_source = self.levels.iter().flat_map(|levels| &levels.sources);
        let level = of_source.into_iter().find(|source| source.source == name);
        match level {
            Some(source) => source.lwa_db,
            None => self.figures.iter().find(|(own, _)| own == name)?.1,
        }
    }
}
