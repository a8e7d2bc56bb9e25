//! Units of results for people: SI or those of a workshop in the United States.
//!
//! Texts, tables and charts are written in metric units, and files for machines stay in them. A renderer for people
//! (terminal, page, chart) has one value of [`Units`] and converts its input: texts, tables, charts and
//! pages. Notes of a result, which are part of its file, are converted in the same way.

mod factors;
mod heading;
mod page;
mod text;

use std::borrow::Cow;

use serde::Serialize;

pub(crate) use factors::Conversion;
pub(crate) use heading::{renamed, unit_of};
pub(crate) use text::{decimals_of_cells, largest, numbers};

/// Units of the quantities that are shown. Levels in dB, frequencies and times are the same in both.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
pub enum Units {
    /// mm, kPa, J, N, kg, L, degC
    #[default]
    Si,
    /// in, psi, ft-lbf, lbf, lb, ft3, degF; compressed air in standard cubic feet a minute
    Us,
}

impl Units {
    /// A text whose quantities are in these units: "4.0 mm deep" becomes "0.157 in deep". Words between backticks and
    /// quantities in quotation marks stay, because they are input for the program.
    pub fn text<'a>(self, text: &'a str) -> Cow<'a, str> {
        match self {
            Self::Si => Cow::Borrowed(text),
            Self::Us => text::converted(text, false),
        }
    }

    /// The texts of a page in these units; its scripts and code stay.
    pub(crate) fn page(self, page: String) -> String {
        match self {
            Self::Si => page,
            Self::Us => page::converted(&page),
        }
    }

    /// The conversion of a metric unit; `None` for units that stay. `largest` is the size of the largest of the values
    /// that are shown together.
    pub(crate) fn conversion(self, unit: &str, largest: f64) -> Option<Conversion> {
        match self {
            Self::Si => None,
            Self::Us => factors::to_us(unit, largest),
        }
    }
}
