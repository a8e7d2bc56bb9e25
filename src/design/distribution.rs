//! Distribution of a quantity over its range, for studies.

use serde::{Deserialize, Serialize};

/// Distribution of a quantity over its range.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// All values in the range are equally likely.
    #[default]
    Uniform,
    /// The density rises linearly from the lower end to the value of the design, and falls linearly to the upper end.
    Triangular,
    /// Normal around the centre of the range, whose ends are two standard deviations away; truncated at three.
    Normal,
    /// The logarithm is uniform.
    LogUniform,
}

impl Distribution {
    /// All of them, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Uniform, Self::Triangular, Self::Normal, Self::LogUniform];

    /// The word in the design file.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Triangular => "triangular",
            Self::Normal => "normal",
            Self::LogUniform => "log-uniform",
        }
    }

    /// The distribution of this name.
    pub(crate) fn parse(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.as_str() == word)
    }

    /// Why a quantity with this value and range cannot have this distribution; `None` if it can.
    pub(crate) fn problem(self, value: f64, [low, high]: [f64; 2]) -> Option<&'static str> {
        match self {
            // An exact value has no distribution.
            _ if low == high => None,
            Self::Triangular if !(low..=high).contains(&value) => Some("its value, the mode, lies outside its range"),
            Self::LogUniform if low <= 0.0 => Some("its range does not lie above zero"),
            _ => None,
        }
    }
}
