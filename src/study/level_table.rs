//! Levels of the draws as a table: one row per draw, one column per source.

use super::draws::{Draw, Draws};
use super::variables::{Drawn, Variable};
use crate::decibels::energy_sum;
use crate::design::Value;
use crate::result::TOTAL;
use crate::stages::levels::Levels;

/// Levels of all draws including the errors of methods; minus infinity for silence.
pub(super) struct LevelTable {
    pub(super) names: Vec<String>,
    pub(super) levels: Vec<Vec<f64>>,
}

impl LevelTable {
    pub(super) fn new(draws: &[Draw]) -> Self {
        let names = draws.first().map_or_else(Vec::new, |draw| {
            draw.levels.sources.iter().map(|source| source.source.clone()).collect()
        });
        let levels = |draw: &Draw| {
            let sources = draw.levels.sources.iter().zip(&draw.method_db);
            sources
                .map(|(source, error)| source.lwa_db.map_or(f64::NEG_INFINITY, |level| level + error))
                .collect()
        };
        Self {
            names,
            levels: draws.iter().map(levels).collect(),
        }
    }

    /// Index of a source in the rows; the first for a name that is not a source.
    pub(super) fn place(&self, source: &str) -> usize {
        self.names.iter().position(|own| own == source).unwrap_or(0)
    }

    /// Levels of the source with an index in each draw.
    pub(super) fn column(&self, place: usize) -> Vec<f64> {
        self.levels.iter().map(|levels| levels[place]).collect()
    }

    /// Levels of the sum of all sources in each draw.
    pub(super) fn totals(&self) -> Vec<f64> {
        self.levels
            .iter()
            .map(|levels| energy_sum(levels.iter().copied()))
            .collect()
    }
}

/// Level of the sum of all sources of a shot \[dB re 1 pW s\]; `None` if all are silent.
pub(crate) fn total_of(levels: &Levels) -> Option<f64> {
    let sources = levels.sources.iter();
    let total = energy_sum(sources.map(|source| source.lwa_db.unwrap_or(f64::NEG_INFINITY)));
    total.is_finite().then_some(total)
}

/// Levels of the total, each source, and the difference of the two loudest in each draw \[dB\], if none is silent;
/// `names` are the sources in their order.
pub(super) fn outputs(table: &LevelTable, names: &[String]) -> Vec<(String, Vec<f64>)> {
    let of = |name: &String| table.column(table.place(name));
    let mut outputs: Vec<(String, Vec<f64>)> = vec![(TOTAL.to_owned(), table.totals())];
    outputs.extend(names.iter().map(|name| (name.clone(), of(name))));
    if let [first, second, ..] = names {
        let difference = of(first).iter().zip(of(second)).map(|(a, b)| a - b).collect();
        outputs.push((format!("{first} less {second}"), difference));
    }
    outputs.retain(|(_, levels)| levels.iter().all(|level| level.is_finite()));
    outputs
}

/// A number for the value of a variable in a draw.
pub(super) fn number(drawn: Option<Drawn>) -> Option<f64> {
    match drawn? {
        Drawn::Value(Value::Number(value)) => Some(value),
        Drawn::Value(Value::Count(count)) => Some(f64::from(count)),
        Drawn::Value(_) => None,
        Drawn::Alternative(chosen) => Some(chosen as f64),
        Drawn::Share(share) => Some(share),
    }
}

/// Value of a variable at a share of its distribution, as a number; none for a word, or outside 0 < share < 1.
pub fn value_at(variable: &Variable, share: f64) -> Option<f64> {
    (share > 0.0 && share < 1.0)
        .then(|| number(variable.drawn(share)))
        .flatten()
}

/// Value of a variable in each draw, as a number; NaN if it is fixed.
pub fn column(made: &Draws, variable: &str) -> Vec<f64> {
    let own = made.variables.iter().enumerate().find(|(_, own)| own.name == variable);
    let drawn = |draw: &Draw| own.and_then(|(place, variable)| variable.drawn(draw.shares[place]));
    made.draws
        .iter()
        .map(|draw| number(drawn(draw)).unwrap_or(f64::NAN))
        .collect()
}

/// The levels of an output in each draw \[dB\]: of a source, of the total, or of a difference `A less B`.
pub fn levels_of(made: &Draws, output: &str) -> Vec<f64> {
    let table = LevelTable::new(&made.draws);
    let of = |name: &str| match name {
        TOTAL => table.totals(),
        source => table.column(table.place(source)),
    };
    match output.split_once(" less ") {
        Some((a, b)) => of(a).iter().zip(of(b)).map(|(a, b)| a - b).collect(),
        None => of(output),
    }
}
