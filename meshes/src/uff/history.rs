//! Writes time histories: dataset 58, "function at nodal DOF", in text.

use std::fmt::Write as _;

use super::write::fortran;

/// Number of lines of a dataset before its values.
const HEADER_LINES: usize = 11;

/// The quantity of a time history: its specific data type, name and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ordinate {
    /// An acceleration, data type 12 \[m/s²\].
    Acceleration,
    /// A pressure, data type 15 \[Pa\].
    Pressure,
}

impl Ordinate {
    fn axis(self) -> (u32, &'static str, &'static str) {
        match self {
            Self::Acceleration => (12, "acceleration", "m/s2"),
            Self::Pressure => (15, "pressure", "Pa"),
        }
    }
}

/// Uniformly sampled values of a quantity, to be written.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    /// Name of the recorded quantity: the first line of the description, truncated to 80 characters.
    pub title: &'a str,
    /// Origin of the data: the second line.
    pub origin: &'a str,
    /// Name of the sensor, truncated to ten characters.
    pub sensor: &'a str,
    /// Node number of the sensor.
    pub node: usize,
    /// The quantity.
    pub ordinate: Ordinate,
    /// Sampling interval \[s\]; the format stores six digits of it.
    pub interval: f64,
    /// The samples, in the unit of the quantity.
    pub values: &'a [f64],
}

impl History<'_> {
    /// Appends the dataset to a file in text form.
    ///
    /// Function type 1 is a time response, data type 4 is real double precision, abscissa spacing 1 is even, specific
    /// data type 17 is time. Reference direction 0 is a scalar, which suits the axis of a sensor.
    pub fn write(&self, text: &mut Vec<u8>) {
        text.extend_from_slice(format!("{:>6}\n{:>6}\n", -1, 58).as_bytes());
        text.extend_from_slice(self.records(4).as_bytes());
        for line in self.values.chunks(4) {
            line.iter().for_each(|value| fortran(text, *value, [20, 12]));
            text.push(b'\n');
        }
        text.extend_from_slice(b"    -1\n");
    }

    /// Appends the dataset in binary form, 58b: IEEE 754, single precision, least significant byte first; a fifth of
    /// the size of text.
    pub fn write_binary(&self, bytes: &mut Vec<u8>) {
        let header = format!(
            "{:>6}\n{:>6}b{:>6}{:>6}{:>12}{:>12}{:>6}{:>6}{:>12}{:>12}\n",
            -1,
            58,
            1,
            2,
            HEADER_LINES,
            4 * self.values.len(),
            0,
            0,
            0,
            0
        );
        bytes.extend_from_slice(header.as_bytes());
        bytes.extend_from_slice(self.records(2).as_bytes());
        for value in self.values {
            bytes.extend_from_slice(&(*value as f32).to_le_bytes());
        }
        bytes.extend_from_slice(b"\n    -1\n");
    }

    /// The records of the dataset before its values; `data` is the data type: 2 for real single, 4 for real double
    /// precision.
    fn records(&self, data: u32) -> String {
        // Writing to a string cannot fail, so the results of `writeln` are ignored.
        let mut text = String::new();
        let (kind, quantity, unit) = self.ordinate.axis();
        for line in [
            self.title,
            self.origin,
            "NONE",
            &format!("{quantity} of one shot"),
            "NONE",
        ] {
            let _ = writeln!(text, "{line:.80}");
        }
        let _ = writeln!(
            text,
            "{:>5}{:>10}{:>5}{:>10} {:<10.10}{:>10}{:>4} {:<10.10}{:>10}{:>4}",
            1, 0, 0, 0, self.sensor, self.node, 0, "NONE", 0, 0
        );
        let mut abscissa = Vec::new();
        for value in [0.0, self.interval, 0.0] {
            fortran(&mut abscissa, value, [13, 5]);
        }
        let abscissa = String::from_utf8_lossy(&abscissa);
        let _ = writeln!(text, "{data:>10}{:>10}{:>10}{abscissa}", self.values.len(), 1);
        for (kind, label, unit) in [
            (17, "time", "s"),
            (kind, quantity, unit),
            (0, "NONE", "NONE"),
            (0, "NONE", "NONE"),
        ] {
            let _ = writeln!(text, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{Function, functions};
    use super::*;

    #[test]
    fn a_binary_history_reads_back_to_single_precision() {
        let values = [1.5, -2.25, 3.0e-3, 1e6, 5.0];
        let mut bytes = Vec::new();
        let history = History {
            title: "N (tool)",
            origin: "nailnoise",
            sensor: "N",
            node: 1,
            ordinate: Ordinate::Acceleration,
            interval: 6.25e-6,
            values: &values,
        };
        history.write_binary(&mut bytes);
        history.write(&mut bytes);
        let read: Vec<Function> = functions(&bytes, Path::new("test.uff")).into_iter().flatten().collect();
        assert_eq!(read.len(), 2);
        assert_eq!((read[0].units[1].as_str(), read[0].abscissa[1]), ("m/s2", 6.25e-6));
        for (read, value) in read[0].ordinate.iter().zip(values) {
            assert!((read / value - 1.0).abs() < 1e-7);
        }
        assert_eq!(read[1].ordinate, values);
    }

    #[test]
    fn a_history_becomes_one_dataset_of_four_values_a_line() {
        let values = [1.0, -2.0, 3.0, 4.0, 5.0];
        let mut text = Vec::new();
        History {
            title: "block_top (workpiece)",
            origin: "nailnoise",
            sensor: "block_top",
            node: 1,
            ordinate: Ordinate::Acceleration,
            interval: 4e-6,
            values: &values,
        }
        .write(&mut text);
        let text = String::from_utf8(text).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            (lines[0], lines[1], lines[lines.len() - 1]),
            ("    -1", "    58", "    -1")
        );
        assert_eq!(lines[2], "block_top (workpiece)");
        assert_eq!(lines.len(), 2 + 5 + 2 + 4 + 2 + 1);
        assert_eq!(lines[8].split_whitespace().nth(1), Some("5"));
        let read = lines[13..15].iter().flat_map(|line| line.split_whitespace());
        let read: Vec<f64> = read.map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        assert_eq!(read, values);
    }
}
