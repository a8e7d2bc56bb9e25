//! Reliability of a value, as shown in a drawing.

use crate::design::Entry;

/// Classes of provenance that a drawing distinguishes, in the order of its legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// Given by the design without further information, or measured.
    Given,
    /// Published.
    Published,
    /// Computed from other values.
    Computed,
    /// Scaled from another tool.
    Scaled,
    /// Estimated or assumed.
    Assumed,
    /// Decided, a constant, or a property of the numerical method.
    Decided,
}

impl Standing {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Given,
        Self::Published,
        Self::Computed,
        Self::Scaled,
        Self::Assumed,
        Self::Decided,
    ];

    /// The class of a value, from the word of its provenance; if that is only "estimated", also from its source, which
    /// states whether the value was scaled from another tool.
    pub fn of(entry: &Entry) -> Self {
        match entry.provenance.as_str() {
            "published" => Self::Published,
            "computed" => Self::Computed,
            "scaled" => Self::Scaled,
            "estimated" | "assumed" if entry.source.starts_with("scaled") => Self::Scaled,
            "estimated" | "assumed" => Self::Assumed,
            "decided" | "numerical" | "constant" => Self::Decided,
            _ => Self::Given,
        }
    }

    /// Class in the style sheet.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Published => "published",
            Self::Computed => "computed",
            Self::Scaled => "scaled",
            Self::Assumed => "assumed",
            Self::Decided => "decided",
        }
    }

    /// Text in the legend.
    pub fn words(self) -> &'static str {
        match self {
            Self::Given => "given by the design",
            Self::Published => "published",
            Self::Computed => "computed from other values",
            Self::Scaled => "scaled from another tool",
            Self::Assumed => "estimated or assumed",
            Self::Decided => "decided or constant",
        }
    }

    /// The symbol in front of a value, as an SVG path of 8 by 8 units about the origin; classes differ in shape as well
    /// as in colour.
    pub(super) fn symbol(self) -> &'static str {
        match self {
            Self::Given => "M-3.6 0a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0-7.2 0z",
            Self::Published => "M-3.2-3.2h6.4v6.4h-6.4z",
            Self::Computed => "M0-4.2L4.2 0 0 4.2-4.2 0z",
            Self::Scaled => "M0-4L4 3.2h-8z",
            Self::Assumed => "M-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0-6.4 0z",
            Self::Decided => "M-3-3h6v6h-6z",
        }
    }
}
