//! Comma-separated tables.

use csv::{ByteRecord, IntoInnerError, QuoteStyle, Writer, WriterBuilder};
use nailnoise_meshes::digits::{exponential, fixed};
use rayon::prelude::*;

use super::Exports;
use crate::error::Error;

/// Number of rows of a long table that are written together.
const BLOCK: usize = 128;

/// Maximum length of a number with nine digits, including sign and comma \[byte\].
const WIDTH: usize = 18;

/// A table of text. Fields with commas are quoted. An apostrophe before a text that a spreadsheet would take for a
/// formula marks it as text.
///
/// # Errors
/// [`Error::Table`] if the length of a row differs from that of the header.
pub(crate) fn table<F, R>(
    header: impl IntoIterator<Item = F>,
    rows: impl IntoIterator<Item = R>,
) -> Result<Vec<u8>, Error>
where
    F: AsRef<[u8]>,
    R: IntoIterator<Item: AsRef<[u8]>>,
{
    let mut writer = Writer::from_writer(Vec::new());
    let mut record = ByteRecord::new();
    let mut write = |fields: &mut dyn Iterator<Item = Vec<u8>>| {
        record.clear();
        fields.for_each(|field| record.push_field(&field));
        writer.write_byte_record(&record)
    };
    write(&mut header.into_iter().map(|field| plain(field.as_ref())))?;
    for row in rows {
        write(&mut row.into_iter().map(|field| plain(field.as_ref())))?;
    }
    finished(writer)
}

/// A field that no spreadsheet evaluates: one that begins like a formula and is not a number is preceded by an
/// apostrophe.
fn plain(field: &[u8]) -> Vec<u8> {
    let number = || std::str::from_utf8(field).is_ok_and(|text| text.trim().parse::<f64>().is_ok());
    let formula = match field {
        [b'=' | b'@' | b'\t' | b'\r', ..] => true,
        [b'+' | b'-', _, ..] => !number(),
        _ => false,
    };
    if formula {
        [b"'", field].concat()
    } else {
        field.to_vec()
    }
}

/// Shortest interval between rows in a table of histories \[s\], unless all samples are requested.
const COARSE: f64 = 1e-5;

/// Stride that thins samples with this interval \[s\] to that of the table, without interpolation.
fn coarse(interval: f64) -> usize {
    (COARSE / interval - 1e-6).ceil().max(1.0) as usize
}

/// Stride of the samples of histories with this interval \[s\]; 1 if all are requested.
pub(super) fn stride(interval: f64, exports: Exports) -> usize {
    if exports.histories { 1 } else { coarse(interval) }
}

/// A long table of numbers with every `stride`-th row. The abscissa has a fixed number of decimals, and the values of
/// the columns have a fixed number of digits after the first.
///
/// # Errors
/// [`Error::Table`] if the header does not name each column.
pub(super) fn numbers(
    header: impl IntoIterator<Item = String>,
    (abscissa, decimals): (impl Fn(usize) -> f64 + Sync, usize),
    (columns, digits): (&[&[f64]], usize),
    stride: usize,
) -> Result<Vec<u8>, Error> {
    let rows = columns.first().map_or(0, |column| column.len()).div_ceil(stride);
    let block = |first: usize| {
        let bytes = Vec::with_capacity(BLOCK * WIDTH * (columns.len() + 1));
        // Numbers need no quotes.
        let mut writer = WriterBuilder::new().quote_style(QuoteStyle::Never).from_writer(bytes);
        let (mut row, mut field) = (ByteRecord::new(), Vec::with_capacity(WIDTH));
        for index in (first..rows.min(first + BLOCK)).map(|row| row * stride) {
            row.clear();
            field.clear();
            fixed(&mut field, abscissa(index), decimals);
            row.push_field(&field);
            for column in columns {
                field.clear();
                exponential(&mut field, column[index], digits);
                row.push_field(&field);
            }
            writer.write_byte_record(&row)?;
        }
        finished(writer)
    };
    let mut blocks = vec![table(header, std::iter::empty::<[&str; 0]>())?];
    let starts: Vec<usize> = (0..rows).step_by(BLOCK).collect();
    blocks.extend(starts.into_par_iter().map(block).collect::<Result<Vec<_>, _>>()?);
    Ok(blocks.concat())
}

fn finished(writer: Writer<Vec<u8>>) -> Result<Vec<u8>, Error> {
    let written = writer.into_inner().map_err(IntoInnerError::into_error);
    Ok(written.map_err(csv::Error::from)?)
}

/// A level with three decimals; empty for silence.
pub(super) fn level(value: Option<f64>) -> String {
    optional(value, 3)
}

/// A number with a fixed number of decimals; empty for `None`.
pub(super) fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(String::new, |value| format!("{value:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_with_a_comma_is_quoted() {
        let table = table(["a", "b"], [["1,5", "2"]]).unwrap_or_default();
        assert_eq!(String::from_utf8_lossy(&table), "a,b\n\"1,5\",2\n");
    }

    #[test]
    fn a_text_that_begins_like_a_formula_is_marked_as_text() {
        let fields = [
            "=1+1",
            "@x",
            "+cmd|' /C calc'!A0",
            "-2+3",
            "-1.5e-3",
            "+3",
            "-",
            "-inf",
            "N",
            "a=b",
        ];
        let table = table(fields, [fields]).unwrap_or_default();
        let expected = "'=1+1,'@x,'+cmd|' /C calc'!A0,'-2+3,-1.5e-3,+3,-,-inf,N,a=b\n";
        assert_eq!(String::from_utf8_lossy(&table), expected.repeat(2));
    }

    #[test]
    fn a_row_has_as_many_fields_as_the_header() {
        assert!(matches!(table(["a", "b"], [["1"]]), Err(Error::Table(_))));
    }

    #[test]
    fn rows_of_numbers_are_complete_and_in_order() {
        let column: Vec<f64> = (0..3 * BLOCK + 1).map(|i| i as f64).collect();
        let header = ["x", "y"].map(str::to_owned);
        let text = numbers(header, (|i| i as f64, 1), (&[&column], 3), 1).unwrap_or_default();
        let text = String::from_utf8(text).unwrap_or_default();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("x,y"));
        for (index, line) in lines.by_ref().enumerate() {
            assert_eq!(line, format!("{index}.0,{:.3e}", column[index]));
        }
        assert_eq!(text.lines().count(), 1 + column.len());
    }

    #[test]
    fn a_coarse_table_holds_samples_at_least_ten_microseconds_apart() {
        assert_eq!([4e-6, 5e-6, 1e-5, 3e-5].map(coarse), [3, 2, 1, 1]);
        let header = ["x", "y"].map(str::to_owned);
        let column = [0.0, 1.0, 2.0, 3.0, 4.0];
        let text = numbers(header, (|i| i as f64, 0), (&[&column], 1), 3).unwrap_or_default();
        assert_eq!(String::from_utf8_lossy(&text), "x,y\n0,0.0e0\n3,3.0e0\n");
    }
}
