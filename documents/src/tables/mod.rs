//! Tables of numbers as text: the only CSV reader, for recordings, drives and laws.
//!
//! A file is encoded in UTF-8, UTF-16 or Windows-1252. Columns are separated by semicolons, tabs, commas or bars; lines
//! that begin with `#` are comments, and Excel's line `sep=;` is honoured. Lines about the instrument may precede the
//! headings, and a row of units may follow them. A file uses decimal points or decimal commas throughout. [`csv`]
//! splits the lines into fields.

mod foreign;
mod heading;
mod label;
mod layout;
mod number;
mod rows;

use crate::text::decode;

pub use foreign::Foreign;
pub use foreign::foreign;
pub use heading::{ColumnOf, Heading, time};
pub use label::{dimension_of, si_of, spelled};
pub use number::number;

/// Longest excerpt of a file shown in a message \[characters\].
const SHOWN: usize = 40;

/// Longest list of headings shown in a message \[characters\].
const SHOWN_HEADINGS: usize = 120;

/// Why a file cannot be read as a table, or which line is wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TableFault {
    /// The file has another format.
    #[error("it is {}", .0.name)]
    Foreign(Foreign),
    /// The file contains bytes that do not occur in text.
    #[error("it is a binary file of an unknown format")]
    Binary,
    /// No line has two columns.
    #[error("no line has two columns, separated by commas, semicolons or tabs")]
    NoColumns,
    /// A line that cannot be read.
    #[error("line {line}: {problem}")]
    Line {
        /// The line, from 1.
        line: usize,
        /// The column; none if the entire line is wrong.
        column: Option<usize>,
        /// The fault.
        problem: String,
    },
}

/// The text of a table, its headings, and where its rows begin.
#[derive(Debug)]
pub struct Table {
    text: String,
    separator: u8,
    /// Headings with their units, including those from a separate row of units.
    pub headings: Vec<Heading>,
    /// Line of the headings, from 1.
    pub line: usize,
    /// Beginning of the line of headings.
    head: layout::Start,
    /// Beginning of the rows.
    start: layout::Start,
}

impl Table {
    /// Finds headings, units and the beginning of the rows of a table. `is_header` recognises the headings; if it
    /// accepts no line, the headings are the line before the first line of numbers.
    ///
    /// # Errors
    /// [`TableFault`] if the file is not text or has no columns.
    pub fn read(bytes: &[u8], is_header: impl Fn(&[Heading]) -> bool) -> Result<Self, TableFault> {
        Self::found(bytes, |text| layout::find(text, is_header))
    }

    fn found(bytes: &[u8], find: impl FnOnce(&str) -> Option<layout::Layout>) -> Result<Self, TableFault> {
        if let Some(foreign) = foreign(bytes) {
            return Err(TableFault::Foreign(foreign));
        }
        let text = decode(bytes).ok_or(TableFault::Binary)?;
        // Classic Mac OS and some instruments end lines with a carriage return.
        let text = if text.contains('\r') {
            text.replace("\r\n", "\n").replace('\r', "\n")
        } else {
            text.into_owned()
        };
        let found = find(&text).ok_or(TableFault::NoColumns)?;
        Ok(Self {
            text,
            separator: found.separator,
            headings: found.headings,
            line: found.head.line,
            head: found.head,
            start: found.start,
        })
    }

    /// Reads a table whose column names are the first line of two or more fields; its cells may be text.
    ///
    /// # Errors
    /// Same as [`Table::read`].
    pub fn of_text(bytes: &[u8]) -> Result<Self, TableFault> {
        Self::found(bytes, layout::first)
    }

    /// Reads a table whose first line may already contain numbers.
    ///
    /// # Errors
    /// Same as [`Table::read`].
    pub fn without_headings(bytes: &[u8]) -> Result<Self, TableFault> {
        let mut table = Self::read(bytes, |headings| !headings.iter().any(Heading::is_number))?;
        if table.headings.iter().all(Heading::is_number) {
            table.start = table.head;
        }
        Ok(table)
    }

    /// The headings for a message.
    pub fn known(&self) -> String {
        let all: Vec<&str> = self.headings.iter().map(|heading| heading.text.as_str()).collect();
        shown(&all.join(", "), SHOWN_HEADINGS)
    }
}

/// The beginning of a text without control characters that would affect a terminal.
fn shown(text: &str, most: usize) -> String {
    let letter = |letter: char| if letter.is_control() { ' ' } else { letter };
    text.chars().map(letter).take(most).collect()
}
