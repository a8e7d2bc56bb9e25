//! Reads time histories of universal files: dataset 58, "function at nodal DOF", in text and binary.

use std::path::Path;

use super::dataset::{Binary, Block, UffError, datasets};
use nailnoise_documents::text::utf8;

/// Samples of a quantity over time or another abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// First line of its description.
    pub name: String,
    /// Function type: 1 time response, 2 auto spectrum, 4 frequency response, 9 power spectral density, 0 unknown.
    pub kind: i64,
    /// Specific data types of abscissa and ordinate: 17 time, 8 displacement, 9 reaction force, 12 acceleration, 13
    /// excitation force, 0 unknown.
    pub kinds: [i64; 2],
    /// Labels of their units; empty if not given.
    pub units: [String; 2],
    /// Line of the file at which it begins, from 1.
    pub line: usize,
    /// The abscissa, in its unit.
    pub abscissa: Vec<f64>,
    /// The ordinate, in its unit.
    pub ordinate: Vec<f64>,
    /// Line of each sample in the file, from 1; for binary samples, the line at which their bytes begin.
    pub lines: Vec<usize>,
}

const HEADER: &str = "data type, number of values, spacing, first abscissa, increment";

/// Reads the functions of a universal file, in order; other datasets are skipped. `path` is for messages.
///
/// A function is text (58) or binary (58b: IEEE 754, either byte order, single or double precision). Each function has
/// its own result, because test systems write time histories, spectra and frequency responses of a run into one file,
/// and an unreadable one must not affect the others. If the file ends within a dataset of another kind, the last result
/// is this error.
///
/// # Errors
/// [`UffError::Truncated`]; [`UffError::Line`] for an unreadable line; [`UffError::NotFinite`]; [`UffError::Form`] for
/// complex data, and for binary data not in IEEE 754.
pub fn functions(bytes: &[u8], path: &Path) -> Vec<Result<Function, UffError>> {
    datasets(&utf8(bytes))
        .iter()
        .filter(|dataset| dataset.number == 58 || dataset.is_cut_off())
        .map(|dataset| dataset.read(path, |block| block.function(dataset.binary)))
        .collect()
}

/// Whether a file is a universal file: its first nonempty line is -1.
pub fn is_universal(bytes: &[u8]) -> bool {
    // The first lines suffice; this avoids copying long recordings.
    let text = utf8(&bytes[..bytes.len().min(4096)]);
    let mut lines = text.split(|byte| *byte == b'\n');
    lines
        .find(|line| !line.trim_ascii().is_empty())
        .is_some_and(|line| line.trim_ascii() == b"-1")
}

/// Data type, spacing and axis of the samples: record 7 of the dataset.
struct Layout {
    double: bool,
    even: bool,
    count: f64,
    first: f64,
    increment: f64,
}

