//! A design file of an earlier version with the keys of today; comments and order stay.

use std::path::Path;

use serde::Serialize;

use super::error::DesignError;
use super::renamed::{OldKey, old_keys, successors};
use super::source::File;

/// A key that a migration renames.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RenamedKey {
    /// Line of the file, from 1.
    pub line: usize,
    /// Full name of the key in the file.
    pub old: String,
    /// Its name of today.
    pub new: &'static str,
}

/// A key that has to be replaced by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ReplacedKey {
    /// Line of the file, from 1.
    pub line: usize,
    /// Full name of the key in the file.
    pub old: String,
    /// What to give in its place.
    pub successors: &'static str,
}

/// What a migration changes in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Migration {
    /// The text of the file with the keys of today.
    pub text: String,
    /// The renamed keys, in their order.
    pub renamed: Vec<RenamedKey>,
    /// The keys that are left as they are, in their order.
    pub by_hand: Vec<ReplacedKey>,
}

impl Migration {
    /// The migration of the design file `path`; its bases are files of their own.
    ///
    /// # Errors
    /// A file that cannot be read as TOML text.
    pub fn of(path: &Path) -> Result<Self, DesignError> {
        let file = File::read(path, None)?;
        let mut migration = Self {
            text: file.text().to_owned(),
            renamed: Vec::new(),
            by_hand: Vec::new(),
        };
        let found = old_keys(&file.table()?);
        for OldKey { key, span, new } in &found {
            let (line, old) = (file.place(span.clone()).line(), key.clone());
            if let Some(new) = *new {
                migration.renamed.push(RenamedKey { line, old, new });
            } else if let Some(successors) = successors(key) {
                migration.by_hand.push(ReplacedKey { line, old, successors });
            }
        }
        // From the last to the first, so that the places of the others stay.
        for old in found.iter().rev() {
            let text = &file.text()[old.span.clone()];
            if let Some(new) = old.replacement(text) {
                migration.text.replace_range(old.span.clone(), &new);
            }
        }
        Ok(migration)
    }
}
