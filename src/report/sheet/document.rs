//! The declaration sheet as a document of a word processor (Office Open XML, `.docx`), by the crate docx-rs.

use std::io::Cursor;

use docx_rs::{
    Docx, DocxError, LineSpacing, PageMargin, Paragraph, Run, RunFonts, RunProperty, TableCell, TableCellMargins,
    TableLayoutType, TableRow, VertAlignType, WidthType,
};

use super::super::typography::{Setting, parts};
use super::{DIGEST, Sheet, TITLES};
use crate::declaration::{Finished, Use};
use crate::tables::Table;
use crate::units::Units;

/// Size of the page, A4, and of its margins \[1/20 pt\].
const PAGE: [u32; 2] = [11_906, 16_838];
const MARGIN: i32 = 1_020;

/// Width of the text \[1/20 pt\].
const WIDTH: usize = PAGE[0] as usize - 2 * MARGIN as usize;

/// Sizes of the heading, of titles, of the text and of small text \[1/2 pt\].
const SIZES: [usize; 4] = [30, 22, 18, 16];

/// Space before a title and after a paragraph \[1/20 pt\].
const SPACES: [u32; 2] = [140, 50];

/// Colour of a warning.
const ALARM: &str = "B00020";

/// Font of code.
const CODE: &str = "Courier New";

/// Line to be filled in by hand.
const BLANK: &str = "\u{2026}";

/// The document with its quantities in these units.
///
/// # Errors
/// [`DocxError`] if docx-rs cannot compose the file.
pub(in super::super) fn document(of: &Finished, usage: Use, units: Units) -> Result<Vec<u8>, DocxError> {
    let sheet = Sheet::new(of, usage).in_units(units);
    let [heading, _, plain, small] = SIZES;
    let mut made = Docx::new()
        .page_size(PAGE[0], PAGE[1])
        .page_margin(PageMargin {
            top: MARGIN,
            left: MARGIN,
            bottom: MARGIN,
            right: MARGIN,
            header: 0,
            footer: 0,
            gutter: 0,
        })
        .default_fonts(RunFonts::new().ascii("Arial").hi_ansi("Arial"))
        .default_size(plain)
        .add_paragraph(spaced(set(&sheet.heading, |run| run.size(heading).bold())))
        .add_paragraph(spaced(set(sheet.standards, |run| run)));
    if let Some(alarm) = &sheet.alarm {
        made = made.add_paragraph(spaced(set(alarm, |run| run.bold().color(ALARM))));
    }
    made = made
        .add_paragraph(spaced(set(sheet.nature, |run| run.size(small))))
        .add_paragraph(title(TITLES[0]))
        .add_table(table(&sheet.values, &[36, 14, 20, 30]))
        .add_paragraph(title(TITLES[1]))
        .add_table(table(&sheet.in_use, &[64, 14, 22]))
        .add_paragraph(spaced(set(sheet.limits, |run| run.size(small))));
    if let Some(rate) = &sheet.too_fast {
        made = made.add_paragraph(spaced(set(rate, |run| run.bold().color(ALARM))));
    }
    let conditions = sheet.conditions.iter().map(|(name, value)| [name.as_str(), value]);
    made = made
        .add_paragraph(title(TITLES[2]))
        .add_table(facts(conditions.collect(), 0))
        .add_paragraph(title(TITLES[3]));
    for line in sheet.basis {
        made = made.add_paragraph(spaced(set(line, |run| run.size(small))));
    }
    let program = format!("{}; {DIGEST}: {}", sheet.program, sheet.digest);
    let blank = BLANK.repeat(20);
    let signature = sheet.signature.map(|field| [field, blank.as_str()]);
    made = made
        .add_paragraph(spaced(
            Paragraph::new().add_run(Run::new().size(small).add_text(program)),
        ))
        .add_table(facts(signature.to_vec(), 100));
    let mut bytes = Cursor::new(Vec::new());
    made.build().pack(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// A paragraph with typeset signs, low subscripts and code; `style` sets each of its runs.
fn set(text: &str, style: impl Fn(Run) -> Run) -> Paragraph {
    parts(text)
        .into_iter()
        .fold(Paragraph::new(), |paragraph, (part, setting)| {
            let mut run = style(Run::new().add_text(part));
            match setting {
                Setting::Plain => {}
                Setting::Low => {
                    let property: RunProperty = run.run_property;
                    run.run_property = property.vert_align(VertAlignType::SubScript);
                }
                Setting::Code => run = run.fonts(RunFonts::new().ascii(CODE).hi_ansi(CODE)),
            }
            paragraph.add_run(run)
        })
}

fn spaced(paragraph: Paragraph) -> Paragraph {
    paragraph.line_spacing(LineSpacing::new().after(SPACES[1]))
}

fn title(text: &str) -> Paragraph {
    let [before, after] = SPACES;
    set(text, |run| run.size(SIZES[1]).bold())
        .line_spacing(LineSpacing::new().before(before).after(after))
        .keep_next(true)
}

/// A table whose columns take these shares of the width, in percent.
fn table(own: &Table, shares: &[usize]) -> docx_rs::Table {
    let widths: Vec<usize> = shares.iter().map(|share| WIDTH * share / 100).collect();
    let row = |texts: Vec<(&str, bool)>| {
        let cells = texts.into_iter().zip(&widths).map(|((text, bold), &width)| {
            let text = set(text, |run| if bold { run.bold() } else { run });
            TableCell::new().width(width, WidthType::Dxa).add_paragraph(text)
        });
        TableRow::new(cells.collect()).cant_split()
    };
    let headings = row(own
        .columns
        .iter()
        .map(|column| (column.heading.as_str(), true))
        .collect());
    let rows = own
        .rows
        .iter()
        .map(|cells| row(cells.iter().map(|cell| (cell.text.as_str(), cell.strong)).collect()));
    laid_out(std::iter::once(headings).chain(rows).collect(), widths, 20)
}

/// Names and values, with this space above and below each \[1/20 pt\].
fn facts(rows: Vec<[&str; 2]>, space: usize) -> docx_rs::Table {
    let widths = vec![WIDTH * 36 / 100, WIDTH * 64 / 100];
    let rows = rows.into_iter().map(|texts| {
        let cells = texts.into_iter().zip(&widths).map(|(text, &width)| {
            let text = set(text, |run| run);
            TableCell::new().width(width, WidthType::Dxa).add_paragraph(text)
        });
        TableRow::new(cells.collect()).cant_split()
    });
    laid_out(rows.collect(), widths.clone(), space)
}

fn laid_out(rows: Vec<TableRow>, widths: Vec<usize>, space: usize) -> docx_rs::Table {
    docx_rs::Table::new(rows)
        .layout(TableLayoutType::Fixed)
        .width(WIDTH, WidthType::Dxa)
        .set_grid(widths)
        .margins(TableCellMargins::new().margin(space, 80, space, 80))
}
