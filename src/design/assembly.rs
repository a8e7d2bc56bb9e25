//! The assembly of a design: its tables `[cycle]` and `[keys]`.

use std::collections::BTreeSet;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyError, AssemblyText};

use super::error::{DesignError, Problem};
use super::source::File;

/// Converts the error of an assembly to one of its design.
pub(crate) fn refused(error: AssemblyError) -> DesignError {
    let at = error.at.clone();
    Problem::Assembly(Box::new(error)).at(at)
}

/// The assembly of a chain of files, beginning with the design itself; none if no file has a table `[cycle]`.
pub(super) fn of_chain(chain: &[File]) -> Result<Option<AssemblyText>, DesignError> {
    if !has_cycle(chain)? {
        return Ok(None);
    }
    AssemblyText::open_design(&documents(chain)).map(Some).map_err(refused)
}

/// Whether a file of a chain has a table `[cycle]`.
pub(super) fn has_cycle(chain: &[File]) -> Result<bool, DesignError> {
    for file in chain {
        if file.table()?.contains_key("cycle") {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The documents of a chain, beginning with the base.
pub(super) fn documents(chain: &[File]) -> Vec<Document> {
    chain.iter().rev().map(|file| file.document().clone()).collect()
}

/// The error of a command that needs more than an assembly, at the table `[cycle]` of the file closest to the design.
pub(super) fn only_assembly(text: &AssemblyText, chain: &[File]) -> DesignError {
    let place = chain.iter().find_map(|file| {
        let table = file.table().ok()?;
        let (key, _) = table.get_key_value("cycle")?;
        Some(file.place(key.span()))
    });
    Problem::OwnAssembly {
        name: text.name().to_owned(),
    }
    .at(place)
}

/// Keys that an assembly adds to those of a design.
#[derive(Debug, Default)]
pub(crate) struct OwnKeys {
    /// Whether there is an assembly.
    given: bool,
    /// Full names of the keys that it declares.
    declared: BTreeSet<String>,
}

impl OwnKeys {
    pub(super) fn of(text: Option<&AssemblyText>) -> Self {
        Self {
            given: text.is_some(),
            declared: text
                .map(|text| text.declared().keys().cloned().collect())
                .unwrap_or_default(),
        }
    }

    /// Whether the key or group of this name is read by the reader of the assembly.
    pub(super) fn covers(&self, name: &str) -> bool {
        let group = format!("{name}.");
        self.given && (matches!(name, "cycle" | "keys") || self.declared.contains(name))
            || self.declared.iter().any(|key| key.starts_with(&group))
    }
}
