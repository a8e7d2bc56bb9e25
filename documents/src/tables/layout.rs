//! Locates the headings, units and rows of a table, and its column separator.

use super::heading::Heading;
use super::label::dimension_of;
use super::number::number;

/// Separators, in the order that the search tries them: a comma may also occur in a heading or a decimal number.
const SEPARATORS: [u8; 4] = [b';', b'\t', b',', b'|'];

/// Number of lines searched for the headings.
const PREAMBLE: usize = 200;

/// Number of lines after the headings that are searched for numbers. A row of units and one damaged row may precede the
/// numbers.
const BEHIND: usize = 4;

/// Beginning of a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// Byte offset in the text.
    pub(super) byte: usize,
    /// Its line, from 1.
    pub(super) line: usize,
}

/// Result of [`find`].
pub(super) struct Layout {
    pub(super) separator: u8,
    pub(super) headings: Vec<Heading>,
    pub(super) head: Start,
    pub(super) start: Start,
}

/// A line that is neither blank nor a comment.
struct Line<'a> {
    number: usize,
    begin: usize,
    /// Offset of the byte after its end.
    end: usize,
    text: &'a str,
}

/// Splits a line into fields; a separator within quotes does not split.
pub(super) fn fields(line: &str, separator: u8) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let mut record = csv::StringRecord::new();
    match reader.read_record(&mut record) {
        Ok(true) => record.iter().map(str::to_owned).collect(),
        _ => Vec::new(),
    }
}

fn lines(text: &str) -> Vec<Line<'_>> {
    let mut at = 0;
    let all = text.split_inclusive('\n').enumerate().map(|(index, line)| {
        let begin = at;
        at += line.len();
        Line {
            number: index + 1,
            begin,
            end: at,
            text: line.trim_end_matches('\n'),
        }
    });
    let content =
        |line: &Line<'_>| !line.text.trim_matches([' ', '\t', ';', ',']).is_empty() && !line.text.starts_with('#');
    all.filter(content).take(PREAMBLE).collect()
}

/// The separator stated by Excel's line `sep=;`.
fn stated(line: &Line<'_>) -> Option<u8> {
    let mark = line.text.trim().trim_matches('"').to_lowercase();
    match mark.strip_prefix("sep=")?.as_bytes() {
        [separator] => Some(*separator),
        b"\\t" => Some(b'\t'),
        [] if line.text.ends_with('\t') => Some(b'\t'),
        _ => None,
    }
}

fn is_numeric(fields: &[String]) -> bool {
    let filled = || fields.iter().filter(|field| !field.is_empty());
    filled().count() > 1 && filled().all(|field| number(field).is_some())
}

/// The fields without trailing empty ones, which a separator at the end of a line produces.
fn filled(fields: &[String]) -> usize {
    fields
        .iter()
        .rposition(|field| !field.is_empty())
        .map_or(0, |last| last + 1)
}

/// Whether a row below the headings contains units: no numbers, and each field is bracketed or a unit.
fn is_units(fields: &[String], columns: usize) -> bool {
    let bracketed = |field: &str| {
        matches!(
            (field.chars().next(), field.chars().last()),
            (Some('(' | '['), Some(')' | ']'))
        )
    };
    let unit = |field: &String| {
        field.is_empty() || bracketed(field) || field == "-" || field == "S" || dimension_of(field).is_some()
    };
    let count = filled(fields);
    (1..=columns).contains(&count) && fields.iter().all(unit)
}

/// Finds the headings of a table: the first line accepted by `is_header` that has numbers soon after it, or else the
/// line before the first line of numbers.
pub(super) fn find(text: &str, is_header: impl Fn(&[Heading]) -> bool) -> Option<Layout> {
    let mut lines = lines(text);
    let stated = lines.first().and_then(stated);
    if stated.is_some() {
        lines.remove(0);
    }
    let separators: Vec<u8> = stated.map_or(SEPARATORS.to_vec(), |own| vec![own]);
    let split = |index: usize, separator: u8| {
        lines
            .get(index)
            .map_or_else(Vec::new, |line: &Line<'_>| fields(line.text, separator))
    };
    let headings = |fields: &[String]| fields.iter().map(|field| Heading::of(field)).collect::<Vec<_>>();
    let has_numbers = |index: usize, separator: u8, columns: usize| {
        (index + 1..=index + BEHIND).any(|row| {
            let row = split(row, separator);
            is_numeric(&row) && filled(&row) <= columns.max(2)
        })
    };
    let mut accepted = None;
    for index in 0..lines.len() {
        for &separator in &separators {
            let own = split(index, separator);
            let columns = filled(&own);
            if columns < 2 || is_numeric(&own) || !is_header(&headings(&own)) {
                continue;
            }
            // A line about the instrument, such as "Time,12:30", may look like headings; the last candidate before the
            // numbers counts.
            let later = (index + 1..=index + BEHIND)
                .map(|row| split(row, separator))
                .take_while(|row| !is_numeric(row))
                .any(|row| filled(&row) > 1 && is_header(&headings(&row)));
            if later {
                continue;
            }
            if has_numbers(index, separator, columns) {
                return Some(layout(&lines, index, separator));
            }
            accepted.get_or_insert((index, separator));
        }
    }
    let before_numbers = (1..lines.len()).find_map(|index| {
        let separator = separators
            .iter()
            .copied()
            .find(|separator| is_numeric(&split(index, *separator)))?;
        let columns = filled(&split(index, separator));
        let of = |place: usize| Some(split(place, separator)).filter(|own| filled(own) >= columns.max(2));
        let units = is_units(&of(index - 1)?, columns);
        let header = match index.checked_sub(2).filter(|place| units && of(*place).is_some()) {
            Some(place) => place,
            None => index - 1,
        };
        Some((header, separator))
    });
    let anything = || {
        let separator = separators
            .iter()
            .copied()
            .find(|separator| filled(&split(0, *separator)) > 1)?;
        Some((0, separator))
    };
    let (index, separator) = accepted.or(before_numbers).or_else(anything)?;
    Some(layout(&lines, index, separator))
}

/// Takes the first line as headings, with the separator that splits it into most columns.
pub(super) fn first(text: &str) -> Option<Layout> {
    let mut lines = lines(text);
    let stated = lines.first().and_then(stated);
    if stated.is_some() {
        lines.remove(0);
    }
    let own = lines.first()?.text;
    let count = |separator: &u8| filled(&fields(own, *separator));
    let best = stated.or_else(|| SEPARATORS.into_iter().max_by_key(count))?;
    (count(&best) > 1).then(|| layout(&lines[..1], 0, best))
}

fn layout(lines: &[Line<'_>], index: usize, separator: u8) -> Layout {
    let mut own = fields(lines[index].text, separator);
    own.truncate(filled(&own).max(1));
    let mut headings: Vec<Heading> = own.iter().map(|field| Heading::of(field)).collect();
    let mut last = index;
    if let Some(next) = lines.get(index + 1) {
        let units = fields(next.text, separator);
        if !is_numeric(&units) && is_units(&units, headings.len()) {
            last += 1;
            for (heading, unit) in headings.iter_mut().zip(&units) {
                if heading.unit.is_empty() && unit != "-" {
                    heading.unit.clone_from(unit);
                }
            }
        }
    }
    Layout {
        separator,
        headings,
        head: Start {
            byte: lines[index].begin,
            line: lines[index].number,
        },
        start: Start {
            byte: lines[last].end,
            line: lines[last].number + 1,
        },
    }
}
