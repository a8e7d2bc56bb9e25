//! Studies kept for `nailnoise run`: which designs a study is of, and those of the user's store.

use serde::{Deserialize, Serialize};

use super::parameters::Parameter;
use super::result::StudyResult;
use crate::design::{Design, Provenance};
use crate::error::Error;
use crate::stages::levels::ShotLevels;
use crate::stages::{Digest, Postcard, Stage};
use crate::store::{Key, Store};
use crate::wording::hexadecimal;

/// Its name in the store.
const STUDY: &str = "study";

/// Studies kept of designs that differ in values alone.
const MOST: usize = 8;

/// A study in the store.
#[derive(Serialize, Deserialize)]
struct Kept {
    population: String,
    result: StudyResult,
}

/// Digest of the code on which levels of draws depend.
pub(super) fn code() -> String {
    hexadecimal(&Key::empty().with(&ShotLevels::NAME).with(&ShotLevels::CODE).digest())
}

/// What designs have in common that differ in values within their ranges alone.
fn ranges(design: &Design) -> Result<String, Error> {
    let entries = design.entries().into_iter();
    let ranged = entries.filter(|entry| entry.range.is_some_and(|[low, high]| low < high));
    let ranged: Vec<_> = ranged
        .map(|entry| {
            let numerical = entry.provenance == Provenance::Numerical;
            (entry.key, entry.range, entry.distribution, numerical)
        })
        .collect();
    serde_json::to_string(&(ranged, design.study())).map_err(Error::Json)
}

/// Digest of the population from which a study of a design draws: designs that differ in values that are drawn alone have the
/// same one.
///
/// # Errors
/// A design that cannot be digested.
pub(super) fn population(design: &Design, result: &StudyResult) -> Result<String, Error> {
    let drawn = |key: &str| result.variables.iter().any(|own| own.drawn && own.name == key);
    let entries = design.entries().into_iter().filter(|entry| drawn(&entry.key));
    let middles: Vec<(String, _)> = entries
        .filter_map(Parameter::of)
        .map(|parameter| (parameter.key.clone(), parameter.at(0.5)))
        .collect();
    let middles: Vec<(&str, _)> = middles
        .iter()
        .map(|(key, value)| (key.as_str(), value.clone()))
        .collect();
    let mut design = design.clone();
    let ranges = ranges(&design)?;
    // A value of a key's own distribution can be set.
    let _ = design.set(&middles);
    Ok(hexadecimal(&Key::empty().with(&ranges).with(&design.digest()).digest()))
}

fn all(store: &Store, design: &Design) -> Result<(Digest, Vec<Kept>), Error> {
    let key = Key::new().with(&ranges(design)?).with(&code()).digest();
    let kept = store.load::<Vec<Kept>, Postcard>(STUDY, &key).unwrap_or_default();
    Ok((key, kept))
}

/// The larger study counts, and one that drew structures above all.
pub(super) fn size(study: &StudyResult) -> (bool, usize) {
    (study.structures > 0, study.draws)
}

/// The largest study in the store of a design, or of one that differs in values that were drawn alone, by the code of today.
///
/// # Errors
/// A design that cannot be digested.
pub fn kept(store: &Store, design: &Design) -> Result<Option<StudyResult>, Error> {
    let mut largest: Option<StudyResult> = None;
    for own in all(store, design)?.1 {
        let is_larger = largest.as_ref().is_none_or(|known| size(known) < size(&own.result));
        if is_larger && population(design, &own.result)? == own.population {
            largest = Some(own.result);
        }
    }
    Ok(largest)
}

/// Keeps a study, unless one of the same designs with drawn structures or more draws is kept.
///
/// # Errors
/// A design that cannot be digested.
pub fn keep(store: &Store, design: &Design, result: &StudyResult) -> Result<(), Error> {
    let (key, mut kept) = all(store, design)?;
    let population = population(design, result)?;
    let known = kept.iter().position(|own| own.population == population);
    if let Some(known) = known {
        if size(&kept[known].result) > size(result) {
            return Ok(());
        }
        kept.remove(known);
    }
    kept.insert(
        0,
        Kept {
            population,
            result: result.clone(),
        },
    );
    kept.truncate(MOST);
    store.save::<_, Postcard>(STUDY, &key, &kept);
    Ok(())
}
