//! Tables of results. Each is described once and rendered as text for the terminal and as HTML for the pages.
//!
//! Texts are written for the terminal in plain characters: `+-0.4`, `-` for a missing value, `dB2`, `L_{WA,1s}`. Pages
//! show them as ±0.4, –, dB², and with a subscript.

pub(crate) mod comparison;
pub(crate) mod cycle;
pub(crate) mod measured;
pub(crate) mod measurement;
pub(crate) mod optimisation;
pub(crate) mod performance;
pub(crate) mod run;
pub(crate) mod study;
pub(crate) mod sweep;
mod units;

/// A table with a legend.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Table {
    /// Columns, from the left.
    pub(crate) columns: Vec<Column>,
    /// One cell per column in each row; missing cells at the end of a row are blank.
    pub(crate) rows: Vec<Vec<Cell>>,
    /// Whether the last row is a sum.
    pub(crate) sum: bool,
    /// Lines below the table; words between backticks are code.
    pub(crate) legend: Vec<String>,
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// Heading, followed by the unit.
    pub(crate) heading: String,
    /// Content, which determines the alignment.
    pub(crate) content: Content,
    /// Whether only the page has room for the column.
    pub(crate) page_only: bool,
}

/// Content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// Words, aligned left.
    Words,
    /// Names of keys, aligned left.
    Keys,
    /// Numbers, aligned right.
    Numbers,
    /// Words in a narrow column, aligned right in the terminal.
    Short,
    /// Bars without text.
    Bars,
}

/// A cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Cell {
    /// Its text.
    pub(crate) text: String,
    /// Half-width of the interval of an estimate, `+-0.04`, or its bound, `> 0.69`; may be empty.
    pub(crate) spread: String,
    /// Whether the text is the main figure of its row.
    pub(crate) strong: bool,
    /// Whether the row reports a failure.
    pub(crate) alarm: bool,
    /// Index in the palette of the dot before the text.
    pub(crate) dot: Option<usize>,
    /// Bar, on the page only.
    pub(crate) bar: Option<Bar>,
    /// File that the text opens on the page, relative to it.
    pub(crate) opens: Option<String>,
}

/// A bar in a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bar {
    /// Length as a fraction of the longest possible bar, 0 to 1.
    pub(crate) length: f64,
    /// Index of its colour in the palette.
    pub(crate) colour: usize,
}

impl Table {
    /// A table with these columns.
    pub(crate) fn new(columns: impl IntoIterator<Item = Column>, rows: impl IntoIterator<Item = Vec<Cell>>) -> Self {
        Self {
            columns: columns.into_iter().collect(),
            rows: rows.into_iter().collect(),
            ..Self::default()
        }
    }

    /// Marks the last row as a sum.
    pub(crate) fn with_sum(self) -> Self {
        Self { sum: true, ..self }
    }

    /// Sets the lines below the table.
    pub(crate) fn with_legend(self, legend: impl IntoIterator<Item = String>) -> Self {
        Self {
            legend: legend.into_iter().collect(),
            ..self
        }
    }
}

impl Column {
    /// A column of words.
    pub(crate) fn words(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            content: Content::Words,
            page_only: false,
        }
    }

    /// A column of names of keys.
    pub(crate) fn keys(heading: impl Into<String>) -> Self {
        Self {
            content: Content::Keys,
            ..Self::words(heading)
        }
    }

    /// A column of numbers.
    pub(crate) fn number(heading: impl Into<String>) -> Self {
        Self {
            content: Content::Numbers,
            ..Self::words(heading)
        }
    }

    /// A column of short words.
    pub(crate) fn short(heading: impl Into<String>) -> Self {
        Self {
            content: Content::Short,
            ..Self::words(heading)
        }
    }

    /// A column of bars, on the page only.
    pub(crate) fn bars() -> Self {
        Self {
            content: Content::Bars,
            ..Self::words("")
        }
        .page_only()
    }

    /// The same column, on the page only.
    pub(crate) fn page_only(self) -> Self {
        Self {
            page_only: true,
            ..self
        }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }
}

impl Cell {
    /// An estimate with the half-width of its interval, or with its bound.
    pub(crate) fn estimate(text: impl Into<String>, spread: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            spread: spread.into(),
            strong: true,
            ..Self::default()
        }
    }

    /// A bar without text.
    pub(crate) fn bar(length: f64) -> Self {
        Self {
            bar: Some(Bar { length, colour: 0 }),
            ..Self::default()
        }
    }

    /// The main figure of its row.
    pub(crate) fn strong(self) -> Self {
        Self { strong: true, ..self }
    }
}

/// The value as text, or a dash without one.
pub(crate) fn dash<T>(value: Option<T>, words: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), words)
}

/// A number with a fixed number of decimals, without a sign if it rounds to zero; a dash for `None`.
pub(crate) fn fixed(value: Option<f64>, decimals: usize) -> String {
    dash(value, |value| crate::wording::fixed(value, decimals))
}

/// A level in dB with one decimal; a silent source shows a dash.
pub(crate) fn decibels(level: Option<f64>) -> String {
    fixed(level, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_rounds_to_zero_has_no_sign() {
        let shown = [-0.04, -0.05, 0.0, -1.0].map(|value| fixed(Some(value), 1));
        assert_eq!(shown, ["0.0", "-0.1", "0.0", "-1.0"]);
        assert_eq!(fixed(Some(-0.4), 0), "0");
    }
}
