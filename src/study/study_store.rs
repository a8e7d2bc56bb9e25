//! Studies stored for `nailnoise run`, in the user's store.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::draw_table::DrawTable;
use super::draws::{Draws, code_of_levels};
use super::population::{Difference, Population};
use super::result::StudyResult;
use super::weighted::reweighted;
use crate::design::Design;
use crate::error::Error;
use crate::graph::program_key;
use crate::result::Weighting;
use crate::stages::{Digest, Postcard};
use crate::store::Store;

/// Its name in the store.
const STUDY: &str = "study";

/// Version of the layout of the stored data.
const LAYOUT: &str = "2";

/// Maximum number of stored studies; older ones are removed.
const MOST: usize = 16;

/// A study in the store.
#[derive(Serialize, Deserialize)]
struct StoredStudy {
    population: Population,
    result: StudyResult,
    draws: DrawTable,
}

/// A study that applies to a design.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its results.
    pub result: StudyResult,
    /// Weighting of the draws of another study; `None` if they are from this population.
    pub weighting: Option<Weighting>,
    /// Decreases of the total if one source is silent, like `DrawTable::silencing`; empty for weighted draws.
    pub silencing: BTreeMap<String, [f64; 2]>,
    /// Its draws; empty for weighted ones.
    pub draws: DrawTable,
}

impl Found {
    /// Results of a study for a design; `None` if it does not apply to it.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub(super) fn of(
        design: &Design,
        population: &Population,
        result: &StudyResult,
        draws: &DrawTable,
    ) -> Result<Option<Self>, Error> {
        Ok(match population.difference(design)? {
            Difference::Other => None,
            Difference::None => Some(Self {
                result: result.clone(),
                weighting: None,
                silencing: draws.silencing(),
                draws: draws.clone(),
            }),
            Difference::Distributions(pairs) => reweighted(result, draws, &pairs).map(|(result, weighting)| Self {
                result,
                weighting: Some(weighting),
                silencing: BTreeMap::new(),
                draws: DrawTable::default(),
            }),
        })
    }

    /// Order of preference: a study with drawn structures, then one with more draws; with few draws, one of the same
    /// population.
    pub fn size(&self) -> (bool, usize) {
        size(&self.result)
    }
}

fn all(store: &Store) -> (Digest, Vec<StoredStudy>) {
    let key = program_key().with(&LAYOUT).with(&code_of_levels()).digest();
    let stored = store
        .load::<Vec<StoredStudy>, Postcard>(STUDY, &key)
        .unwrap_or_default();
    (key, stored)
}

fn size(study: &StudyResult) -> (bool, usize) {
    (study.structures > 0, study.draws)
}

/// The largest study in the store that applies to a design and was made by the current code.
///
/// # Errors
/// If a design cannot be digested.
pub fn stored_study(store: &Store, design: &Design) -> Result<Option<Found>, Error> {
    let mut largest: Option<Found> = None;
    for own in all(store).1 {
        if let Some(found) = Found::of(design, &own.population, &own.result, &own.draws)?
            && largest.as_ref().is_none_or(|known| known.size() < found.size())
        {
            largest = Some(found);
        }
    }
    Ok(largest)
}

/// Stores a study, unless one of the same population with drawn structures or more draws is stored.
///
/// # Errors
/// If a design cannot be digested.
pub fn store_study(store: &Store, design: &Design, result: &StudyResult, made: &Draws) -> Result<(), Error> {
    let (key, mut stored) = all(store);
    let population = Population::of(design, result)?;
    let known = stored.iter().position(|own| own.population == population);
    if let Some(known) = known {
        if size(&stored[known].result) > size(result) {
            return Ok(());
        }
        stored.remove(known);
    }
    stored.insert(
        0,
        StoredStudy {
            population,
            result: result.clone(),
            draws: DrawTable::of(made),
        },
    );
    stored.truncate(MOST);
    store.save::<_, Postcard>(STUDY, &key, &stored);
    Ok(())
}
