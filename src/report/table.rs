//! Tables as HTML.

use maud::{Markup, PreEscaped, html};

use super::typography::{capitalised, with_code, with_subscripts};
use crate::tables::{Cell, Column, Content, Table};

/// Longest text of a cell that is not broken into lines \[characters\].
const SHORT: usize = 14;

/// Largest length of a number with its unit \[characters\]; print breaks only longer texts, such as lists, into lines.
const NUMBER: usize = 24;

/// A table with its legend.
pub(super) fn markup(table: &Table) -> Markup {
    let last = table.rows.len().saturating_sub(1);
    html! {
        div.scroll { table.pinned {
            thead { tr { @for column in &table.columns {
                th.n[column.content == Content::Numbers] { (heading(&column.heading)) }
            } } }
            tbody { @for (place, row) in table.rows.iter().enumerate() { tr.sum[table.sum && place == last]
                .failed[row.iter().any(|cell| cell.alarm)] {
                @for (place, column) in table.columns.iter().enumerate() {
                    (cell(place, column, row.get(place).unwrap_or(&Cell::default())))
                }
            } } }
        } }
        @for line in &table.legend { p.quiet { (with_code(&capitalised(line))) } }
    }
}

/// A heading; keys in it may be broken after a full stop or an underscore.
fn heading(text: &str) -> Markup {
    let set = with_subscripts(text).into_string();
    let letters: Vec<char> = set.chars().collect();
    let mut broken = String::with_capacity(set.len());
    for (place, letter) in letters.iter().enumerate() {
        broken.push(*letter);
        let before = place.checked_sub(1).and_then(|before| letters.get(before));
        let word = |letter: Option<&char>| letter.is_some_and(char::is_ascii_lowercase);
        if matches!(letter, '.' | '_') && word(before) && word(letters.get(place + 1)) {
            broken.push_str("<wbr>");
        }
    }
    PreEscaped(broken)
}

fn cell(place: usize, column: &Column, cell: &Cell) -> Markup {
    let key = column.content == Content::Keys;
    html! {
        @if key && place == 0 { th.key-name scope="row" { (cell.text)
            @if !cell.spread.is_empty() { br; span.meaning { (with_code(&cell.spread)) } }
        } }
        @else if key { td.key-name { (cell.text) } }
        @else if place == 0 { th.source[cell.dot.is_some()] scope="row" { (content(cell)) } }
        @else if column.content == Content::Numbers {
            td.n.list[cell.text.chars().count() > NUMBER] { (content(cell)) }
        }
        @else { td.short[cell.text.chars().count() <= SHORT] { (content(cell)) } }
    }
}

/// The content of a cell.
pub(super) fn content(cell: &Cell) -> Markup {
    let text = with_code(&cell.text);
    html! {
        @if let Some(place) = cell.dot { span class={ "dot c" (place) } {} }
        @if let Some(bar) = cell.bar {
            div.share {
                div class={ "bar c" (bar.colour) }
                    style={ "width:" (format!("{:.1}%", 100.0 * bar.length.clamp(0.0, 1.0))) } {}
                @if !cell.text.is_empty() { span { (text) } }
            }
        } @else if let Some(file) = &cell.opens { a href=(file) { (text) }
        } @else if cell.strong { b { (text) } } @else { (text) }
        @if !cell.spread.is_empty() { " " span.quiet { (with_code(&cell.spread)) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_in_headings_are_broken_between_words() {
        let set = heading("exhaust.hole_diameter, L_{WA,1s} over 0.5 s").into_string();
        assert_eq!(set, "exhaust.<wbr>hole_<wbr>diameter, L<sub>WA,1s</sub> over 0.5 s");
    }

    #[test]
    fn code_in_a_remark_is_set_as_code() {
        let cell = Cell::estimate("wood.penetration_fit", "of `nailnoise penetration fit`");
        let set = content(&cell).into_string();
        assert!(
            set.contains("<code>nailnoise penetration fit</code>") && !set.contains('`'),
            "{set}"
        );
    }

    #[test]
    fn every_row_has_a_cell_for_each_column() {
        let columns = [Column::words("source"), Column::number("L_{WA,1s} dB"), Column::bars()];
        let rows = [
            vec!["exhaust".into(), Cell::estimate("97.0", "+-0.4"), Cell::bar(0.5)],
            vec!["total".into()],
        ];
        let text = markup(&Table::new(columns, rows).with_sum()).into_string();
        assert_eq!(text.matches("<td").count() + text.matches("scope=\"row\"").count(), 6);
        assert!(text.contains("L<sub>WA,1s</sub> dB") && text.contains("<b>97.0</b> <span class=\"quiet\">\u{b1}0.4"));
        assert_eq!(text.matches("<tr class=\"sum\">").count(), 1);
    }
}
