//! The shot of a design: figures of its cycle, and its levels.

use serde::{Serialize, Serializer};

use crate::chain;
use crate::design::{Design, inputs};
use crate::error::Error;
use crate::result::{Performance, TOTAL};
use crate::stages::cycle::{AssembledCycle, ShotRecord, SummaryFigures};
use crate::stages::levels::Levels;

/// The work that nail and wood take up \[J\], in addition to the figures of the cycle's summary.
pub(super) const DRIVE_ENERGY: &str = "drive_energy";

/// Depth of the head \[m\], which the summary of a design's keys contains, and kinetic energy left at flush \[J\].
const HEAD_DEPTH: &str = "head_depth";
const FLUSH_ENERGY: &str = "flush_energy";

/// The shot of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shot {
    /// Name of the outcome.
    pub outcome: String,
    /// Name and value of each figure of the cycle \[SI\]; none for a phase that does not occur.
    #[serde(serialize_with = "as_object")]
    pub figures: Vec<(String, Option<f64>)>,
    /// Costs of noise reduction.
    pub performance: Performance,
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
        if let Some(cycle) = inputs::assembly::cycle(design)? {
            return Self::of_assembly(&cycle, design);
        }
        let record = chain::cycle(design)?;
        let performance = Performance::of(&record.figures, &inputs::cycle::parameters(design)?);
        let summary = serde_json::to_value(&record.figures.summary).map_err(Error::Json)?;
        let figures = summary.as_object().into_iter().flatten();
        let figures = figures.map(|(name, value)| (name.clone(), value.as_f64()));
        let energies = [
            (DRIVE_ENERGY.to_owned(), Some(record.figures.energy.penetration)),
            (FLUSH_ENERGY.to_owned(), performance.energy_left_j),
        ];
        Ok(Self {
            outcome: record.figures.outcome.name().to_owned(),
            figures: figures.chain(energies).collect(),
            performance,
            levels: None,
            total_db: None,
        })
    }

    /// The shot of an assembly, whose figures have the names of its blocks.
    fn of_assembly(cycle: &AssembledCycle, design: &Design) -> Result<Self, Error> {
        let record = cycle.record()?;
        let performance = Performance::of_assembly(&record, &cycle.assembly, &design.ambient);
        let shot = ShotRecord::of_assembly(&cycle.assembly, record);
        let of_fastener = [
            (HEAD_DEPTH.to_owned(), performance.head_depth_m),
            (FLUSH_ENERGY.to_owned(), performance.energy_left_j),
        ];
        let figures = match shot.figures {
            SummaryFigures::Assembly(own) => own,
            SummaryFigures::Keys(_) => Default::default(),
        };
        let figures = figures.into_iter().map(|(name, value)| (name, Some(value)));
        Ok(Self {
            outcome: shot.outcome,
            figures: figures.chain(of_fastener).collect(),
            performance,
            levels: None,
            total_db: None,
        })
    }

    /// A figure of the cycle \[SI\] or a level \[dB re 1 pW s\] by its name; none if it does not occur, is silent, or
    /// was not computed.
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
