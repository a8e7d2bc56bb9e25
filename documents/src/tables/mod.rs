//! Tables of numbers as text: the one reader of CSV for recordings, drives and laws.
//!
//! A file is in UTF-8, UTF-16 or Windows-1252. Its columns are separated by semicolons, tabs, commas or bars; lines
//! that begin with `#` are comments, and `sep=;` of Excel is followed. The headings may follow lines about the
//! instrument and precede a row of units. Numbers have a decimal point, or throughout a decimal comma. [`csv`] splits
//! the lines into fields.

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

/// Characters of a text of a file that a message shows.
const SHOWN: usize = 40;

/// Characters of all headings that a message shows.
const SHOWN_HEADINGS: usize = 120;

/// Why a file is not a table, or which line of it cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TableFault {
    /// A file of another format.
    #[error("it is {}", .0.name)]
    Foreign(Foreign),
    /// Bytes that no text has.
    #[error("it is a binary file of an unknown format")]
    Binary,
    /// No line with two columns.
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
    /// Headings with their units, those of a row of units included.
    pub headings: Vec<Heading>,
    /// Line of the headings, from 1.
    pub line: usize,
    /// Beginning of the line of headings.
    head: layout::Start,
    /// Beginning of the rows.
    start: layout::Start,
}

impl Table {
    /// Finds headings, units and the beginning of the rows of a table. `is_header` is whether these headings are those
    /// that are looked for; without such a line they are those before the first line of numbers.
    ///
    /// # Errors
    /// [`TableFault`] if it is not text, or is without columns.
    pub fn read(bytes: &[u8], is_header: impl Fn(&[Heading]) -> bool) -> Result<Self, TableFault> {
        Self::found(bytes, |text| layout::find(text, is_header))
    }

    fn found(bytes: &[u8], find: impl FnOnce(&str) -> Option<layout::Layout>) -> Result<Self, TableFault> {
        if let Some(foreign) = foreign(bytes) {
            return Err(TableFault::Foreign(foreign));
        }
        let text = decode(bytes).ok_or(TableFault::Binary)?;
        // Old Mac OS and some instruments end lines only by a carriage return.
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

    /// A table whose first line of two fields or more names its columns; its cells may be text.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn of_text(bytes: &[u8]) -> Result<Self, TableFault> {
        Self::found(bytes, layout::first)
    }

    /// A table whose first line may be of numbers already.
    ///
    /// # Errors
    /// As [`Table::read`].
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

/// The beginning of a text without characters that a terminal would obey.
fn shown(text: &str, most: usize) -> String {
    let letter = |letter: char| if letter.is_control() { ' ' } else { letter };
    text.chars().map(letter).take(most).collect()
}
