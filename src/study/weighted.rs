//! The study of a design from the draws of another one, each with its weight (`population.rs`).

use super::draw_table::DrawTable;
use super::population::{Marginal, effective, weight};
use super::result::{LevelStudy, OrderProbability, SourceStudy, StudyResult};
use super::statistics::{Bootstrap, Estimate, Quantiles, order, weighted_quantiles};
use super::tolerance::STATED_FROM;
use crate::result::{TOTAL, Weighting};

/// The levels of a design from the draws of a study, if the distributions of some quantities differ: that of the study,
/// and that of the design. `None` if there are too few effective draws, or if they are on several structures.
pub(super) fn reweighted(
    study: &StudyResult,
    table: &DrawTable,
    pairs: &[(Marginal, Marginal)],
) -> Option<(StudyResult, Weighting)> {
    if study.structures > 0 || table.is_empty() {
        return None;
    }
    let values: Vec<Vec<f64>> = pairs
        .iter()
        .map(|(own, _)| Some(table.shares(&own.key)?.iter().map(|share| own.at(*share)).collect()))
        .collect::<Option<_>>()?;
    let of_draw = |draw: usize| weight(pairs.iter().zip(values.iter().map(|values| values[draw])));
    let weights: Vec<f64> = (0..table.len()).map(of_draw).collect();
    let effective = effective(&weights);
    if effective < STATED_FROM as f64 {
        return None;
    }
    let names: Vec<&str> = study.sources.iter().map(|own| own.source.as_str()).collect();
    let columns: Vec<Vec<f64>> = names.iter().map(|name| table.levels(name)).collect::<Option<_>>()?;
    let totals = table.levels(TOTAL)?;
    let orders: Vec<Vec<usize>> = (0..table.len())
        .map(|draw| order(&columns.iter().map(|column| column[draw]).collect::<Vec<_>>()))
        .collect();
    let by_weight = Weighted {
        bootstrap: Bootstrap::new(&vec![0; table.len()]),
        weights: &weights,
    };
    let mut result = study.clone();
    result.draws = effective.floor() as usize;
    for (place, own) in result.sources.iter_mut().enumerate() {
        *own = SourceStudy {
            source: own.source.clone(),
            level: by_weight.level(&columns[place]),
            first: by_weight.share(|draw| orders[draw][0] == place),
            loss_db: NOT_STATED,
            silencing_db: NOT_STATED,
            bands: Vec::new(),
            intervals: Vec::new(),
        };
    }
    result.total = by_weight.level(&totals);
    let mut found: Vec<Vec<usize>> = Vec::new();
    for own in &orders {
        if !found.contains(own) {
            found.push(own.clone());
        }
    }
    let probability = |places: Vec<usize>| OrderProbability {
        probability: by_weight.share(|draw| orders[draw] == places),
        order: places.iter().map(|&place| names[place].to_owned()).collect(),
    };
    result.orders = found.into_iter().map(probability).collect();
    let value = |own: &OrderProbability| own.probability.value.unwrap_or_default();
    result.orders.retain(|own| value(own) > 0.0);
    result.orders.sort_by(|a, b| value(b).total_cmp(&value(a)));
    result.louder.clear();
    result.perfect_information_db = NOT_STATED;
    result.contributions.clear();
    (result.condition, result.groups, result.one_at_a_time) = (None, None, None);
    result.surrogates.clear();
    result.convergence.clear();
    let weighting = Weighting {
        draws: table.len(),
        effective,
        keys: pairs.iter().map(|(own, _)| own.key.clone()).collect(),
    };
    Some((result, weighting))
}

const NOT_STATED: Estimate = Estimate {
    value: None,
    interval: [None, None],
};

/// Statistics of weighted draws.
struct Weighted<'a> {
    bootstrap: Bootstrap,
    weights: &'a [f64],
}

impl Weighted<'_> {
    /// Weights of a resample.
    fn counted(&self, counts: &[u32]) -> Vec<f64> {
        counts
            .iter()
            .zip(self.weights)
            .map(|(&count, weight)| f64::from(count) * weight)
            .collect()
    }

    fn share(&self, is_so: impl Fn(usize) -> bool) -> Estimate {
        let is_so: Vec<bool> = (0..self.weights.len()).map(is_so).collect();
        self.bootstrap.estimate(|counts| {
            let counted = self.counted(counts);
            // The sum of no numbers is -0.
            let so = counted
                .iter()
                .zip(&is_so)
                .filter(|(_, so)| **so)
                .map(|(weight, _)| weight);
            (0.0 + so.sum::<f64>()) / counted.iter().sum::<f64>()
        })
    }

    fn level(&self, levels: &[f64]) -> LevelStudy {
        let quantile = |p: f64| {
            let of = |counts: &[u32]| weighted_quantiles(levels, &self.counted(counts), p);
            self.bootstrap.estimate(of)
        };
        let seen = levels.iter().zip(self.weights).filter(|(_, weight)| **weight > 0.0);
        let seen = seen.map(|(level, _)| *level);
        let ends = [
            seen.clone().fold(f64::INFINITY, f64::min),
            seen.fold(f64::NEG_INFINITY, f64::max),
        ];
        LevelStudy {
            nominal_db: None,
            below_nominal: None,
            extremes_db: ends.map(|end| end.is_finite().then_some(end)),
            level_db: Quantiles {
                p05: quantile(0.05),
                p50: quantile(0.5),
                p95: quantile(0.95),
            },
        }
    }
}
