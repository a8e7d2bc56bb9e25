//! Rows of a table as numbers or text, with their line numbers.

use super::number::number;
use super::{SHOWN, Table, TableFault, shown};

/// Columns of numbers and the line of each row.
#[derive(Debug, Default)]
pub struct Columns {
    /// Values by column. Columns may have different lengths.
    pub values: Vec<Vec<f64>>,
    /// Line of each row, from 1.
    pub lines: Vec<usize>,
}

/// The decimal mark of a file, and a line that shows it.
#[derive(Debug, Clone, Copy, Default)]
struct Marks {
    point: Option<usize>,
    comma: Option<usize>,
}

impl Table {
    /// Reads columns of numbers. A column may end before the others; a number after its end is an error.
    ///
    /// # Errors
    /// [`TableFault::Line`] for the first field that is not a number; its column is an index into `columns`.
    pub fn columns(&self, columns: &[usize]) -> Result<Columns, TableFault> {
        let mut found = Columns {
            values: vec![Vec::new(); columns.len()],
            lines: Vec::new(),
        };
        // Line number of the end of each column.
        let mut ends: Vec<Option<usize>> = vec![None; columns.len()];
        let mut marks = Marks::default();
        self.rows(|line, record| {
            for (place, column) in columns.iter().enumerate() {
                let field = record.get(*column).unwrap_or("");
                let fault = |line: usize, problem: String| TableFault::Line {
                    line,
                    column: Some(place),
                    problem,
                };
                let heading = || shown(self.headings.get(*column).map_or("", |own| &own.text[..]), SHOWN);
                if field.is_empty() {
                    ends[place].get_or_insert(line);
                    continue;
                }
                if let Some(end) = ends[place] {
                    let problem = format!("\"{}\" is empty, and a number follows on line {line}", heading());
                    return Err(fault(end, problem));
                }
                let problem = match number(field) {
                    Some(_) if self.is_ambiguous(field) => format!(
                        "\"{}\" is \"{}\", which can be read with a decimal comma or with one between thousands",
                        heading(),
                        shown(field, SHOWN)
                    ),
                    Some(value) => {
                        marks.see(line, field).map_err(|problem| fault(line, problem))?;
                        found.values[place].push(value);
                        continue;
                    }
                    None => format!(
                        "\"{}\" is \"{}\", which is not a finite number{}",
                        heading(),
                        shown(field, SHOWN),
                        if field.contains(':') {
                            "; give times in s instead of the time of day"
                        } else {
                            ""
                        }
                    ),
                };
                return Err(fault(line, problem));
            }
            found.lines.push(line);
            Ok(())
        })?;
        Ok(found)
    }

    /// Whether a comma may separate thousands. It can do so only if commas also separate the columns, so that the
    /// number was quoted.
    fn is_ambiguous(&self, field: &str) -> bool {
        let Some((whole, decimals)) = field.trim_start_matches(['+', '-']).split_once(',') else {
            return false;
        };
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        self.separator == b','
            && (1..=3).contains(&whole.len())
            && decimals.len() == 3
            && digits(whole)
            && digits(decimals)
            && !whole.starts_with('0')
    }

    /// Calls `row` with the line number and the fields of each row that is not blank.
    ///
    /// # Errors
    /// The errors of `row`; [`TableFault::Line`] for a row with more or fewer fields than there are headings.
    pub fn rows(
        &self,
        mut row: impl FnMut(usize, &csv::StringRecord) -> Result<(), TableFault>,
    ) -> Result<(), TableFault> {
        let text = &self.text[self.start.byte..];
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(self.separator)
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut record = csv::StringRecord::new();
        let (mut at, mut line) = (0, self.start.line);
        let whole = |line: usize, problem: String| TableFault::Line {
            line,
            column: None,
            problem,
        };
        loop {
            // The reader skips blank lines and comments but reports the line before them.
            let begin = usize::try_from(reader.position().byte())
                .unwrap_or(text.len())
                .min(text.len());
            line += text.as_bytes()[at..begin].iter().filter(|byte| **byte == b'\n').count();
            at = begin;
            while let Some(end) = text[at..].find('\n') {
                if !matches!(text.as_bytes()[at], b'\n' | b'#') {
                    break;
                }
                at += end + 1;
                line += 1;
            }
            match reader.read_record(&mut record) {
                Ok(true) => {}
                Ok(false) => return Ok(()),
                Err(error) => return Err(whole(line, error.to_string())),
            }
            let count = (0..record.len())
                .rfind(|place| !record[*place].is_empty())
                .map_or(0, |last| last + 1);
            // DOS text may end with Ctrl-Z.
            if count == 0 || count == 1 && &record[0] == "\u{1a}" {
                continue;
            }
            let columns = self.headings.len();
            if count > columns || record.len() < columns {
                let problem = format!("it has {} fields, the line of headings has {columns}", record.len());
                return Err(whole(line, problem));
            }
            row(line, &record)?;
        }
    }
}

