//! Reads universal files: nodes and measured modes.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Complex, Point3};

use super::dataset::{Block, UffError, datasets};
use super::systems::{Axes, LocalNode, Systems};

/// Nodes and modes of a modal test.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurement {
    /// Position of each node by its label \[m\], in global axes; empty if the file has none of the datasets 15, 781 and
    /// 2411.
    pub nodes: HashMap<u64, Point3<f64>>,
    /// Displacement axes of nodes whose axes differ from the global ones, by label.
    pub axes: HashMap<u64, Axes>,
    /// The modes, in file order.
    pub modes: Vec<MeasuredMode>,
}

/// A mode of a universal file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredMode {
    /// Natural frequency \[Hz\].
    pub hz: f64,
    /// Complex displacement of each node along its axes (see [`Measurement::axes`]), in arbitrary units.
    pub shape: Vec<(u64, [Complex<f64>; 3])>,
}

/// Largest file size accepted \[byte\].
const LARGEST: u64 = 1 << 30;

/// Accepted range of the unit factors in dataset 164: from kilometres and meganewtons to nanometres and nanonewtons.
const UNITS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// Reads datasets 15, 781 and 2411 (nodes), 18 and 2420 (their coordinate systems), 164 (units) and 55 (modes); skips
/// others.
///
/// # Errors
/// [`UffError`].
pub fn read(path: &Path) -> Result<Measurement, UffError> {
    let bytes = nailnoise_documents::read_regular(path, LARGEST).map_err(|source| UffError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&bytes, path)
}

/// Units of length \[m\] and force \[N\] from dataset 164 of a universal file; none without that dataset.
///
/// # Errors
/// [`UffError::Line`] for invalid factors; [`UffError::Truncated`].
pub fn units(bytes: &[u8], path: &Path) -> Result<Option<[f64; 2]>, UffError> {
    let last = datasets(bytes).into_iter().rfind(|dataset| dataset.number == 164);
    last.map(|dataset| dataset.read(path, |block| block.units()))
        .transpose()
}

/// Parses the contents of a universal file; `path` is for messages.
///
/// # Errors
/// Same as [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Measurement, UffError> {
    let mut measurement = Measurement::default();
    let (mut nodes, mut systems, mut metres) = (HashMap::new(), Systems::default(), 1.0);
    // Coordinate systems and units may follow the nodes that need them.
    for dataset in datasets(bytes) {
        match dataset.number {
            15 => dataset.read(path, |block| block.nodes(1, &mut nodes))?,
            781 | 2411 => dataset.read(path, |block| block.nodes(2, &mut nodes))?,
            18 => dataset.read(path, |block| systems.read_18(block))?,
            2420 => dataset.read(path, |block| systems.read_2420(block))?,
            164 => metres = dataset.read(path, |block| block.units())?[0],
            55 => dataset.read(path, |block| block.mode(&mut measurement))?,
            _ if dataset.is_cut_off() => dataset.read(path, |_| Ok(()))?,
            _ => {}
        }
    }
    if measurement.modes.is_empty() {
        return Err(UffError::NoModes {
            path: path.to_owned(),
            analyses: datasets(bytes)
                .into_iter()
                .filter(|dataset| dataset.number == 2414)
                .count(),
        });
    }
    systems.scale(metres);
    for (label, mut node) in nodes {
        node.position *= metres;
        let (position, axes) = systems.resolve(&node, path)?;
        measurement.nodes.insert(label, position);
        measurement.axes.extend(axes.map(|axes| (label, axes)));
    }
    Ok(measurement)
}

impl Block<'_> {
    fn nodes(&self, lines_each: usize, nodes: &mut HashMap<u64, LocalNode>) -> Result<(), UffError> {
        let expected = "a node: label, three numbers, three coordinates";
        for line in (0..self.lines.len()).step_by(lines_each) {
            let mut numbers = self.numbers(line, expected)?;
            if lines_each == 2 {
                numbers.extend(self.numbers(line + 1, expected)?);
            }
            let &[label, definition, displacement, _, x, y, z] = numbers.as_slice() else {
                return Err(self.error(line, expected));
            };
            let whole = |number: f64| number >= 0.0 && number.fract() == 0.0;
            if ![label, definition, displacement].into_iter().all(whole) {
                return Err(self.error(line, expected));
            }
            let node = LocalNode {
                definition: definition as u64,
                displacement: displacement as u64,
                position: Point3::new(x, y, z),
                dataset: self.dataset,
                line: self.first + line,
            };
            // Datasets 781 and 2411 have more digits than 15 and replace it.
            if lines_each == 2 {
                nodes.insert(label as u64, node);
            } else {
                nodes.entry(label as u64).or_insert(node);
            }
        }
        Ok(())
    }

    /// Units of length \[m\] and force \[N\] of the file, from dataset 164. It gives the factors by which values in the
    /// file are divided to obtain SI units.
    fn units(&self) -> Result<[f64; 2], UffError> {
        let expected = "factors of the units of length, force and temperature";
        match self.numbers(1, expected)?.as_slice() {
            &[length, force, ..] if [length, force].iter().all(|factor| UNITS.contains(factor)) => {
                Ok([length, force].map(|factor| 1.0 / factor))
            }
            _ => Err(self.error(1, expected)),
        }
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
