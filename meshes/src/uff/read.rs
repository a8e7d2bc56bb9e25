//! Reading universal files: nodes and measured modes.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Complex, Point3};

use super::dataset::{Block, UffError, datasets};

/// What a universal file holds of a modal test.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurement {
    /// Position of each node by its label \[m\]; empty when the file has neither dataset 15 nor 2411.
    pub nodes: HashMap<u64, Point3<f64>>,
    /// The modes, in the order of the file.
    pub modes: Vec<MeasuredMode>,
}

/// A mode of a universal file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredMode {
    /// Natural frequency \[Hz\].
    pub hz: f64,
    /// Complex displacement of each node along x, y and z, in any unit.
    pub shape: Vec<(u64, [Complex<f64>; 3])>,
}

/// The largest file that is read \[byte\].
const LARGEST: u64 = 1 << 30;

/// Reads datasets 15, 2411 and 55; others are left out.
///
/// # Errors
/// [`UffError`].
pub fn read(path: &Path) -> Result<Measurement, UffError> {
    let bytes = crate::read_regular(path, LARGEST).map_err(|source| UffError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&bytes, path)
}

/// Reads the content of a universal file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Measurement, UffError> {
    let mut measurement = Measurement::default();
    for dataset in datasets(bytes) {
        match dataset.number {
            15 => dataset.read(path, |block| block.nodes(1, &mut measurement))?,
            2411 => dataset.read(path, |block| block.nodes(2, &mut measurement))?,
            55 => dataset.read(path, |block| block.mode(&mut measurement))?,
            _ => {}
        }
    }
    if measurement.modes.is_empty() {
        return Err(UffError::NoModes { path: path.to_owned() });
    }
    Ok(measurement)
}

impl Block<'_> {
    fn nodes(&self, lines_each: usize, measurement: &mut Measurement) -> Result<(), UffError> {
        let expected = "a node: label, three numbers, three coordinates";
        for line in (0..self.lines.len()).step_by(lines_each) {
            let mut numbers = self.numbers(line, expected)?;
            if lines_each == 2 {
                numbers.extend(self.numbers(line + 1, expected)?);
            }
            let &[label, _, _, _, x, y, z] = numbers.as_slice() else {
                return Err(self.error(line, expected));
            };
            // 2411 has more digits than 15 and stands.
            let position = Point3::new(x, y, z);
            if lines_each == 2 {
                measurement.nodes.insert(label as u64, position);
            } else {
                measurement.nodes.entry(label as u64).or_insert(position);
            }
        }
        Ok(())
    }

    fn mode(&self, measurement: &mut Measurement) -> Result<(), UffError> {
        let header = self.numbers(5, "six numbers that tell the kind of data")?;
        let &[_, analysis, _, _, data, per_node] = header.as_slice() else {
            return Err(self.error(5, "six numbers that tell the kind of data"));
        };
        let record = self.numbers(7, "a frequency")?;
        let hz = match (analysis as i64, record.as_slice()) {
            (2, [hz, ..]) => *hz,
            // An eigenvalue in rad/s.
            (3 | 7, [re, im, ..]) => re.hypot(*im) / std::f64::consts::TAU,
            (2 | 3 | 7, _) => return Err(self.error(7, "a frequency")),
            _ => return Ok(()),
        };
        let complex = matches!(data as i64, 5 | 6);
        let per_node = per_node as usize;
        if !matches!(per_node, 3 | 6) {
            return Err(self.error(5, "3 or 6 values a node"));
        }
        let values_each = per_node * if complex { 2 } else { 1 };
        let mut shape = Vec::new();
        let mut line = 8;
        while line < self.lines.len() {
            let label = self.numbers(line, "the label of a node")?;
            let &[label, ..] = label.as_slice() else {
                return Err(self.error(line, "the label of a node"));
            };
            let mut values = Vec::with_capacity(values_each);
            line += 1;
            while values.len() < values_each {
                let more = self.numbers(line, "values at a node")?;
                if more.is_empty() {
                    return Err(self.error(line, "values at a node"));
                }
                values.extend(more);
                line += 1;
            }
            let component = |k: usize| {
                if complex {
                    Complex::new(values[2 * k], values[2 * k + 1])
                } else {
                    Complex::new(values[k], 0.0)
                }
            };
            shape.push((label as u64, [component(0), component(1), component(2)]));
        }
        measurement.modes.push(MeasuredMode { hz, shape });
        Ok(())
    }
}
