//! The draws of a study that applies to a design, as values of its keys and levels of its sources.

use super::draw_table::DrawTable;
use super::parameters::Parameter;
use super::provided::ProvidedStudy;
use super::study_store::stored_study;
use super::tolerance::STATED_FROM;
use crate::design::{Design, Value};
use crate::error::Error;
use crate::result::TOTAL;
use crate::store::Store;

/// Draws of a known study.
#[derive(Debug, Clone)]
pub struct DrawsAtHand {
    /// Level of all sources together in each draw \[dB re 1 pW s\].
    pub total: Vec<f64>,
    /// Name of each source, and its level in each draw \[dB re 1 pW s\]; minus infinity for silence.
    pub sources: Vec<(String, Vec<f64>)>,
    /// Keys that were drawn.
    pub keys: Vec<DrawnKey>,
}

/// A key in the draws of a known study.
#[derive(Debug, Clone)]
pub struct DrawnKey {
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Its value in each draw.
    pub values: Vec<f64>,
}

impl DrawsAtHand {
    /// The draws of the largest study that applies to a design, in the store or in the program. There are none without
    /// a study, if the draws have to be weighted, or if they are too few for percentiles.
    ///
    /// # Errors
    /// If a design cannot be digested, or a provided study does not follow its layout.
    pub fn of(store: &Store, design: &Design) -> Result<Option<Self>, Error> {
        let stored = stored_study(store, design)?;
        let provided = ProvidedStudy::of(design)?.map(|own| own.found);
        let found = match (stored, provided) {
            (Some(stored), Some(provided)) if stored.size() < provided.size() => Some(provided),
            (stored, provided) => stored.or(provided),
        };
        Ok(found
            .filter(|own| own.draws.len() >= STATED_FROM)
            .and_then(|own| Self::of_table(design, &own.draws)))
    }

    fn of_table(design: &Design, draws: &DrawTable) -> Option<Self> {
        let sources = draws.levels_db.keys().filter(|name| *name != TOTAL);
        let sources = sources.map(|name| Some((name.clone(), draws.levels(name)?)));
        let keys = Parameter::all(design).into_iter().filter_map(|(own, _)| {
            let values = draws.shares(&own.key)?.into_iter().map(|share| match own.at(share) {
                Value::Number(value) => value,
                Value::Count(count) => f64::from(count),
                _ => f64::NAN,
            });
            Some(DrawnKey {
                values: values.collect(),
                name: own.key.clone(),
                unit: own.unit.clone(),
            })
        });
        Some(Self {
            total: draws.levels(TOTAL)?,
            sources: sources.collect::<Option<_>>()?,
            keys: keys.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn values_of_a_provided_study_lie_in_the_ranges_of_the_design() {
        let design = Design::shipped("n80cb.toml").unwrap();
        let draws = DrawsAtHand::of(&Store::none(), &design).unwrap().unwrap();
        let entries = design.entries();
        assert!(draws.keys.len() > 40 && draws.sources.len() == 3);
        for key in &draws.keys {
            assert_eq!(key.values.len(), draws.total.len());
            let Some([low, high]) = entries.iter().find(|own| own.key == key.name).and_then(|own| own.range) else {
                continue;
            };
            let outside = key.values.iter().filter(|own| !(low..=high).contains(*own)).count();
            // Normal distributions extend beyond their range, which contains 95 % of them.
            assert!(outside * 8 < key.values.len(), "{}: {outside}", key.name);
        }
        for draw in 0..draws.total.len() {
            let loudest = draws
                .sources
                .iter()
                .map(|(_, own)| own[draw])
                .fold(f64::NEG_INFINITY, f64::max);
            assert!((-0.01..5.0).contains(&(draws.total[draw] - loudest)));
        }
    }
}
