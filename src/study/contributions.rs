//! Inputs that determine each level of a study: the fraction of the variance that one input explains, and its effect on
//! the level.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::correlation_ratio::{Binned, Structures, Sums, Thirds, Unit, by_chance};
use super::draws::{Draw, Draws};
use super::level_table::{LevelTable, number, outputs};
use super::statistics::{Bootstrap, Estimate};

/// Minimum number of draws for an estimate of contributions.
pub(super) const FEWEST: usize = 40;

/// Inputs that determine a level.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Contributions {
    /// Source, `total`, or the difference of two sources.
    pub output: String,
    /// Variance over the draws \[dB2\].
    pub variance_db2: f64,
    /// First-order contribution that the largest of all shot inputs exceeds by chance in one of twenty cases; in one of
    /// forty if structures are drawn.
    pub by_chance: f64,
    /// First-order contribution that the largest of all structure inputs exceeds by chance in one of forty cases; null
    /// if structures are fixed or too few.
    #[serde(default)]
    pub by_chance_of_structures: Option<f64>,
    /// Inputs above the limit for their kind.
    pub inputs: Vec<Contribution>,
}

/// Contribution of an input.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Contribution {
    /// The variable.
    pub variable: String,
    /// Fraction of the variance that it explains alone \[-\].
    pub first_order: f64,
    /// 5th and 95th percentile of this fraction over resampled draws.
    #[serde(default)]
    pub first_order_interval: [Option<f64>; 2],
    /// Mean level of the draws in the upper third of its values, minus that in the lower third \[dB\].
    pub effect_db: f64,
    /// 5th and 95th percentile of this difference over resampled draws.
    #[serde(default)]
    pub effect_interval_db: [Option<f64>; 2],
}

impl Contribution {
    /// The fraction of the variance with its interval.
    pub fn part(&self) -> Estimate {
        Estimate {
            value: Some(self.first_order),
            interval: self.first_order_interval,
        }
    }

    /// The difference between the outer thirds with its interval \[dB\].
    pub fn effect(&self) -> Estimate {
        Estimate {
            value: Some(self.effect_db),
            interval: self.effect_interval_db,
        }
    }
}

/// An input that explains more than chance, before its interval is known.
struct Found<'a> {
    variable: usize,
    input: &'a Binned,
    first_order: f64,
    thirds: Thirds,
}

/// Contributions of inputs to the total, each source, and the difference of the two loudest; `names` are the sources in
/// their order. Empty if there are too few draws.
pub(super) fn contributions(
    made: &Draws,
    table: &LevelTable,
    names: &[String],
    bootstrap: &Bootstrap,
) -> Vec<Contributions> {
    let draws = made.draws.len();
    if draws < FEWEST {
        return Vec::new();
    }
    let column = |place: usize| -> Option<Vec<f64>> {
        let number = |draw: &Draw| number(made.variables[place].drawn(draw.shares[place]));
        made.draws.iter().map(number).collect()
    };
    let numbers: Vec<usize> = made.draws.iter().map(|draw| draw.structure).collect();
    let structures = Structures::new(&numbers, made.structures > 0);
    // Columns are computed again when needed, because they are long for many draws.
    let binned = |variable: usize| Some((variable, Binned::new(&column(variable)?, &structures)?));
    let inputs: Vec<(usize, Binned)> = (0..made.variables.len()).filter_map(binned).collect();
    let of_units = |unit: Unit| -> Vec<&Binned> {
        let own = inputs.iter().map(|(_, input)| input);
        own.filter(|input| input.unit == unit).collect()
    };
    let contribution = |(output, levels): (String, Vec<f64>)| {
        let sums_of = |counts: &[u32]| Unit::ALL.map(|unit| Sums::new(&levels, counts, &structures, unit));
        let once = vec![1; draws];
        let sums = sums_of(&once);
        let kinds = Unit::ALL.map(of_units);
        let limit = |unit: Unit| {
            let own = &kinds[unit as usize];
            let alone = own.len() == inputs.len();
            (!own.is_empty()).then(|| by_chance(own, &sums[unit as usize], alone))
        };
        let limits = Unit::ALL.map(limit);
        let found = inputs.iter().filter_map(|(variable, input)| {
            let first_order = input.first_order(&sums[input.unit as usize]);
            (first_order > limits[input.unit as usize]?).then_some(Found {
                variable: *variable,
                input,
                first_order,
                thirds: Thirds::new(&column(*variable)?),
            })
        });
        let mut found: Vec<Found<'_>> = found.collect();
        found.sort_by(|a, b| b.first_order.total_cmp(&a.first_order));
        // If no input is above its limit, no resamples are needed.
        let figures_of = |counts: &[u32]| {
            let sums = sums_of(counts);
            let figures = |own: &Found<'_>| {
                let part = own.input.resampled(&sums[own.input.unit as usize]);
                [part, own.thirds.effect(&levels, counts)]
            };
            found.iter().flat_map(figures).collect()
        };
        let intervals = if found.is_empty() {
            Vec::new()
        } else {
            bootstrap.intervals(figures_of)
        };
        let stated = found
            .iter()
            .zip(intervals.chunks(2))
            .map(|(own, intervals)| Contribution {
                variable: made.variables[own.variable].name.clone(),
                first_order: own.first_order,
                first_order_interval: intervals[0],
                effect_db: own.thirds.effect(&levels, &once),
                effect_interval_db: intervals[1],
            });
        let mean = levels.iter().sum::<f64>() / draws as f64;
        Contributions {
            output,
            variance_db2: levels.iter().map(|level| (level - mean).powi(2)).sum::<f64>() / (draws - 1) as f64,
            by_chance: limits[Unit::Draw as usize].unwrap_or_default(),
            by_chance_of_structures: limits[Unit::Structure as usize],
            inputs: stated.collect(),
        }
    };
    outputs(table, names).into_par_iter().map(contribution).collect()
}
