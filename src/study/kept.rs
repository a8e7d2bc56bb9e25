//! The largest study of a design, kept for `nailnoise run`.

use super::result::StudyResult;
use crate::design::Design;
use crate::error::Error;
use crate::stages::{Digest, Postcard};
use crate::store::{Key, Store};

/// Its name in the store.
const STUDY: &str = "study";

/// Everything that a study of a design depends on, but the number of draws and their seed.
fn key(design: &Design) -> Result<Digest, Error> {
    let entries = design.entries().into_iter();
    let entries: Vec<_> = entries
        .map(|entry| {
            (
                entry.key,
                entry.value,
                entry.range,
                entry.distribution,
                entry.provenance,
            )
        })
        .collect();
    let said = serde_json::to_string(&(entries, design.study())).map_err(Error::Json)?;
    Ok(Key::new().with(&design.digest()).with(&said).digest())
}

/// The study of a design that is kept, if any.
///
/// # Errors
/// A design that cannot be digested.
pub fn kept(store: &Store, design: &Design) -> Result<Option<StudyResult>, Error> {
    Ok(store.load::<StudyResult, Postcard>(STUDY, &key(design)?))
}

/// Keeps a study, unless one with drawn structures or more draws is kept.
///
/// # Errors
/// A design that cannot be digested.
pub fn keep(store: &Store, design: &Design, result: &StudyResult) -> Result<(), Error> {
    let size = |study: &StudyResult| (study.structures > 0, study.draws);
    if kept(store, design)?.is_none_or(|old| size(&old) <= size(result)) {
        store.save::<_, Postcard>(STUDY, &key(design)?, result);
    }
    Ok(())
}
