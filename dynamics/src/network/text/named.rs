//! Names in the texts of an assembly.

use std::collections::BTreeSet;

use super::node::{Node, Tree};

/// Fields that contain prose.
const PROSE: [&str; 3] = ["text", "provenance", "note"];

/// Names in the texts of all files of an assembly.
#[derive(Debug, Clone, Default)]
pub(super) struct NamedInTexts {
    /// Words with dots, as in formulas.
    words: BTreeSet<String>,
    /// Groups of keys that a text names as a group, such as "=exhaust".
    groups: BTreeSet<String>,
}

impl NamedInTexts {
    /// Adds the names in the texts of a value.
    pub(super) fn add(&mut self, node: &Node) {
        match &node.value {
            Tree::Table(entries) => {
                let values = entries.iter().filter(|entry| !PROSE.contains(&entry.key.as_str()));
                values.for_each(|entry| self.add(&entry.node));
            }
            Tree::Array(items) => items.iter().for_each(|item| self.add(item)),
            Tree::Text(text) => {
                let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
                let words = text.split(|c| !is_part(c)).filter(|word| !word.is_empty());
                self.words.extend(words.map(str::to_owned));
                let group = text.strip_prefix('=').map(str::trim);
                self.groups.extend(group.map(str::to_owned));
            }
            Tree::Number(_) | Tree::Flag(_) | Tree::Other(_) => {}
        }
    }

    /// Whether a text names a block or one of its channels.
    pub(super) fn has_block(&self, name: &str) -> bool {
        let channel = format!("{name}.");
        let mut from = self.words.range(channel.clone()..);
        self.words.contains(name) || from.next().is_some_and(|word| word.starts_with(&channel))
    }

    /// Whether a text names a key or a group of it.
    pub(super) fn has_key(&self, path: &str) -> bool {
        let groups = path.match_indices('.').map(|(end, _)| &path[..end]);
        self.words.contains(path)
            || self.words.contains(&format!("key.{path}"))
            || groups.into_iter().any(|group| self.groups.contains(group))
    }
}