impl Marks {
    /// Rejects a file that mixes decimal points and decimal commas.
    fn see(&mut self, line: usize, field: &str) -> Result<(), String> {
        if field.contains(',') {
            self.comma.get_or_insert(line);
        } else if field.contains('.') {
            self.point.get_or_insert(line);
        }
        match (self.point, self.comma) {
            (Some(point), Some(comma)) => Err(format!(
                "numbers have a decimal point on line {point} and a decimal comma on line {comma}"
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::heading::{Heading, time};
    use super::*;

    /// Reads times and the values of the second column of a table.
    fn read(text: &str) -> Result<[Vec<f64>; 2], TableFault> {
        let table = Table::read(text.as_bytes(), |headings| time(headings).is_some())?;
        let mut columns = table.columns(&[0, 1])?.values.into_iter();
        Ok([columns.next().unwrap_or_default(), columns.next().unwrap_or_default()])
    }

    #[test]
    fn a_table_reads_alike_with_each_separator_mark_and_quote() {
        let expected = Ok([vec![0.0, 0.5, 1.0], vec![1.25, -3.0, 2e-3]]);
        for text in [
            "t,N\n0,1.25\n0.5,-3\n1,2e-3\n",
            "t;N\n0;1,25\n0,5;-3\n1;2E-3\n",
            "t\tN\r\n0\t1,25\r\n0,5\t-3,0\r\n1\t2,0E-3\r\n",
            "t|N\n0|1.25\n0.5|-3\n1|0.002",
            "\"t\",\"N\"\n\"0\",\"1.25\"\n\"0.5\",\"-3\"\n\"1\",\"2e-3\"\n",
            "\"t\",\"N\"\n\"0\",\"1,25\"\n\"0,5\",\"-3\"\n\"1\",\"2e-3\"\n",
            "sep=;\nt;N\n0;1.25\n0.5;-3\n1;2D-3\n",
            "# recorder\n\nt,N\n# begin\n0,1.25\n\n0.5,-3\n1,2e-3\n\u{1a}",
            "t,N,\n0,1.25,\n0.5,-3,\n1,2e-3,\n",
            "t,N\r0,1.25\r0.5,-3\r1,2e-3\r",
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn lines_before_the_headings_and_units_below_them_are_understood() {
        let table = |text: &str| Table::read(text.as_bytes(), |headings| headings.iter().any(Heading::is_time));
        for (text, line) in [
            (
                "Model;DSO 123\nDate;2024-01-01\n\nTime;N\n(ms);(g)\n\n0,0;1,0\n0,5;2,0\n",
                4,
            ),
            ("x-axis,1\nsecond,Volt\n0,1\n1,2\n", 1),
            ("Time,12:30\nTime,N\ns,g\n0,1\n1,2\n", 2),
        ] {
            let table = table(text);
            let found = table
                .as_ref()
                .map(|own| (own.line, own.headings.iter().all(|heading| !heading.unit.is_empty())));
            assert_eq!(found, Ok((line, true)), "{text}");
        }
    }

    #[test]
    fn a_file_with_points_and_commas_is_refused() {
        let said = |text: &str| read(text).map_err(|fault| fault.to_string());
        let mixed = said("t;N\n0;1.5\n1;1,5\n");
        assert!(mixed.is_err_and(|text| text.contains("line 3") && text.contains("line 2")));
        // 1234 or 1.234? The file decides only if its columns are not separated by commas.
        let thousands = said("t,N\n0,\"1,234\"\n");
        assert!(thousands.is_err_and(|text| text.contains("line 2") && text.contains("thousands")));
        assert!(said("t;N\n0;1.234,5\n").is_err());
    }

    #[test]
    fn a_line_is_named_as_an_editor_counts_it() {
        let text = "# a\n\nt,N\n0,1\n\n# b\n1,2\n2,none\n";
        let fault = read(text).map_err(|fault| fault.to_string());
        assert_eq!(
            fault,
            Err("line 8: \"N\" is \"none\", which is not a finite number".to_owned())
        );
        let fields = read("t,N\n0,1\n1,2,3\n").map_err(|fault| fault.to_string());
        assert_eq!(
            fields,
            Err("line 3: it has 3 fields, the line of headings has 2".to_owned())
        );
    }

    #[test]
    fn a_column_may_end_early_but_has_no_gap() {
        assert_eq!(read("t,N\n0,1\n1,2\n2,\n"), Ok([vec![0.0, 1.0, 2.0], vec![1.0, 2.0]]));
        let gap = read("t,N\n0,1\n1,\n2,3\n").map_err(|fault| fault.to_string());
        assert!(gap.is_err_and(|text| text.contains("line 3") && text.contains("line 4")));
    }
}
