//! Plain text tables: columns as wide as their widest cell, numbers to the right.

use crate::table::Table;

/// Lays out rows under headings. The first column is text (left), the others numbers (right).
pub(super) fn table(headings: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count())
            .chain([headings[column].chars().count()])
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..headings.len()).map(width).collect();
    let line = |cells: &[&str]| {
        let mut text = String::new();
        for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
            text.push_str("  ");
            let padding = " ".repeat(width - cell.chars().count());
            if column == 0 {
                text.push_str(cell);
                text.push_str(&padding);
            } else {
                text.push_str(&padding);
                text.push_str(cell);
            }
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
        text
    };
    let mut text = line(headings);
    for row in rows {
        text.push_str(&line(&row.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    text
}

/// A table with its legend.
pub(super) fn with_legend(shown: &Table) -> String {
    let headings: Vec<&str> = shown.headings.iter().map(String::as_str).collect();
    let legend = shown.legend.iter().map(|line| format!("  {line}\n"));
    format!("{}\n{}", table(&headings, &shown.rows), legend.collect::<String>())
}

/// The same with text in all columns, each to the left.
pub(super) fn texts(headings: &[&str], rows: &[Vec<String>]) -> String {
    let columns = headings.len();
    let cell = |row: &[String], column: usize| row.get(column).cloned().unwrap_or_default();
    let titles: Vec<String> = headings.iter().map(|own| (*own).to_owned()).collect();
    let all = || std::iter::once(titles.as_slice()).chain(rows.iter().map(Vec::as_slice));
    let widths: Vec<usize> = (0..columns)
        .map(|column| all().map(|row| cell(row, column).chars().count()).max().unwrap_or(0))
        .collect();
    let line = |row: &[String]| {
        let cells = (0..columns).map(|column| format!("  {:<width$}", cell(row, column), width = widths[column]));
        format!("{}\n", cells.collect::<String>().trim_end())
    };
    all().map(line).collect()
}

/// The value in words, or a dash without one.
pub(super) fn dash<T>(value: Option<T>, words: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), words)
}

/// A number with so many decimals; a dash for none.
pub(super) fn fixed(value: Option<f64>, decimals: usize) -> String {
    dash(value, |value| format!("{value:.decimals$}"))
}

/// A level in dB with one decimal; a silent source shows a dash.
pub(super) fn decibels(level: Option<f64>) -> String {
    fixed(level, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_begin_at_the_same_column() {
        let rows = [
            vec!["a".to_owned(), "long text".to_owned()],
            vec!["bcd".to_owned(), "x".to_owned()],
        ];
        assert_eq!(texts(&["key", "of"], &rows), "  key  of\n  a    long text\n  bcd  x\n");
    }

    #[test]
    fn columns_line_up() {
        let text = table(
            &["source", "dB"],
            &[
                vec!["exhaust".into(), "112.3".into()],
                vec!["body".into(), "9.0".into()],
            ],
        );
        assert_eq!(text, "  source      dB\n  exhaust  112.3\n  body       9.0\n");
    }
}
