//! Blocks and keys of an assembly that nothing names.

use nailnoise_documents::Place;

use super::keys::standard;
use super::layers::AssemblyText;
use super::node::{Entry, Node};

/// Tables of blocks that act only where another block, event or formula names them. A sensor is not among them: it is a
/// channel of the record, which is written to the table of histories.
const NAMED: [&str; 3] = ["reservoir", "trigger", "let"];

/// A block, name or key that has no effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{path}` has no effect: nothing names it")]
pub struct Unused {
    /// Its full name.
    pub path: String,
    /// Location.
    pub at: Box<Place>,
}

impl Unused {
    /// The remedy.
    pub fn help(&self) -> String {
        let path = &self.path;
        let mut words = path.split('.');
        match (words.next(), words.next(), words.next()) {
            (Some("cycle"), Some("trigger"), Some(name)) => format!(
                "let a passage follow it, as open = {{ when = \"{name}\" }}, or a motor or latch, as while = \
                 \"{name}\"; or remove it"
            ),
            (Some("cycle"), Some("reservoir"), Some(name)) => {
                format!("connect it by a passage, as between = [\"{name}\", ..], or a face; or remove it")
            }
            (Some("cycle"), Some("let"), Some(name)) => format!("use it in a formula, as \"=2*{name}\", or remove it"),
            _ => {
                let key = path.trim_start_matches("keys.");
                format!("use it in a formula, as \"={key}\", or remove its declaration and value")
            }
        }
    }
}

impl AssemblyText {
    /// Blocks and declared keys without an effect: triggers, reservoirs, names of `[cycle.let]` and keys of `[keys]`
    /// that no file names. A block whose only user is removed or replaced by a nearer file is not among them, because
    /// it has a use in another file.
    pub fn unused(&self) -> Vec<Unused> {
        let blocks = NAMED.iter().flat_map(|table| {
            let entries = self.cycle.get(table).map_or(&[][..], Node::entries).iter();
            let unused = entries.filter(|entry| entry.key != "atmosphere" && !self.named.has_block(&entry.key));
            unused.map(move |Entry { key, spot, .. }| Unused {
                path: format!("cycle.{table}.{key}"),
                at: self.sources.place(spot),
            })
        });
        let keys = self.declared().iter();
        // Standard keys may also be read outside the cycle.
        let keys = keys.filter(|(path, _)| standard(path).is_none() && !self.named.has_key(path));
        let keys = keys.map(|(path, declared)| Unused {
            path: format!("keys.{path}"),
            at: Box::new(declared.at.clone()),
        });
        blocks.chain(keys).collect()
    }
}
