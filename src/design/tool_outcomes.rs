//! Outcomes of a design's tool, and those that its studies require.

use nailnoise_documents::Place;
use nailnoise_dynamics::Outcome;
use nailnoise_dynamics::network::AssemblyText;

use super::error::{DesignError, Problem};

/// Names of the outcomes of a shot of the tool described by keys.
pub(super) fn outcomes() -> impl Iterator<Item = &'static str> {
    Outcome::ALL.into_iter().map(Outcome::name)
}

/// The outcomes of a design's tool.
#[derive(Debug)]
pub(crate) struct ToolOutcomes {
    names: Vec<String>,
    /// Number of files in the chain up to the one that names the tool, nearest first. Files behind it are bases, which
    /// may describe another tool.
    files: usize,
}

impl ToolOutcomes {
    /// The outcomes that an assembly declares, or those of the tool described by keys. `files` is the number of files
    /// up to the one that names the tool.
    pub(super) fn of(assembly: Option<&AssemblyText>, files: usize) -> Self {
        Self {
            names: match assembly {
                Some(text) => text.outcomes().into_iter().map(str::to_owned).collect(),
                None => outcomes().map(str::to_owned).collect(),
            },
            files,
        }
    }

    /// Whether the tool has all of these outcomes.
    fn include(&self, required: &[RequiredOutcome]) -> bool {
        required.iter().all(|own| self.names.contains(&own.word))
    }

    /// The words of a requirement. A requirement of a base with outcomes that the tool does not have is that of the
    /// base's tool: it does not apply.
    pub(super) fn checked(&self, depth: usize, required: Vec<RequiredOutcome>) -> Result<Vec<String>, DesignError> {
        if depth >= self.files && !self.include(&required) {
            return Ok(Vec::new());
        }
        let word = |own: RequiredOutcome| {
            if self.names.contains(&own.word) {
                return Ok(own.word);
            }
            Err(Problem::WrongKind {
                key: "study.require".to_owned(),
                found: own.found,
                expected: match self.names.as_slice() {
                    [] => {
                        "as [] until the assembly declares an outcome, as [cycle.outcome] NAME = \"EVENT\"".to_owned()
                    }
                    names => format!("{OUTCOME}: {}", names.join(", ")),
                },
            }
            .at(own.at))
        };
        required.into_iter().map(word).collect()
    }
}

/// Parts of a requirement.
pub(super) const OUTCOME: &str = "as an outcome of the tool, or a list of outcomes";

/// An outcome that a file requires.
#[derive(Debug)]
pub(super) struct RequiredOutcome {
    /// Its name.
    pub(super) word: String,
    /// The text in the file.
    pub(super) found: String,
    /// Its place in the file.
    pub(super) at: Box<Place>,
}
