//! Origin of a value.

use std::fmt;

/// The reliability of a value; the reports state it next to the number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Provenance {
    /// Published.
    Published,
    /// Computed from published values.
    Computed,
    /// An engineer's estimate.
    Estimated,
    /// Scaled from the value of another design by a stated rule.
    Scaled,
    /// Decided where sources contradict each other or leave a choice.
    Decided,
    /// A property of the numerical method.
    Numerical,
    /// A constant of nature or of the reference atmosphere.
    Constant,
    /// Set by a design without further information.
    Design,
}

impl Provenance {
    /// All of them, in the order of the documentation.
    pub const ALL: [Self; 8] = [
        Self::Published,
        Self::Computed,
        Self::Estimated,
        Self::Scaled,
        Self::Decided,
        Self::Numerical,
        Self::Constant,
        Self::Design,
    ];

    /// The word in the design file.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Computed => "computed",
            Self::Estimated => "estimated",
            Self::Scaled => "scaled",
            Self::Decided => "decided",
            Self::Numerical => "numerical",
            Self::Constant => "constant",
            Self::Design => "design",
        }
    }

    /// Reads "published: thesis Table 4-3" as a class of provenance and its source.
    pub(crate) fn parse(text: &str) -> Option<(Self, String)> {
        let (word, source) = text.split_once(':').unwrap_or((text, ""));
        let standing = Self::ALL
            .into_iter()
            .find(|standing| standing.as_str() == word.trim())?;
        Some((standing, source.trim().to_owned()))
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
