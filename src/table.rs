//! A table of words: one model, which the terminal and the pages show in their own forms.

/// A table. The first column is a name, the others are numbers in words.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    /// Headings of the columns.
    pub(crate) headings: Vec<String>,
    /// A cell for each column in each row.
    pub(crate) rows: Vec<Vec<String>>,
    /// Lines below the table; words between backticks are code.
    pub(crate) legend: Vec<String>,
}