impl Block<'_> {
    fn form(&self, found: &'static str, expected: &'static str) -> UffError {
        UffError::Form {
            path: self.path.to_owned(),
            line: self.first - 2,
            dataset: self.dataset,
            found,
            expected,
        }
    }

    /// The function type: the first number of record 6.
    fn kind(&self) -> i64 {
        let line = self.lines.get(5).unwrap_or(&"");
        // The field is five columns wide and may touch the next one.
        let word = line.get(..5).unwrap_or(line).trim();
        word.parse().unwrap_or(0)
    }

    fn function(&self, binary: Option<Binary<'_>>) -> Result<Function, UffError> {
        let header = self.numbers(6, HEADER)?;
        let &[data, count, spacing, first, increment, ..] = header.as_slice() else {
            return Err(self.error(6, HEADER));
        };
        let layout = Layout {
            double: data == 4.0,
            even: spacing == 1.0,
            count,
            first,
            increment,
        };
        let kind = self.kind();
        if data != 2.0 && !layout.double {
            return Err(self.form(
                match kind {
                    1 => "a complex time response",
                    2 | 3 | 9 | 10 | 12 => "a complex spectrum",
                    4 => "a frequency response, which is complex",
                    _ => "complex",
                },
                "real values, or read another dataset",
            ));
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
            kind,
            name: self.lines.first().map_or("", |line| line.trim()).to_owned(),
            kinds: [x.0, y.0],
            units: [x.1, y.1],
            line: self.first - 2,
            abscissa: Vec::new(),
            ordinate: Vec::new(),
            lines: Vec::new(),
        };
        match binary {
            Some(binary) => self.bytes(binary, &layout, &mut function)?,
            None => self.words(&layout, &mut function)?,
        }
        if function.ordinate.len() as f64 != layout.count {
            return Err(self.error(6, "as many values as the dataset holds"));
        }
        Ok(function)
    }

    /// Reads samples in text.
    fn words(&self, layout: &Layout, function: &mut Function) -> Result<(), UffError> {
        // Widths of the abscissa and ordinate fields in a row, used to split numbers without separators.
        let widths: &[usize] = match (layout.even, layout.double) {
            (true, false) | (false, false) => &[13],
            (true, true) => &[20],
            (false, true) => &[13, 20],
        };
        let (mut pending, mut values) = (None, Vec::new());
        for line in 11..self.lines.len() {
            self.samples(line, widths, &mut values)?;
            for &value in &values {
                if layout.even {
                    function.abscissa.push(layout.abscissa(function.ordinate.len()));
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
        match pending {
            Some(_) => Err(self.error(6, "as many values as the dataset holds")),
            None => Ok(()),
        }
    }

    /// Reads samples in IEEE 754. An uneven abscissa is in single precision or, in files of some programs, in the
    /// precision of the ordinate.
    fn bytes(&self, binary: Binary<'_>, layout: &Layout, function: &mut Function) -> Result<(), UffError> {
        const EXPECTED: &str = "IEEE 754 (format 2), byte order 1 or 2, or as text";
        let little = match (binary.order, binary.format) {
            (1, 2) => true,
            (2, 2) => false,
            _ => return Err(self.form("binary of a machine without IEEE 754", EXPECTED)),
        };
        let width = if layout.double { 8 } else { 4 };
        let spread = if layout.even { 0.0 } else { layout.count };
        let size = binary.bytes.len() as f64;
        let abscissa = [0, 4, width]
            .into_iter()
            .find(|&own| (own == 0) == layout.even && spread * own as f64 + layout.count * width as f64 == size);
        let Some(abscissa) = abscissa else {
            return Err(self.error(6, "as many values as the dataset has bytes for"));
        };
        let number = |bytes: &[u8]| match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes), little) {
            (Ok(bytes), _, true) => f64::from(f32::from_le_bytes(bytes)),
            (Ok(bytes), _, false) => f64::from(f32::from_be_bytes(bytes)),
            (_, Ok(bytes), true) => f64::from_le_bytes(bytes),
            (_, Ok(bytes), false) => f64::from_be_bytes(bytes),
            _ => f64::NAN,
        };
        for (index, sample) in binary.bytes.chunks_exact(abscissa + width).enumerate() {
            let (x, y) = sample.split_at(abscissa);
            let x = if layout.even { layout.abscissa(index) } else { number(x) };
            let y = number(y);
            if let Some(value) = [x, y].into_iter().find(|value| !value.is_finite()) {
                return Err(UffError::NotFinite {
                    path: self.path.to_owned(),
                    line: self.first - 2,
                    dataset: self.dataset,
                    sample: index + 1,
                    value,
                });
            }
            function.abscissa.push(x);
            function.ordinate.push(y);
            function.lines.push(self.first + 11);
        }
        Ok(())
    }

    /// Reads the values of a line: separated words, or fields of alternating widths.
    fn samples(&self, line: usize, widths: &[usize], values: &mut Vec<f64>) -> Result<(), UffError> {
        let text = self.lines[line].trim_end();
        let number = |word: &str| {
            let word = word.trim();
            let number = word.parse::<f64>().or_else(|_| word.replace(['D', 'd'], "E").parse());
            number.ok().filter(|x| x.is_finite())
        };
        values.clear();
        let mut words = text.split_whitespace().map(number);
        if words.all(|value| value.map(|value| values.push(value)).is_some()) {
            return Ok(());
        }
        values.clear();
        let (mut rest, mut widths) = (text, widths.iter().cycle());
        while let Some(width) = widths.next().filter(|_| !rest.is_empty()) {
            let (field, more) = rest.split_at_checked(*width).unwrap_or((rest, ""));
            values.push(number(field).ok_or_else(|| {
                let word = text.split_whitespace().find(|word| number(word).is_none());
                self.unexpected(line, "finite numbers", word.unwrap_or(field))
            })?);
            rest = more;
        }
        Ok(())
    }
}

impl Layout {
    fn abscissa(&self, index: usize) -> f64 {
        self.first + self.increment * index as f64
    }
}
