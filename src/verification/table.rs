use std::fmt::Write as _;

use super::row::Row;

/// Rows of a case above which [`summary`] shows only the worst.
const SHOWN: usize = 9;

/// A row to show, and the number of rows of its case that it represents.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// The row.
    pub row: &'a Row,
    /// Number of rows of the case if this is the worst of them, otherwise 1.
    pub of: usize,
}

/// All rows of short cases; for a long case, the row that uses most of its tolerance.
pub fn summary(rows: &[Row]) -> Vec<Shown<'_>> {
    let mut shown = Vec::new();
    for case in rows.chunk_by(|a, b| a.case == b.case) {
        if case.len() <= SHOWN {
            shown.extend(case.iter().map(|row| Shown { row, of: 1 }));
            continue;
        }
        let used = |row: &&Row| row.share().abs();
        let worst = case.iter().max_by(|a, b| used(a).total_cmp(&used(b)));
        shown.extend(worst.map(|row| Shown { row, of: case.len() }));
    }
    shown
}

/// Rows as a Markdown table, with the name and source of each case in its first row.
pub fn markdown(shown: &[Shown<'_>]) -> String {
    let mut text = String::from("| case, source | quantity | reference | computed | difference | tolerance | used |\n");
    text.push_str("|---|---|---|---|---|---|---|\n");
    for case in shown.chunk_by(|a, b| a.row.case == b.row.case) {
        for (index, Shown { row, of }) in case.iter().enumerate() {
            let of_case = match index {
                0 => format!("**{}**: {}", row.case.name, row.case.source),
                _ => String::new(),
            };
            let worst = if *of > 1 {
                format!(" (worst of {of})")
            } else {
                String::new()
            };
            let _ = writeln!(
                text,
                "| {of_case} | {}{worst} | {} | {} | {} | {} | {} |",
                row.quantity,
                row.number(row.reference),
                row.number(row.computed),
                row.number(row.computed - row.reference),
                row.tolerance(),
                row.used(),
            );
        }
    }
    text
}
