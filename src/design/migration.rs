//! Rewrites a design file of an earlier version with the current keys; comments and order are preserved.

use std::path::Path;

use serde::Serialize;

use super::error::DesignError;
use super::renamed::{OldKey, old_keys, successors};
use super::source::File;

/// A key that a migration renames.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RenamedKey {
    /// Line in the file, starting at 1.
    pub line: usize,
    /// Full name of the key in the file.
    pub old: String,
    /// Its current name.
    pub new: &'static str,
}

/// A key that has to be replaced by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ReplacedKey {
    /// Line in the file, starting at 1.
    pub line: usize,
    /// Full name of the key in the file.
    pub old: String,
    /// What to write instead.
    pub successors: &'static str,
}

/// Changes to a file by a migration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Migration {
    /// The text of the file with the current keys.
    pub text: String,
    /// The renamed keys, in file order.
    pub renamed: Vec<RenamedKey>,
    /// The keys to be replaced by hand, in file order; they are left unchanged.
    pub by_hand: Vec<ReplacedKey>,
}

impl Migration {
    /// Migrates the design file `path`, but not its bases.
    ///
    /// # Errors
    /// If the file cannot be read as TOML.
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
        // From last to first, so that the positions of the others remain valid.
        for old in found.iter().rev() {
            let text = &file.text()[old.span.clone()];
            if let Some(new) = old.replacement(text) {
                migration.text.replace_range(old.span.clone(), &new);
            }
        }
        Ok(migration)
    }
}
