//! Plain-text tables with columns as wide as their widest cell.

use super::red::red;
use crate::tables::{Cell, Column, Content, Table};
use crate::units::Units;

/// Formats a table with its legend.
pub(super) fn text(table: &Table) -> String {
    let shown: Vec<(usize, &Column)> = table
        .columns
        .iter()
        .enumerate()
        .filter(|(_, own)| !own.page_only)
        .collect();
    let headings: Vec<String> = shown.iter().map(|(_, column)| plain(&column.heading)).collect();
    let blank = Cell::default();
    let cell = |row: usize, place: usize| table.rows[row].get(place).unwrap_or(&blank);
    let rows = (0..table.rows.len()).map(|row| shown.iter().map(|(place, _)| one(cell(row, *place))).collect());
    let lines: Vec<Vec<String>> = std::iter::once(headings).chain(rows).collect();
    let width = |place: usize| lines.iter().map(|line| line[place].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..shown.len()).map(width).collect();
    let mut text = String::new();
    for (number, line) in lines.iter().enumerate() {
        let start = text.len();
        for ((own, width), (place, column)) in line.iter().zip(&widths).zip(&shown) {
            let set = match column.content {
                Content::Words | Content::Keys => format!("  {own:<width$}"),
                _ => format!("  {own:>width$}"),
            };
            let alarm = number > 0 && cell(number - 1, *place).alarm;
            text.push_str(&if alarm { red(&set) } else { set });
        }
        text.truncate(start + text[start..].trim_end().len());
        text.push('\n');
    }
    if !table.legend.is_empty() {
        text.push('\n');
        let lines = table.legend.iter().flat_map(|line| line.lines());
        lines.for_each(|line| text.push_str(&format!("  {line}\n")));
    }
    text
}

/// A table with text in the first column and numbers in the others.
pub(super) fn table(headings: &[&str], rows: &[Vec<String>]) -> String {
    numbers(headings, rows, Units::Si)
}

/// The same table in these units.
pub(super) fn numbers(headings: &[&str], rows: &[Vec<String>], units: Units) -> String {
    let columns = headings.iter().enumerate();
    let columns = columns.map(|(place, heading)| match place {
        0 => Column::words(*heading),
        _ => Column::number(*heading),
    });
    text(&Table::new(columns, cells(rows)).in_units(units))
}

/// A table of text.
pub(super) fn texts(headings: &[&str], rows: &[Vec<String>]) -> String {
    words(headings, rows, Units::Si)
}

/// The same table in these units.
pub(super) fn words(headings: &[&str], rows: &[Vec<String>], units: Units) -> String {
    let columns = headings.iter().map(|heading| Column::words(*heading));
    text(&Table::new(columns, cells(rows)).in_units(units))
}

fn cells(rows: &[Vec<String>]) -> Vec<Vec<Cell>> {
    let row = |row: &Vec<String>| row.iter().map(|cell| Cell::from(cell.as_str())).collect();
    rows.iter().map(row).collect()
}

/// A heading without the braces of its subscripts.
fn plain(heading: &str) -> String {
    crate::figures::subscripts(heading, "_", "")
}

/// Formats a cell: an estimate is followed by its half width or, after a comma, by its bound.
fn one(cell: &Cell) -> String {
    let text = &cell.text;
    match cell.spread.as_str() {
        "" => text.clone(),
        bound if bound.starts_with(['<', '>']) => format!("{text}, {bound}"),
        half => format!("{text} {half}"),
    }
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

    #[test]
    fn the_terminal_shows_bounds_and_no_column_of_the_page() {
        let table = Table::new(
            [Column::words("source"), Column::bars(), Column::number("L_{WA,1s} dB")],
            [
                vec!["exhaust".into(), Cell::bar(0.5), Cell::estimate("1.00", "> 0.69")],
                vec!["body".into(), Cell::bar(0.1), Cell::estimate("0.50", "+-0.04")],
            ],
        )
        .with_legend(["a line".to_owned()]);
        assert_eq!(
            text(&table),
            "  source     L_WA,1s dB\n  exhaust  1.00, > 0.69\n  body      0.50 +-0.04\n\n  a line\n"
        );
    }
}
