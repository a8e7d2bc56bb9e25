//! Reading time histories of universal files: dataset 58, "function at nodal DOF", in text.

use std::path::Path;

use super::dataset::{Block, UffError, blocks};

/// Samples of a quantity over time or another abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// Its first line of description.
    pub name: String,
    /// Specific data types of abscissa and ordinate: 17 time, 8 displacement, 9 reaction force, 12 acceleration, 13 excitation
    /// force, 0 unknown.
    pub kinds: [i64; 2],
    /// Labels of their units; empty where there is none.
    pub units: [String; 2],
    /// Line of the file where it begins, from 1.
    pub line: usize,
    /// The abscissa, in its unit.
    pub abscissa: Vec<f64>,
    /// The ordinate, in its unit.
    pub ordinate: Vec<f64>,
    /// Line of the file that holds each sample, from 1.
    pub lines: Vec<usize>,
}

const HEADER: &str = "data type, number of values, spacing, first abscissa, increment";

/// Reads the functions of a universal file, in their order; other datasets are left out. `path` is for messages.
///
/// # Errors
/// [`UffError::Truncated`]; [`UffError::Line`] with the line that cannot be read; [`UffError::Form`] for binary and complex data.
pub fn functions(bytes: &[u8], path: &Path) -> Result<Vec<Function>, UffError> {
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = text.lines().collect();
    let blocks = blocks(&lines, path)?;
    blocks
        .iter()
        .filter(|block| block.dataset == 58)
        .map(Block::function)
        .collect()
}

impl Block<'_> {
    fn function(&self) -> Result<Function, UffError> {
        let form = |found, expected| UffError::Form {
            path: self.path.to_owned(),
            line: self.first - 2,
            dataset: self.dataset,
            found,
            expected,
        };
        if self.binary {
            return Err(form("binary", "text (ASCII)"));
        }
        let header = self.numbers(6, HEADER)?;
        let &[data, count, spacing, first, increment, ..] = header.as_slice() else {
            return Err(self.error(6, HEADER));
        };
        let (double, even) = (data == 4.0, spacing == 1.0);
        if data != 2.0 && !double {
            return Err(form("complex", "real values"));
        }
        let axis = |line: usize| -> Result<(i64, String), UffError> {
            let expected = "the kind, label and unit of an axis";
            let text = self.lines.get(line).ok_or_else(|| self.error(line, expected))?;
            let kind = text.split_whitespace().next().and_then(|word| word.parse().ok());
            let unit: String = text.chars().skip(47).take(20).collect();
            let unit = unit.trim();
            let unit = if unit == "NONE" { "" } else { unit };
            Ok((kind.ok_or_else(|| self.error(line, expected))?, unit.to_owned()))
        };
        let [x, y] = [axis(7)?, axis(8)?];
        let mut function = Function {
            name: self.lines.first().map_or("", |line| line.trim()).to_owned(),
            kinds: [x.0, y.0],
            units: [x.1, y.1],
            line: self.first - 2,
            abscissa: Vec::new(),
            ordinate: Vec::new(),
            lines: Vec::new(),
        };
        // Fields of abscissa and ordinate in a row, from which run-together numbers are taken.
        let widths: &[usize] = match (even, double) {
            (true, false) | (false, false) => &[13],
            (true, true) => &[20],
            (false, true) => &[13, 20],
        };
        let mut pending = None;
        for line in 11..self.lines.len() {
            for value in self.samples(line, widths)? {
                if even {
                    function
                        .abscissa
                        .push(first + increment * function.ordinate.len() as f64);
                } else {
                    match pending.take() {
                        Some(abscissa) => function.abscissa.push(abscissa),
                        None => {
                            pending = Some(value);
                            continue;
                        }
                    }
                }
                function.ordinate.push(value);
                function.lines.push(self.first + line);
            }
        }
        if pending.is_some() || function.ordinate.len() as f64 != count {
            return Err(self.error(6, "as many values as the dataset holds"));
        }
        Ok(function)
    }

    /// The values of a line: separate words, or fields of these widths in turn.
    fn samples(&self, line: usize, widths: &[usize]) -> Result<Vec<f64>, UffError> {
        let text = self.lines[line].trim_end();
        let number = |word: &str| {
            let number = word.trim().replace(['D', 'd'], "E").parse::<f64>().ok();
            number.filter(|x| x.is_finite())
        };
        let words: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        let fields = || {
            let mut values = Vec::new();
            let (mut rest, mut widths) = (text, widths.iter().cycle());
            while let Some(width) = widths.next().filter(|_| !rest.is_empty()) {
                let (field, more) = rest.split_at_checked(*width).unwrap_or((rest, ""));
                values.push(number(field)?);
                rest = more;
            }
            Some(values)
        };
        words.or_else(fields).ok_or_else(|| self.error(line, "finite numbers"))
    }
}
