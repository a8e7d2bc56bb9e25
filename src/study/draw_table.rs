//! The stored record of a study's draws: their levels, and the position of each quantity in its distribution, so that
//! the draws can be weighted for another design.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::draws::Draws;
use super::level_table::LevelTable;
use super::statistics::{benefit, quantile};
use super::tolerance::STATED_FROM;
use super::variables::VariableKind;
use crate::result::TOTAL;

/// Maximum number of stored draws.
const MOST: usize = 4096;

/// Reciprocal of the rounding unit of levels \[1/dB\].
const DECIMALS: f64 = 100.0;

/// Number of parts of a distribution to which a position is rounded: three hexadecimal digits.
const PARTS: f64 = 4096.0;
const DIGITS: usize = 3;

/// Levels and positions of the draws.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DrawTable {
    /// Level of each source and of the total in each draw, including the errors of methods \[dB re 1 pW s\]; null for
    /// silence.
    pub levels_db: BTreeMap<String, Vec<Option<f64>>>,
    /// Position of each drawn key in its distribution for each draw: three hexadecimal digits, 0 to 4095 of 4096 parts.
    pub places: BTreeMap<String, String>,
}

impl DrawTable {
    /// The table of these draws.
    pub(super) fn of(made: &Draws) -> Self {
        let draws = &made.draws[..made.draws.len().min(MOST)];
        let table = LevelTable::new(draws);
        let rounded = |level: f64| level.is_finite().then(|| (DECIMALS * level).round() / DECIMALS);
        let column = |levels: Vec<f64>| levels.into_iter().map(rounded).collect();
        let sources = table.names.iter().enumerate();
        let mut levels_db: BTreeMap<String, Vec<Option<f64>>> = sources
            .map(|(place, name)| (name.clone(), column(table.column(place))))
            .collect();
        levels_db.insert(TOTAL.to_owned(), column(table.totals()));
        let places = made.variables.iter().enumerate().filter_map(|(place, variable)| {
            let shares = || draws.iter().map(|draw| draw.shares[place]);
            let is_drawn = matches!(variable.kind, VariableKind::Quantity(_)) && shares().all(|share| !share.is_nan());
            let digits = |share: f64| format!("{:03x}", (PARTS * share).clamp(0.0, PARTS - 1.0) as u16);
            is_drawn.then(|| (variable.name.clone(), shares().map(digits).collect()))
        });
        Self {
            levels_db,
            places: places.collect(),
        }
    }

    /// 5th and 95th percentile of the decrease of the total when one source is silent, for each source \[dB\]. For
    /// fewer draws than [`STATED_FROM`], the smallest and the largest decrease. Empty if any draw is completely silent.
    pub(super) fn silencing(&self) -> BTreeMap<String, [f64; 2]> {
        let ends = if self.len() < STATED_FROM {
            [0.0, 1.0]
        } else {
            [0.05, 0.95]
        };
        let sources = || self.levels_db.iter().filter(|(name, _)| *name != TOTAL);
        let silent = |level: &Option<f64>| level.unwrap_or(f64::NEG_INFINITY);
        let of_draw = |draw: usize| sources().map(|(_, levels)| silent(&levels[draw])).collect();
        let levels: Vec<Vec<f64>> = (0..self.len()).map(of_draw).collect();
        let falls = sources().enumerate().map(|(place, (name, _))| {
            let mut falls: Vec<f64> = levels.iter().map(|levels| benefit(levels, place)).collect();
            falls.sort_by(f64::total_cmp);
            (name.clone(), ends.map(|end| quantile(&falls, end)))
        });
        falls
            .filter(|(_, ends)| ends.iter().all(|end| end.is_finite()))
            .collect()
    }

    /// Whether its first draws equal those of another table: the same positions, and levels that differ by at most one
    /// unit in the last decimal.
    pub(super) fn begins_with(&self, other: &Self) -> bool {
        let count = other.len();
        let near = |(own, other): (&Option<f64>, &Option<f64>)| match (own, other) {
            (Some(own), Some(other)) => (own - other).abs() < 1.5 / DECIMALS,
            (own, other) => own == other,
        };
        let levels = |(name, other): (&String, &Vec<Option<f64>>)| {
            let own = self.levels_db.get(name);
            own.is_some_and(|own| own.len() >= count && own.iter().zip(other).all(near))
        };
        let places = |(key, other): (&String, &String)| self.places.get(key).is_some_and(|own| own.starts_with(other));
        count > 0
            && self.levels_db.len() == other.levels_db.len()
            && self.places.len() == other.places.len()
            && other.levels_db.iter().all(levels)
            && other.places.iter().all(places)
    }

    /// Number of draws.
    pub fn len(&self) -> usize {
        self.levels_db.get(TOTAL).map_or(0, Vec::len)
    }

    /// Whether there are no draws.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Quantile of a key's value in each draw; `None` for a key that is not drawn.
    pub(super) fn shares(&self, key: &str) -> Option<Vec<f64>> {
        let digits = self.places.get(key)?;
        let share = |place: usize| {
            let own = digits.get(DIGITS * place..DIGITS * (place + 1))?;
            Some((f64::from(u16::from_str_radix(own, 16).ok()?) + 0.5) / PARTS)
        };
        (0..self.len()).map(share).collect()
    }

    /// Level of a source or of the total in each draw; minus infinity for silence.
    pub(super) fn levels(&self, name: &str) -> Option<Vec<f64>> {
        let own = self.levels_db.get(name)?.iter();
        Some(own.map(|level| level.unwrap_or(f64::NEG_INFINITY)).collect())
    }
}
